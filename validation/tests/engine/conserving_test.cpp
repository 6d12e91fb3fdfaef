// Methods that keep invariants: what they keep, to how many digits, and what they refuse.
#include <catch2/catch.hpp>

#include "scenes.hpp"

namespace atwood::testing {
namespace {

const char* const keepers[] = {"average-vector-field", "discrete-gradient", "projected-rk4", "relaxation-rk4"};

Scene henon_heiles() {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("star", 1, {0.1, 0, 0}, {0, 0.5, 0}));
  scene.forces.push_back(Potential{{0}, "henon-heiles", {}});
  return scene;
}

// Every law with an energy at once: gravity, springs, charges, fields, a fixed mass; a box that turns freely.
Scene everything() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0.1, -0.2, -1};
  scene.bodies = {point("a", 1, {0, 0, 0}, {0.3, 0.1, 0}), point("b", 2, {1.5, 0.2, 0.1}, {0, -0.2, 0.1}),
                  point("sun", 40, {0, 3, 1}, {0, 0, 0}), box({0.6, 0.8, 1.0}, {0.3, 1, 0.2})};
  scene.bodies[2].fixed = true;
  scene.bodies[3].position_m = {4, 4, 4};
  scene.bodies[3].velocity_m_per_s = {0, 0, 0.3};
  scene.bodies[0].charge_C = 1;
  scene.bodies[1].charge_C = -0.5;
  scene.forces.push_back(MutualGravity{{0, 1, 2, 3}, 0.02, 0.1});
  scene.forces.push_back(Coulomb{{0, 1}, 0.3});
  scene.forces.push_back(Lorentz{{0, 1}, {0.1, 0.3, 0}, {0.2, 0, 0.7}});
  scene.forces.push_back(Attractor{{0}, {0, 0, -2}, 1.2});
  Spring tie;
  tie.bodies = {0, 1};
  tie.stiffness_N_per_m = 3;
  tie.rest_length_m = 1.2;
  scene.forces.push_back(tie);
  Spring anchored;
  anchored.bodies = {3};
  anchored.anchor_m = {4, 4, 5};
  anchored.stiffness_N_per_m = 6;
  scene.forces.push_back(anchored);
  return scene;
}

// A discrete gradient's two properties, and its limit against the forces that run.
TEST_CASE("discrete forces do the work of the potential, to round-off, and tend to the forces") {
  Scene scene = everything();
  for (const bool rotating_frame : {false, true}) {
    if (rotating_frame) {
      scene = kepler(0.3);
      scene.forces.push_back(RotatingFrame{{0.1, 0.2, 0.9}});
      scene.forces.push_back(Potential{{0}, "henon-heiles", {{"lambda", 0.7}}});
    }
    RigidModel<Quad> model(scene);
    REQUIRE(model.conservative().refusal().empty());
    std::vector<Quad> y(model.state_size()), z(y.size()), dydt(y.size());
    model.initial_state(y.data());
    for (std::size_t i = 0; i < y.size(); ++i) z[i] = y[i] + Quad(0.01 * ((i * 7) % 11) - 0.05);
    const auto motion = [&](const std::vector<Quad>& state) { return model.motion(Quad(0), state.data()); };
    std::vector<Vec3<Quad>> forward(model.body_count()), back(forward), local(forward);
    model.conservative().add_discrete_forces(motion(y), motion(z), forward.data());
    model.conservative().add_discrete_forces(motion(z), motion(y), back.data());
    model.conservative().add_discrete_forces(motion(y), motion(y), local.data());
    model.system().rate(Quad(0), y.data(), dydt.data());
    Quad work = Quad(0), power = Quad(0);
    for (const int body : model.moving()) {
      const int p = model.offset(body) + kAtPosition, v = model.offset(body) + kAtVelocity;
      const Vec3<Quad> u = Quad(0.5) * (load3(&y[v]) + load3(&z[v])), dp = load3(&z[p]) - load3(&y[p]);
      work += dot(forward[body], dp);
      power += dot(forward[body], u);
      CHECK(static_cast<double>(norm(forward[body] - back[body])) < 1e-31);
      const Vec3<Quad> force = model.mass(body).mass_kg * load3(&dydt[v]);
      CHECK(static_cast<double>(norm(local[body] - force)) < 1e-30);
    }
    // Forces at right angles to the mean velocity do work along this unrelated dp; take the velocities along it
    // instead.
    for (const int body : model.moving())
      for (int i = 0; i < 3; ++i) {
        const int p = model.offset(body) + i;
        y[p + kAtVelocity] = z[p + kAtVelocity] = z[p] - y[p];
      }
    std::fill(forward.begin(), forward.end(), Vec3<Quad>{});
    model.conservative().add_discrete_forces(motion(y), motion(z), forward.data());
    Quad exact = Quad(0);
    for (const int body : model.moving())
      exact += dot(forward[body], load3(&z[model.offset(body)]) - load3(&y[model.offset(body)]));
    const Quad lost =
        model.conservative().potential_energy(motion(y)) - model.conservative().potential_energy(motion(z));
    CHECK(static_cast<double>(real::abs(exact - lost)) < 1e-30);
    CHECK(static_cast<double>(real::abs(lost)) > 1e-3);
  }
}

