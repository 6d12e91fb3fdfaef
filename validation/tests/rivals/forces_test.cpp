// The adapters' forces against the reference's equations of motion: two authors, one answer.
#include <catch2/catch.hpp>
#include <random>

#include "dynamics/rates.hpp"
#include "rivals/applied_forces.hpp"
#include "rivals/vector.hpp"
#include "scenes.hpp"

namespace atwood::test {
namespace {

using rivals::operator+;
using rivals::operator-;
using rivals::operator*;
using rivals::Motion;
using rivals::Wrench;

class Dice {
 public:
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Real3 vector(double size) { return {real(-size, size), real(-size, size), real(-size, size)}; }

 private:
  std::mt19937_64 engine_{20240607};
};

// Two bodies that turn, or two point masses, in a random state.
Scene random_scene(Dice& dice, bool turning) {
  Scene scene = empty_scene();
  for (int i = 0; i < 2; ++i) {
    Body body = box_body(i == 0 ? "a" : "b", dice.real(0.5, 3), turning ? Real3{0.6, 0.8, 1.1} : Real3{});
    body.position_m = dice.vector(2);
    body.velocity_m_per_s = dice.vector(2);
    body.charge_C = dice.real(-2, 2);
    if (turning) {
      Real4 q{dice.real(-1, 1), dice.real(-1, 1), dice.real(-1, 1), dice.real(-1, 1)};
      const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      for (double& x : q) x /= norm;
      body.orientation_wxyz = q;
      body.angular_velocity_body_rad_per_s = dice.vector(2);
    }
    scene.bodies.push_back(body);
  }
  return scene;
}

// Largest difference between m v' and I w' + w x I w of the reference and the wrench of the adapter.
double disagreement(const Scene& scene, double t_s) {
  const dynamics::Dynamics<double> truth(scene, 10);
  std::vector<double> y(truth.size()), rate(truth.size());
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const auto& slot = truth.layout().slots[i];
    const Motion m{body.position_m, body.orientation_wxyz, body.velocity_m_per_s, body.angular_velocity_body_rad_per_s};
    for (int k = 0; k < 3; ++k) {
      y[slot.position + k] = m.p_WB[k];
      y[slot.velocity + k] = m.v_WB[k];
      if (slot.rate >= 0) y[slot.rate + k] = m.w_WB_B[k];
    }
    for (int k = 0; k < 4 && slot.attitude >= 0; ++k) y[slot.attitude + k] = m.q_WB[k];
    motions.push_back(m);
  }
  truth.rate(t_s, y.data(), rate.data(), truth.interval_at(t_s));
  std::vector<Wrench> wrenches(scene.bodies.size());
  rivals::applied_wrenches(scene, t_s, t_s, motions, wrenches);

  double worst = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const auto& slot = truth.layout().slots[i];
    for (int k = 0; k < 3; ++k) {
      const double force = body.mass_kg * (rate[slot.velocity + k] - scene.gravity_m_per_s2[k]);
      worst = std::max(worst, std::abs(force - wrenches[i].force_N[k]));
    }
    if (slot.rate < 0) continue;
    const Real3 w = motions[i].w_WB_B, dw{rate[slot.rate], rate[slot.rate + 1], rate[slot.rate + 2]};
    const Real3 moment = rivals::times(body.inertia_kg_m2, dw) + rivals::cross(w, rivals::times(body.inertia_kg_m2, w));
    const Real3 torque = rivals::to_body(motions[i].q_WB, wrenches[i].torque_N_m);
    for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(moment[k] - torque[k]));
  }
  return worst;
}

}  // namespace

TEST_CASE("every force of the scene agrees with the reference's equations") {
  Dice dice;
  for (int repeat = 0; repeat < 20; ++repeat) {
    const double t_s = dice.real(0, 3);
    const Real3 point_a = dice.vector(0.5), point_b = dice.vector(0.5);
    const std::vector<Force> forces{
        MutualGravity{{0, 1}, 1.5, 0.1},
        Attractor{{0, 1}, {0.1, 0.2, 0.3}, 2},
        LinearDrag{{0, 1}, 0.4, {0.5, 0, -0.2}, 0.05},
        QuadraticDrag{{0, 1}, 1.2, 0.47, 0.3, {0, 1, 0}, 0.02},
        Spring{{0}, {0, 0, 1}, 12, 0.7, 0.4, {point_a}},
        Spring{{0, 1}, {}, 9, 0.3, 0.2, {point_a, point_b}},
        Spring{{1}, {0.5, 0, 0}, 7, 0.2, 0, {}},
        Drive{{0, 1}, {1, -2, 3}, 2.5, 0.3},
        Lorentz{{0, 1}, {0.3, 0, 0.1}, {0, 0.2, 1}},
        Coulomb{{0, 1}, 0.8},
        Thruster{0, point_a, {0.6, 0, 0.8}, 3, {{0, 1}, {2, 3}}},
        PointForce{1, point_b, {1, 2, -1}, {{1, 2}}},
        Potential{{0, 1}, "henon-heiles", {{"lambda", 0.9}}},
    };
    for (const auto& force : forces) {
      Scene scene = random_scene(dice, true);
      scene.gravity_m_per_s2 = {0, 0, -9.81};
      scene.forces = {force};
      INFO(rivals::names_of_forces(scene) << ", t = " << t_s);
      CHECK(disagreement(scene, t_s) < 1e-10);
    }
    Scene scene = random_scene(dice, false);
    scene.forces = {RotatingFrame{{0.1, -0.3, 0.9}}};
    CHECK(disagreement(scene, t_s) < 1e-12);
  }
}

TEST_CASE("forces that are not covered are named") {
  Dice dice;
  Scene scene = random_scene(dice, true);
  scene.forces = {RotatingFrame{{0, 0, 1}}};
  CHECK_THAT(rivals::uncovered_force(scene), Catch::Contains("rotating frame"));
  scene.forces = {Potential{{0}, "henon-heiles", {{"mu", 1.0}}}};
  CHECK_THAT(rivals::uncovered_force(scene), Catch::Contains("mu"));
  scene.forces = {Potential{{0}, "henon-heiles", {}}, LinearDrag{{0}, 1, {}, 0}};
  CHECK(rivals::uncovered_force(scene).empty());
  CHECK(rivals::names_of_forces(scene) == "drag, potential");
}

}  // namespace atwood::test
