// What the runs of one scene have in common and their differences do not show: the location of impacts, round-off, the
// bounces that a series sums up; each grown along the motion, through every impact.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/instants.hpp"
#include "protocol/sample.hpp"

namespace atwood::dynamics {

// Of what is certified: samples before t_s are
struct End {
  Wide t_s = 0;
  std::string why;
};

struct SharedErrors {
  std::vector<std::vector<Wide>> samples;  // per sample and component of y: the half-width
  std::vector<double> events_s;            // per event: of its time
  std::optional<End> end;
};

// `apart_s`: per event, what the runs' differences say of its time; `apart`: per sample and component, of the state.
// `instants` begin with sample 0; `round_off` is the relative error of one operation of the run.
// Ends where an outcome is not decided within the half-widths: impacts of contacts that act on each other closer in
// time than that, a passage or an impact at a glancing rate that cannot be told from each other.
// The half-width of a velocity at a sample within an impact's is the jump.
SharedErrors shared_errors(const Scene& scene, double t_end_s, const std::vector<Instant<Wide>>& instants,
                           const std::vector<Event>& events, const std::vector<double>& apart_s,
                           const std::vector<std::vector<Wide>>& apart, double round_off);

}  // namespace atwood::dynamics
