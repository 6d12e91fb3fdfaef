// Where surfaces end, and where touches do: balls that roll off a sheet, bodies over its end, graze, and dead impacts
// in free flight.
#include <catch2/catch.hpp>
#include <random>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double g = 9.81, r = 0.1;

std::vector<Shape> tops() { return {Rectangle{{0.5, 0.4}}, Box{{0.5, 0.4, 0.2}}, flat_mesh(0.5, 0.4)}; }
double top_of(const Shape& shape) { return std::holds_alternative<Box>(shape) ? 0.2 : 0; }

// A ball that slides without friction about an edge, from its top at speed v0:
//   R theta'^2 = v^2 / R = v0^2 / R + 2 g (1 - cos theta)
//   N = m (g cos theta - v^2 / R), which vanishes at 3 cos theta = v0^2 / (g R) + 2.
// The time there by Simpson's rule.
struct Leaves {
  double angle = 0, after_s = 0;
};
Leaves leaves_edge(double v0, double R) {
  Leaves leaves;
  leaves.angle = std::acos((v0 * v0 / (g * R) + 2) / 3);
  const auto slowness = [&](double theta) { return R / std::sqrt(v0 * v0 + 2 * g * R * (1 - std::cos(theta))); };
  const int parts = 2000;
  const double h = leaves.angle / parts;
  double sum = slowness(0) + slowness(leaves.angle);
  for (int i = 1; i < parts; ++i) sum += (i % 2 ? 4 : 2) * slowness(i * h);
  leaves.after_s = h / 3 * sum;
  return leaves;
}

}  // namespace

TEST_CASE("a fast ball that rolls off an end flies at once") {
  for (const Shape& top : tops())
    for (const double v0 : {2., 5.}) {  // v0^2 > g r
      Scene scene = world({0, 0, -g}, 0, 0.5);
      scene.bodies = {fixed("top", top), ball("ball", 1, r, {0, 0, top_of(top) + r}, {v0, 0, 0}, {0, v0 / r, 0})};
      for (const int steps : {1, 20, 33}) {
        INFO("shape " << top.index() << ", " << v0 << " m/s, " << steps << " steps");
        const Recorded it = run("atwood/rk4+event", scene, {1, steps, 1});
        REQUIRE(it.events.size() == 1);
        CHECK(it.events[0].kind == EventKind::separate);
        const double left = 0.5 / v0, fell = 1 - left;
        CHECK(time_of(it.events[0]) == Approx(left).epsilon(1e-13));
        CHECK(it.p(1)[0] == Approx(v0).epsilon(1e-12));
        CHECK(it.p(1)[2] == Approx(top_of(top) + r - g * fell * fell / 2).epsilon(1e-11));
        CHECK(it.w(1)[1] == Approx(v0 / r).epsilon(1e-12));
      }
    }
}

TEST_CASE("a slow ball goes about the edge until nothing presses it on, at the method's order") {
  const double v0 = 0.5, end_s = 1.2;
  const Leaves leaves = leaves_edge(v0, r);
  const double at_s = 0.5 / v0 + leaves.after_s;
  for (const Shape& top : tops()) {
    INFO("shape " << top.index());
    Scene scene = world({0, 0, -g}, 0, 0);
    scene.bodies = {fixed("top", top), ball("ball", 1, r, {0, 0, top_of(top) + r}, {v0, 0, 0})};
    double error[2]{};
    for (int i = 0; i < 2; ++i) {
      const Recorded it = run("atwood/rk4+event", scene, {end_s, 300 << i, 1});
      REQUIRE(it.events.size() == 1);
      CHECK(it.events[0].kind == EventKind::separate);
      error[i] = std::abs(time_of(it.events[0]) - at_s);
      CHECK(error[i] < 1e-8);
      const double v = std::sqrt(g * r * std::cos(leaves.angle)), fell = end_s - at_s;
      CHECK(std::abs(it.p(1)[0] - (0.5 + r * std::sin(leaves.angle) + v * std::cos(leaves.angle) * fell)) < 1e-8);
      CHECK(std::abs(it.p(1)[2] - (top_of(top) + r * std::cos(leaves.angle) - v * std::sin(leaves.angle) * fell -
                                   g * fell * fell / 2)) < 1e-8);
    }
    CHECK(std::log2(error[0] / error[1]) == Approx(4).margin(0.4));
  }
}

