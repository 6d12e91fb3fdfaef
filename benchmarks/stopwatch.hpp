// Times runs alternately, A B A B ..., one at a time, each by its own worker, pinned to a processor unless it has
// threads. Changes of the machine (clock rate, temperature, other load) then affect all of them equally.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/figures.hpp"
#include "validation/study/study.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {

struct Contender {
  const Worker* worker = nullptr;
  std::string method;
  const Scene* scene = nullptr;
  Plan plan;
  double expected_s = 0;  // of one run; 0: unknown
  // Of the run whose error is known; 0 or NaN: unknown. A timed run with another number is rejected.
  double evaluations = 0;
  int most_rounds = std::numeric_limits<int>::max();  // it takes part in the first so many
};

// A method that names its threads is not pinned: they would share one processor.
bool pinned(const std::string& method);

inline constexpr int kRounds = 15;  // in turns, where a figure needs an interval

class Stopwatch {
 public:
  explicit Stopwatch(double limit_s) : limit_s_(limit_s) {}
  void allow(double limit_s) { limit_s_ = limit_s; }
  // Median seconds of one run over repeats of about 2 ms in total; NaN where it failed. Taken again, at most twice,
  // where the worker had to wait for its processor; a run of 50 ms or more, which other programs interrupt on any
  // machine, is taken once, and counts as interrupted where it waited for more than a hundredth of its time. Throws
  // Interrupted.
  double seconds(const Contender& contender);
  // Times [s], rounds x contenders: every contender once per round, in order; NaN: it did not take part, or failed.
  std::vector<std::vector<double>> in_turns(const std::vector<Contender>& contenders, int rounds);
  MachineState take_machine() { return std::exchange(machine_, {}); }  // since the last call, or the start

 private:
  WorkerClient& client(const Contender& contender);
  double once(const Contender& contender);

  double limit_s_;
  MachineState machine_;
  std::map<std::pair<std::string, bool>, std::unique_ptr<WorkerClient>> clients_;  // by path and pinned or not
};

// Clock rate [GHz] of this thread's processor, by a chain of dependent multiplications and additions of four cycles.
double clock_rate_ghz();

// The median of the finite values; NaN where there are none.
double median_time(std::vector<double> seconds);

}  // namespace atwood
