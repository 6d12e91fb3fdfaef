// Walls of dummy particles: Couette flow, a column at rest, plates of given temperature and flux, bodies that float.
#include <catch2/catch.hpp>

#include "fluid/law.hpp"
#include "fluid/run.hpp"
#include "scene/fluid_walls.hpp"
#include "scenes.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

Sample last_of(const std::string& id, const Scene& scene, double t_end_s, std::int64_t steps, Sample* first = nullptr) {
  Sample last;
  bool begun = false;
  const Outcome outcome = run_fluid(parse_method_id("atwood/" + id), scene, {t_end_s, steps, 1, {}},
                                    {[&](const Sample& sample) {
                                       if (!begun && first != nullptr) *first = sample;
                                       begun = true;
                                       last = sample;
                                     },
                                     {},
                                     nullptr},
                                    0);
  INFO(outcome.reason);
  REQUIRE(outcome.status == Status::ok);
  return last;
}

void add_plane(Scene& scene, const std::string& name, const Real3& normal, double offset_m, FluidBoundary boundary = {},
               const Real3& velocity = {}) {
  Body body;
  body.name = name;
  body.shape = Plane{normal, offset_m};
  body.fixed = true;
  body.velocity_m_per_s = velocity;
  boundary.body = static_cast<int>(scene.bodies.size());
  scene.bodies.push_back(body);
  scene.fluid_boundaries.push_back(boundary);
}

// The unit square of fluid at rest, on the lattice, periodic along x.
Scene channel(int across) {
  Scene scene = block_scene({.across = across, .spacing_m = 1.0 / across, .disturbance = 0, .speed_m_per_s = 0});
  scene.domain.periodic_m = {1, 0, 0};
  Fluid& fluid = scene.fluids[0];
  fluid.region = BoxRegion{{0, 0, 0}, {1, 1, 0}};
  fluid.viscosity_m2_per_s = 0.1;
  for (double& density : fluid.particles.density_kg_per_m3) density = 1000;
  for (double& temperature : fluid.particles.temperature_K) temperature = 300;
  return scene;
}

}  // namespace

