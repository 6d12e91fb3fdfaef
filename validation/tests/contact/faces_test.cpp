// Boxes, capsules and cylinders on faces of boxes, sheets and flat meshes under `+event`: as on a plane, and refused by
// name where they come over the face's end.
#include <catch2/catch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double g = 9.81;

struct Case {
  const char* name;
  Body body;
};

std::vector<Case> bodies() {
  const double s = std::sqrt(0.5);
  const Real3 I = {0.004, 0.005, 0.003}, fast = {0.3, 0.1, 0};
  std::vector<Case> all = {{"box on its face", moving("top", Box{{0.1, 0.12, 0.08}}, 1, I, {0, 0, 0.18}, fast)},
                           {"box on its edge", moving("top", Box{{0.1, 0.12, 0.1}}, 1, I, {0, 0, 0.25}, fast)},
                           {"box on its corner", moving("top", Box{{0.1, 0.12, 0.1}}, 1, I, {0, 0, 0.3}, fast)},
                           {"capsule on its side", moving("top", Capsule{0.05, 0.1}, 1, I, {0, 0, 0.15}, fast)},
                           {"capsule on its end", moving("top", Capsule{0.05, 0.1}, 1, I, {0, 0, 0.25}, fast)},
                           {"cylinder on its side", moving("top", Cylinder{0.05, 0.1}, 1, I, {0, 0, 0.15}, fast)},
                           {"cylinder on its rim", moving("top", Cylinder{0.05, 0.1}, 1, I, {0, 0, 0.25}, fast)}};
  all[1].body.orientation_wxyz = {std::cos(0.15), 0, std::sin(0.15), 0};
  all[2].body.orientation_wxyz = {0.9, 0.2, 0.3, std::sqrt(1 - 0.94)};
  all[3].body.orientation_wxyz = all[5].body.orientation_wxyz = {s, 0, s, 0};
  all[6].body.orientation_wxyz = {std::cos(0.5), 0, std::sin(0.5), 0};
  return all;
}

}  // namespace

TEST_CASE("on the face of a box, a sheet or a flat mesh bodies move as on a plane") {
  for (const Case& one : bodies())
    for (const double friction : {0., 0.4})
      for (const double e : {0., 0.5}) {
        Scene scene = world({0, 0, -g}, e, friction);
        scene.bodies = {fixed("under", Plane{{0, 0, 1}, 0}), one.body};
        const std::string method = "atwood/rk4+event{restitution=poisson}";
        const Plan plan{0.35, 70, 7};
        const Recorded plane = run(method, scene, plan);
        REQUIRE(plane.outcome.status == Status::ok);
        for (const Shape& under : {Shape{Box{{1, 1, 0.2}}}, Shape{Rectangle{{1, 1}}}, Shape{flat_mesh(1, 1)}}) {
          scene.bodies[0] = fixed("under", under, {0, 0, std::holds_alternative<Box>(under) ? -0.2 : 0});
          const Recorded it = run(method, scene, plan);
          INFO(one.name << " on shape " << under.index() << ", mu " << friction << ", e " << e << ": "
                        << it.outcome.reason);
          REQUIRE(it.outcome.status == Status::ok);
          REQUIRE(!it.events.empty());
          CHECK(time_of(it.events[0]) == Approx(time_of(plane.events[0])).epsilon(1e-13));
          for (int k = 0; k < 3; ++k) {
            CHECK(std::abs(it.p(1)[k] - plane.p(1)[k]) < 2e-6);
            CHECK(std::abs(it.v(1)[k] - plane.v(1)[k]) < 2e-4);
          }
        }
      }
}

TEST_CASE("boxes rest and slide on boxes") {
  Scene stack = world({0, 0, -g}, 0, 0.3);
  stack.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), box("low", 5, {0.1, 0.1, 0.1}, {0, 0, 0.1}),
                  box("middle", 1, {0.1, 0.1, 0.1}, {0, 0, 0.3}), box("high", 2, {0.1, 0.1, 0.1}, {0, 0, 0.5})};
  const Recorded it = run("atwood/rk4+event", stack, {0.5, 20, 2});
  REQUIRE(it.outcome.status == Status::ok);
  CHECK(std::abs(it.p(3)[2] - 0.5) < 1e-13);
  double on_low = 0;
  for (const auto& contact : it.samples.back().contacts)
    if (contact.body_a == 1 && contact.body_b == 2) on_low += contact.force_n_N;
  CHECK(on_low == Approx(3 * g).epsilon(1e-9));

  // Slides at v0 on a slab free to slide on ice: mu g against it, mu g m / M with the slab, until both go alike.
  const double mu = 0.3, v0 = 0.5, m = 1, M = 5, ends = v0 / (mu * g * (1 + m / M));
  Scene slab = world({0, 0, -g}, 0, 0);
  slab.materials.push_back({"rough", 0, mu, 0});
  slab.pairs = {{0, 0, 0, 0, 0}, {0, 1, 0, mu, 0}, {1, 1, 0, mu, 0}};
  slab.bodies = {fixed("ice", Plane{{0, 0, 1}, 0}), box("slab", M, {0.5, 0.5, 0.1}, {0, 0, 0.1}),
                 box("top", m, {0.1, 0.1, 0.1}, {0, 0, 0.3}, {v0, 0, 0})};
  slab.bodies[2].material = 1;
  const Recorded both = run("atwood/rk4+event", slab, {0.5, 20, 2});
  REQUIRE(both.outcome.status == Status::ok);
  REQUIRE(both.events.size() == 1);
  CHECK(both.events[0].kind == EventKind::stick);
  CHECK(time_of(both.events[0]) == Approx(ends).epsilon(1e-10));
  for (const int body : {1, 2}) CHECK(both.v(body)[0] == Approx(m * v0 / (m + M)).epsilon(1e-10));
}

TEST_CASE("round shapes and polyhedra over the end of a box, and parallel edges, are refused by name") {
  Scene over = world({0, 0, -g}, 0, 0.3);
  Convex wedge;
  wedge.points_m = {{-0.1, -0.1, -0.1}, {0.1, -0.1, -0.1}, {0.1, 0.1, -0.1}, {-0.1, 0.1, -0.1}, {0, 0, 0.2}};
  over.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), box("slab", 5, {0.5, 0.5, 0.1}, {0, 0, 0.1}),
                 moving("top", wedge, 1, {0.004, 0.005, 0.003}, {0.35, 0, 0.3}, {1, 0, 0})};
  Scene round = over;
  round.bodies[2].shape = Capsule{0.1, 0.1};
  round.bodies[2].orientation_wxyz = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  Scene edges = world({0, 0, 0}, 1, 0);
  edges.bodies = {box("one", 1, {0.1, 0.1, 1}, {0, 0, 0}), box("other", 1, {0.1, 0.1, 0.5}, {0, 0.9, 0}, {0, -1, 0})};
  for (Body& body : edges.bodies) body.orientation_wxyz = {std::cos(M_PI / 8), 0, 0, std::sin(M_PI / 8)};
  for (const Scene& scene : {over, round, edges})
    for (const int steps : {2, 30}) {
      const Recorded it = run("atwood/rk4+event", scene, {1.5, steps, 1});
      INFO(scene.bodies.back().name << ", shape " << scene.bodies.back().shape.index() << ", " << steps << " steps");
      CHECK(it.outcome.status == Status::unsupported);
      CHECK(it.outcome.reason.find("over which it lies") != std::string::npos);
    }
}
