// Seven broad phases find the same pairs: on random clouds, moving heaps and degenerate scenes.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "collision/broad_kinds.hpp"
#include "scene/split_mix.hpp"
#include "validation/tests/engine/counted_allocations.hpp"

using namespace atwood;

namespace {

template <class S> using Cloud = std::vector<BroadItem<S>>;

struct Random {
  SplitMix64 bits{1};
  double operator()(double low, double high) { return low + (high - low) * bits.next_unit(); }
};

template <class S> BroadItem<S> ball(double x, double y, double z, double radius) {
  const Vec3<S> c{S(x), S(y), S(z)}, r{S(radius), S(radius), S(radius)};
  return {{c - r, c + r}, c, S(radius), true};
}

// A box around one corner of the bounding box of its sphere, as a rotated rectangle or rod has it.
template <class S> BroadItem<S> brick(double x, double y, double z, double a, double b, double c) {
  BroadItem<S> item;
  item.center = {S(x), S(y), S(z)};
  const Vec3<S> half{S(a), S(b), S(c)};
  item.box = {item.center - half, item.center + half};
  item.radius = S(std::sqrt(a * a + b * b + c * c));
  return item;
}

// The definition, written independently: overlap of intervals on three axes, and of spheres.
template <class S> std::vector<BodyPair> true_pairs(const Cloud<S>& items) {
  std::vector<BodyPair> pairs;
  for (int i = 0; i < int(items.size()); ++i) {
    for (int j = i + 1; j < int(items.size()); ++j) {
      const auto &a = items[i], &b = items[j];
      if (!a.moves && !b.moves) continue;
      const auto meet = [](S low_a, S high_a, S low_b, S high_b) { return !(low_a > high_b) && !(low_b > high_a); };
      const bool number = [&] {
        S sum = a.box.low.x + a.box.low.y + a.box.low.z + b.box.low.x + b.box.low.y + b.box.low.z;
        return sum == sum;
      }();
      if (!number || !meet(a.box.low.x, a.box.high.x, b.box.low.x, b.box.high.x) ||
          !meet(a.box.low.y, a.box.high.y, b.box.low.y, b.box.high.y) ||
          !meet(a.box.low.z, a.box.high.z, b.box.low.z, b.box.high.z))
        continue;
      const S dx = b.center.x - a.center.x, dy = b.center.y - a.center.y, dz = b.center.z - a.center.z;
      if (dx * dx + dy * dy + dz * dz <= (a.radius + b.radius) * (a.radius + b.radius)) pairs.push_back({i, j});
    }
  }
  return pairs;
}

template <class S> Cloud<S> uniform(int n, double side, double radius, std::uint64_t seed) {
  Random random{{seed}};
  Cloud<S> cloud;
  for (int i = 0; i < n; ++i)
    cloud.push_back(ball<S>(random(0, side), random(0, side), random(0, side), radius * random(0.5, 1.5)));
  return cloud;
}

template <class S> struct Named {
  const char* name;
  Cloud<S> cloud;
};

template <class S> std::vector<Named<S>> clouds() {
  std::vector<Named<S>> all;
  Random random{{5}};
  all.push_back({"no bodies", {}});
  all.push_back({"one", {ball<S>(1, 2, 3, 1)}});
  all.push_back({"a dense cloud", uniform<S>(600, 10, 0.6, 1)});
  all.push_back({"a thin cloud", uniform<S>(600, 100, 0.6, 2)});
  auto giant = uniform<S>(400, 10, 0.3, 3);
  giant.insert(giant.begin() + 200, ball<S>(5, 5, 5, 7));
  all.push_back({"a giant among small ones", giant});
  Cloud<S> sizes, line, row, same, points, slabs, far, fixed, table;
  for (int i = 0; i < 400; ++i)
    sizes.push_back(ball<S>(random(0, 10), random(0, 10), random(0, 10), std::pow(10.0, random(-6, 0.5))));
  for (int i = 0; i < 400; ++i) line.push_back(ball<S>(i, 0, 0, 0.5));  // each touches the next exactly
  for (int i = 0; i < 400; ++i) row.push_back(ball<S>(0, i * 1e-3, 7, 0.5));
  for (int i = 0; i < 60; ++i) same.push_back(ball<S>(1, 1, 1, 0.25));
  for (int i = 0; i < 300; ++i)
    points.push_back(ball<S>(std::floor(random(0, 6)), std::floor(random(0, 6)), std::floor(random(0, 6)), 0));
  for (int i = 0; i < 300; ++i)
    slabs.push_back(brick<S>(random(0, 10), random(0, 10), random(0, 10), random(0, 5), random(0, 0.01),
                             i % 3 == 0 ? 0 : random(0, 5)));
  for (int i = 0; i < 300; ++i)
    far.push_back(ball<S>(1e9 + 64 * std::floor(random(0, 9)), -1e9 + 64 * std::floor(random(0, 9)),
                          64 * std::floor(random(0, 9)), i % 2 ? 64 : 0));
  far.push_back(ball<S>(0, 0, 0, 1e-9));
  far.push_back(ball<S>(1e-9, 0, 0, 1e-9));
  for (int i = 0; i < 300; ++i) {
    fixed.push_back(ball<S>(random(0, 5), random(0, 5), random(0, 5), 0.5));
    fixed.back().moves = i % 3 == 0;
  }
  for (int i = 0; i < 300; ++i)
    table.push_back(ball<S>(i < 200 ? 0 : random(0, 50), random(0, 50), random(0, 50), 0.7));  // most begin at one x
  all.push_back({"all sizes", sizes});
  all.push_back({"all in a line, touching", line});
  all.push_back({"all in a line, on top of each other", row});
  all.push_back({"all coincident", same});
  all.push_back({"points on a lattice", points});
  all.push_back({"slabs and needles", slabs});
  all.push_back({"at 1e9 m, beside 1e-9 m", far});
  all.push_back({"two of three fixed", fixed});
  all.push_back({"most begin in one plane", table});
  Cloud<S> broken = uniform<S>(60, 4, 0.5, 9);
  constexpr S none = std::numeric_limits<S>::quiet_NaN(), endless = std::numeric_limits<S>::infinity();
  broken[10].box.low.x = broken[10].box.high.x = broken[10].center.x = none;
  broken[20] = {{{none, none, none}, {none, none, none}}, {none, none, none}, none, true};
  broken[30].box = {{-endless, -endless, S(1)}, {endless, endless, S(2)}};
  broken[30].radius = endless;
  all.push_back({"not a number, and without end", broken});
  return all;
}

template <class S> void every_kind_agrees(Team* team) {
  for (const auto& [name, cloud] : clouds<S>()) {
    const auto right = true_pairs(cloud);
    for (int kind = 0; kind < int(broad_phase_names().size()); ++kind) {
      INFO(name << ", " << broad_phase_names()[kind]);
      const auto phase = make_broad_phase<S>(BroadPhaseKind(kind), team);
      std::vector<BodyPair> pairs{{7, 9}};
      for (int call = 0; call < 2; ++call) {
        phase->find(cloud, pairs);
        CHECK(pairs == right);
        CHECK(phase->tested() >= std::int64_t(right.size()));
      }
    }
  }
}

// One broad phase for a heap that jitters, falls, is stirred, loses and gains bodies.
template <class S> void every_kind_follows(Team* team) {
  std::vector<std::unique_ptr<BroadPhase<S>>> phases;
  for (int kind = 0; kind < int(broad_phase_names().size()); ++kind)
    phases.push_back(make_broad_phase<S>(BroadPhaseKind(kind), team));
  Cloud<S> cloud = uniform<S>(1200, 10, 0.4, 4);
  for (int i = 0; i < 60; ++i) cloud[i * 7].moves = false;
  Random random{{6}};
  std::vector<BodyPair> pairs;
  const auto shift = [&](int i, double x, double y, double z) {
    const Vec3<S> d{S(x), S(y), S(z)};
    cloud[i].box.low += d, cloud[i].box.high += d, cloud[i].center += d;
  };
  for (int call = 0; call < 40; ++call) {
    for (int i = 0; i < int(cloud.size()); ++i) {
      if (call < 10) shift(i, random(-1e-4, 1e-4), random(-1e-4, 1e-4), random(-1e-4, 1e-4));
      else if (call < 20) shift(i, 0, 0, i % 40 == 0 ? -0.3 : 0);  // a few fall
      else if (call < 30) shift(i, random(-0.2, 0.2), 0, -0.1);
    }
    if (call == 31) cloud.resize(900);
    if (call == 33) cloud.push_back(ball<S>(5, 5, 5, 3));
    if (call == 35)
      for (auto& item : cloud) item.moves = !item.moves;
    if (call == 36) cloud[17].moves = !cloud[17].moves;
    if (call == 38) cloud.clear();
    if (call == 39) cloud = uniform<S>(900, 8, 0.5, 8);
    const auto right = true_pairs(cloud);
    for (std::size_t kind = 0; kind < phases.size(); ++kind) {
      INFO("call " << call << ", " << broad_phase_names()[kind]);
      phases[kind]->find(cloud, pairs);
      REQUIRE(pairs == right);
    }
  }
}

}  // namespace