// relative, largest over the run
struct Drift {
  double energy, momentum;
};

template <class S>
Drift drift(const std::string& scheme, const Scene& scene, double h_s, int steps, const Settings& settings = {}) {
  RigidModel<S> model(scene);
  const auto stepper = stepper_of(scheme, model, settings);
  std::vector<S> y(model.state_size()), y_new(y.size());
  model.initial_state(y.data());
  const auto momentum = [&](const std::vector<S>& state) { return cross(load3(&state[0]), load3(&state[3])); };
  const S energy = model.energy(y.data()), scale = model.energy_scale(y.data());
  const Vec3<S> start = momentum(y);
  Drift worst{0, 0};
  for (int n = 0; n < steps; ++n) {
    REQUIRE(stepper->step(S(n) * S(h_s), S(h_s), y.data(), y_new.data()));
    y.swap(y_new);
    worst.energy = std::max(worst.energy, static_cast<double>(real::abs(model.energy(y.data()) - energy) / scale));
    worst.momentum = std::max(worst.momentum, static_cast<double>(norm(momentum(y) - start) / norm(start)));
  }
  return worst;
}

TEST_CASE("energy stays to round-off over 20 000 steps: Kepler e = 0.6 and Henon-Heiles") {
  for (const char* scheme : keepers) {
    INFO(scheme);
    const Drift orbit = drift<double>(scheme, kepler(0.6), 2 * M_PI / 200, 20000);  // a hundred orbits
    const Drift star = drift<double>(scheme, henon_heiles(), 0.05, 20000);
    CAPTURE(orbit.energy, orbit.momentum, star.energy);
    const bool held = std::string(scheme).ends_with("rk4");  // to the run's energy at every step; the others by sums
    CHECK(orbit.energy < (held ? 4e-15 : 4e-14));
    CHECK(star.energy < (held ? 4e-15 : 4e-14));
    if (std::string(scheme) == "discrete-gradient" || std::string(scheme) == "projected-rk4")
      CHECK(orbit.momentum < 1e-13);
  }
  CHECK(drift<double>("rk4", kepler(0.6), 2 * M_PI / 200, 20000).energy > 1e-5);  // without the correction
}

TEST_CASE("energy stays under every law with an energy, in every arithmetic") {
  for (const char* scheme : keepers) {
    INFO(scheme);
    CHECK(drift<float>(scheme, everything(), 0.01, 400).energy < 2e-5);
    CHECK(drift<double>(scheme, everything(), 0.01, 400).energy < 2e-14);
    CHECK(drift<Quad>(scheme, everything(), 0.01, 100).energy < 2e-32);
    CHECK(drift<double>(scheme, everything(), 0.01, 400, {{"compensated", true}}).energy < 2e-14);
  }
}

