// Every smooth closed form solves the reference's equations of motion: differentiated samples against the rates.
#include <catch2/catch.hpp>

#include "scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

double residual_of(const std::string& solution, double t_end_s, std::vector<Body> bodies, std::vector<Force> forces,
                   Real3 gravity, std::int64_t samples = 1024) {
  Scenario given = scenario(solution, t_end_s);
  given.scene.bodies = std::move(bodies);
  given.scene.forces = std::move(forces);
  given.scene.gravity_m_per_s2 = gravity;
  const Truth truth = closed_form_truth(given, samples);
  INFO(truth.outcome.reason);
  CHECK(truth.outcome.status == Status::ok);
  double bar = 0;
  for (const SampleView sample : truth.bars)
    for (const BodySample& body : sample.bodies)
      for (int k = 0; k < 3; ++k)
        bar = std::fmax(bar, static_cast<double>(fmaxq(body.p_m[k], fmaxq(body.v_m_per_s[k], body.q_wxyz[k]))));
  CHECK(bar > 0);
  CHECK(bar < 1e-22);
  return residual(given, samples);
}

}  // namespace

TEST_CASE("Points in force fields solve their equations") {
  CHECK(residual_of("ballistic", 2, {point("p", 1, {1, 2, 3}, {7.5, 0, 7.5})}, {}, down) < 1e-24);
  const LinearDrag drag{{0}, 0.3, {1, -2, 0.5}, 0};
  CHECK(residual_of("linear-drag", 2, {point("p", 0.7, {0, 1, 2}, {8, 3, 6})}, {drag}, down) < 1e-22);
  const LinearDrag faint{{0}, 1e-9, {1, -2, 0.5}, 0};
  CHECK(residual_of("linear-drag", 2, {point("p", 0.7, {0, 1, 2}, {8, 3, 6})}, {faint}, down) < 1e-22);
}

TEST_CASE(
    "Quadratic drag along gravity: dropped, thrown down too fast, and in wind; without gravity in any direction") {
  const QuadraticDrag air{{0}, 1.2, 0.47, 0.05, {0, 0, 0}, 0}, draught{{0}, 1.2, 0.47, 0.05, {2, 0, 1}, 0};
  CHECK(residual_of("vertical-quadratic-drag", 3, {point("p", 0.2, {0, 0, 9}, {0, 0, 0})}, {air}, down) < 1e-20);
  CHECK(residual_of("vertical-quadratic-drag", 3, {point("p", 0.2, {0, 0, 9}, {0, 0, -40})}, {air}, down, 4096) <
        1e-20);
  CHECK(residual_of("vertical-quadratic-drag", 0.5, {point("p", 0.2, {0, 0, 9}, {2, 0, 9})}, {draught}, down) < 1e-18);
  CHECK(residual_of("vertical-quadratic-drag", 3, {point("p", 0.2, {0, 0, 9}, {3, 4, -5})}, {draught}, {0, 0, 0}) <
        1e-18);
  // Thrown up it turns: |u| u has a kink in its second derivative there, so the two sides are differentiated apart.
  Scenario up = scenario("vertical-quadratic-drag", 3);
  up.scene.bodies = {point("p", 0.2, {0, 0, 9}, {0, 0, 15})};
  up.scene.forces = {air};
  up.scene.gravity_m_per_s2 = down;
  const Truth whole = closed_form_truth(up, 4096);
  std::size_t turn = 0;
  while (whole.values[turn].bodies[0].v_m_per_s[2] > 0) ++turn;
  REQUIRE(turn > 100);
  Scenario after = up;  // the rest of the flight, restarted from doubles near a sample past the turn
  const BodySample& from = whole.values[turn + 1].bodies[0];
  after.scene.bodies[0].position_m[2] = static_cast<double>(from.p_m[2]);
  after.scene.bodies[0].velocity_m_per_s[2] = static_cast<double>(from.v_m_per_s[2]);
  after.t_end_s = 3 * 1024 / 4096.0;
  const Truth rest = closed_form_truth(after, 1024);
  CHECK(static_cast<double>(fabsq(rest.values[1024].bodies[0].p_m[2] - whole.values[turn + 1025].bodies[0].p_m[2])) <
        1e-14);
  Scenario before = up;
  before.t_end_s = 3.0 * static_cast<double>(turn - 1) / 4096;
  CHECK(residual(before, 2048) < 1e-18);
}