TEST_CASE("every broad phase finds the same pairs") {
  every_kind_agrees<double>(nullptr);
  every_kind_agrees<float>(nullptr);
  Team two(2);
  every_kind_agrees<double>(&two);
}

TEST_CASE("data kept between calls do not change the pairs") {
  every_kind_follows<double>(nullptr);
  every_kind_follows<float>(nullptr);
  Team three(3);
  every_kind_follows<double>(&three);
}

TEST_CASE("any cloud: every broad phase finds the same pairs") {
  CHECK(rc::check("same pairs", [] {
    const auto numbers = *rc::gen::container<std::vector<std::array<int, 7>>>(
        rc::gen::container<std::array<int, 7>>(rc::gen::inRange(-12, 13)));
    Cloud<double> cloud;
    for (const auto& n : numbers) {
      const double scale = std::pow(10.0, n[6] / 4);
      cloud.push_back(brick<double>(n[0], n[1], n[2], scale * std::abs(n[3]) / 8, scale * std::abs(n[4]) / 8,
                                    scale * std::abs(n[5]) / 8));
    }
    const auto right = true_pairs(cloud);
    for (int kind = 0; kind < int(broad_phase_names().size()); ++kind) {
      std::vector<BodyPair> pairs;
      make_broad_phase<double>(BroadPhaseKind(kind))->find(cloud, pairs);
      RC_ASSERT(pairs == right);
    }
  }));
}