TEST_CASE("a ball slides from a capsule's side over its end") {
  const double v0 = 1, R = 0.3;
  const Leaves leaves = leaves_edge(v0, R);
  Scene scene = world({0, 0, -g}, 0, 0);
  scene.bodies = {fixed("log", Capsule{0.2, 0.3}), ball("ball", 1, r, {0, 0, R}, {v0, 0, 0})};
  scene.bodies[0].orientation_wxyz = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  const Recorded it = run("atwood/rk4+event", scene, {0.6, 600, 1});
  REQUIRE(it.events.size() == 1);
  CHECK(it.events[0].kind == EventKind::separate);
  CHECK(time_of(it.events[0]) == Approx(0.3 / v0 + leaves.after_s).epsilon(1e-9));
}

TEST_CASE("capsules over the end of a sheet, and boxes over that of a mesh, are refused by name, in any step") {
  const double s = std::sqrt(0.5);
  struct Case {
    const char* what;
    Shape on;
    Body body;
  };
  std::vector<Case> cases = {
      {"a capsule across", Rectangle{{0.1, 0.1}},
       moving("crate", Capsule{0.05, 0.3}, 1, {0.1, 0.1, 0.01}, {0, 0, 0.5})},
      {"larger than a mesh", flat_mesh(0.05, 0.05), box("crate", 1, {0.1, 0.1, 0.05}, {0, 0, 0.5})}};
  cases[0].body.orientation_wxyz = {s, 0, s, 0};
  for (const Case& one : cases)
    for (const int steps : {1, 7, 100}) {
      INFO(one.what << ", " << steps << " steps");
      Scene scene = world({0, 0, -g}, 0, 0.1);
      scene.bodies = {fixed("ledge", one.on), one.body};
      const Recorded it = try_run("atwood/rk4+event", scene, {1, steps, 1});
      CHECK(it.outcome.status == Status::unsupported);
      CHECK(it.outcome.reason.find("`crate`") != std::string::npos);
      CHECK(it.outcome.reason.find("`ledge`") != std::string::npos);
    }
  Scene beside = world({0, 0, -g}, 0, 0.1);  // past the sheet, it is another thing
  beside.bodies = {fixed("ledge", Rectangle{{0.5, 0.5}}), box("crate", 1, {0.1, 0.1, 0.05}, {0.601, 0, 0.5})};
  for (const int steps : {1, 7, 100}) run("atwood/rk4+event", beside, {1, steps, 1});
}

TEST_CASE("right above an inner edge of a mesh is above a face") {
  Scene scene = world({0, 0, -g}, 0, 0.5);
  scene.bodies = {fixed("floor", flat_mesh(1, 1)),
                  box("box", 1, {0.1, 0.1, 0.05}, {0, 0, 0.05})};  // two corners above the diagonal
  const Recorded rests = run("atwood/rk4+event", scene, {0.5, 10, 1});
  CHECK(rests.samples.back().contacts.size() == 4);
  scene.bodies[1] = moving("peg", Capsule{0.1, 0.1}, 1, {0.1, 0.1, 0.01}, {0, 0, 0.6});
  const Recorded falls = run("atwood/rk4+event", scene, {0.35, 10, 1});
  REQUIRE(falls.count(EventKind::impact) == 1);
  CHECK(time_of(falls.events[0]) == Approx(std::sqrt(0.8 / g)).epsilon(1e-13));
}

