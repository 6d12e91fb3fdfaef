// What is MuJoCo's own: integrators, cones, how a pair's friction gets there, refusals, and its log file.
#include <catch2/catch.hpp>
#include <filesystem>

#include "mujoco/mujoco.hpp"
#include "mujoco/pair_laws.hpp"
#include "rivals/vector.hpp"
#include "scenes.hpp"

namespace atwood::test {
namespace {

const Engine& engine() {
  static const Engine made = mujoco_engine();
  return made;
}

Run run_with(const std::string& scheme, const Scene& scene, const Plan& plan, const Settings& overrides = {}) {
  return run(engine(), method(engine(), scheme, overrides), scene, plan);
}

// Materials a, b, c (and the floor's, 3), with friction `table` for the pairs of a, b, c among each other.
Scene of_materials(const std::vector<PairLaw>& laws, int materials) {
  Scene scene = bounce(0, 0);
  scene.materials.assign(static_cast<std::size_t>(materials), Material{});
  scene.pairs = laws;
  return scene;
}

}  // namespace

TEST_CASE("Runge-Kutta falls exactly, and leaves the attitude at second order") {
  const Run fall = run_with("rk4", free_box_complex(), Plan{10, 600, 10});
  CHECK(fall.p(0, 2) == Approx(8 * 10 - 0.5 * 9.8 * 100).epsilon(1e-12));
  const auto end = [](std::int64_t steps) { return run_with("rk4", free_box_complex(), Plan{1, steps, 1}).q(0); };
  const Real4 finest = end(20000);
  const double coarse = angle_between(end(200), finest), fine = angle_between(end(400), finest);
  CHECK(coarse / fine == Approx(4).epsilon(0.1));
  const double euler = angle_between(run_with("default", free_box_complex(), Plan{1, 200, 1}).q(0), finest);
  CHECK(coarse < 0.02 * euler);
}

// Forces that the adapter evaluates are those of each stage: x'' = -x; y'' = cos(w t + p) from rest; a rate w with
// w' = -0.05 w / 0.25.
TEST_CASE("Runge-Kutta has its order under forces of the scene") {
  const double t = 5, w = 0.7, p = 0.2, y = (std::cos(p) - std::cos(w * t + p)) / (w * w) - std::sin(p) * t / w;
  Scene sprung = empty_scene(), driven = empty_scene();
  sprung.bodies = driven.bodies = {box_body("mass", 1, {0.1, 0.2, 0.25})};
  sprung.bodies[0].position_m = {1, 0, 0};
  sprung.forces = {Spring{{0}, {}, 1, 0, 0, {}}};
  driven.bodies[0].angular_velocity_body_rad_per_s = {0, 0, 2};
  driven.forces = {Drive{{0}, {0, 1, 0}, w, p}, LinearDrag{{0}, 0, {}, 0.05}};
  const auto errors = [&](std::int64_t steps) {
    const Run x = run_with("rk4", sprung, Plan{t, steps, 1}), yw = run_with("rk4", driven, Plan{t, steps, 1});
    CHECK_THAT(x.outcome.reason, Catch::Contains("at every rate call: spring"));
    CHECK(x.outcome.rate_evaluations == 4 * steps);
    return std::array{std::abs(x.p(0, 0) - std::cos(t)), std::abs(yw.p(0, 1) - y),
                      std::abs(yw.w(0, 2) - 2 * std::exp(-0.2 * t))};
  };
  const auto coarse = errors(40), fine = errors(80);
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::log2(coarse[k] / fine[k]) == Approx(4).margin(0.15));
  CHECK(errors(1000)[0] < 1e-10);
  CHECK(run_with("default", sprung, Plan{t, 100, 1}).outcome.rate_evaluations == 100);
}

TEST_CASE("the pyramid slides too far off its axes, the elliptic cone does not") {
  const double exact = 4 / (2 * 0.4 * 9.81), c = std::sqrt(0.5);
  const auto distance = [&](const std::string& scheme, double cos, double sin) {
    const Run end = run_with(scheme, sliding_box(0.4, cos, sin), Plan{1, 240, 24});
    REQUIRE(end.outcome.status == Status::ok);
    return std::hypot(end.p(1, 0), end.p(1, 1)) / exact - 1;
  };
  CHECK(std::abs(distance("default", 1, 0)) < 0.02);
  CHECK(distance("default", c, c) > 0.25);
  for (const auto& [cos, sin] : {std::pair(1.0, 0.0), std::pair(c, c), std::pair(0.8, -0.6)}) {
    CHECK(std::abs(distance("stiff", cos, sin)) < 5e-3);
  }
}

TEST_CASE("scenes with restitution are refused, where the pair can meet") {
  Scene scene = of_materials({PairLaw{0, 0, 0, 0.3, 0}, PairLaw{0, 1, 0.5, 0.3, 0}, PairLaw{1, 1, 0, 0, 0}}, 2);
  CHECK(run_with("default", scene, Plan{0.1, 10, 1}).outcome.status == Status::ok);  // no body has material 1
  scene.bodies[1].material = 1;
  const Run refused = try_run(engine(), method(engine(), "stiff"), scene, Plan{0.1, 10, 1});
  CHECK(to_string(refused.outcome.status) == "unsupported");
  CHECK_THAT(refused.outcome.reason, Catch::Contains("MuJoCo has no restitution"));
}

