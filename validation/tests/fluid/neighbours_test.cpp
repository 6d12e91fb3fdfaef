// Neighbour lists against all pairs: periodic and open, two and three dimensions, moving points, threads.
#include "fluid/neighbours.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "scene/split_mix.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

std::vector<double> random_points(int count, int dimensions, double size, std::uint64_t seed) {
  SplitMix64 random{seed};
  std::vector<double> x;
  for (int i = 0; i < count * dimensions; ++i) x.push_back(size * random.next_unit());
  return x;
}

// The points within `reach` of point i, by the nearest image.
std::vector<int> near(const Domain& domain, const std::vector<double>& x, int i, double reach) {
  const int d = domain.dimensions, count = static_cast<int>(x.size()) / d;
  std::vector<int> found;
  for (int j = 0; j < count; ++j) {
    double r2 = 0;
    for (int axis = 0; axis < d; ++axis) {
      const double period = domain.periodic_m[axis];
      double dx = x[i * d + axis] - x[j * d + axis];
      if (period > 0) dx -= period * std::round(dx / period);
      r2 += dx * dx;
    }
    if (j != i && r2 <= reach * reach) found.push_back(j);
  }
  return found;
}

std::vector<int> listed(const Neighbours<double>& lists, int point) {
  const int slot = lists.slot_of()[point];
  const NeighbourBlock block = lists.block(slot / kLaneCount);
  std::vector<int> points;
  for (int n = 0; n < block.longest; ++n) {
    const int entry = block.entries[n * kLaneCount + slot % kLaneCount];
    if (n < block.counts[slot % kLaneCount]) points.push_back(lists.order()[entry]);
    else CHECK(entry == slot);
  }
  return points;
}

void check_lists(const Domain& domain, std::vector<double> x, double support, double skin, Team* team) {
  Neighbours<double> lists(domain, support, skin);
  const int count = static_cast<int>(x.size()) / domain.dimensions;
  SplitMix64 random{7};
  for (int round = 0; round < 3; ++round) {
    REQUIRE(lists.update(x.data(), count, team));
    for (int i = 0; i < count; ++i) {
      const std::vector<int> points = listed(lists, i), needed = near(domain, x, i, support);
      REQUIRE(std::is_sorted(points.begin(), points.end()));
      REQUIRE(std::adjacent_find(points.begin(), points.end()) == points.end());
      REQUIRE(std::includes(points.begin(), points.end(), needed.begin(), needed.end()));
      const std::vector<int> allowed = near(domain, x, i, support + 2 * skin);
      REQUIRE(std::includes(allowed.begin(), allowed.end(), points.begin(), points.end()));
    }
    for (double& coordinate : x) coordinate += (round == 1 ? 3.0 : 0.3) * skin * (random.next_unit() - 0.5);
  }
  CHECK(lists.builds() >= 2);
}

std::vector<int> listed_of_block(const Neighbours<double>& lists, int b) {
  const NeighbourBlock block = lists.block(b);
  std::vector<int> points;
  for (int n = 0; n < block.longest; ++n) points.push_back(lists.order()[block.entries[n]]);
  return points;
}

// A block's list: of each point its own and all within the support, and no point that is far from all of them.
void check_lists_of_blocks(const Domain& domain, std::vector<double> x, double support, double skin, Team* team) {
  const int count = static_cast<int>(x.size()) / domain.dimensions;
  Neighbours<double> lists(domain, support, skin, 0.4 * support);
  SplitMix64 random{7};
  for (int round = 0; round < 3; ++round) {
    REQUIRE(lists.update(x.data(), count, team));
    for (int b = 0; b < lists.blocks(); ++b) {
      const std::vector<int> points = listed_of_block(lists, b);
      REQUIRE(std::is_sorted(points.begin(), points.end()));
      REQUIRE(std::adjacent_find(points.begin(), points.end()) == points.end());
      std::vector<int> allowed;
      for (int slot = b * kLaneCount; slot < std::min((b + 1) * kLaneCount, count); ++slot) {
        const int i = lists.order()[slot];
        const std::vector<int> needed = near(domain, x, i, support), wide = near(domain, x, i, support + 2 * skin);
        REQUIRE(std::binary_search(points.begin(), points.end(), i));
        REQUIRE(std::includes(points.begin(), points.end(), needed.begin(), needed.end()));
        allowed.push_back(i);
        allowed.insert(allowed.end(), wide.begin(), wide.end());
      }
      std::sort(allowed.begin(), allowed.end());
      REQUIRE(std::includes(allowed.begin(), allowed.end(), points.begin(), points.end()));
    }
    for (double& coordinate : x) coordinate += (round == 1 ? 3.0 : 0.3) * skin * (random.next_unit() - 0.5);
  }
  CHECK(lists.builds() >= 2);
}

}  // namespace

