// The settings of the response "+impulse".
#pragma once

#include <string>

#include "collision/broad_phase.hpp"
#include "contact/impulse.hpp"
#include "protocol/method.hpp"

namespace atwood::stepping {

enum class Solver : unsigned char { automatic, sequential, direct };

struct Options {
  // sequential impulses, or Newton on all contacts of an island at once (automatic: few)
  Solver solver = Solver::automatic;
  int direct_points = 64;  // the most points that an island solved directly has
  int substeps = 0;        // 0: four or more, none longer than 1/480 s
  int iterations = 2;      // sweeps of the velocities in a substep
  // ... up to, where nothing moves faster than a substep's fall: few are needed once it stands
  int rest_sweeps = 1000;
  bool push_apart = true;   // overlap is taken away, in the positions alone
  double correction = 0.3;  // ... this share of it in a substep
  BroadPhaseKind broad_phase = BroadPhaseKind::tree;
  Restitution restitution = Restitution::newton;
  bool warm_start = true;
  int threads = 1;
  bool sleeping = false;              // islands at rest stand still, unsolved, until somebody comes (sleep.cpp)
  double sleep_after_s = 0.5;         // ... at rest for so long
  double sleep_below_m_per_s = 0.05;  // ... every point of theirs slower than this
};

std::vector<Setting> setting_table();
int substeps_of(const Options& options, double h_s);
Options options_of(const Settings& settings);  // of settings that were checked against the table

}  // namespace atwood::stepping
