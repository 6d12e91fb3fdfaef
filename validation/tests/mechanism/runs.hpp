// Runs of an engine over a scenario's time.
#pragma once

#include "validation/tests/recorded.hpp"

namespace atwood {

using testing::Recorded;

// Whatever the outcome's status: for tests of a refusal or of an end.
inline Recorded try_run(const Engine& engine, const std::string& method, const Scenario& scenario, std::int64_t steps,
                        std::int64_t samples) {
  return testing::record(engine.run, parse_method_id(method), scenario.scene, {scenario.t_end_s, steps, samples});
}
// The test fails here unless the run ended ok with all its samples.
inline Recorded run(const Engine& engine, const std::string& method, const Scenario& scenario, std::int64_t steps,
                    std::int64_t samples) {
  Recorded made = try_run(engine, method, scenario, steps, samples);
  testing::require_whole(made, method, {scenario.t_end_s, steps, samples});
  return made;
}

}  // namespace atwood
