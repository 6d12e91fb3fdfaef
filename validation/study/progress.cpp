#include "validation/study/progress.hpp"

#include <algorithm>
#include <cmath>

namespace atwood {

void Progress::expect(std::size_t total, std::size_t truths) {
  const std::lock_guard<std::mutex> held(mutex_);
  total_ = total;
  truths_ = truths;
}

// Truths come first, and each takes as long as many cells. The remaining truths are assumed to take as long as the mean
// of those done, and the other pieces as long as the mean of those done since the last truth. Before the first of these
// no estimate is possible.
double Progress::seconds_left(double since_start_s, double since_truths_s) const {
  const std::size_t cells = done_ - truths_done_, all_cells = total_ - std::min(truths_, total_);
  const auto left = [](std::size_t all, std::size_t some) { return static_cast<double>(all - std::min(some, all)); };
  double seconds = 0;
  if (truths_done_ > 0)
    seconds += (since_start_s - since_truths_s) / static_cast<double>(truths_done_) * left(truths_, truths_done_);
  if (cells > 0) seconds += since_truths_s / static_cast<double>(cells) * left(all_cells, cells);
  return seconds;
}

void Progress::done(const std::string& what) {
  const std::lock_guard<std::mutex> held(mutex_);
  const auto now = now_();
  ++done_;
  if (what == "truth") {
    ++truths_done_;
    truth_end_ = now;
  }
  if (!print_ || now - printed_ < std::chrono::milliseconds(500)) return;
  printed_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const double left_s = seconds_left(elapsed_s, std::chrono::duration<double>(now - truth_end_).count());
  const bool truths_alone = done_ == truths_done_ && total_ > truths_;
  print_(what + ": " + std::to_string(done_) + " of " + std::to_string(total_) + ", " +
         std::to_string(std::lround(elapsed_s)) + " s, about " + std::to_string(std::lround(left_s)) + " s left" +
         (truths_alone ? " for the truths" : ""));
}

}  // namespace atwood