// A pair of a ball and a mesh has one contact: in a concave edge the ball would roll on through the other face.
TEST_CASE("a ball that rolls into a wall of its mesh is refused there, one that rolls over a ridge goes on") {
  const auto ground = [](const Real3& end) {  // level up to x = 1, from there on to `end`
    Mesh mesh;
    mesh.points_m = {{-2, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-2, 1, 0}, {end[0], -1, end[2]}, {end[0], 1, end[2]}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
    return mesh;
  };
  for (const double friction : {0., 0.4})
    for (const int steps : {16, 100}) {
      Scene scene = world({0, 0, -g}, 0.5, friction);
      for (const Real3& up : {Real3{1, 0, 1}, Real3{2, 0, 0.5}}) {
        scene.bodies = {fixed("ground", ground(up)), ball("ball", 1, r, {0, 0.3, r}, {1, 0, 0}, {0, 1 / r, 0})};
        const Recorded into = try_run("atwood/rk4+event", scene, {1.6, steps, 4});
        INFO("mu " << friction << ", " << steps << " steps: " << into.outcome.reason);
        CHECK(into.outcome.status == Status::unsupported);
        CHECK(into.outcome.reason.find("sphere `ball` touches two facets of mesh `ground`") != std::string::npos);
      }
      scene.bodies[0] = fixed("ground", ground({2, 0, -0.1}));
      const Recorded over = run("atwood/rk4+event", scene, {1.6, steps, 4});
      CHECK(over.p(1)[0] > 1.5);
      CHECK(over.p(1)[2] < r);
    }
}

TEST_CASE("balls that meet dead and rough in empty space stay whole, and pass on") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 60; ++i) {
    // At 0.2 s the centres are one diameter apart along n.
    const double x = any(random), y = any(random), z = any(random), size = std::sqrt(x * x + y * y + z * z);
    const Real3 n{x / size, y / size, z / size};
    Real3 v[2], at[2];
    double approach = 0;
    for (int k = 0; k < 3; ++k) {
      v[0][k] = any(random) + n[k];
      v[1][k] = any(random) - n[k];
      approach += (v[0][k] - v[1][k]) * n[k];
    }
    if (approach < 0.1) continue;
    for (int k = 0; k < 3; ++k) {
      at[0][k] = 0.3 - 0.2 * v[0][k];
      at[1][k] = 0.3 + 2 * r * n[k] - 0.2 * v[1][k];
    }
    Scene scene = world({}, 0, i % 3);
    scene.bodies = {ball("a", 1 + i, r, at[0], v[0], {3 * any(random), 0, 5}),
                    ball("b", 2, r, at[1], v[1], {0, 7 * any(random), 0})};
    for (const char* method : {"atwood/rk4+event", "atwood/dopri5+event", "atwood/rk4+event@long-double"})
      for (const int steps : {1, 7, 64}) {
        INFO(i << " " << method << " " << steps);
        const Recorded it = run(method, scene, {0.5, steps, 1});
        REQUIRE(it.events.size() == 1);
        CHECK(it.events[0].kind == EventKind::impact);
        CHECK(time_of(it.events[0]) == Approx(0.2).epsilon(1e-12));
        for (int k = 0; k < 3; ++k)
          CHECK(std::abs((1 + i) * (it.v(0)[k] - v[0][k]) + 2 * (it.v(1)[k] - v[1][k])) < 1e-14 * (1 + i + 2) * 4);
      }
  }
}

