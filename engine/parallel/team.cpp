#include "parallel/team.hpp"

#include <atomic>
#include <thread>
#include <vector>

namespace atwood {
namespace {

constexpr int kSpins = 4000;  // some 10 us to 100 us

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

constexpr std::uint64_t ticket_of(std::uint32_t round, int next, int end) {
  return std::uint64_t(round) << 32 | std::uint64_t(next) << 16 | std::uint64_t(end);
}
constexpr int next_of(std::uint64_t ticket) { return static_cast<int>(ticket >> 16 & 0xffff); }
constexpr int end_of(std::uint64_t ticket) { return static_cast<int>(ticket & 0xffff); }

}  // namespace

struct Team::Members {
  explicit Members(int threads);
  ~Members();
  void end();

  // A member's parts of the present round that are not begun: the round, the next part and the end, in one word.
  struct alignas(64) Queue {
    std::atomic<std::uint64_t> ticket{0};
  };
  void share_out(Call call, const void* work, int parts);
  void run_member(int member);
  int do_parts(int member);
  bool claim(int owner, int& part);

  int size;
  Call call_ = nullptr;
  const void* work_ = nullptr;
  std::unique_ptr<Queue[]> queues_;                  // one a member
  alignas(64) std::atomic<std::uint32_t> round_{0};  // grows by one for each run(); members wait for it to change
  alignas(64) std::atomic<int> left_{0};             // parts of the round that are not done
  std::atomic<bool> stopping_{false};
  std::vector<std::thread> threads_;
};

Team::Members::Members(int threads)
    : size(threads), queues_(std::make_unique<Queue[]>(static_cast<std::size_t>(threads))) {
  threads_.reserve(threads - 1);
  try {
    for (int member = 1; member < threads; ++member) threads_.emplace_back([this, member] { run_member(member); });
  } catch (...) {  // a thread that is destroyed unjoined ends the program
    end();
    throw;
  }
}

Team::Members::~Members() { end(); }

void Team::Members::end() {
  stopping_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& other : threads_) other.join();
}

// call_ and work_ are written before the tickets (release) and read after one is claimed (acquire); they stay until its
// part is done. The members' writes reach the caller through left_. A ticket of an earlier round cannot be
// claimed: its queue was empty when that round ended, and its word never comes back.
void Team::Members::share_out(Call call, const void* work, int parts) {
  call_ = call;
  work_ = work;
  left_.store(parts, std::memory_order_relaxed);
  const std::uint32_t round = round_.load(std::memory_order_relaxed) + 1;
  for (int member = 0; member < size; ++member) {
    const Share own = share(parts, member, size);
    queues_[member].ticket.store(ticket_of(round, own.first, own.last), std::memory_order_release);
  }
  round_.store(round, std::memory_order_release);
  round_.notify_all();
  int left = left_.fetch_sub(do_parts(0), std::memory_order_acq_rel);
  for (int n = 0; n < kSpins && (left = left_.load(std::memory_order_acquire)) != 0; ++n) pause();
  for (; left != 0; left = left_.load(std::memory_order_acquire)) left_.wait(left, std::memory_order_acquire);
}

bool Team::Members::claim(int owner, int& part) {
  std::atomic<std::uint64_t>& ticket = queues_[owner].ticket;
  std::uint64_t seen = ticket.load(std::memory_order_acquire);
  while (next_of(seen) < end_of(seen)) {
    if (!ticket.compare_exchange_weak(seen, seen + (std::uint64_t(1) << 16), std::memory_order_acq_rel)) continue;
    part = next_of(seen);
    return true;
  }
  return false;
}

// The member's own parts first, then those of the others; returns how many it did.
int Team::Members::do_parts(int member) {
  int done = 0;
  for (int i = 0; i < size; ++i) {
    const int owner = (member + i) % size;
    for (int part; claim(owner, part); ++done) call_(work_, part);
  }
  return done;
}

void Team::Members::run_member(int member) {
  std::uint32_t seen = 0;
  for (;;) {
    for (int n = 0; n < kSpins && round_.load(std::memory_order_acquire) == seen; ++n) pause();
    round_.wait(seen, std::memory_order_acquire);
    seen = round_.load(std::memory_order_acquire);
    if (stopping_.load(std::memory_order_relaxed)) return;
    const int done = do_parts(member);
    if (done > 0 && left_.fetch_sub(done, std::memory_order_acq_rel) == done) left_.notify_one();
  }
}

Team::Team(int threads)
    : size_(threads > 1 ? threads : 1), members_(size_ > 1 ? std::make_unique<Members>(size_) : nullptr) {}
Team::~Team() = default;

void Team::share_out(Call call, const void* work, int parts) { members_->share_out(call, work, parts); }

}  // namespace atwood