TEST_CASE("a free body keeps its rotational energy; projection keeps its momentum in the world") {
  for (const char* scheme : keepers) {
    INFO(scheme);
    const Scene scene = free_box(true);
    RigidModel<double> model(scene);
    const auto stepper = stepper_of(scheme, model);
    std::vector<double> y(model.state_size()), y_new(y.size());
    model.initial_state(y.data());
    const auto momentum = [&] {
      return rotate(load4(&y[kAtAttitude]), model.mass(0).times_inertia(load3(&y[kAtBodyRate])));
    };
    const auto spin_energy = [&] {
      return dot(load3(&y[kAtBodyRate]), model.mass(0).times_inertia(load3(&y[kAtBodyRate])));
    };
    const Vec3<double> before = momentum();
    const double energy = spin_energy(), total = model.energy(y.data());
    for (int n = 0; n < 2000; ++n) {
      REQUIRE(stepper->step(n * 0.01, 0.01, y.data(), y_new.data()));
      y.swap(y_new);
    }
    CHECK(std::fabs(model.energy(y.data()) - total) < 1e-12 * model.energy_scale(y.data()));
    if (std::string(scheme) == "relaxation-rk4") continue;  // one factor keeps one invariant
    CHECK(spin_energy() == Approx(energy).epsilon(1e-12));
    CHECK(norm(momentum()) == Approx(norm(before)).epsilon(1e-12));
    if (std::string(scheme) == "projected-rk4") CHECK(norm(momentum() - before) < 1e-12 * norm(before));
  }
}

// The relaxed state stands at t + gamma h; were it reported as that of t + h, order 3 would be left.
TEST_CASE("relaxation and projection keep order 4") {
  const auto end = [](const char* scheme, std::int64_t steps) {
    return run(scheme, kepler(0.6), {10, steps, 1}, "quad").samples.at(1).bodies[0].p_m;
  };
  const auto truth = end("gauss8", 8000);
  for (const char* scheme : {"projected-rk4", "relaxation-rk4"}) {
    INFO(scheme);
    CHECK(std::log2(distance(end(scheme, 4000), truth) / distance(end(scheme, 8000), truth)) == Approx(4).margin(0.1));
  }
}

TEST_CASE("an edited state is a new energy to keep") {
  for (const char* scheme : keepers) {
    INFO(scheme);
    RigidModel<double> model(kepler(0.3));
    const auto stepper = stepper_of(scheme, model);
    std::vector<double> y(model.state_size()), y_new(y.size());
    model.initial_state(y.data());
    for (int n = 0; n < 50; ++n) {
      if (n == 25) y[3] += 0.2;  // an impulse
      const double before = model.energy(y.data());
      REQUIRE(stepper->step(n * 0.02, 0.02, y.data(), y_new.data()));
      y.swap(y_new);
      CHECK(model.energy(y.data()) == Approx(before).epsilon(1e-13));
    }
  }
}

TEST_CASE("scenes without an energy are refused by name") {
  const auto why_not = [](const Scene& scene) { return try_run("discrete-gradient", scene, {1, 10, 1}).outcome; };
  for (const auto& [scene, word] : std::vector<std::pair<Scene, std::string>>{{quadratic_drag(), "drag"},
                                                                              {oscillator(0.5), "dashpot"},
                                                                              {driven_oscillator(), "drive"},
                                                                              {thrust_and_drag(), "thruster"}}) {
    const Outcome outcome = why_not(scene);
    CHECK(outcome.status == Status::unsupported);
    CHECK(outcome.reason.find(word) != std::string::npos);
  }
  Scene hung = free_box(false);
  Spring spring;
  spring.bodies = {0};
  spring.stiffness_N_per_m = 5;
  spring.points_body_m = {{0.1, 0, 0}};
  hung.forces.push_back(spring);
  CHECK(why_not(hung).status == Status::unsupported);
  CHECK(why_not(hung).reason.find("centres of mass") != std::string::npos);
}

}  // namespace
}  // namespace atwood::testing