TEST_CASE("Oscillators: free in three dimensions, damped three ways, driven, at resonance, with rest length") {
  const auto spring = [](double k, double c, double length) { return Spring{{0}, {0.5, 0, 0}, k, c, length, {}}; };
  const Body bob = point("bob", 2, {1, 0, 0}, {-0.5, 0, 0}), free = point("bob", 2, {1, 0.25, -1}, {-0.5, 1, 2});
  const Drive push{{0}, {3, 0, 0}, 1.7, 0.4};
  CHECK(residual_of("oscillator", 4, {free}, {spring(8, 0, 0)}, down) < 1e-20);
  CHECK(residual_of("oscillator", 4, {free}, {spring(8, 0, 0), LinearDrag{{0}, 0.7, {1, 2, 0}, 0}}, down) < 1e-20);
  CHECK(residual_of("oscillator", 4, {bob}, {spring(8, 1, 0), push}, {0, 0, 0}) < 1e-20);         // under
  CHECK(residual_of("oscillator", 4, {bob}, {spring(8, 8, 0), push}, {0, 0, 0}) < 1e-20);         // critical
  CHECK(residual_of("oscillator", 4, {bob}, {spring(8, 8.0000001, 0)}, {0, 0, 0}) < 1e-20);       // beside it
  CHECK(residual_of("oscillator", 4, {bob}, {spring(8, 30, 0), push}, {0, 0, 0}, 4096) < 1e-18);  // over
  CHECK(residual_of("oscillator", 4, {bob}, {spring(8, 0, 0), Drive{{0}, {3, 1, 0}, 2, 0.4}}, {0, 0, 0}) < 1e-20);
  Body small = point("bob", 2, {3, 0, 0}, {-0.5, 0, 0});
  CHECK(residual_of("oscillator", 4, {small}, {spring(8, 0.5, 2)}, {0, 0, 0}) < 1e-20);
}

TEST_CASE("Conics: circle, near circle, long ellipse, parabola, hyperbola, in three dimensions, and of two bodies") {
  const Attractor sun{{0}, {0.25, 0, -1}, 2};
  CHECK(residual_of("kepler", 5, {point("p", 1, {1.25, 0, -1}, {0, 1, 1})}, {sun}, {0, 0, 0}) < 1e-20);  // e = 0
  CHECK(residual_of("kepler", 5, {point("p", 1, {1.25, 0, -1}, {1e-9, 1, 1})}, {sun}, {0, 0, 0}) < 1e-20);
  CHECK(residual_of("kepler", 1, {point("p", 1, {1.25, 0.5, -1}, {0.2, 0.5, 0.25})}, {sun}, {0, 0, 0}, 8192) < 1e-16);
  CHECK(residual_of("kepler", 5, {point("p", 1, {1.25, 0, -1}, {0, 2, 0})}, {sun}, {0, 0, 0}, 2048) < 1e-20);  // e = 1
  CHECK(residual_of("kepler", 5, {point("p", 1, {1.25, 0, -1}, {-1, 3, 1})}, {sun}, {0, 0, 0}, 4096) < 1e-18);
  CHECK(residual_of("kepler", 100, {point("p", 1, {1.25, 0, -1}, {0, 1, 1})}, {sun}, {0, 0, 0}, 32768) < 1e-20);
  const std::vector<Body> pair{point("a", 3, {0, 0, 0}, {0.1, 0, 0.2}), point("b", 1, {1, 0.5, 0}, {0, 1.5, 0.5})};
  CHECK(residual_of("kepler", 3, pair, {MutualGravity{{0, 1}, 1, 0}}, down, 2048) < 1e-18);
  std::vector<Body> charges{point("a", 3, {0, 0, 0}, {0.1, 0, 0.2}), point("b", 1, {4, 0.5, 0}, {-2, 0, 0.5})};
  charges[0].charge_C = 2;
  charges[1].charge_C = 1.5;
  CHECK(residual_of("coulomb-two-body", 4, charges, {Coulomb{{0, 1}, 1}}, {0, 0, 0}, 4096) < 1e-18);
  charges[1].charge_C = -1.5;
  CHECK(residual_of("coulomb-two-body", 3, charges, {Coulomb{{0, 1}, 1}}, {0, 0, 0}, 8192) < 1e-16);
}

