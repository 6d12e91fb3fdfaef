#include <chrono>
#include <new>

#include "validation/study/confinement.hpp"
#include "validation/study/descendants.hpp"

namespace atwood {
namespace {

constexpr std::chrono::milliseconds kOfWorker{50};        // between two looks at the worker alone
constexpr std::chrono::milliseconds kOfDescendants{200};  // ... at all processes of the machine
constexpr int kLookShare = 50;                            // looking takes at most one part of this of the time

}  // namespace

MemoryWatch::MemoryWatch(pid_t worker, std::string mark, std::int64_t most_bytes)
    : worker_(worker), mark_(std::move(mark)), most_bytes_(most_bytes) {
  if (most_bytes_ > 0) thread_ = std::thread([this] { watch(); });
}

void MemoryWatch::end() {
  {
    const std::lock_guard<std::mutex> held(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void MemoryWatch::watch() {
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_of_all = Clock::now() + kOfDescendants;
  std::unique_lock<std::mutex> held(mutex_);
  while (!changed_.wait_for(held, kOfWorker, [this] { return stop_; })) {
    held.unlock();
    bool above = false;
    try {
      above = resident_bytes(worker_) > most_bytes_;
      if (const auto begun = Clock::now(); above || begun >= next_of_all) {
        above = family_bytes(worker_, mark_, most_bytes_) > most_bytes_;
        const auto end = Clock::now();
        next_of_all = end + std::max<Clock::duration>(kOfDescendants, kLookShare * (end - begun));
      }
      if (above) {
        exceeded_ = true;
        kill_family(worker_, mark_);
      }
    } catch (const std::bad_alloc&) {
      above = false;  // of this program: it looks again
    }
    held.lock();
    if (above) return;
  }
}

}  // namespace atwood
