// A team of threads that lives as long as a run: work is handed out in parts fixed by their number, so what is computed never
// depends on who is quick.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace atwood {

// The caller is the first of the team; a team of one starts no thread. Idle members spin for some microseconds, enough for the
// next stage of a step, and then sleep. run() allocates nothing. One caller at a time; parts do not throw.
class Team {
 public:
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int size() const { return static_cast<int>(members_.size()) + 1; }

  // Below some ten microseconds of work the team costs more than it brings: then call it with `worth_it` false, and the caller
  // does all parts in turn. Results must not depend on who does what.
  //
  // work(part) for part = 0 .. size() - 1, each on its own thread; returns when all are done.
  template <class Work> void run(bool worth_it, const Work& work) {
    if (members_.empty() || !worth_it) {
      for (int part = 0; part < size(); ++part) work(part);
      return;
    }
    share_out([](const void* w, int part) { (*static_cast<const Work*>(w))(part); }, &work);
  }

 private:
  using Call = void (*)(const void* work, int part);
  void share_out(Call call, const void* work);
  void serve(int part);

  Call call_ = nullptr;
  const void* work_ = nullptr;
  std::atomic<std::uint32_t> round_{0};  // grows by one for each run(); members wait for it to change
  std::atomic<int> busy_{0};
  std::atomic<bool> closing_{false};
  std::vector<std::thread> members_;
};

// Part `part` of `parts` of the items 0 .. count - 1: contiguous, sizes that differ by at most one.
struct Share { int first, last; };
constexpr Share share(int count, int part, int parts) {
  const auto bound = [=](int p) { return static_cast<int>(static_cast<std::int64_t>(count) * p / parts); };
  return {bound(part), bound(part + 1)};
}

}  // namespace atwood
