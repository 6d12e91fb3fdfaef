// A run of an engine with its samples.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "scene/scene.hpp"

namespace atwood {

struct Ran {
  Outcome outcome;
  std::vector<Sample> samples;
};
inline Ran run(const Engine& engine, const std::string& method, const Scenario& scenario, std::int64_t steps,
               std::int64_t samples) {
  Ran made;
  made.outcome = engine.run(parse_method_id(method), scenario.scene, {scenario.t_end_s, steps, samples},
                            {[&](const Sample& s) { made.samples.push_back(s); }, {}}, 0);
  return made;
}

}  // namespace atwood
