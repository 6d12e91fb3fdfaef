// Radau 15 for gravitating point masses in one kernel: the stages of the general sweeps to round-off or to the
// tolerance, with fewer evaluations, the same bits at every vector width; and which systems it takes.
#include <catch2/catch.hpp>

#include "integrators/radau15_point_masses.hpp"
#include "many_bodies.hpp"

namespace atwood::testing {
namespace {

// Three bodies that meet closely, in the plane z = `z_m` if they do not move out of it.
Scene triangle(double z_m, double out_of_plane_m_per_s) {
  Scene scene = empty_scene();
  MutualGravity gravity;
  gravity.constant_m3_per_kg_s2 = 1;
  const double x[] = {1, -2, 1}, y[] = {3, -1, -1};
  for (int i = 0; i < 3; ++i) {
    scene.bodies.push_back(point("mass-" + std::to_string(3 + i), 3 + i, {x[i], y[i], z_m}, {0, 0, 0}));
    gravity.bodies.push_back(i);
  }
  scene.bodies[0].velocity_m_per_s = {0.1, 0, out_of_plane_m_per_s};
  scene.forces.push_back(gravity);
  return scene;
}

Scene softened() {
  Scene scene = triangle(0, 0.2);
  std::get<MutualGravity>(scene.forces[0]).softening_m = 0.1;
  return scene;
}

// Two planets about a centre, which also attract each other, in a uniform field.
Scene planets_in_field() {
  Scene scene = kepler(0.3);
  scene.gravity_m_per_s2 = {0, 0.01, -0.02};
  scene.bodies.push_back(point("second", 1e-3, {0, 3, 0.5}, {-0.5, 0, 0}));
  std::get<Attractor>(scene.forces[0]).bodies.push_back(1);
  MutualGravity gravity;
  gravity.constant_m3_per_kg_s2 = 1;
  gravity.bodies = {0, 1};
  scene.forces.push_back(gravity);
  return scene;
}

struct Path {
  std::vector<std::vector<double>> states;
  std::int64_t evaluations = 0;
  SolveTally sweeps;
};

// rtol = 0: equal steps. Every fifth step is taken again from its start with 0.7 of its length first, as samples are.
Path path_of(const Scene& scene, double h_s, double rtol, int steps, const RadauOptions& options,
             VectorWidth width = widest_vectors()) {
  RigidModel<double> model(scene);
  Radau15<double> stepper(model.system(), &model, options);
  stepper.set_vector_width(width);
  Path path;
  std::vector<double> y(model.state_size()), y_new(model.state_size());
  model.initial_state(y.data());
  if (rtol > 0) stepper.set_tolerance(rtol, rtol / 100);
  double t_s = 0;
  for (int n = 0; n < steps; ++n) {
    if (n % 5 == 4) {
      stepper.step(t_s, 0.7 * h_s, y.data(), y_new.data());
      path.states.push_back(y_new);
    }
    stepper.step(t_s, h_s, y.data(), y_new.data());
    const double taken_s = h_s;
    if (rtol > 0) {
      const auto advice = stepper.advise(rtol, rtol / 100);
      h_s = advice.next_s;
      if (!advice.accepted) continue;
    }
    t_s += taken_s;
    y.swap(y_new);
    path.states.push_back(y);
    if (n % 17 == 16) y[0] += 1e-3;  // as an impact does: the next step has no prediction
  }
  path.evaluations = model.system().evaluations;
  path.sweeps = model.system().solvers.of[static_cast<std::size_t>(IterativeSolver::implicit_stages)];
  return path;
}

double largest_difference(const Path& a, const Path& b) {
  double most = 0;
  for (std::size_t n = 0; n < a.states.size(); ++n)
    for (std::size_t i = 0; i < a.states[n].size(); ++i)
      most = std::max(most, std::abs(a.states[n][i] - b.states[n][i]));
  return most;
}

// In 120 equal steps. Round-off makes the two differ as starts differ that are a unit in the last place apart.
void compare(const Scene& scene, double h_s, bool compensated = true) {
  const auto path = [&](bool fused, VectorWidth width) {
    return path_of(scene, h_s, 0, 120, RadauOptions{false, compensated, fused}, width);
  };
  const Path general = path(false, widest_vectors()), one_kernel = path(true, widest_vectors());
  for (const VectorWidth width : widths_here()) {
    const Path at_width = path(true, width);
    CHECK(one_kernel.states == at_width.states);
    CHECK(one_kernel.evaluations == at_width.evaluations);
    CHECK(one_kernel.sweeps == at_width.sweeps);
  }
  CHECK(one_kernel.evaluations < general.evaluations);
  REQUIRE(one_kernel.states.size() == general.states.size());
  Scene beside = scene;
  for (double& x : beside.bodies[0].position_m) x = std::nextafter(x, 10);
  const Path moved = path_of(beside, h_s, 0, 120, RadauOptions{false, compensated, false});
  CHECK(largest_difference(general, one_kernel) / largest_difference(general, moved) < 10);
}

bool taken(const Scene& scene) { return gravitating_bodies(RigidModel<double>(scene)) != nullptr; }

TEST_CASE("one kernel solves the stages of the general sweeps, with fewer evaluations") {
  compare(kepler(0.6), 0.05);
  compare(kepler(0.6), 0.05, false);
  compare(triangle(0, 0), 0.02);
  compare(triangle(0.5, 0), 0.02);
  compare(triangle(0, 0.2), 0.02);
  compare(softened(), 0.02);
  compare(planets_in_field(), 0.05);
}

TEST_CASE("the gradient of gravity saves a third of the evaluations of steps with a tolerance") {
  for (const double rtol : {1e-8, 1e-10}) {
    INFO("tolerance " << rtol);
    const auto evaluations = [&](bool fused) {
      const Path path = path_of(kepler(0.6), 0.05, rtol, 120, RadauOptions{false, true, fused});
      return static_cast<double>(path.evaluations) / static_cast<double>(path.states.size());
    };
    CHECK(evaluations(true) < 0.67 * evaluations(false));
  }
}

TEST_CASE("a step without a finite rate fails alike") {
  Scene on_centre = kepler(0.6), on_each_other = triangle(0, 0);
  on_centre.bodies[0].position_m = {0, 0, 0};
  on_centre.bodies[0].velocity_m_per_s = {0, 0, 0};
  on_each_other.bodies[1].position_m = on_each_other.bodies[0].position_m;
  for (const Scene& scene : {on_centre, on_each_other})
    for (const bool fused : {false, true}) {
      RigidModel<double> model(scene);
      Radau15<double> stepper(model.system(), &model, RadauOptions{false, true, fused});
      std::vector<double> y(model.state_size()), y_new(y);
      model.initial_state(y.data());
      CHECK_FALSE(stepper.step(0, 0.05, y.data(), y_new.data()));
    }
}

TEST_CASE("the kernel takes point masses under gravity alone, and says when they stay in a plane") {
  CHECK(taken(kepler(0.6)));
  CHECK(taken(triangle(0, 0)));
  CHECK(taken(planets_in_field()));
  for (const Scene& scene :
       {free_box(), quadratic_drag(), e_cross_b(), driven_oscillator(), thrust_and_drag(), oscillator()})
    CHECK_FALSE(taken(scene));
  Scene released = kepler(0.6);
  released.bodies[0].release_s = 0.5;
  CHECK_FALSE(taken(released));
  const auto in_plane = [](const Scene& scene) {
    RigidModel<double> model(scene);
    std::vector<double> y(model.state_size());
    model.initial_state(y.data());
    return gravitating_bodies(model)->in_plane(y.data());
  };
  CHECK(in_plane(triangle(0.5, 0)));
  CHECK_FALSE(in_plane(triangle(0.5, 0.1)));
  CHECK_FALSE(in_plane(planets_in_field()));
}

TEST_CASE("a fixed body of mutual gravity is a centre") {
  Scene scene = triangle(0, 0.2);
  scene.bodies[1].fixed = true;
  REQUIRE(taken(scene));
  const Path general = path_of(scene, 0.02, 0, 40, RadauOptions{false, true, false}),
             one_kernel = path_of(scene, 0.02, 0, 40, RadauOptions{});
  REQUIRE(general.states.size() == one_kernel.states.size());
  for (std::size_t i = 0; i < general.states.back().size(); ++i)
    CHECK(general.states.back()[i] == Approx(one_kernel.states.back()[i]).epsilon(1e-12).margin(1e-12));
}

}  // namespace
}  // namespace atwood::testing
