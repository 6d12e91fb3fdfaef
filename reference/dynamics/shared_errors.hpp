// Errors that all runs of one scene have in common, so that their differences do not show them: the location of
// impacts, round-off, and the neglected bounces of a series. Each is propagated along the motion, through every impact.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/certified_end.hpp"
#include "dynamics/instants.hpp"
#include "protocol/ragged_array.hpp"
#include "protocol/sample.hpp"

namespace atwood::dynamics {

struct SharedErrors {
  std::vector<std::vector<Wide>> samples;  // [sample][component of y]: half-width
  std::vector<double> events_s;            // [event]: half-width of its time
  std::optional<CertifiedEnd> end;         // empty: the whole run is certified
};

// `instants` begin with sample 0. `run_difference_s` [event] and `run_difference` [sample][component of y] are the
// half-widths that follow from the differences between the runs. `round_off` is the relative error of one operation.
//
// The certified part ends where an outcome is not decided within the half-widths: when contacts that act on each other
// are struck closer in time than their half-widths, or when a grazing impact cannot be distinguished from a passage
// without contact. The half-width of a velocity at a sample within the half-width of an impact's time is the velocity
// jump of this impact.
SharedErrors shared_errors(const Scene& scene, double t_end_s, const std::vector<Instant<Wide>>& instants,
                           const std::vector<Event>& events, const std::vector<double>& run_difference_s,
                           const RaggedArray<Wide>& run_difference, double round_off);

}  // namespace atwood::dynamics