TEST_CASE("each pair has its own friction, by priorities or one by one") {
  // Box 1 lies on the floor, box 2 on box 1, box 3 on the floor. Materials: floor 0, box 1 is 1, box 2 is 2, box 3
  // is 2.
  const auto end_speeds = [](const Scene& scene) {
    const Run end = run_with("stiff", scene, Plan{0.15, 300, 10});
    INFO(end.outcome.reason);
    REQUIRE(end.outcome.status == Status::ok);
    return std::array{end.v(1, 0), end.v(2, 0), end.v(3, 0)};
  };
  for (const bool orderly : {true, false}) {
    const double mu02 = orderly ? 0.1 : 0.25;
    Scene scene = of_materials({PairLaw{0, 0, 0, 0.9, 0}, PairLaw{0, 1, 0, 0.4, 0}, PairLaw{1, 1, 0, 0.7, 0},
                                PairLaw{0, 2, 0, mu02, 0}, PairLaw{1, 2, 0, 0.1, 0}, PairLaw{2, 2, 0, 0.1, 0}},
                               3);
    scene.bodies[1] = flat_box("low", {0, 0, 0.05});
    scene.bodies.push_back(flat_box("high", {0, 0, 0.15}));
    scene.bodies.push_back(flat_box("apart", {0, 3, 0.05}));
    for (int i = 1; i < 4; ++i) {
      scene.bodies[i].material = std::min(i, 2);
      if (i != 1) scene.bodies[i].velocity_m_per_s = {1, 0, 0};
    }
    CHECK(mujoco::precedences(scene).has_value() == orderly);
    const auto v = end_speeds(scene);
    CHECK(v[0] == Approx(0).margin(1e-3));  // 0.1 from above can't move it against 0.4 below
    CHECK(1 - v[1] == Approx(0.1 * 9.81 * 0.15).epsilon(0.03));
    CHECK(1 - v[2] == Approx(mu02 * 9.81 * 0.15).epsilon(0.03));
  }
}

TEST_CASE("a hinged ball that lies on the floor: the contact carries it, not the hinge") {
  Scene scene = bounce(0, 0);
  Joint hinge;
  hinge.name = "hinge";
  hinge.child = 1;
  hinge.axis_body = {0, 1, 0};
  hinge.anchors_body_m = {{{-1, 0, 0.1}, {-1, 0, 0}}};
  scene.joints = {hinge};
  const Run rest = run_with("stiff", scene, Plan{2, 2000, 2});
  REQUIRE(rest.outcome.status == Status::ok);
  const JointSample& end = rest.samples.back().joints[0];
  CHECK(std::abs(static_cast<double>(end.force_N[2])) < 0.01 * 9.81);
  double carried = 0;
  for (const ContactSample& contact : rest.samples.back().contacts) carried += contact.force_n_N;
  CHECK(carried == Approx(9.81).epsilon(0.01));
}

// MuJoCo's body of a plane stands on the plane, wherever the scene's body is.
TEST_CASE("joints and ropes may be tied to a fixed plane") {
  Scene scene = bounce(0, 2);
  scene.bodies[0].position_m = {0.5, -0.3, -7};
  scene.bodies[0].orientation_wxyz = {0.6, 0, 0.8, 0};
  scene.bodies[0].shape = Plane{{0, 0, 1}, -7};
  const auto in_floor = [](const Real3& point) {
    return rivals::to_body({0.6, 0, 0.8, 0}, {point[0] - 0.5, point[1] + 0.3, point[2] + 7});
  };
  Joint closing;
  closing.name = "closing";
  closing.parent = 0;
  closing.child = 1;
  closing.kind = JointKind::ball;
  closing.closes_loop = true;
  closing.coordinates = {1, 0, 0, 0};
  closing.anchors_body_m = {in_floor({0, 0, 3.1}), {0, 0, 1}};
  Scene roped = scene;
  scene.joints = {closing};
  const Run hangs = run_with("stiff", scene, Plan{0.5, 2000, 2});
  REQUIRE(hangs.outcome.status == Status::ok);
  CHECK(hangs.p(1, 2) == Approx(2.1).margin(1e-3));
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  rope.points_body_m = {in_floor({0, 0, 3.1}), {0, 0, 0}};
  roped.ropes = {rope};
  const Run held = run_with("stiff", roped, Plan{0.5, 2000, 2});
  REQUIRE(held.outcome.status == Status::ok);
  CHECK(held.p(1, 2) == Approx(2.1).margin(1e-3));
  CHECK(static_cast<double>(held.samples.back().ropes[0].tension_N) == Approx(9.81).epsilon(1e-3));
}

TEST_CASE("scenes that MuJoCo does not support are refused, with its own message where there is one") {
  Scene light = free_box_complex();
  light.bodies[0].mass_kg = 1e-16;
  CHECK_THAT(try_run(engine(), method(engine(), "default"), light, Plan{1, 10, 10}).outcome.reason,
             Catch::Contains("MuJoCo's compiler says"));
  Scene heap = bounce(0, 1, 0.5);
  for (int i = 0; i < 5000; ++i) heap.bodies.push_back(sphere_body("b" + std::to_string(i), 1, 0.1, {0.3 * i, 0, 1}));
  const Run refused = try_run(engine(), method(engine(), "default"), heap, Plan{1, 10, 10});
  CHECK(to_string(refused.outcome.status) == "unsupported");
  CHECK_THAT(refused.outcome.reason, Catch::Contains("2 GiB"));
}

TEST_CASE("warnings go into the outcome, and no log file into the working directory") {
  const auto here = std::filesystem::current_path() / "MUJOCO_LOG.TXT";
  std::filesystem::remove(here);
  Scene scene = free_box_complex();
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1});  // the box starts in its centre: 0 / 0
  const Run lost = try_run(engine(), method(engine(), "default"), scene, Plan{1, 10, 10});
  CHECK(to_string(lost.outcome.status) == "not finite");
  CHECK_THAT(lost.outcome.reason, Catch::Contains("MuJoCo warned"));
  CHECK_FALSE(std::filesystem::exists(here));
}

}  // namespace atwood::test
