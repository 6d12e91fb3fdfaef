// Small scenario texts for tests of reading.
#pragma once

#include <string>

#include "scene/files.hpp"

namespace scene_test {

// Six lines that every text starts with; the text that follows starts on line 7.
inline const std::string kHead =
    "id = \"test\"\n"
    "[run]\n"
    "t_end_s = 2.0\n"
    "steps = [60, 120]\n"
    "samples = 60\n"
    "\n";

inline atwood::Scenario read(const std::string& text, const std::string& folder = ".") {
  return atwood::read_scenario_text(text, "t.toml", folder);
}
inline atwood::Body read_body(const std::string& keys) {
  return read(kHead + "[[body]]\nname = \"b\"\n" + keys).scene.bodies.front();
}

// The message of the error, or "no error".
inline std::string message(const std::string& text, const std::string& folder = ".") {
  try {
    read(text, folder);
  } catch (const atwood::InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace scene_test
