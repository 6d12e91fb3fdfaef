#include "threads.hpp"

namespace atwood {
namespace {

constexpr int spins = 4000;  // some 10 us to 50 us

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

Team::Team(int threads) {
  members_.reserve(threads > 1 ? threads - 1 : 0);
  for (int part = 1; part < threads; ++part) members_.emplace_back([this, part] { serve(part); });
}

Team::~Team() {
  closing_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& member : members_) member.join();
}

// call_ and work_ are written before round_ grows (release) and read after a member sees it (acquire); what the members wrote
// is seen by the caller through busy_.
void Team::share_out(Call call, const void* work) {
  call_ = call;
  work_ = work;
  busy_.store(static_cast<int>(members_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  call(work, 0);
  for (int n = 0; n < spins && busy_.load(std::memory_order_acquire) != 0; ++n) relax();
  for (int left = busy_.load(std::memory_order_acquire); left != 0; left = busy_.load(std::memory_order_acquire))
    busy_.wait(left, std::memory_order_acquire);
}

void Team::serve(int part) {
  std::uint32_t seen = 0;
  for (;;) {
    for (int n = 0; n < spins && round_.load(std::memory_order_acquire) == seen; ++n) relax();
    round_.wait(seen, std::memory_order_acquire);
    ++seen;
    if (closing_.load(std::memory_order_relaxed)) return;
    call_(work_, part);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_one();
  }
}

}  // namespace atwood