TEST_CASE("Charges in uniform fields") {
  Body proton = point("p", 0.5, {1, 2, 3}, {1, -1, 0.5});
  proton.charge_C = 0.75;
  CHECK(residual_of("lorentz", 5, {proton}, {Lorentz{{0}, {0, 0, 0}, {0, 0, 2}}}, {0, 0, 0}) < 1e-20);
  CHECK(residual_of("lorentz", 5, {proton}, {Lorentz{{0}, {1, 0.5, -2}, {0.3, -1, 2}}}, down) < 1e-20);
  CHECK(residual_of("lorentz", 5, {proton}, {Lorentz{{0}, {1, 0.5, -2}, {0, 0, 1e-12}}}, down) < 1e-20);
}

TEST_CASE("Free tops: both sides of the separatrix, at it, symmetric, axes not principal, tumbling with gravity") {
  const auto top = [](Real3 I, Real3 w, std::int64_t n = 1024) {
    return residual_of("free-rigid-body", 10, {solid("top", 1, I, w)}, {}, down, n);
  };
  CHECK(top({0.6, 0.8, 1.0}, {3, 0.5, -0.9}, 4096) < 1e-18);
  CHECK(top({0.6, 0.8, 1.0}, {-0.2, 0.5, -0.9}) < 1e-18);
  CHECK(top({1.0, 0.6, 0.8}, {-0.2, -0.5, 0.9}) < 1e-18);
  CHECK(top({0.8, 1.0, 0.6}, {-1, 0.1, 0.2}) < 1e-18);
  CHECK(top({0.5, 0.75, 1.0}, {1, -1, 0.7071067811865476}) < 1e-18);  // beside the separatrix by round-off
  CHECK(top({3, 5, 6}, {1, 0.5, 1}) < 1e-18);  // on it exactly: I1 (I2 - I1) w1^2 = I3 (I3 - I2) w3^2
  CHECK(top({0.04, 0.04, 0.02}, {0.3, -0.4, 1.5}) < 1e-18);
  CHECK(top({0.04, 0.02, 0.02}, {0.3, -0.4, 1.5}) < 1e-18);
  CHECK(top({0.5, 0.5, 0.5}, {0.3, -0.4, 1.5}) < 1e-18);
  CHECK(top({0.5, 0.6, 0.7}, {0, 1.5, 0}) < 1e-18);
  CHECK(top({0.5, 0.6, 0.7}, {0, 1.5, 0.1}) < 1e-18);
  CHECK(top({0.5, 0.6, 0.7}, {1e-7, 1.5, 0}) < 1e-18);
  Body skew = solid("skew", 2, {1, 1.5, 2}, {0.5, -1, 0.75});
  skew.inertia_kg_m2 = {1, 0.2, -0.1, 0.2, 1.5, 0.3, -0.1, 0.3, 2};
  skew.orientation_wxyz = {0.5, 0.5, -0.5, 0.5};
  CHECK(residual_of("free-rigid-body", 10, {skew}, {}, down, 1024) < 1e-18);
  Body damped = solid("damped", 2, {1, 1.5, 2}, {0, 0, 3});
  CHECK(residual_of("linear-drag", 3, {damped}, {LinearDrag{{0}, 0.5, {0, 0, 0}, 0.25}}, down, 2048) < 1e-18);
}

TEST_CASE("A ship whose thruster turns it about its axis, and one that fires in turns") {
  Body ship = solid("ship", 5, {2, 3, 4}, {0, 0, 0.5});
  ship.orientation_wxyz = {0.5, 0.5, -0.5, 0.5};
  const Thruster side{0, {1, 0, 0.0}, {0, 1, 0}, 6, {}};
  CHECK(residual_of("axis-torque", 4, {ship}, {side}, down, 2048) < 1e-18);
  const Thruster slanted{0, {0, 0, -1}, {0, 0, 1}, 2, {{1, 3}}}, turned{0, {1, 0, 0}, {0, 1, 0}, 6, {{0, 2}, {2.5, 3}}};
  CHECK(residual_of("axis-torque", 4, {ship}, {slanted, turned}, down, 2048) < 1e-18);
  Body still = solid("ship", 5, {2, 3, 4}, {0, 0, 0});
  CHECK(residual_of("axis-torque", 4, {still}, {side}, {0, 0, 0}, 2048) < 1e-18);
}