TEST_CASE(
    "grazing: a ball that just overlaps on its way is struck, one that just misses is not; at none of both round-off "
    "may choose") {
  for (const double overlap : {1e-3, 1e-6, 1e-9, 0.0, -1e-12, -1e-9, -1e-3}) {
    Scene scene = world({}, 1, 0);
    scene.bodies = {ball("a", 1, r, {0, 0, 0}), ball("b", 1, r, {-1, 2 * r - overlap, 0}, {1, 0, 0})};
    for (const int steps : {1, 7, 64}) {
      INFO(overlap << " m, " << steps << " steps");
      const Recorded it = run("atwood/rk4+event", scene, {2, steps, 1});
      if (overlap ==
          0) {  // the gap is round-off, eps, over 2 sqrt(eps d) m of the way: at most that much of an approach
        for (const Event& event : it.events) CHECK(std::abs(static_cast<double>(event.vn_before_m_per_s)) < 1e-7);
        CHECK(it.v(0)[1] == Approx(0).margin(1e-7));
        continue;
      }
      REQUIRE(static_cast<int>(it.events.size()) == (overlap > 0 ? 1 : 0));
      if (!(overlap > 0)) continue;
      // They touch where x = -sqrt(overlap (4 r - overlap)); that is the approach's sine, too.
      const double before = std::sqrt(overlap * (4 * r - overlap));
      CHECK(time_of(it.events[0]) == Approx(1 - before).epsilon(1e-15 / before + 1e-13));
      CHECK(static_cast<double>(it.events[0].vn_before_m_per_s) ==
            Approx(-before / (2 * r)).epsilon(1e-15 / overlap + 1e-13));
    }
  }
  for (const double over : {1e-3, 1e-6, -1e-9, -1e-3}) {  // an apex at a ceiling
    const double v = 3, rises = v * v / (2 * g);
    Scene scene = world({0, 0, -g}, 0.5, 0);
    scene.bodies = {fixed("ceiling", Plane{{0, 0, -1}, -(rises + r - over)}),
                    ball("ball", 1, r, {0, 0, 0}, {0.3, 0, v})};
    for (const int steps : {1, 4, 33}) {
      INFO(over << " m over the ceiling, " << steps << " steps");
      const Recorded it = run("atwood/rk4+event", scene, {0.5, steps, 1});
      REQUIRE(static_cast<int>(it.events.size()) == (over > 0 ? 1 : 0));
      if (over > 0) CHECK(time_of(it.events[0]) == Approx((v - std::sqrt(2 * g * over)) / g).epsilon(1e-10));
    }
  }
}

TEST_CASE("an impact far from where the bodies began is found") {
  for (const double far : {1., 1e3, 1e6}) {
    INFO(far << " m");
    Scene wall = world({}, 0.5, 0);
    wall.bodies = {fixed("wall", Plane{{-1, 0, 0}, -far}), ball("ball", 1, r, {0, 0, 0}, {far, 0, 0})};
    Scene chase = world({}, 0.5, 0);
    chase.bodies = {ball("slow", 1, r, {1, 0, 0}, {far, 0, 0}), ball("fast", 1, r, {0, 0, 0}, {far + 1, 0, 0})};
    for (const int steps : {1, 10}) {
      const Recorded it = run("atwood/rk4+event", wall, {2, steps, 1}),
                     caught = run("atwood/rk4+event", chase, {2, steps, 1});
      REQUIRE(it.events.size() == 1);
      CHECK(time_of(it.events[0]) == Approx((far - r) / far).epsilon(1e-13));
      CHECK(it.v(1)[0] == Approx(-far / 2).epsilon(1e-13));
      REQUIRE(caught.events.size() == 1);
      CHECK(time_of(caught.events[0]) == Approx(0.8).epsilon(1e-14 * far + 1e-13));
    }
  }
}

TEST_CASE("a box that has sunk a little into a sheet or a plane at the start rests where it is, away from any end") {
  for (const double depth : {1e-11, 1e-3, 0.05}) {
    Scene scene = world({0, 0, -g}, 0, 0.5);
    Body crate = ball("crate", 1, r, {0, 0, r - depth});
    crate.shape = Box{{r, r, r}};
    scene.bodies = {fixed("sheet", Rectangle{{1, 1}}), crate};
    const Recorded it = run("atwood/rk4+event", scene, {0.5, 60, 1});
    INFO(depth << " m: " << it.outcome.reason);
    CHECK(it.p(1)[2] == Approx(r - depth).epsilon(1e-13));
  }
}
