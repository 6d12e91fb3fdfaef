// The largest settled heap that each engine steps within a frame of 16.7 ms and of 40 ms.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/figures.hpp"
#include "validation/study/study.hpp"

namespace atwood {

struct FrameBudgetSetup {
  const std::vector<Worker>& workers;
  std::vector<std::string> methods;  // empty: ours with one and with two threads, other engines with their defaults
  Scene spheres, boxes;              // patterns of the heaps: the bin and one kind of body each
  double limit_s = 20;               // of one run
  std::function<void(const std::string&)> notice = [](const std::string&) {};
};

// The table `frame-budget`, and `phase-shares` where an engine reports the phases of its steps. Interrupted by a
// signal: the rows measured until then. InputError: a method of no available engine, or a wrong setting.
struct FrameBudgetTables {
  std::vector<BenchTable> tables;
  bool interrupted = false;
  bool failed = false;  // an engine crashed, or sent an invalid answer
};
FrameBudgetTables measure_frame_budget(const FrameBudgetSetup& setup);

}  // namespace atwood
