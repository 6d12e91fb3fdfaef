// Compositions and rotation methods in motion: executed order, symmetry, what they keep, and the exact free top.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <functional>

#include "rigid/free_top.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

const std::vector<std::string> composed{"forest-ruth", "pefrl", "mclachlan4", "suzuki4", "suzuki6", "suzuki8", "yoshida4",
                                        "yoshida6", "yoshida8", "blanes-moan4", "blanes-moan6", "kahan-li8"};
const std::vector<std::string> charges{"boris", "boris4", "boris6"};
const std::vector<std::string> turning{"rkmk4", "lie4", "free-top2", "free-top4", "free-top6", "moser-veselov",
                                       "implicit-midpoint-so3", "jacobi2", "jacobi4"};

std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> lists) {
  std::vector<std::string> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

// The tumbling body, in a magnetic field too, pulled by a spring at a corner: torque that depends on attitude, position
// and velocity.
Scene charged_box_on_a_spring() {
  Scene scene = thrust_and_drag();
  scene.bodies[0].charge_C = 1;
  scene.forces.push_back(Lorentz{{0}, {0.1, 0.3, 0}, {0.2, 0, 1.5}});
  return scene;
}

Scene tumbling(Real3 moments, Real3 w) {
  Scene scene = empty_scene();
  scene.bodies.push_back(box(moments, w));
  return scene;
}

// Neither free nor driven by velocities: a thruster off the centre.
Scene thrust_only() {
  Scene scene = thrust_and_drag();
  scene.forces.pop_back();
  return scene;
}

// A charge in a magnetic field and a central force: position and velocity both matter.
Scene charge_round_a_center() {
  Scene scene = e_cross_b();
  scene.bodies[0].position_m = {1, 0.2, 0};
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1.3});
  return scene;
}

double apart(const BodySample& a, const BodySample& b) {
  return distance(a.p_m, b.p_m) + distance(a.v_m_per_s, b.v_m_per_s) + attitude_distance(a.q_wxyz, b.q_wxyz) +
         distance(a.w_rad_per_s, b.w_rad_per_s);
}

BodySample end_of(const std::string& scheme, const Scene& scene, double t_end_s, std::int64_t steps, const std::string& scalar) {
  const Recorded r = run(scheme, scene, {t_end_s, steps, 1}, scalar);
  INFO(scheme << ": " << r.outcome.reason);
  REQUIRE(r.outcome.status == Status::ok);
  return r.samples.at(1).bodies[0];
}

double claimed(const std::string& scheme) { return find_integrator(scheme)->claimed_order.at("point-mass"); }

// Order over the last two rungs where the error falls by two orders of the finest.
void check_orders(const std::vector<std::string>& schemes, const Scene& scene, double t_end_s, std::int64_t base) {
  const BodySample truth = end_of("gauss8", scene, t_end_s, 48 * base, "quad");
  for (const std::string& scheme : schemes) {
    const double order = claimed(scheme);
    const std::int64_t steps = order > 6 ? 2 * base : order > 4 ? 4 * base : order > 2 ? 16 * base : 128 * base;
    const double coarse = apart(end_of(scheme, scene, t_end_s, steps, "quad"), truth);
    const double fine = apart(end_of(scheme, scene, t_end_s, 2 * steps, "quad"), truth);
    if (std::getenv("ATWOOD_SHOW") != nullptr)
      std::printf("  %-24s %4lld steps  error %.2e  order %.3f\n", scheme.c_str(), static_cast<long long>(2 * steps), fine, std::log2(coarse / fine));
    INFO(scheme << ", " << 2 * steps << " steps: " << fine);
    CHECK(std::log2(coarse / fine) == Approx(order).margin(0.15));
  }
}

TEST_CASE("executed order of compositions: points, position-only and time-dependent forces") {
  check_orders(joined({composed, charges, turning}), kepler(0.3), 1, 8);
  check_orders(joined({composed, charges, turning}), driven_oscillator(), 1, 8);
}

TEST_CASE("executed order of compositions: velocities matter") {
  check_orders(joined({composed, charges, turning}), charge_round_a_center(), 1, 8);
  check_orders(joined({composed, turning}), quadratic_drag(), 0.5, 8);
}

TEST_CASE("executed order of compositions: rotation") {
  check_orders(joined({composed, charges, turning}), thrust_only(), 1, 8);
  check_orders(joined({composed, turning}), charged_box_on_a_spring(), 1, 8);
  auto inexact = turning;
  inexact.resize(inexact.size() - 2);
  check_orders(joined({composed, charges, inexact}), tumbling({0.6, 0.8, 1.0}, {3, 0.5, -0.9}), 1, 8);
}

}  // namespace
}  // namespace atwood::testing
