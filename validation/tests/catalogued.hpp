// Scenes of the catalogue, by their ids.
#pragma once

#include <string>

#include "scene/files.hpp"

namespace atwood::testing {

inline Scenario catalogued(const std::string& id) {
  return read_scenario(std::string(ATWOOD_SOURCE_DIR) + "/validation/scenarios/" + id + ".toml");
}

}  // namespace atwood::testing
