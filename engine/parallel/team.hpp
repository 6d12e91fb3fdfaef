// A team of threads that lives as long as a run: work is handed out in numbered parts, so what is computed never
// depends on who does it.
#pragma once

#include <cstdint>
#include <memory>

namespace atwood {

// The caller is the first of the team; a team of one starts no thread. Idle members spin for some microseconds, enough
// for the next stage of a step, and then sleep. Every member has parts of his own, and takes those that nobody has
// begun when his are done: one without a core delays the others by the part that he is at, by nothing if he is at none.
// run() allocates nothing. One caller at a time; parts do not throw.
class Team {
 public:
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int size() const { return size_; }

  // work(part) for part = 0 .. parts - 1 (at most 65535), each once, by whoever comes to it; returns when all are done.
  // Neighbouring parts are a member's own, the same in every call. Results must not depend on who does what.
  template <class Work> void run(int parts, const Work& work) {
    if (size_ == 1 || parts == 1) {
      for (int part = 0; part < parts; ++part) work(part);
      return;
    }
    share_out([](const void* w, int part) { (*static_cast<const Work*>(w))(part); }, &work, parts);
  }

  // A part a member. Below some ten microseconds of work the team costs more than it brings: then call it with
  // `worth_it` false, and the caller does all parts in turn.
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