TEST_CASE("points of walls: layers to the reach, corners once") {
  Scene scene = channel(8);
  add_plane(scene, "floor", {0, 1, 0}, 0);
  CHECK(wall_points(scene, 0.3).size() == 8 * 3);
  CHECK(wall_points(scene, 0.25).size() == 8 * 2);
  for (const WallPoint& point : wall_points(scene, 0.3)) {
    CHECK(point.at_m[1] < 0);
    CHECK(point.at_m[1] > -0.32);
  }
  scene.domain.periodic_m = {};
  add_plane(scene, "left", {1, 0, 0}, 0);
  const std::vector<WallPoint> walls = wall_points(scene, 0.25);
  for (std::size_t a = 0; a < walls.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      REQUIRE(std::hypot(walls[a].at_m[0] - walls[b].at_m[0], walls[a].at_m[1] - walls[b].at_m[1]) > 0.124);
  scene.bodies[1].shape = Plane{{0.6, 0.8, 0}, 0};
  CHECK_THROWS_WITH(wall_points(scene, 0.25), Catch::Contains("left"));
}

TEST_CASE("Couette flow: a wall that slides in itself drags the fluid to a linear profile") {
  Scene scene = channel(12);
  add_plane(scene, "floor", {0, 1, 0}, 0);
  add_plane(scene, "lid", {0, -1, 0}, -1, {}, {1, 0, 0});
  // The extrapolated velocity is of first order in the spacing: off by .0105 at 12 particles across.
  const Sample end = last_of("rk4+sph", scene, 6, 1200);
  for (const ParticleSample& one : end.particles) {
    CHECK(static_cast<double>(one.v_m_per_s[0]) == Approx(static_cast<double>(one.p_m[1])).margin(0.015));
    CHECK(static_cast<double>(one.v_m_per_s[1]) == Approx(0).margin(0.005));
  }
  // A lid without friction moves nothing.
  scene.fluid_boundaries[1].slip = Slip::free_slip;
  for (const ParticleSample& one : last_of("rk4+sph", scene, 1, 200).particles)
    CHECK(static_cast<double>(real::abs(one.v_m_per_s[0])) < 1e-12);
}

TEST_CASE("a column rests on its floor between its walls with the pressure of its weight") {
  Scene scene = channel(12);
  scene.domain.periodic_m = {};
  scene.gravity_m_per_s2 = {0, -1, 0};
  add_plane(scene, "floor", {0, 1, 0}, 0);
  add_plane(scene, "left", {1, 0, 0}, 0);
  add_plane(scene, "right", {-1, 0, 0}, -1);
  Fluid& fluid = scene.fluids[0];
  fluid.viscosity_m2_per_s = 0.05;
  for (std::size_t i = 0; i < fluid.particles.mass_kg.size(); ++i) {
    fluid.particles.density_kg_per_m3[i] = 1000 * (1 + (1 - fluid.particles.position_m[i][1]) / 100);
    fluid.particles.mass_kg[i] = fluid.particles.density_kg_per_m3[i] / 144;
  }
  const Sample end = last_of("rk4+sph", scene, 2, 800);
  double fastest = 0;
  for (const ParticleSample& one : end.particles) {
    const double depth = 1 - static_cast<double>(one.p_m[1]);
    if (depth > 0.25) CHECK(static_cast<double>(one.pressure_Pa) == Approx(1000 * depth).margin(60));
    fastest = std::max(fastest, static_cast<double>(real::abs(one.v_m_per_s[1])));
  }
  CHECK(fastest < 0.02);
}

TEST_CASE("plates of given temperature conduct to a linear profile, a given flux warms by its heat") {
  Scene scene = channel(12);
  Fluid& fluid = scene.fluids[0];
  fluid.heat_capacity_J_per_kg_K = 1;
  fluid.conductivity_W_per_m_K = 200;
  FluidBoundary cold, warm;
  cold.temperature_K = 300;
  warm.temperature_K = 310;
  add_plane(scene, "cold", {0, 1, 0}, 0, cold);
  add_plane(scene, "warm", {0, -1, 0}, -1, warm);
  for (const ParticleSample& one : last_of("rk4+sph", scene, 3, 600).particles)
    CHECK(static_cast<double>(one.temperature_K) == Approx(300 + 10 * static_cast<double>(one.p_m[1])).margin(0.05));
  scene.fluid_boundaries[0].temperature_K.reset();
  scene.fluid_boundaries[1].temperature_K.reset();
  scene.fluid_boundaries[1].heat_flux_W_per_m2 = 500;
  // Also of particles in disorder, whatever the smoothing, and in a corner of two walls.
  for (const double disturbance : {0.0, 0.3})
    for (const char* method : {"rk4+sph", "rk4+sph{smoothing=2}"})
      for (const bool closed : {false, true}) {
        Scene heated = scene;
        if (closed) {
          heated.domain.periodic_m = {};
          add_plane(heated, "left", {1, 0, 0}, 0);
          add_plane(heated, "right", {-1, 0, 0}, -1);
        }
        const Scene moved = block_scene({.across = 12, .spacing_m = 1.0 / 12, .disturbance = disturbance});
        heated.fluids[0].particles.position_m = moved.fluids[0].particles.position_m;
        Wide heat = 0;
        for (const ParticleSample& one : last_of(method, heated, 0.2, 200).particles)
          heat += (one.temperature_K - 300) * 1000 / 144;
        CAPTURE(disturbance, method, closed);
        CHECK(static_cast<double>(heat) == Approx(100).epsilon(1e-10));
      }
}

TEST_CASE("+polynomial refuses a flux into a fluid that conducts no heat") {
  Scene scene = channel(12);
  scene.fluids[0].heat_capacity_J_per_kg_K = 1;
  FluidBoundary warm;
  warm.heat_flux_W_per_m2 = 500;
  add_plane(scene, "floor", {0, 1, 0}, 0);
  add_plane(scene, "warm", {0, -1, 0}, -1, warm);
  const auto outcome = [&] {
    return run_fluid(parse_method_id("atwood/rk4+polynomial{degree=2}"), scene, {0.01, 20, 1, {}}, {}, 0);
  };
  CHECK(outcome().status == Status::unsupported);
  CHECK_THAT(outcome().reason, Catch::Contains("conducts no heat"));
  scene.fluids[0].conductivity_W_per_m_K = 1;
  CHECK(outcome().status == Status::ok);
}

TEST_CASE("points of walls at the surface have its area, in corners none twice") {
  Scene scene = channel(8);
  scene.domain.periodic_m = {};
  add_plane(scene, "floor", {0, 1, 0}, 0);
  add_plane(scene, "left", {1, 0, 0}, 0);
  add_plane(scene, "right", {-1, 0, 0}, -1);
  add_plane(scene, "lid", {0, -1, 0}, -1);
  Body disc;
  disc.name = "disc";
  disc.shape = Sphere{0.2};
  disc.position_m = {0.5, 0.5, 0};
  scene.bodies.push_back(disc);
  scene.fluid_boundaries.push_back({4, Slip::no_slip, {}, {}});
  disc.shape = Box{{0.1, 0.05, 1}};
  disc.position_m = {0.85, 0.85, 0};
  scene.bodies.push_back(disc);
  scene.fluid_boundaries.push_back({5, Slip::no_slip, {}, {}});
  double areas[6] = {};
  for (const WallPoint& point : wall_points(scene, 0.3)) areas[point.boundary] += point.area_m2;
  for (int wall = 0; wall < 4; ++wall) CHECK(areas[wall] == Approx(1).epsilon(1e-13));
  CHECK(areas[4] == Approx(2 * 3.14159265358979 * 0.2).epsilon(1e-13));
  CHECK(areas[5] == Approx(0.6).epsilon(1e-13));
}

TEST_CASE("a floating body and the fluid exchange momentum to round-off") {
  Scene scene = block_scene({.across = 12, .spacing_m = 1.0 / 12});
  scene.domain.periodic_m = {};
  Body cube;
  cube.name = "cube";
  cube.mass_kg = 40;
  cube.inertia_kg_m2 = {1, 0, 0, 0, 1, 0, 0, 0, 0.4};
  cube.shape = Box{{0.17, 0.17, 0.5}};
  cube.position_m = {0.5, 0.5, 0};
  cube.velocity_m_per_s = {0.5, 0.2, 0};
  scene.bodies.push_back(cube);
  scene.fluid_boundaries.push_back({0, Slip::no_slip, {}, {}});
  Particles& particles = scene.fluids[0].particles;
  for (std::size_t i = particles.mass_kg.size(); i-- > 0;)
    if (depth_in_body_m(cube, 2, particles.position_m[i]) > -0.03) {
      particles.position_m.erase(particles.position_m.begin() + i);
      particles.velocity_m_per_s.erase(particles.velocity_m_per_s.begin() + i);
      particles.mass_kg.erase(particles.mass_kg.begin() + i);
      particles.density_kg_per_m3.erase(particles.density_kg_per_m3.begin() + i);
      particles.temperature_K.erase(particles.temperature_K.begin() + i);
    }
  Sample start;
  const Sample end = last_of("rk4+sph", scene, 0.2, 200, &start);
  const auto momentum = [&](const Sample& sample, int c, bool size) {
    Wide sum = Wide(cube.mass_kg) * sample.bodies[0].v_m_per_s[c];
    if (size) sum = real::abs(sum);
    for (std::size_t i = 0; i < sample.particles.size(); ++i) {
      const Wide one = Wide(particles.mass_kg[i]) * sample.particles[i].v_m_per_s[c];
      sum += size ? real::abs(one) : one;
    }
    return sum;
  };
  for (const int c : {0, 1}) {
    CHECK(static_cast<double>(real::abs(momentum(end, c, false) - momentum(start, c, false)) / momentum(end, c, true)) <
          1e-15);
    CHECK(static_cast<double>(real::abs(end.bodies[0].v_m_per_s[c] - start.bodies[0].v_m_per_s[c])) > 1e-3);
  }
}

TEST_CASE("a particle that goes through a wall ends the run with its name") {
  Scene scene = channel(12);
  add_plane(scene, "floor", {0, 1, 0}, 0);
  scene.fluids[0].particles.velocity_m_per_s[3] = {0, -400, 0};
  const Outcome outcome = run_fluid(parse_method_id("atwood/rk4+sph"), scene, {0.01, 20, 20, {}}, {}, 0);
  CHECK(outcome.status == Status::diverged);
  CHECK_THAT(outcome.reason, Catch::Contains("particle 3 of `water` went through the boundary `floor` at [") &&
                                 Catch::Contains(" m at t = "));
}

TEST_CASE("a lost particle is reported in the step in which it is lost, whatever the samples") {
  Scene scene = channel(12);
  add_plane(scene, "floor", {0, 1, 0}, 0);
  scene.fluids[0].particles.velocity_m_per_s[3] = {0, -400, 0};
  for (const char* method : {"atwood/rk4+sph", "atwood/rk4+polynomial{degree=2}"}) {
    const MethodId id = parse_method_id(method);
    const Outcome often = run_fluid(id, scene, {0.01, 200, 200, {}}, {}, 0);
    const Outcome once = run_fluid(id, scene, {0.01, 200, 1, {}}, {}, 0);
    const Outcome timed = run_fluid(id, scene, {0.01, 200, 1, {}}, {}, 1);
    INFO(method << ": " << often.reason << " / " << once.reason);
    CHECK(often.status == Status::diverged);
    CHECK_THAT(often.reason, Catch::Contains("went through the boundary `floor`"));
    CHECK(once.reason == often.reason);
    CHECK(timed.reason == often.reason);
  }
}

TEST_CASE("a particle inside a fixed box or ball is lost too") {
  for (const Shape& shape : {Shape(Box{{0.25, 0.25, 0.25}}), Shape(Sphere{0.25})}) {
    Scene scene = channel(12);
    Body body;
    body.name = "obstacle";
    body.shape = shape;
    body.fixed = true;
    body.position_m = {0.5, -0.5, 0};
    scene.bodies.push_back(body);
    scene.fluid_boundaries.push_back({0, Slip::no_slip, {}, {}});
    scene.fluids[0].particles.position_m[3] = {0.5, -0.5, 0};
    const Outcome outcome = run_fluid(parse_method_id("atwood/rk4+sph"), scene, {1e-4, 10, 1, {}}, {}, 0);
    CHECK_THAT(outcome.reason, Catch::Contains("particle 3 of `water` went through the boundary `obstacle`"));
  }
}

namespace {

Body moving_body(const std::string& name, const Shape& shape, const Real3& at, const Real3& velocity) {
  Body body;
  body.name = name;
  body.shape = shape;
  body.mass_kg = 1e6;  // the fluid hardly moves it
  body.inertia_kg_m2 = {1e6, 0, 0, 0, 1e6, 0, 0, 0, 1e6};
  body.position_m = at;
  body.velocity_m_per_s = velocity;
  return body;
}

Scene with_bodies(const std::vector<Body>& bodies) {
  Scene scene = channel(12);
  add_plane(scene, "floor", {0, 1, 0}, -1);
  for (const Body& body : bodies) {
    scene.fluid_boundaries.push_back({static_cast<int>(scene.bodies.size()), Slip::no_slip, {}, {}});
    scene.bodies.push_back(body);
  }
  return scene;
}

Outcome run_bodies(const Scene& scene, double t_end_s, const std::string& method = "atwood/rk4+sph") {
  return run_fluid(parse_method_id(method), scene, {t_end_s, 200, 1, {}}, {}, 0);
}

double time_in(const std::string& reason) {
  const std::string before = " at t = ";
  const std::size_t at = reason.rfind(before);
  return at == std::string::npos ? -1 : std::stod(reason.substr(at + before.size()));
}

}  // namespace

TEST_CASE("a body that runs into a boundary or a body ends the run where and when it does") {
  const Box cube{{0.1, 0.1, 0.1}};
  // All far from the fluid, which is at rest above y = 0: the touch is known.
  const Body falling = moving_body("cube", cube, {0.5, -0.8, 0}, {0, -10, 0});  // the floor is 0.1 m below
  const Outcome floor = run_bodies(with_bodies({falling}), 0.02);
  INFO(floor.reason);
  CHECK(floor.status == Status::diverged);
  CHECK_THAT(floor.reason, Catch::Contains("the body `cube` ran into the boundary `floor`") &&
                               Catch::Contains("contact between bodies is not part of +sph"));
  CHECK(time_in(floor.reason) == Approx(0.01).margin(2e-4));
  CHECK(run_bodies(with_bodies({falling}), 0.0098).status == Status::ok);
  CHECK(time_in(run_bodies(with_bodies({falling}), 0.02, "atwood/rk4+sph@float").reason) == Approx(0.01).margin(2e-4));

  // Two boxes, the second turned by 45 degrees; a ball; an image along the period of 1 m.
  Body turned = moving_body("turned", cube, {0.8, -0.5, 0}, {-10, 0, 0});
  turned.orientation_wxyz = {std::cos(std::acos(-1.0) / 8), 0, 0, std::sin(std::acos(-1.0) / 8)};
  const Body still = moving_body("still", cube, {0.5, -0.5, 0}, {0, 0, 0});
  const double corner = 0.3 - 0.1 - 0.1 * std::sqrt(2.0);
  const Outcome pair = run_bodies(with_bodies({still, turned}), 0.02);
  CHECK_THAT(pair.reason, Catch::Contains("the body `still` ran into the body `turned`"));
  CHECK(time_in(pair.reason) == Approx(corner / 10).margin(2e-4));
  const Body ball = moving_body("ball", Sphere{0.1}, {0.2, -0.5, 0}, {-10, 0, 0});
  const Outcome image =
      run_bodies(with_bodies({moving_body("east", Sphere{0.1}, {0.9, -0.5, 0}, {0, 0, 0}), ball}), 0.02);
  CHECK_THAT(image.reason, Catch::Contains("the body `east` ran into the body `ball`"));
  CHECK(time_in(image.reason) == Approx(0.01).margin(2e-4));
  CHECK(run_bodies(with_bodies({still, ball}), 0.002).status == Status::ok);
}

TEST_CASE("a scene that starts with overlapping bodies is refused, one with bodies that touch is not") {
  const Box cube{{0.1, 0.1, 0.1}};
  const auto refused = [&](const std::vector<Body>& bodies) { return run_bodies(with_bodies(bodies), 1e-4); };
  const Outcome low = refused({moving_body("cube", cube, {0.5, -0.95, 0}, {})});
  CHECK(low.status == Status::unsupported);
  CHECK_THAT(low.reason, Catch::Contains("the body `cube` and the boundary `floor` overlap at the start, by 0.05"));
  const Outcome two =
      refused({moving_body("a", cube, {0.5, -0.5, 0}, {}), moving_body("b", cube, {0.65, -0.5, 0}, {})});
  CHECK(two.status == Status::unsupported);
  CHECK_THAT(two.reason, Catch::Contains("the body `a` and the body `b` overlap at the start"));
  CHECK(refused({moving_body("cube", cube, {0.5, -0.9, 0}, {})}).status == Status::ok);
  CHECK(refused({moving_body("a", cube, {0.5, -0.5, 0}, {}), moving_body("b", cube, {0.7, -0.5, 0}, {})}).status ==
        Status::ok);
  // What a joint ties may overlap.
  Scene tied = with_bodies({moving_body("a", cube, {0.5, -0.5, 0}, {}), moving_body("b", cube, {0.65, -0.5, 0}, {})});
  Joint joint;
  joint.parent = 1, joint.child = 2;
  tied.joints.push_back(joint);
  CHECK_THAT(run_bodies(tied, 1e-4).reason, !Catch::Contains("overlap"));
}
