// Shapes of every kind slide on floors of every kind: they keep their height and stop after v^2 / (2 mu g). Kinds that
// an engine does not support it refuses by name.
#include <catch2/catch.hpp>

#include "under_test.hpp"

namespace atwood::test {
namespace {

constexpr double kMu = 0.4, kSpeed_m_per_s = 2, kGravity_m_per_s2 = 9.81;
const double kStop_m = kSpeed_m_per_s * kSpeed_m_per_s / (2 * kMu * kGravity_m_per_s2);

struct Named {
  std::string name;
  Shape shape;
};

std::vector<Real3> corners_of_box(double a, double b, double c) {
  std::vector<Real3> corners;
  for (const double x : {-a, a})
    for (const double y : {-b, b})
      for (const double z : {-c, c}) corners.push_back({x, y, z});
  return corners;
}

// The square [-3, 3]^2 at z = 0 in 12 x 12 cells of two triangles, seen from above.
Mesh grid() {
  Mesh mesh;
  constexpr int n = 12;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.points_m.push_back({-3 + 0.5 * i, -3 + 0.5 * j, 0});
  const auto at = [](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

// What lies 5 cm high and 40 cm wide.
std::vector<Named> sliders() {
  return {{"box", Box{{0.2, 0.2, 0.05}}},
          {"cylinder", Cylinder{0.2, 0.05}},
          {"convex", Convex{corners_of_box(0.2, 0.2, 0.05)}},
          {"compound", Compound{{{{0.1, 0.2, 0.05}, {-0.1, 0, 0}, {1, 0, 0, 0}},
                                 {{0.2, 0.1, 0.05}, {0.1, 0, 0}, {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}}}}};
}

// What has its top at z = 0 when its centre is at z = -depth.
std::vector<std::pair<Named, double>> floors() {
  return {{{"plane", Plane{}}, 0},
          {{"rectangle", Rectangle{{3, 3}}}, 0},
          {{"box", Box{{3, 3, 0.5}}}, 0.5},
          {{"cylinder", Cylinder{3, 0.5}}, 0.5},
          {{"convex", Convex{corners_of_box(3, 3, 0.5)}}, 0.5},
          {{"mesh", grid()}, 0},
          // Two boxes side by side, with a seam across the way.
          {{"compound",
            Compound{{{{1.5, 3, 0.5}, {-1.27, 0, 0}, {1, 0, 0, 0}}, {{1.5, 3, 0.5}, {1.73, 0, 0}, {1, 0, 0, 0}}}}},
           0.5}};
}

bool is_supported(const Engine& engine, const Named& shape) {
  if (engine.name == "dart") return shape.name != "convex";
  return engine.name != "mujoco" || (shape.name != "rectangle" && shape.name != "mesh");
}

Scene scene_of(const Shape& floor, double depth_m, const Body& mover, double friction) {
  Scene scene = bounce(0, 0, friction);
  scene.bodies[0].shape = floor;
  scene.bodies[0].position_m = {0, 0, -depth_m};
  scene.bodies[1] = mover;
  scene.bodies[1].velocity_m_per_s = {kSpeed_m_per_s, 0, 0};
  return scene;
}

Body flat(const Shape& shape) {
  Body body = box_body("slider", 1, {0.17 / 12, 0.17 / 12, 0.32 / 12});
  body.shape = shape;
  body.position_m = {0.02, 0.01, 0.05};
  return body;
}

// `one_point`: the engine finds one contact between these two (MuJoCo between a box and a hull or cylinder), so the box
// rocks.
void check_slide(const Engine& engine, const Scene& scene, const std::string& what, bool one_point = false) {
  const Run end = run(engine, sharpest(engine), scene, Plan{1, 480, 24});
  INFO(engine.name << ", " << what);
  CHECK(end.p(1, 0) - 0.02 == Approx(kStop_m).epsilon(one_point ? 0.25 : 0.04));
  CHECK(end.p(1, 1) - 0.01 == Approx(0).margin(one_point ? 0.03 : 5e-3));
  CHECK(end.p(1, 2) == Approx(0.05).margin(one_point ? 0.01 : 2e-3));
  CHECK(angle_between(end.q(1), {end.q(1)[0], 0, 0, end.q(1)[3]}) < (one_point ? 0.1 : 0.02));  // flat, turned or not
}

}  // namespace

TEST_CASE("every shape that can slide stops where it should") {
  const Engine engine = engine_under_test();
  for (const auto& slider : sliders()) {
    if (!is_supported(engine, slider)) continue;
    check_slide(engine, scene_of(Plane{}, 0, flat(slider.shape), kMu), slider.name + " on a plane");
  }
}

TEST_CASE("a box slides over every shape of floor") {
  const Engine engine = engine_under_test();
  for (const auto& [floor, depth_m] : floors()) {
    const Scene scene = scene_of(floor.shape, depth_m, flat(Box{{0.2, 0.2, 0.05}}), kMu);
    if (engine.name == "ode" && floor.name == "convex") {  // ODE's own loss: one point between a box and a hull
      const Run sunk = run(engine, sharpest(engine), scene, Plan{1, 480, 24});
      CHECK(sunk.p(1, 2) < 0.04);
    } else if (is_supported(engine, floor)) {
      check_slide(engine, scene, "box on a " + floor.name,
                  engine.name == "mujoco" && (floor.name == "convex" || floor.name == "cylinder"));
    } else {
      const Run refused = try_run(engine, sharpest(engine), scene, Plan{1, 480, 24});
      CHECK(to_string(refused.outcome.status) == "unsupported");
      CHECK_THAT(refused.outcome.reason, Catch::Contains("`" + scene.bodies[0].name + "`"));
    }
  }
}

TEST_CASE("a smooth ball glides over every shape of floor, seams and all") {
  const Engine engine = engine_under_test();
  for (const auto& [floor, depth_m] : floors()) {
    if (!is_supported(engine, floor)) continue;
    const Scene scene = scene_of(floor.shape, depth_m, sphere_body("ball", 1, 0.1, {0.02, 0.01, 0.1}), 0);
    const Run end = run(engine, sharpest(engine), scene, Plan{1, 480, 480});
    INFO(engine.name << ", ball on a " << floor.name);
    const bool hits_seam =
        is_bullet(engine) && floor.name == "compound";  // Bullet's own loss: a seam it knows nothing of
    CHECK(end.p(1, 0) == Approx(0.02 + kSpeed_m_per_s).epsilon(hits_seam ? 0.1 : 5e-3));
    CHECK(end.p(1, 1) == Approx(0.01).margin(2e-3));
    double highest = 0, lowest = 1;
    for (const auto& sample : end.samples) {
      highest = std::max(highest, static_cast<double>(sample.bodies[1].p_m[2]));
      lowest = std::min(lowest, static_cast<double>(sample.bodies[1].p_m[2]));
    }
    CHECK(highest < (hits_seam ? 0.11 : 0.103));
    CHECK(lowest > (hits_seam ? 0.09 : 0.098));
  }
}

TEST_CASE("rolling friction slows a rolling ball by 5/7 c g / r") {
  const Engine engine = engine_under_test();
  Scene scene = bounce(0, 0, 0.5);
  scene.pairs[0].rolling_friction_m = 0.002;
  scene.bodies[1].velocity_m_per_s = {1, 0, 0};
  scene.bodies[1].angular_velocity_body_rad_per_s = {0, 10, 0};
  if (engine.name == "dart") {
    const Run refused = try_run(engine, sharpest(engine), scene, Plan{1, 1000, 10});
    CHECK(to_string(refused.outcome.status) == "unsupported");
    CHECK_THAT(refused.outcome.reason, Catch::Contains("no rolling friction"));
    return;
  }
  const Run end = run(engine, sharpest(engine), scene, Plan{1, 1000, 10});
  CHECK(1 - end.v(1, 0) == Approx(5.0 / 7 * 0.002 * kGravity_m_per_s2 / 0.1).epsilon(0.02));
  CHECK(end.w(1, 1) * 0.1 == Approx(end.v(1, 0)).epsilon(0.01));
}

}  // namespace atwood::test
