// The settings of the response "+impulse".
#pragma once

#include <string>

#include "collision/broad_phase.hpp"
#include "contact/impulse.hpp"
#include "protocol/method.hpp"

namespace atwood::stepping {

enum class Solver : unsigned char { automatic, sequential, direct };

struct Options {
  // sequential: sweeps of projected Gauss-Seidel (sequential impulses); direct: Newton's method on all contacts of an
  // island at once; automatic: direct where the contacts are few
  Solver solver = Solver::automatic;
  int direct_points = 64;   // 1 to 1000: an island with more contact points is not solved directly
  int substeps = 0;         // of a step, up to 1000; 0: at least four, and none longer than 1/480 s
  int iterations = 2;       // sweeps in a substep
  int rest_sweeps = 1000;   // limit of the sweeps of a substep at rest (step.cpp, is_at_rest())
  double correction = 0.3;  // position correction: share of the overlap removed in a substep, 0 to 1; 0: none
  BroadPhaseKind broad_phase = BroadPhaseKind::tree;
  Restitution restitution = Restitution::newton;
  bool warm_start = true;  // the solvers start from the impulses of the last substep
  int threads = 1;
  bool sleeping = false;              // islands at rest are treated as fixed (sleep.cpp)
  double sleep_after_s = 0.5;         // ... once they have been at rest for so long
  double sleep_below_m_per_s = 0.05;  // ... with every surface point slower than this
};

// The settings of +impulse: name, default, range and meaning.
std::vector<Setting> setting_table();
// Number of substeps of a step of h_s.
int substeps_of(const Options& options, double h_s);
// From settings that were checked against the table.
Options options_of(const Settings& settings);

}  // namespace atwood::stepping