TEST_CASE("the sum of coordinates' differences against r1 + r2 drops true pairs; against sqrt(3) of it none") {
  const Cloud<double> diagonal{ball<double>(0, 0, 0, 1),
                               ball<double>(1.1, 1.1, 1.1, 1)};  // 1.905 apart, 3.3 in the sum
  std::vector<BodyPair> pairs;
  broad::manhattan_pairs<double>(diagonal, 1, pairs);
  CHECK(pairs.empty());
  broad::manhattan_pairs<double>(diagonal, std::sqrt(3.0), pairs);
  CHECK(pairs == true_pairs(diagonal));
  CHECK(pairs.size() == 1);

  // Touching exactly on the diagonal, where both sides of the test are equal: rounding must not decide.
  int touching = 0;
  Random random{{11}};
  for (int n = 0; n < 1000; ++n) {
    const double d = random(0.1, 10), r = d * std::sqrt(3.0) / 2;
    const Cloud<double> two{ball<double>(0, 0, 0, r), ball<double>(d, -d, d, r)};
    broad::manhattan_pairs<double>(two, std::sqrt(3.0), pairs);
    CHECK(pairs == true_pairs(two));
    touching += int(pairs.size());
  }
  CHECK(touching > 100);
  CHECK(touching < 1000);
}

TEST_CASE("each broad phase keeps far fewer candidate pairs than there are pairs") {
  const auto cloud = uniform<double>(1000, 20, 0.4, 12);
  std::map<std::string, std::int64_t> kept;
  std::vector<BodyPair> pairs;
  for (const auto& name : broad_phase_names()) {
    const auto phase = make_broad_phase<double>(broad_phase_kind(name));
    phase->find(cloud, pairs);
    kept[name] = phase->tested();
  }
  CHECK(kept["all-pairs"] == 1000 * 999 / 2);
  CHECK(kept["manhattan"] < kept["all-pairs"] / 100);
  CHECK(kept["bounding-spheres"] < kept["manhattan"]);
  CHECK(kept["bounding-spheres"] == std::int64_t(pairs.size()));  // a sphere's box is wider than the sphere
  CHECK(kept["sweep-and-prune"] < kept["all-pairs"] / 10);
  for (const char* quick : {"grid", "tree", "bsp"}) CHECK(kept[quick] < kept["all-pairs"] / 20);
}

TEST_CASE("after its first calls no broad phase allocates memory") {
  Team two(2);
  for (const auto& name : broad_phase_names()) {
    for (Team* team : {static_cast<Team*>(nullptr), &two}) {
      INFO(name);
      const auto phase = make_broad_phase<double>(broad_phase_kind(name), team);
      std::vector<BodyPair> pairs;
      const auto run = [&] {
        auto cloud = uniform<double>(2000, 10, 0.4, 13);
        const long before = testing::allocations;
        for (int call = 0; call < 12; ++call) {
          for (std::size_t i = 0; i < cloud.size(); ++i) {
            const Vec3<double> d{0, 0, call < 6 ? (i % 50 == 0 ? -0.2 : 0.0) : (i % 2 == 0 ? 0.1 : -0.1)};
            cloud[i].box.low += d, cloud[i].box.high += d, cloud[i].center += d;
          }
          phase->find(cloud, pairs);
        }
        return testing::allocations - before;
      };
      run();
      run();
      CHECK(run() == 0);
    }
  }
}

TEST_CASE("the names of broad phases are known and read back") {
  CHECK(broad_phase_kind("tree") == BroadPhaseKind::tree);
  for (int kind = 0; kind < int(broad_phase_names().size()); ++kind)
    CHECK(broad_phase_kind(broad_phase_names()[kind]) == BroadPhaseKind(kind));
  CHECK_THROWS_WITH(broad_phase_kind("oct-tree"), Catch::Contains("oct-tree") && Catch::Contains("sweep-and-prune"));
}
