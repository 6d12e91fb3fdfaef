// Compares the broad phases: candidate pairs per touching pair, time of a call, its growth with the number of bodies,
// and the scenes on which each is slowest. Prints a table as JSON (`atwood bench broad-phases` shows it and keeps it
// for the report).
//
//   heap    balls of one size, as dense as poured ones (58 % of space); settled: each call moves them by 1e-5 of a
//           radius; stirred: by a twentieth of a radius in random directions, and all of them down by as much
//   planes  one oblique rectangle for 80 balls: a ball inside the bounding sphere or box of a rectangle is mostly far
//           from the rectangle itself, in particular near its corners
//   giant   one ball of 25 radii among the others
//   line    a row of balls, each touching the next
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "collision/broad_kinds.hpp"
#include "scene/split_mix.hpp"
#include "validation/metrics/metrics.hpp"

namespace {

using namespace atwood;
using Json = nlohmann::ordered_json;
using Cloud = std::vector<BroadItem<double>>;

// u, v: unit axes
struct Rectangle {
  Vec3<double> center, u, v;
  double half_m;
};

struct Crowd {
  Cloud items;
  std::vector<Rectangle> rectangles;  // of the last items
  std::size_t balls() const { return items.size() - rectangles.size(); }
};

constexpr double kRadius_m = 0.1;

BroadItem<double> ball(const Vec3<double>& c, double r) {
  return {{c - Vec3<double>{r, r, r}, c + Vec3<double>{r, r, r}}, c, r, true};
}

// Cubic lattice at 58 % of space, each ball displaced at random by up to a fifth of a radius.
Crowd heap(int balls) {
  Crowd crowd;
  SplitMix64 random{42};
  const auto within = [&](double half) { return half * (2 * random.next_unit() - 1); };
  const int side = static_cast<int>(std::ceil(std::cbrt(balls)));
  const double spacing = kRadius_m * std::cbrt(4.0 / 3 * M_PI / 0.58);
  for (int n = 0; n < balls; ++n) {
    const Vec3<double> c{spacing * (n % side), spacing * (n / side % side), spacing * (n / side / side)};
    crowd.items.push_back(
        ball(c + Vec3<double>{within(0.2 * kRadius_m), within(0.2 * kRadius_m), within(0.2 * kRadius_m)}, kRadius_m));
  }
  return crowd;
}

Crowd with_planes(int balls) {
  Crowd crowd = heap(balls);
  SplitMix64 random{7};
  const double side = std::cbrt(balls) * 0.19;
  for (int n = 0; n < balls / 80; ++n) {
    const auto unit = [&] {
      Vec3<double> a{random.next_unit() - 0.5, random.next_unit() - 0.5, random.next_unit() - 0.5};
      return (1 / norm(a)) * a;
    };
    Rectangle r;
    r.center = {side * random.next_unit(), side * random.next_unit(), side * random.next_unit()};
    r.u = unit();
    Vec3<double> v = unit();
    v = v - dot(r.u, v) * r.u;
    r.v = (1 / norm(v)) * v;
    r.half_m = 5 * kRadius_m;
    const auto reach = [&](double a, double b) { return r.half_m * (std::abs(a) + std::abs(b)); };
    const Vec3<double> half{reach(r.u.x, r.v.x), reach(r.u.y, r.v.y), reach(r.u.z, r.v.z)};
    crowd.items.push_back({{r.center - half, r.center + half}, r.center, std::sqrt(2.0) * r.half_m, false});
    crowd.rectangles.push_back(r);
  }
  return crowd;
}

Crowd with_giant(int balls) {
  Crowd crowd = heap(balls);
  const std::size_t middle = crowd.items.size() / 2;
  crowd.items[middle] = ball(crowd.items[middle].center, 25 * kRadius_m);
  return crowd;
}

Crowd in_line(int balls) {
  Crowd crowd;
  for (int n = 0; n < balls; ++n) crowd.items.push_back(ball({2 * kRadius_m * n, 0, 0}, kRadius_m));
  return crowd;
}

bool touch(const Crowd& crowd, const BodyPair& pair) {
  const auto first_rectangle = static_cast<std::int32_t>(crowd.balls());
  if (pair.second < first_rectangle) return true;  // for balls the bounding sphere is exact
  const Rectangle& r = crowd.rectangles[static_cast<std::size_t>(pair.second - first_rectangle)];
  const BroadItem<double>& b = crowd.items[static_cast<std::size_t>(pair.first)];
  const Vec3<double> d = b.center - r.center;
  const auto inside = [&](double x) { return std::clamp(x, -r.half_m, r.half_m); };
  return norm(d - inside(dot(d, r.u)) * r.u - inside(dot(d, r.v)) * r.v) <= b.radius;
}

struct Kind {
  std::string name;
  std::unique_ptr<BroadPhase<double>> (*make)(Team*);
};
std::vector<Kind> kinds() {
  return {{"all-pairs", [](Team*) { return broad::make_all_pairs<double>(); }},
          {"manhattan", [](Team*) { return broad::make_manhattan<double>(); }},
          {"bounding-spheres", [](Team*) { return broad::make_bounding_spheres<double>(); }},
          {"sweep-and-prune", [](Team*) { return broad::make_sweep_and_prune<double>(); }},
          {"grid", [](Team* team) { return broad::make_grid<double>(team); }},
          {"tree", [](Team* team) { return broad::make_tree<double>(team); }},
          {"bsp", [](Team*) { return broad::make_bsp<double>(); }}};
}

// Moves every ball at random by up to `shake_m` in each direction, and by `fall_m` down.
void move(Crowd& crowd, double shake_m, double fall_m, SplitMix64& random) {
  const auto within = [&] { return shake_m * (2 * random.next_unit() - 1); };
  for (std::size_t i = 0; i < crowd.balls(); ++i) {
    const Vec3<double> d{within(), within(), within() - fall_m};
    BroadItem<double>& item = crowd.items[i];
    item.box.low += d, item.box.high += d, item.center += d;
  }
}

// Processor time of the calling thread, which other load does not change; for two threads wall time.
double now_s(bool one_thread) {
  if (!one_thread) return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Calls {
  double seconds = 0, kept = 0, touching = 0;
};

// Mean of the fastest eight consecutive calls, after two for warm-up: other load disturbs these least, and eight calls
// average over a phase that reuses results in some calls and updates them in others. Pairs are those of the last call.
Calls timed(const Kind& kind, Crowd crowd, double shake_m, double fall_m, Team* team) {
  const auto phase = kind.make(team);
  std::vector<BodyPair> pairs;
  double quickest = std::numeric_limits<double>::infinity(), total = 0, of_round = 0;
  SplitMix64 random{3};
  for (int call = -2; call < 48 && (call <= 8 || total < 0.4 || call % 8 != 0); ++call) {
    move(crowd, shake_m, fall_m, random);
    const double start_s = now_s(team == nullptr);
    phase->find(crowd.items, pairs);
    const double s = now_s(team == nullptr) - start_s;
    of_round = call % 8 == 0 ? s : of_round + s;
    if (call % 8 == 7) quickest = std::min(quickest, of_round / 8);
    total += s;
  }
  const auto touching =
      std::count_if(pairs.begin(), pairs.end(), [&](const BodyPair& pair) { return touch(crowd, pair); });
  return {quickest, static_cast<double>(phase->tested()), static_cast<double>(touching)};
}

constexpr double kSettled_m = 1e-5 * kRadius_m, kStirred_m = 0.05 * kRadius_m;

}  // namespace

// `atwood-broad-phases [BALLS]`: the size of the heaps, 8000 unless given; the ladders of N scale with it.
int main(int argc, char** argv) {
  const int balls = argc > 1 ? std::atoi(argv[1]) : 8000;
  if (argc > 2 || balls < 160) {
    std::fprintf(stderr, "atwood-broad-phases: expected at most one argument, a number of balls from 160 on\n");
    return 2;
  }
  const auto scaled = [balls](int n) { return static_cast<int>(static_cast<std::int64_t>(n) * balls / 8000); };
  Json rows = Json::array();
  Team two(2);
  for (const Kind& kind : kinds()) {
    const bool every_pair = kind.name == "all-pairs" || kind.name == "manhattan" || kind.name == "bounding-spheres";
    std::fprintf(stderr, "atwood: broad phase %s\n", kind.name.c_str());
    std::vector<double> bodies, seconds;
    const std::vector<int> sizes = every_pair                       ? std::vector{500, 1000, 2000, 4000, 8000}
                                   : kind.name == "sweep-and-prune" ? std::vector{1000, 2000, 5000, 10000, 30000}
                                                                    : std::vector{1000, 3000, 10000, 30000, 100000};
    for (const int size : sizes) {
      const int n = scaled(size);
      bodies.push_back(n);
      seconds.push_back(timed(kind, heap(n), kStirred_m, kStirred_m, nullptr).seconds);
    }
    const ScalingFit fit = fit_scaling(bodies, seconds);
    const Calls settled = timed(kind, heap(balls), kSettled_m, 0, nullptr),
                stirred = timed(kind, heap(balls), kStirred_m, kStirred_m, nullptr);
    const Calls stirred_by_two = timed(kind, heap(balls), kStirred_m, kStirred_m, &two),
                settled_by_two = timed(kind, heap(balls), kSettled_m, 0, &two);
    const Calls planes = timed(kind, with_planes(balls), kSettled_m, 0, nullptr),
                giant = timed(kind, with_giant(balls), kSettled_m, 0, nullptr);
    const Calls line = timed(kind, in_line(balls), kSettled_m, 0, nullptr);
    const bool teams = kind.name == "grid" || kind.name == "tree";
    const Json none = nullptr;
    rows.push_back({kind.name, stirred.kept / stirred.touching, 1e6 * settled.seconds, 1e6 * stirred.seconds,
                    teams ? Json(1e6 * settled_by_two.seconds) : none,
                    teams ? Json(1e6 * stirred_by_two.seconds) : none, fit.exponent, fit.half_width_95,
                    fit.exponent_over_log, fit.half_width_over_log_95, bodies.back(), planes.kept / planes.touching,
                    1e6 * planes.seconds, giant.kept / giant.touching, 1e6 * giant.seconds, line.kept / line.touching,
                    1e6 * line.seconds, 0});
  }
  // The touching pairs that a Manhattan distance of r1 + r2 would miss.
  const Crowd crowd = heap(balls);
  std::vector<BodyPair> all, some;
  broad::manhattan_pairs<double>(crowd.items, std::sqrt(3.0), all);
  const std::int64_t kept = broad::manhattan_pairs<double>(crowd.items, 1, some);
  Json narrow = Json::array({"manhattan, r1 + r2", static_cast<double>(kept) / static_cast<double>(all.size())});
  while (narrow.size() < 17) narrow.push_back(nullptr);
  narrow.push_back(1 - static_cast<double>(some.size()) / static_cast<double>(all.size()));
  rows.insert(rows.begin() + 2, narrow);

  const Json table = {
      {"id", "broad-phases"},
      {"title", "Broad phases: pairs looked at per pair that touches, and the time of a call [us], N = " +
                    std::to_string(balls)},
      {"columns",
       {"broad phase", "heap kept", "settled", "stirred", "settled, 2 threads", "stirred, 2 threads", "a: T ~ N^a",
        "a +-", "b: T/log N ~ N^b", "b +-", "N to", "planes kept", "planes", "giant kept", "giant", "line kept", "line",
        "lost"}},
      {"rows", rows},
      {"notes",
       {"kept: pairs that the phase's own test let through, over pairs whose shapes touch; lost: the share of true "
        "pairs that it drops. Times: the processor's; of two threads the wall's.",
        "heap: balls at 58 % of space; settled: moved by 1e-5 r a call; stirred: shaken by r/20 and falling as much, "
        "also for the exponents (95 %).",
        "planes: " + std::to_string(balls / 80) +
            " finite planes askew among the balls (a box or sphere around a rectangle is mostly empty); giant: one ball "
            "of 25 r; line: " +
            std::to_string(balls) + " in a row, touching."}}};
  std::printf("%s\n", Json{{"tables", {table}}}.dump(1).c_str());
  return 0;
}
