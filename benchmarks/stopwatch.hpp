// Runs timed in turns: A B A B ..., each by its own worker, pinned unless it has threads, one at a time. What drifts on
// the machine (clock rate, temperature, other load) then affects all of them alike.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "validation/study/study.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {

struct Contender {
  const Worker* worker = nullptr;
  std::string method;
  const Scene* scene = nullptr;
  Plan plan;
  double expected_s = 0;  // of one run; 0: unknown
  double evaluations =
      0;  // of the run whose error is known; 0 or NaN: unknown. A timed run that did other work times another run
};

// A method that names its threads is not pinned: they would share one processor.
bool pinned(const std::string& method);

inline constexpr int kRounds = 15;  // in turns, where a figure needs an interval

class Stopwatch {
 public:
  explicit Stopwatch(double limit_s) : limit_s_(limit_s) {}
  void allow(double limit_s) { limit_s_ = limit_s; }
  // Median seconds of one run over a burst of repeats (about 2 ms of them); NaN when it failed. Throws Interrupted.
  double seconds(const Contender& contender);
  // rounds x contenders: every contender once a round, in order.
  std::vector<std::vector<double>> in_turns(const std::vector<Contender>& contenders, int rounds);

 private:
  WorkerClient& client(const Contender& contender);

  double limit_s_;
  std::map<std::pair<std::string, bool>, std::unique_ptr<WorkerClient>> clients_;  // by path and pinned or not
};

// The median of the finite ones; NaN when there are none.
double median_time(std::vector<double> seconds);

}  // namespace atwood
