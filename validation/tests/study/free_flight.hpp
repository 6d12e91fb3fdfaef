// Bodies that fly straight on, and a folder to work in.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "validation/study/study.hpp"

namespace atwood {

inline Scenario free_flight(const std::string& id, double speed = 3) {
  Scenario scenario;
  scenario.id = id;
  scenario.t_end_s = 2;
  scenario.steps = {8, 16, 32, 64};
  scenario.samples = 8;
  scenario.tags = {"smooth"};
  scenario.invariants.push_back({"energy"});
  scenario.truth.kind = TruthKind::closed_form;
  scenario.truth.solution = "free-flight";
  scenario.scene.materials.push_back({"default", 0, 0, 0});
  scenario.scene.pairs.push_back({});
  Body body;
  body.name = "ball";
  body.mass_kg = 1;
  body.position_m = {0.1, 0.2, 0.3};
  body.velocity_m_per_s = {speed, -1, 0.5};
  scenario.scene.bodies.push_back(body);
  return scenario;
}

struct Folder {
  std::string path;
  Folder() {
    char name[] = "/tmp/atwood-study-XXXXXX";
    if (!mkdtemp(name)) throw std::runtime_error("no folder for the test");
    path = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
  std::string operator/(const std::string& name) const { return path + "/" + name; }
};

}  // namespace atwood