TEST_CASE("lists of blocks hold all pairs within the support, in the order of the points") {
  Team team(3);
  Team* const none = nullptr;
  for (Team* members : {none, &team})
    for (const int d : {2, 3}) {
      const std::vector<double> x = random_points(d == 2 ? 2101 : 2013, d, 1, 5);
      check_lists_of_blocks({d, {}}, x, 0.1, 0.02, members);
      check_lists_of_blocks({d, {1, 1, d == 3 ? 1.0 : 0.0}}, x, 0.1, 0.02, members);
      check_lists_of_blocks({d, {1, 0, 0}}, x, 0.13, 0.02, members);
    }
  for (const double support : {0.3, 0.45, 0.5})
    check_lists_of_blocks({2, {1, 1, 0}}, random_points(60, 2, 1, 9), support, 0.05, none);
}

TEST_CASE("lists hold all pairs within the support, in the order of the points") {
  Team team(3);
  Team* const none = nullptr;
  for (Team* members : {none, &team})
    for (const int d : {2, 3}) {
      const std::vector<double> x = random_points(d == 2 ? 2100 : 2010, d, 1, 5);
      check_lists({d, {}}, x, 0.1, 0.02, members);
      check_lists({d, {1, 1, d == 3 ? 1.0 : 0.0}}, x, 0.1, 0.02, members);
      check_lists({d, {1, 0, 0}}, x, 0.13, 0.02, members);
    }
  for (const double support : {0.3, 0.45, 0.5})
    check_lists({2, {1, 1, 0}}, random_points(60, 2, 1, 9), support, 0.05, none);
}

TEST_CASE("any number of threads builds the same lists") {
  Team two(2), five(5);
  for (const int d : {2, 3})
    for (const double period : {0.0, 1.0})
      for (const double support : {0.04, 0.11, 0.2}) {
        const Domain domain{d, {period, period, d == 3 ? period : 0.0}};
        const std::vector<double> x = random_points(3000, d, 1, 11);
        Neighbours<double> alone(domain, support, 0.02), shared(domain, support, 0.02);
        Neighbours<double> alone_of_blocks(domain, support, 0.02, 0.05), shared_of_blocks(domain, support, 0.02, 0.05);
        REQUIRE(alone.update(x.data(), 3000, nullptr));
        REQUIRE(alone_of_blocks.update(x.data(), 3000, nullptr));
        for (Team* team : {&two, &five}) {
          shared.forget();
          REQUIRE(shared.update(x.data(), 3000, team));
          REQUIRE(shared.order() == alone.order());
          for (int i = 0; i < 3000; ++i) REQUIRE(listed(shared, i) == listed(alone, i));
          shared_of_blocks.forget();
          REQUIRE(shared_of_blocks.update(x.data(), 3000, team));
          REQUIRE(shared_of_blocks.order() == alone_of_blocks.order());
          for (int b = 0; b < alone_of_blocks.blocks(); ++b)
            REQUIRE(listed_of_block(shared_of_blocks, b) == listed_of_block(alone_of_blocks, b));
        }
      }
}

TEST_CASE("points outside the period, and points far away from all others, keep their pairs") {
  std::vector<double> x = random_points(300, 2, 1, 3);
  for (std::size_t i = 0; i < x.size(); i += 7) x[i] += 5 - static_cast<double>(i % 11);
  check_lists({2, {1, 1, 0}}, x, 0.2, 0.03, nullptr);
  x[0] = 1e9;
  check_lists({2, {0, 1, 0}}, x, 0.2, 0.03, nullptr);
  check_lists({3, {}}, {1, 2, 3}, 0.2, 0.03, nullptr);
  check_lists({3, {}}, {1, 2, 3, 1, 2, 3.1, 1, 2, 3}, 0.2, 0.03, nullptr);
}

TEST_CASE("lists are built when points have moved by half the skin, and refuse what is not finite") {
  std::vector<double> x = random_points(200, 2, 1, 4);
  Neighbours<double> lists({2, {1, 1, 0}}, 0.1, 0.02);
  REQUIRE(lists.update(x.data(), 200, nullptr));
  for (double& coordinate : x) coordinate += 0.0070;
  REQUIRE(lists.update(x.data(), 200, nullptr));
  CHECK(lists.builds() == 1);
  x[17] += 0.004;
  REQUIRE(lists.update(x.data(), 200, nullptr));
  CHECK(lists.builds() == 2);
  x[18] = std::nan("");
  CHECK_FALSE(lists.update(x.data(), 200, nullptr));
  CHECK(lists.builds() == 2);
}
