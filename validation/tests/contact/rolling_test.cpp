// "+impulse": coins that roll in a circle or spin on their rim without loss, and impacts of one instant.
#include <catch2/catch.hpp>

#include <cmath>

#include "stepping_scenes.hpp"

using namespace atwood;
using namespace atwood::stepping_scenes;

namespace {

constexpr double g = 9.81;

struct Coin {
  double radius_m = 0.02, half_length_m = 0.001, mass_kg = 0.01;
};

// A coin whose axis leans by `lean` from the vertical towards +x and goes round it at `precession`, as it rolls on its
// lower rim without slip: E. J. Routh, Advanced Rigid Dynamics (1905), art. 241 ff. With rho from the centre to the
// touch, H the centre's height and s the spin about the axis, the centre is c from the middle of its circle:
//   c = -rho_x - s R / W,   W sin (I_a (s + W cos) - I_t W cos) = m H W^2 c - m g rho_x
Scene steady(const Coin& coin, double lean, double precession, double friction) {
  const double R = coin.radius_m, l = coin.half_length_m, m = coin.mass_kg, W = precession;
  const double sine = std::sin(lean), cosine = std::cos(lean), H = l * cosine + R * sine, rho_x = R * cosine - l * sine;
  const double I_a = m * R * R / 2, I_t = m * (3 * R * R + 4 * l * l) / 12;
  const double s =
      -(W * W * sine * cosine * (I_a - I_t) + m * H * W * W * rho_x + m * g * rho_x) / (W * (I_a * sine + m * H * R));
  Body body;
  body.name = "coin";
  body.mass_kg = m;
  body.inertia_kg_m2 = {I_t, 0, 0, 0, I_t, 0, 0, 0, I_a};
  body.shape = Cylinder{R, l};
  body.position_m = {-rho_x - s * R / W, 0, H};
  body.orientation_wxyz = {std::cos(lean / 2), 0, std::sin(lean / 2), 0};
  body.velocity_m_per_s = {0, -(W * rho_x + s * R), 0};
  body.angular_velocity_body_rad_per_s = {-W * sine, 0, s + W * cosine};
  return scene_of({floor_plane(), body}, 0, friction, g);
}

// Its centre at rest: Euler's disc.
double precession_of_disc(const Coin& coin, double lean) {
  const double R = coin.radius_m, l = coin.half_length_m;
  const double sine = std::sin(lean), cosine = std::cos(lean), rho_x = R * cosine - l * sine;
  const double I_a = R * R / 2, I_t = (3 * R * R + 4 * l * l) / 12;
  return std::sqrt(-g * rho_x / (sine * (I_a * (cosine - rho_x / R) - I_t * cosine)));
}

double largest_change_of_energy(const std::string& method, const Scene& scene, const Plan& plan) {
  const Recorded r = run(method, scene, plan);
  const double start = total(scene, r.samples.front()).energy;
  double most = 0;
  for (const Sample& sample : r.samples) most = std::max(most, std::abs(total(scene, sample).energy / start - 1));
  return most;
}

double y_velocity(const Recorded& r, int body) {
  return static_cast<double>(r.samples.back().bodies[body].v_m_per_s[1]);
}

}  // namespace

TEST_CASE("+impulse: a coin that rolls or spins on its rim keeps its energy") {
  // At 1 kHz, half a second. Contacts, gyroscopic term and inertia of the step's start took 12 % of the disc's.
  const Plan plan{0.5, 500, 25};
  const Coin coin;
  for (const std::string method :
       {"atwood/symplectic-euler+impulse", "atwood/rk4+impulse", "atwood/symplectic-euler+impulse{solver=sequential}"})
    for (const double way : {1.0, -1.0}) {
      INFO(method << ", way " << way);
      for (const double lean : {0.2, 0.5, 1.0})
        CHECK(largest_change_of_energy(method, steady(coin, lean, way * precession_of_disc(coin, lean), 0.5), plan) <
              2e-4);
      CHECK(largest_change_of_energy(method, steady(coin, 1.05, way * 12, 0.5), plan) < 2e-5);
      CHECK(largest_change_of_energy(method, steady(coin, 0.6, way * 10, 10), plan) < 2e-5);
      const Coin wheel{1.5, 0.1, 400};
      CHECK(largest_change_of_energy(method, steady(wheel, 1.2, way * 1.2, 0.5), plan) < 2e-5);
    }
}

