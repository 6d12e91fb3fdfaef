// Walls of +polynomial in two and three dimensions: start-up flows between plates, heat between insulated walls, the
// points that walls have.
#include <catch2/catch.hpp>
#include <cmath>

#include "fluid/polynomial.hpp"
#include "rk4_run.hpp"
#include "scenes.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

constexpr double kPi = 3.14159265358979323846;

// A block of edge 1 m, at rest, of uniform density, n particles across.
Scene block_at_rest(int dimensions, int n, double disturbance) {
  Scene scene = block_scene(
      {.dimensions = dimensions, .across = n, .spacing_m = 1.0 / n, .disturbance = disturbance, .speed_m_per_s = 0});
  Fluid& fluid = scene.fluids.front();
  fluid.density_kg_per_m3 = 1;
  fluid.region = BoxRegion{{0, 0, 0}, {1, 1, dimensions == 3 ? 1.0 : 0.0}};
  for (std::size_t i = 0; i < fluid.particles.mass_kg.size(); ++i) {
    fluid.particles.velocity_m_per_s[i] = {};
    fluid.particles.density_kg_per_m3[i] = 1;
    fluid.particles.mass_kg[i] = std::pow(fluid.spacing_m, dimensions);
  }
  return scene;
}

// Walls at 0 and 1 m across an axis.
void add_walls(Scene& scene, int axis, const Real3& upper_velocity = {}) {
  scene.domain.periodic_m[axis] = 0;
  for (const bool lower : {true, false}) {
    Body wall;
    wall.name = std::string(lower ? "lower " : "upper ") + "xyz"[axis];
    wall.fixed = true;
    Plane plane{{}, lower ? 0.0 : -1.0};
    plane.normal[axis] = lower ? 1 : -1;
    wall.shape = plane;
    if (!lower) wall.velocity_m_per_s = upper_velocity;
    FluidBoundary boundary;
    boundary.body = static_cast<int>(scene.bodies.size());
    scene.bodies.push_back(wall);
    scene.fluid_boundaries.push_back(boundary);
  }
}

std::vector<double> run(Polynomial<double>& fluid, double t_end_s, int steps) {
  REQUIRE(fluid.unsupported() == "");
  return run_rk4(fluid, t_end_s, steps);
}

// The largest error of the velocity at t = 0.05 s with nu = 1 m^2/s, over the largest exact speed: a flow that gravity
// drives between fixed plates, or one that the upper plate drags. Series of J. P. Morris, P. J. Fox and Y. Zhu, J.
// Comput. Phys. 136 (1997) 214.
double start_up_error(int dimensions, int n, bool dragged) {
  Scene scene = block_at_rest(dimensions, n, 0.2);
  scene.fluids.front().viscosity_m2_per_s = 1;
  add_walls(scene, 1, {dragged ? 1.0 : 0.0, 0, 0});
  if (!dragged) scene.gravity_m_per_s2 = {8, 0, 0};
  Polynomial<double> fluid(scene, {});
  const double t = 0.05;
  const std::vector<double> y = run(fluid, t, n * n / 2);
  const Layout& at = fluid.layout();
  double error = 0, speed = 0;
  for (int i = 0; i < at.particles; ++i) {
    const double s = y[dimensions * i + 1];
    double exact = dragged ? s : 4 * s * (1 - s);
    for (int k = 1; k < 40; ++k) {
      const double decayed = std::sin(k * kPi * s) * std::exp(-k * k * kPi * kPi * t);
      if (dragged) exact += 2 / (k * kPi) * (k % 2 == 0 ? 1 : -1) * decayed;
      else if (k % 2 == 1) exact -= 32 / std::pow(k * kPi, 3) * decayed;
    }
    for (int c = 0; c < dimensions; ++c)
      error = std::max(error, std::abs(y[at.velocities() + dimensions * i + c] - (c == 0 ? exact : 0)));
    speed = std::max(speed, exact);
  }
  return error / speed;
}

// The root mean square of the temperature's error at t = 0.05 s over that of the temperature, with a diffusivity of
// 1 m^2/s: a fluid at 0 between a wall at 0 and one at 1 across y, while its other walls let no heat through.
double conduction_error(int dimensions, int n) {
  Scene scene = block_at_rest(dimensions, n, 0.2);
  Fluid& fluid = scene.fluids.front();
  fluid.heat_capacity_J_per_kg_K = 1;
  fluid.conductivity_W_per_m_K = 1;
  fluid.particles.temperature_K.assign(fluid.particles.mass_kg.size(), 0);
  for (int axis = 0; axis < dimensions; ++axis) add_walls(scene, axis);
  for (FluidBoundary& boundary : scene.fluid_boundaries) {
    const double upward = std::get<Plane>(scene.bodies[boundary.body].shape).normal[1];
    if (upward != 0) boundary.temperature_K = upward > 0 ? 0 : 1;
  }
  Polynomial<double> particles(scene, {});
  const double t = 0.05;
  const std::vector<double> y = run(particles, t, 7 * n * n / 2);
  double error2 = 0, size2 = 0;
  for (int i = 0; i < particles.layout().particles; ++i) {
    const double s = y[std::size_t(i) * dimensions + 1];
    double exact = s;
    for (int k = 1; k < 40; ++k)
      exact += 2 / (k * kPi) * (k % 2 == 0 ? 1 : -1) * std::sin(k * kPi * s) * std::exp(-k * k * kPi * kPi * t);
    error2 += std::pow(y[particles.layout().temperatures() + i] - exact, 2);
    size2 += exact * exact;
  }
  return std::sqrt(error2 / size2);
}

}  // namespace

TEST_CASE("Start-up flows between plates: order 4, and in three dimensions the error of two") {
  for (const bool dragged : {false, true}) {
    CAPTURE(dragged);
    const double coarse = start_up_error(2, 10, dragged), fine = start_up_error(2, 20, dragged);
    CAPTURE(coarse, fine);
    CHECK(std::log2(coarse / fine) > 3.6);
    const double in_space = start_up_error(3, 10, dragged);
    CAPTURE(in_space);
    CHECK(in_space < 1.5 * coarse);
  }
}

TEST_CASE("Heat between plates beside insulated walls: order 4, and in three dimensions an error near that of two") {
  const double coarsest = conduction_error(2, 8), coarse = conduction_error(2, 10), fine = conduction_error(2, 20);
  const double in_space = conduction_error(3, 8);
  CAPTURE(coarsest, coarse, fine, in_space);
  CHECK(std::log2(coarse / fine) > 3.6);
  CHECK(in_space < 3 * coarsest);
}

TEST_CASE("A closed box has the points of its walls that some particle reaches, and no others") {
  Scene scene = block_at_rest(3, 6, 0);
  for (int axis = 0; axis < 3; ++axis) add_walls(scene, axis);
  Polynomial<double> fluid(scene, {});
  REQUIRE(fluid.unsupported() == "");
  std::vector<double> y(fluid.layout().size());
  fluid.initial_state(y.data());
  fluid.mean_neighbours(y.data());
  // 6^3 particles, a node a cell of the surface, and two layers of points around them.
  CHECK(fluid.neighbours().count() == 6 * 6 * 6 + 6 * 6 * 6 + (10 * 10 * 10 - 6 * 6 * 6));
}
