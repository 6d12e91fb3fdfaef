#include "validation/study/progress.hpp"

#include <algorithm>
#include <cmath>

namespace atwood {

void Progress::expect(std::size_t total) {
  const std::lock_guard<std::mutex> held(mutex_);
  total_ = total;
}

void Progress::done(const std::string& what) {
  const std::lock_guard<std::mutex> held(mutex_);
  ++done_;
  if (!print_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - printed_ < std::chrono::milliseconds(500)) return;
  printed_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const double left_s = elapsed_s * static_cast<double>(total_ - std::min(done_, total_)) / static_cast<double>(done_);
  std::string line = what + ": " + std::to_string(done_) + " of " + std::to_string(total_) + ", " +
                     std::to_string(std::lround(elapsed_s)) + " s";
  // The first pieces are truths, each as long as many cells: they foretell nothing.
  if (done_ * 20 >= total_) line += ", about " + std::to_string(std::lround(left_s)) + " s left";
  print_(line);
}

}  // namespace atwood
