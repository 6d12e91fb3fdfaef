// Progress of a study and the estimated remaining time: at most two lines per second.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>

namespace atwood {

class Progress {
 public:
  using Clock = std::chrono::steady_clock;
  Progress(std::size_t total, std::function<void(const std::string&)> print,
           std::function<Clock::time_point()> now = Clock::now)
      : total_(total), print_(std::move(print)), now_(std::move(now)) {}

  // Sets the number of pieces, truths included. May be called again with other numbers.
  void expect(std::size_t total, std::size_t truths);
  void done(const std::string& what);  // one piece of work; `what` is the phase it belongs to, "truth" for truths

 private:
  double seconds_left(double since_start_s, double since_truths_s) const;

  std::mutex mutex_;
  std::size_t total_, truths_ = 0, done_ = 0, truths_done_ = 0;
  std::function<void(const std::string&)> print_;
  std::function<Clock::time_point()> now_;
  Clock::time_point start_ = now_(), truth_end_ = start_, printed_ = start_;
};

}  // namespace atwood