TEST_CASE("+impulse: the energy loss of a rolling coin is of second order in the step") {
  const Coin coin;
  const Scene scene = steady(coin, 0.5, precession_of_disc(coin, 0.5), 0.5);
  const double coarse = largest_change_of_energy("atwood/rk4+impulse", scene, {0.5, 250, 25}),
               fine = largest_change_of_energy("atwood/rk4+impulse", scene, {0.5, 1000, 25});
  CHECK(coarse < 1e-3);
  CHECK(fine < coarse / 10);
}

TEST_CASE("+impulse: a coin that slips loses the energy that friction dissipates") {
  // friction 0.1 where rolling asks for 0.325
  const Coin coin;
  const Scene scene = steady(coin, 1.05, 12, 0.1);
  const double fine = largest_change_of_energy(euler, scene, {0.5, 4000, 25});
  CHECK(fine > 0.2);
  CHECK(largest_change_of_energy(euler, scene, {0.5, 500, 25}) == Approx(fine).epsilon(5e-3));
}

TEST_CASE("+impulse: simultaneous impacts follow the order that the scene names") {
  // A ball hits two others at the same time and speed: the first in the scene's order comes first.
  const double c = std::sqrt(3.0) / 2;  // of the line of centres along y
  for (const bool left_first : {true, false}) {
    Body left = ball("left", 1, 0.5, {-0.5, 1, 0}, {}), right = ball("right", 1, 0.5, {0.5, 1, 0}, {});
    Body cue = ball("cue", 1, 0.5, {0, -1, 0}, {0, 3, 0});
    Scene scene = left_first ? scene_of({left, right, cue}, 1, 0) : scene_of({right, left, cue}, 1, 0);
    scene.simultaneous_impacts = SimultaneousImpacts::sequential;
    const Recorded r = run(euler, scene, {1, 60, 1});
    // first: 3 c along its line, 3 c^2 along y. The cue keeps 3 (1 - c^2) = 3/4 along y and 3 c / 2 along x, away from
    // the first; along the second's line that is (3/4) c + (3 c / 2) / 2 = 3 c / 2.
    CHECK(y_velocity(r, 0) == Approx(3 * c * c));
    CHECK(y_velocity(r, 1) == Approx(1.5 * c * c));
  }
  // It touches both, 60 and 20 degrees off its direction: the second comes first, because its approach is faster.
  const double near = std::acos(-1.0) / 9, far = 3 * near;
  Scene fastest = scene_of(
      {ball("far", 1, 0.5, {-std::sin(far), std::cos(far), 0}, {}),
       ball("near", 1, 0.5, {std::sin(near), std::cos(near), 0}, {}), ball("cue", 1, 0.5, {0, 0, 0}, {0, 3, 0})},
      1, 0);
  fastest.simultaneous_impacts = SimultaneousImpacts::sequential;
  CHECK(y_velocity(run(euler, fastest, {1, 60, 1}), 1) == Approx(3 * std::cos(near) * std::cos(near)));
  Scene together = scene_of({ball("left", 1, 0.5, {-0.5, 1, 0}, {}), ball("right", 1, 0.5, {0.5, 1, 0}, {}),
                             ball("cue", 1, 0.5, {0, -1, 0}, {0, 3, 0})},
                            1, 0);
  together.simultaneous_impacts = SimultaneousImpacts::together;
  const Recorded refused = try_run(euler, together, {1, 60, 1});
  CHECK(refused.outcome.status == Status::unsupported);
  CHECK(refused.outcome.reason.find("simultaneous_impacts is together") != std::string::npos);
  // Without restitution all contacts are solved together.
  together.materials[0].restitution = together.pairs[0].restitution = 0;
  const Recorded plastic = run(euler, together, {1, 60, 1});
  CHECK(y_velocity(plastic, 0) == Approx(y_velocity(plastic, 1)));
  together.simultaneous_impacts = SimultaneousImpacts::sequential;
  CHECK(try_run(euler, together, {1, 60, 1}).outcome.status == Status::unsupported);
}
