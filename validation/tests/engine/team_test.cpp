// The team of threads by itself. Its program is linked without the engine, so that a build with the thread sanitizer
// takes seconds: parts write plain memory that the caller and the parts of the next round read.
#include "parallel/team.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

namespace atwood {
namespace {

using Counts = std::vector<std::int64_t>;

// Each part adds what its neighbour wrote in the round before: a part that is left out, done twice or not seen by the
// others changes all rounds after it.
Counts after_rounds(int threads, int rounds) {
  Team team(threads);
  Counts before(61, 1), now(61);
  for (int round = 0; round < rounds; ++round) {
    const int parts = 1 + round * 7 % 61;
    now = before;
    team.run(parts, [&](int part) {
      const std::size_t i = static_cast<std::size_t>(part);
      now[i] = (before[i] + before[(i + 1) % before.size()] + round) % 1000003;
    });
    before.swap(now);
  }
  return before;
}

}  // namespace

TEST_CASE("every part is done once and seen by all, whatever the number of threads") {
  const Counts alone = after_rounds(1, 2000);
  for (const int threads : {2, 3, 8}) {
    CAPTURE(threads);
    CHECK(after_rounds(threads, 2000) == alone);
  }
}

TEST_CASE("a thread that is held up delays the others by the part it is working on alone") {
  Team team(2);
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> done{0};
    const auto work =
        [&](int part) {  // 0 to 3 are the caller's own; the first waits until the other thread did the rest
          while (part == 0 && done.load() < 7) std::this_thread::yield();
          done.fetch_add(1);
        };
    team.run(8, work);
    REQUIRE(done.load() == 8);
  }
}

TEST_CASE("a team that never works, or whose members sleep between rounds, ends") {
  for (int i = 0; i < 50; ++i) Team team(4);
  Team team(4);
  std::vector<int> parts(4);
  std::atomic<std::int64_t> sum{0};
  for (int round = 0; round < 5; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // longer than idle threads spin
    team.run(true, [&](int part) { ++parts[static_cast<std::size_t>(part)]; });
    sum += std::accumulate(parts.begin(), parts.end(), 0);
  }
  CHECK(sum == 4 * (1 + 2 + 3 + 4 + 5));
}

}  // namespace atwood
