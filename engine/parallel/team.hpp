// A team of threads that lives as long as a run. Work is divided into numbered parts, so results do not depend on which
// thread does a part.
#pragma once

#include <cstdint>
#include <memory>

namespace atwood {

// The calling thread is the first member; a team of one starts no thread. Idle threads spin for some microseconds, long
// enough for the next stage of a step, and then sleep. Each thread does its own parts first and then steals parts that
// are not yet begun, so a thread that is preempted delays the others by at most the part it is working on.
// run() allocates nothing. One caller at a time; parts must not throw.
class Team {
 public:
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int size() const { return size_; }

  // Calls work(part) for part = 0 .. parts - 1 (at most 65535), each once, on any thread; returns when all are done. A
  // thread's own parts are contiguous and the same in every call. Results must not depend on the thread.
  template <class Work> void run(int parts, const Work& work) {
    if (size_ == 1 || parts == 1) {
      for (int part = 0; part < parts; ++part) work(part);
      return;
    }
    share_out([](const void* w, int part) { (*static_cast<const Work*>(w))(part); }, &work, parts);
  }

  // One part for each thread. Below some ten microseconds of work starting the team costs more than it saves: with
  // `worth_it` false the caller does all parts in turn.
  template <class Work> void run(bool worth_it, const Work& work) {
    if (worth_it) return run(size(), work);
    for (int part = 0; part < size(); ++part) work(part);
  }

 private:
  struct Members;
  using Call = void (*)(const void* work, int part);
  void share_out(Call call, const void* work, int parts);

  int size_ = 1;
  std::unique_ptr<Members> members_;  // null: a team of one
};

// Part `part` of `parts` of the items 0 .. count - 1: contiguous, sizes that differ by at most one.
struct Share {
  int first, last;
};
constexpr Share share(int count, int part, int parts) {
  const auto bound = [=](int p) { return static_cast<int>(static_cast<std::int64_t>(count) * p / parts); };
  return {bound(part), bound(part + 1)};
}

}  // namespace atwood
