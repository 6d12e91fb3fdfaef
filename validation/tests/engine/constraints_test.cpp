// Loops, ropes and stops against closed forms and against balances of force.
#include <catch2/catch.hpp>
#include <numeric>

#include "joints/planar_loops.hpp"
#include "mechanisms.hpp"
#include "rigid/model.hpp"
#include "simulation.hpp"

namespace atwood::testing {
namespace {

const double g = 9.81, kPi = std::acos(-1.0);

Recorded record(const Scene& scene, const std::string& method, double t_end_s, std::int64_t steps,
                std::int64_t samples) {
  Recorded recorded = testing::record(atwood_engine().run, parse_method_id(method), scene, {t_end_s, steps, samples});
  INFO(recorded.outcome.reason);
  CHECK(recorded.outcome.status != Status::unsupported);
  return recorded;
}
double value(Wide x) { return static_cast<double>(x); }

Joint closing(Joint made) {
  made.closes_loop = true;
  return made;
}

// N parallelograms in a row: N + 1 rockers and N couplers of length `size`, mass 1, upward vertical at 0, `turn`
// turning everything about the x axis. Rockers stand at -angle, so that angle is measured clockwise as in the closed
// form.
Scene four_bars(int loops, double angle, double rate, double size = 1, double turn = 0, int closings = 1) {
  Scene scene = empty_scene();
  const Real4 turned{std::cos(turn / 2), std::sin(turn / 2), 0, 0};
  const auto about_x = [&](Real3 v) {
    return Real3{v[0], std::cos(turn) * v[1] - std::sin(turn) * v[2], std::sin(turn) * v[1] + std::cos(turn) * v[2]};
  };
  scene.gravity_m_per_s2 = about_x({0, -g * size, 0});
  const double I = size * size / 12;
  for (int i = 0; i <= loops; ++i)
    scene.bodies.push_back(link("rocker." + std::to_string(i), 1, {I, 1e-3 * size * size, I}));
  for (int i = 0; i < loops; ++i)
    scene.bodies.push_back(link("coupler." + std::to_string(i), 1, {1e-3 * size * size, I, I}));
  const auto hinge = [&](const std::string& name, int parent, int child, Real3 on_parent, Real3 on_child, double q,
                         double u) {
    Joint made = joint(name, JointKind::hinge, parent, child, on_parent, on_child);
    made.coordinates[0] = q;
    made.rates[0] = u;
    return made;
  };
  for (int i = 0; i <= loops; ++i) {
    scene.joints.push_back(
        hinge("ground." + std::to_string(i), -1, i, about_x({i * size, 0, 0}), {0, -size / 2, 0}, -angle, -rate));
    scene.joints.back().frame_wxyz = turned;
  }
  for (int i = 0; i < loops; ++i)
    scene.joints.push_back(
        hinge("pin." + std::to_string(i), i, loops + 1 + i, {0, size / 2, 0}, {-size / 2, 0, 0}, angle, rate));
  for (int k = 0; k < closings; ++k)
    for (int i = 0; i < loops; ++i)
      scene.joints.push_back(closing(hinge("close." + std::to_string(i) + "." + std::to_string(k), loops + 1 + i, i + 1,
                                           {size / 2, 0, 0}, {0, size / 2, 0}, -angle, -rate)));
  return placed(scene);
}

// theta'' = g ((N + 1) / 2 + N) / ((N + 1) / 3 + N) sin theta by the classical Runge-Kutta method in small steps.
long double four_bar_angle(int loops, long double angle, long double rate, long double t_s) {
  const long double k = 9.81L * ((loops + 1) / 2.0L + loops) / ((loops + 1) / 3.0L + loops);
  const int steps = 100000;
  const long double h = t_s / steps;
  for (int i = 0; i < steps; ++i) {
    const long double a1 = k * std::sin(angle), a2 = k * std::sin(angle + h / 2 * rate),
                      a3 = k * std::sin(angle + h / 2 * rate + h * h / 4 * a1),
                      a4 = k * std::sin(angle + h * rate + h * h / 2 * a2);
    angle += h * rate + h * h / 6 * (a1 + a2 + a3);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return angle;
}

double distance(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  double square = 0;
  for (int k = 0; k < 3; ++k) square += value(a[k] - b[k]) * value(a[k] - b[k]);
  return std::sqrt(square);
}
std::array<Wide, 3> point_of(const BodySample& body, const Real3& r) {
  const auto& q = body.q_wxyz;
  const Vec3<Quad> x = rotate(Quat<Quad>{q[0], q[1], q[2], q[3]}, Vec3<Quad>{r[0], r[1], r[2]});
  return {body.p_m[0] + x.x, body.p_m[1] + x.y, body.p_m[2] + x.z};
}

// ---- loops --------------------------------------------------------------------------------------------------------
TEST_CASE("four-bars follow their one degree of freedom through their flat configurations, their gaps at round-off") {
  for (const int loops : {1, 2}) {
    const Scene scene = four_bars(loops, 0, 1);
    const Recorded run = record(scene, "atwood/dop853", 4, 256, 64);
    REQUIRE(run.outcome.status == Status::ok);
    const double exact = static_cast<double>(-four_bar_angle(loops, 0, 1, 4));
    CAPTURE(loops);
    CHECK(std::abs(value(run.samples.back().joints[0].q[0]) - exact) < 1e-8);
    double gap = 0;
    for (const Sample& sample : run.samples)
      for (const Joint& joint : scene.joints)
        if (joint.parent >= 0)
          gap = std::max(gap, distance(point_of(sample.bodies[joint.parent], joint.anchors_body_m[0]),
                                       point_of(sample.bodies[joint.child], joint.anchors_body_m[1])));
    CHECK(gap < 4e-15 * (loops + 2));
    const SolveTally& tally = run.outcome.solvers.at("invariant-projection");
    CHECK(tally.capped == 0);
    CHECK(tally.solves() >= 256);
  }
}

TEST_CASE("a loop's motion knows no plane, no unit of length and no second closing of the same loop") {
  const double exact = static_cast<double>(-four_bar_angle(2, 0.4, 1, 0.3L));
  const auto end = [](const Scene& scene) {
    const Recorded run = record(scene, "atwood/dop853", 0.3, 32, 1);
    REQUIRE(run.outcome.status == Status::ok);
    return value(run.samples.back().joints[0].q[0]);
  };
  CHECK(std::abs(end(four_bars(2, 0.4, 1)) - exact) < 2e-13);
  CHECK(std::abs(end(four_bars(2, 0.4, 1, 1000)) - exact) < 2e-13);
  CHECK(std::abs(end(four_bars(2, 0.4, 1, 1, 0.7)) - exact) < 2e-13);
  CHECK(std::abs(end(four_bars(2, 0.4, 1, 1, 0, 2)) - exact) < 2e-13);
}

// The rates of loops in planes against the articulated bodies and the pivoted factorisation, in space.
template <class S> double loop_difference(const Scene& scene, const Vec3<S>& force_at_centre_W) {
  RigidModel<S> model(scene);
  REQUIRE(model.unsupported().empty());
  REQUIRE(model.constraints()->planar() != nullptr);
  std::vector<S> y(model.state_size()), dydt(y);
  model.initial_state(y.data());
  model.system().rate(S(0), y.data(), dydt.data());
  Tree<S> tree(scene, std::vector<int>(scene.bodies.size(), -1), 0);
  Constraints<S> constraints(scene, tree);
  constraints.start(y.data());
  tree.kinematics(S(0), y.data());
  std::vector<Load<S>> loads(scene.bodies.size());
  for (auto& load : loads) load.acceleration_W = narrow3<S>(scene.gravity_m_per_s2);
  loads[0].force_W += force_at_centre_W;
  std::vector<S> du(tree.rate_count());
  tree.accelerations(loads.data(), nullptr, du.data());
  constraints.constrain(du.data());
  S most = S(0), scale = S(0);
  for (int k = 0; k < tree.rate_count(); ++k) {
    most = real::max(most, real::abs(du[k] - dydt[tree.state_of_rate(k)]));
    scale = real::max(scale, real::abs(du[k]));
  }
  return static_cast<double>(most / scale);
}

TEST_CASE("closed loops in planes accelerate as in space, with forces on their bodies and without") {
  double in_double = 0, in_quad = 0;
  for (const int loops : {1, 2, 5})
    for (const double turn : {0.0, 0.7}) {
      const Scene scene = four_bars(loops, 0.4, 1, 1, turn);
      in_double = std::max(in_double, loop_difference<double>(scene, {}));
      in_quad = std::max(in_quad, loop_difference<Quad>(scene, {}));
    }
  // A spring without length from a fixed point to the first rocker's centre: the force is that of its stretch.
  Scene sprung = four_bars(2, 0.4, 1);
  Spring spring;
  spring.bodies = {0};
  spring.anchor_m = {3, 1, 0};
  spring.stiffness_N_per_m = 7;
  sprung.forces.push_back(spring);
  const Real3& p = sprung.bodies[0].position_m;
  const Vec3<double> force{7 * (3 - p[0]), 7 * (1 - p[1]), 0};
  CAPTURE(in_double, in_quad, loop_difference<double>(sprung, force));
  CHECK(in_double < 1e-12);
  CHECK(in_quad < 1e-29);
  CHECK(loop_difference<double>(sprung, force) < 1e-12);
  CHECK(loop_difference<double>(sprung, {}) > 1e-3);
}

TEST_CASE("hanging four-bars: each end of a coupler carries half of it; forces that are not determined are marked") {
  const Recorded run = record(four_bars(1, kPi, 0), "atwood/rk4", 0.01, 1, 1);
  const std::vector<JointSample>& joints = run.samples.front().joints;  // ground.0, ground.1, pin.0, close.0
  CHECK(value(joints[3].force_N[1]) == Approx(-g / 2).epsilon(1e-13));  // on the rocker
  CHECK(value(joints[2].force_N[1]) == Approx(g / 2).epsilon(1e-13));   // on the coupler
  for (const int ground : {0, 1}) CHECK(value(joints[ground].force_N[1]) == Approx(1.5 * g).epsilon(1e-13));
  for (const JointSample& joint : joints) {
    CHECK((joint.not_unique & 0b000011u) == 0u);  // forces in the plane
    CHECK((joint.not_unique & 0b000100u) != 0u);  // a hinge pushed along its axis
    CHECK((joint.not_unique & 0b100000u) == 0u);  // no torque about the axis
  }
  const Recorded twice = record(four_bars(1, kPi, 0, 1, 0, 2), "atwood/rk4", 0.01, 1, 1);
  const std::vector<JointSample>& both = twice.samples.front().joints;
  CHECK((both[3].not_unique & 0b000011u) == 0b000011u);  // shared with the second closing
  CHECK((both[2].not_unique & 0b000011u) == 0u);
  CHECK(value(both[3].force_N[1] + both[4].force_N[1]) == Approx(-g / 2).epsilon(1e-13));
}

constexpr double kCrank = 0.3, kRod = 1.1, kCrankRate = 7;

// Its piston runs along x; the crank stands at 0.4.
Scene slider_crank(bool driven) {
  Scene scene = empty_scene();
  const double r = kCrank, l = kRod, rate = kCrankRate;
  scene.bodies = {link("crank", 2, {1e-3, 0.1, 0.1}), link("rod", 1, {1e-3, 0.1, 0.1}),
                  link("piston", 3, {0.1, 0.1, 0.1})};
  scene.gravity_m_per_s2 = {0, -g, 0};
  Joint crank = joint("crank", JointKind::hinge, -1, 0, {0, 0, 0}, {-r / 2, 0, 0});
  crank.coordinates[0] = 0.4;
  crank.rates[0] = rate;
  if (driven) crank.driven_rate = rate;
  Joint rod = joint("rod", JointKind::hinge, 0, 1, {r / 2, 0, 0}, {-l / 2, 0, 0});
  const double lean = std::asin(r * std::sin(0.4) / l);
  rod.coordinates[0] = -lean - 0.4;
  rod.rates[0] = -rate - r * rate * std::cos(0.4) / (l * std::cos(lean));
  Joint piston = joint("piston", JointKind::slider, -1, 2, {0, 0, 0}, {0, 0, 0});
  piston.axis_body = {1, 0, 0};
  piston.coordinates[0] = r * std::cos(0.4) + l * std::cos(lean);
  piston.rates[0] = -r * rate * std::sin(0.4) - r * rate * std::cos(0.4) * std::tan(lean);
  scene.joints = {crank, rod, piston, closing(joint("pin", JointKind::hinge, 1, 2, {l / 2, 0, 0}, {0, 0, 0}))};
  scene.joints.back().coordinates[0] = lean;
  return placed(scene);
}

// The largest distance of the anchors of a loop's ends, of the state as it is, in quad.
double exact_gap(const Scene& scene, const RigidModel<double>& model, const std::vector<double>& y) {
  std::vector<int> offsets;
  for (int i = 0; i < model.body_count(); ++i) offsets.push_back(model.offset(i));
  Tree<Quad> tree(scene, offsets, model.tree()->scalars_at());
  const std::vector<Quad> fine(y.begin(), y.end());
  tree.kinematics(Quad(0), fine.data(), DrivenJoints::from_state);
  double worst = 0;
  for (const Joint& joint : scene.joints) {
    if (!joint.closes_loop) continue;
    const auto anchor = [&](int body, const Real3& at) {
      const int i = tree.link_of(body);
      return tree.centre_W(i) + rotate(tree.motion(i).q_WB, narrow3<Quad>(at));
    };
    const auto gap = anchor(joint.child, joint.anchors_body_m[1]) - anchor(joint.parent, joint.anchors_body_m[0]);
    worst = std::max(worst, static_cast<double>(norm(gap)));
  }
  return worst;
}

// Beside a flat configuration by less than the root of a rounding the step by gaps of a wider scalar diverges: it left
// gaps of up to 1e-6 m, and projections that called themselves converged.
TEST_CASE("projections beside a flat configuration leave loops closed, or say that they do not converge") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  int stagnated = 0;
  for (int power = 1; power <= 14; ++power)
    for (int trial = 0; trial < 20; ++trial) {
      const double beside = kPi / 2 - std::pow(10.0, -power), start = 0.5, phi = 1 + unit(random);
      Scene scene = four_bars(1 + trial % 2, start, 0.3 * unit(random), 0.7 + 0.1 * unit(random));
      for (Joint& joint : scene.joints) {  // turned in its plane: lengths along the rods' line are rounded
        if (joint.parent >= 0) continue;
        const double x = joint.anchors_body_m[0][0];
        joint.anchors_body_m[0] = {x * std::cos(phi), x * std::sin(phi), 0};
        joint.frame_wxyz = {std::cos(phi / 2), 0, 0, std::sin(phi / 2)};
      }
      scene = placed(scene);
      RigidModel<double> model(scene);
      REQUIRE(model.unsupported().empty());
      std::vector<double> y(static_cast<std::size_t>(model.state_size()));
      model.initial_state(y.data());
      for (std::size_t j = 0; j < scene.joints.size(); ++j)
        if (const int link = model.tree()->link_of_joint(static_cast<int>(j)); link >= 0)
          y[static_cast<std::size_t>(model.tree()->links()[link].at_q)] +=
              (scene.joints[j].parent < 0 ? start - beside : beside - start) + 2e-16 * unit(random);
      if (!model.constraints()->project(y.data())) continue;
      const bool converged = model.constraints()->report().ended == SolveEnd::converged;
      stagnated += converged ? 0 : 1;
      CAPTURE(power, trial, converged);
      CHECK(exact_gap(scene, model, y) < 3e-14);  // 16 roundings of the lengths in it
      if (power <= 7) CHECK(converged);
    }
  CHECK(stagnated > 20);
}

TEST_CASE("without projection a loop drifts open, with it no accuracy is lost") {
  const Scene scene = slider_crank(false);
  const auto gap = [&](const std::string& method) {
    const Recorded run = record(scene, method, 1, 64, 1);
    const Joint& last = scene.joints.back();
    return distance(point_of(run.samples.back().bodies[last.parent], last.anchors_body_m[0]),
                    point_of(run.samples.back().bodies[last.child], last.anchors_body_m[1]));
  };
  CHECK(gap("atwood/heun{projection=none}") > 1e-7);
  CHECK(gap("atwood/heun") < 2e-14);  // 16 roundings of the lengths in it
}

TEST_CASE("every method that claims mechanisms keeps a loop closed, or refuses it by name") {
  const Scene scene = slider_crank(false);
  int kept = 0;
  for (const MethodInfo& info : atwood_engine().methods) {
    if (info.claimed_order.count("mechanism") == 0 || info.id == "atwood/baumgarte") continue;
    std::vector<Sample> samples;
    Observer observer;
    observer.sample = [&](const Sample& sample) { samples.push_back(sample); };
    const Outcome outcome = atwood_engine().run(parse_method_id(info.id), scene, {0.5, 128, 1}, observer, 0);
    INFO(info.id << ": " << outcome.reason);
    CHECK((outcome.status == Status::ok || outcome.status == Status::unsupported));
    if (outcome.status != Status::ok) continue;
    const Joint& pin = scene.joints.back();
    CHECK(distance(point_of(samples.back().bodies[pin.parent], pin.anchors_body_m[0]),
                   point_of(samples.back().bodies[pin.child], pin.anchors_body_m[1])) < 2e-14);
    ++kept;
  }
  CHECK(kept > 30);
}

TEST_CASE("a slider-crank at constant rate is where its geometry has it") {
  const double r = kCrank, l = kRod;
  const Recorded run = record(slider_crank(true), "atwood/dop853", 2, 200, 10);
  REQUIRE(run.outcome.status == Status::ok);
  for (const Sample& sample : run.samples) {
    const double angle = 0.4 + kCrankRate * value(sample.t_s), s = r * std::sin(angle);
    CHECK(value(sample.joints[2].q[0]) == Approx(r * std::cos(angle) + std::sqrt(l * l - s * s)).epsilon(1e-13));
    CHECK(value(sample.joints[3].q[0]) == Approx(std::asin(s / l)).epsilon(1e-11));  // R_piston = R_rod exp(q)
  }
}

TEST_CASE("many steps of a driven loop leave no gap at its samples") {
  const Scene scene = slider_crank(true);
  const Recorded run = record(scene, "atwood/rk4", 20, 20000, 10);
  REQUIRE(run.outcome.status == Status::ok);
  const Joint& pin = scene.joints.back();
  for (const Sample& sample : run.samples)
    CHECK(distance(point_of(sample.bodies[pin.parent], pin.anchors_body_m[0]),
                   point_of(sample.bodies[pin.child], pin.anchors_body_m[1])) < 2e-14);
}

// th'' = (g - F / m) cos th / (1 + I / m) with F = k times the overlap; the ball's centre is at (cos th, 0, -sin th).
TEST_CASE("a ball on a hinge rebounds from a compliant floor as its one equation of motion has it") {
  const double radius = 0.1, floor = -0.5, stiffness = 1e4, inertia = 0.004;
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -g};
  scene.materials = {{"soft", 0, 0, 0}};
  PairLaw law;
  law.contact_law = ContactLaw::linear;
  law.stiffness_N_per_m = stiffness;
  scene.pairs = {law};
  Body ground;
  ground.name = "floor";
  ground.fixed = true;
  ground.shape = Plane{{0, 0, 1}, floor};
  Body ball = link("ball", 1, {inertia, inertia, inertia});
  ball.shape = Sphere{radius};
  scene.bodies = {ground, ball};
  Joint pin = joint("pin", JointKind::hinge, -1, 1, {0, 0, 0}, {-1, 0, 0});
  pin.axis_body = {0, 1, 0};
  scene.joints = {pin};
  scene = placed(scene);
  const auto acceleration = [&](double angle) {
    const double overlap = std::max(0., radius - (-std::sin(angle) - floor));
    return (g - stiffness * overlap) * std::cos(angle) / (1 + inertia);
  };
  double angle = 0, rate = 0;
  const int steps = 400000;
  const double h = 2.0 / steps;
  for (int i = 0; i < steps; ++i) {
    const double a1 = acceleration(angle), a2 = acceleration(angle + h / 2 * rate),
                 a3 = acceleration(angle + h / 2 * rate + h * h / 4 * a1),
                 a4 = acceleration(angle + h * rate + h * h / 2 * a2);
    angle += h * rate + h * h / 6 * (a1 + a2 + a3);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  const Recorded run = record(scene, "atwood/dop853+penalty", 2, 40000, 20);
  REQUIRE(run.outcome.status == Status::ok);
  double deepest = 0;
  for (const Sample& sample : run.samples) deepest = std::max(deepest, value(sample.joints[0].q[0]));
  CHECK(deepest > 0.3);
  CHECK(value(run.samples.back().joints[0].q[0]) == Approx(angle).margin(1e-6));
  CHECK(value(run.samples.back().joints[0].u[0]) == Approx(rate).margin(1e-5));
}

// ---- ropes --------------------------------------------------------------------------------------------------------
Scene atwood_machine(double m1, double m2, std::vector<Pulley> over) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -g};
  scene.bodies = {point("left", m1, {-0.3, 0, -1}, {0, 0, 0}), point("right", m2, {0.3, 0, -1.5}, {0, 0, 0})};
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  rope.over = std::move(over);
  scene.ropes = {rope};
  return scene;
}
Pulley pulley(double x, double radius_m, double inertia) {
  Pulley made;
  made.axle_m = {x, 0, 0};
  made.axis = {0, 1, 0};
  made.radius_m = radius_m;
  made.inertia_kg_m2 = inertia;
  made.angle_rad = 0.25;
  return made;
}

TEST_CASE("Atwood's machine: acceleration, tension and the pulley's angle, light and heavy") {
  const double m1 = 1, m2 = 1.75, r = 0.3;
  for (const double inertia : {0.0, 0.09}) {
    const Scene scene = atwood_machine(m1, m2, {pulley(0, r, inertia)});
    const Recorded run = record(scene, "atwood/rk4", 0.7, 64, 4);
    REQUIRE(run.outcome.status == Status::ok);
    const double a = g * (m2 - m1) / (m1 + m2 + inertia / (r * r));
    for (const Sample& sample : run.samples) {
      const double t = value(sample.t_s), rise = a * t * t / 2;
      CAPTURE(inertia, t);
      CHECK(std::abs(value(sample.bodies[0].p_m[2]) - (-1 + rise)) < 1e-14);
      CHECK(std::abs(value(sample.bodies[1].p_m[2]) - (-1.5 - rise)) < 1e-14);
      CHECK(value(sample.ropes[0].tension_N) == Approx(m1 * (g + a)).epsilon(1e-13));
      REQUIRE(sample.ropes[0].pulley_angle_rad.size() == 1);
      CHECK(value(sample.ropes[0].pulley_angle_rad[0]) == Approx(0.25 + rise / r).epsilon(1e-13));
    }
  }
}

TEST_CASE("a rope over two points pulls as one over a pulley; a rope that would push ends the run") {
  Scene scene = atwood_machine(1, 1.75, {pulley(-0.3, 0, 0), pulley(0.3, 0, 0)});
  const Recorded run = record(scene, "atwood/rk4", 0.7, 64, 1);
  const double a = g * 0.75 / 2.75;
  CHECK(std::abs(value(run.samples.back().bodies[0].p_m[2]) - (-1 + a * 0.49 / 2)) < 1e-14);
  // A motor that lifts the heavier body with more than its weight.
  PointForce lift;
  lift.body = 1;
  lift.force_N = {0, 0, 3 * g * 1.75};
  lift.on_s = {{0.25, 9}};
  scene.forces = {lift};
  const Recorded slack = record(scene, "atwood/rk4", 0.7, 56, 1);
  CHECK(slack.outcome.status == Status::diverged);
  CHECK(slack.outcome.reason.find("rope `rope` is slack at t = 0.2") != std::string::npos);
}

TEST_CASE("a swinging Atwood machine with a heavy pulley keeps its energy, from whichever end its rope is named") {
  Scene scene = atwood_machine(1.2, 1, {pulley(0, 0.2, 0.05)});
  scene.bodies[0].position_m = {-0.2, 0, -1};
  scene.bodies[1].position_m = {0.9, 0, -0.6};
  Scene reversed = scene;
  reversed.ropes[0].bodies = {1, 0};
  reversed.ropes[0].over[0].axis = {0, -1, 0};
  const Recorded run = record(scene, "atwood/dop853", 0.8, 200, 20);
  const Recorded other = record(reversed, "atwood/dop853", 0.8, 200, 20);
  REQUIRE((run.outcome.status == Status::ok && other.outcome.status == Status::ok));
  const auto energy = [&](std::size_t k) {
    const Sample& sample = run.samples[k];
    double sum = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& v = sample.bodies[i].v_m_per_s;
      const double m = scene.bodies[i].mass_kg;
      sum += m / 2 * value(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + m * g * value(sample.bodies[i].p_m[2]);
    }
    const double s = value(sample.bodies[0].v_m_per_s[2]);  // the rope's speed: this body hangs vertically
    return sum + 0.05 * s * s / (2 * 0.2 * 0.2);
  };
  CHECK(std::abs(value(run.samples.back().bodies[0].p_m[2]) + 1) > 0.01);
  for (std::size_t k = 1; k < run.samples.size(); ++k) {
    CHECK(std::abs(energy(k) - energy(0)) < 1e-12);
    for (int i = 0; i < 2; ++i) CHECK(distance(run.samples[k].bodies[i].p_m, other.samples[k].bodies[i].p_m) < 1e-12);
    // What turns one way seen along an axis turns the other way seen against it.
    CHECK(value(run.samples[k].ropes[0].pulley_angle_rad[0] + other.samples[k].ropes[0].pulley_angle_rad[0]) ==
          Approx(0.5).epsilon(1e-11));
  }
}

// ---- stops --------------------------------------------------------------------------------------------------------
Scene falling_slider(double height, double restitution) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -g};
  scene.bodies = {link("weight", 2, {0.1, 0.1, 0.1})};
  Joint guide = joint("guide", JointKind::slider, -1, 0, {0, 0, 0}, {0, 0, 0});
  guide.coordinates[0] = height;
  guide.limits = JointLimits{0, 10, restitution};
  scene.joints = {guide};
  return placed(scene);
}

TEST_CASE("a weight on a guide bounces off its stop and comes to rest at the end of its bounces") {
  const double height = 1.3, e = 0.6, first = std::sqrt(2 * height / g);
  for (const char* method : {"atwood/rk4", "atwood/dopri5:1e-9", "atwood/adams-bashforth4"}) {
    const Recorded run = record(falling_slider(height, e), method, 4, 50, 10);
    CAPTURE(method, run.outcome.reason);
    REQUIRE(run.outcome.status == Status::ok);
    REQUIRE(run.events.size() > 20);
    double t = first;
    for (int n = 0; n < 15; ++n) {
      const Event& event = run.events[n];
      CHECK(event.kind == EventKind::impact);
      CHECK(value(event.t_s) == Approx(t).epsilon(1e-12));
      CHECK(value(event.vn_before_m_per_s) == Approx(-g * first * std::pow(e, n)).epsilon(1e-10));
      CHECK(value(event.impulse_n_N_s) == Approx(2 * (1 + e) * g * first * std::pow(e, n)).epsilon(1e-10));
      CHECK((event.body_a == -1 && event.body_b == 0));
      t += 2 * first * std::pow(e, n + 1);
    }
    const SolveTally& searches = run.outcome.solvers.at("event-location");  // of each bounce
    CHECK((searches.converged >= 15 && searches.capped == 0));
    CHECK(run.events.back().kind == EventKind::rest);
    CHECK(value(run.events.back().t_s) == Approx(first * (1 + e) / (1 - e)).epsilon(1e-12));
    CHECK(value(run.samples.back().joints[0].q[0]) == 0);
    CHECK(value(run.samples.back().joints[0].u[0]) == 0);
  }
}

TEST_CASE("a stop that gives all back keeps the energy") {
  const Recorded run = record(falling_slider(0.5, 1), "atwood/rk4", 20, 200, 40);
  REQUIRE(run.outcome.status == Status::ok);
  for (const Sample& sample : run.samples) {
    const double u = value(sample.joints[0].u[0]);
    CHECK(u * u / 2 + g * value(sample.joints[0].q[0]) == Approx(g * 0.5).epsilon(1e-12));
  }
}

TEST_CASE("a motor lifts a weight off its stop when it can carry it") {
  Scene scene = falling_slider(0, 0.5);
  JointTorque motor;  // carries the weight from 2 sin(2 t) = 1 on
  motor.torque = 2 * 2 * g;
  motor.angular_frequency_rad_per_s = 2;
  motor.phase_rad = -kPi / 2;  // 2 m g sin(2 t)
  scene.joint_forces = {motor};
  const Recorded run = record(scene, "atwood/dop853", 0.6, 30, 3);
  REQUIRE(run.outcome.status == Status::ok);
  REQUIRE(run.events.size() == 2);
  CHECK(run.events[0].kind == EventKind::rest);
  CHECK(run.events[1].kind == EventKind::separate);
  const double release = std::asin(0.5) / 2;
  CHECK(value(run.events[1].t_s) == Approx(release).epsilon(1e-13));
  const double t = 0.6 - release;  // q'' = 2 g sin 2 t - g from there
  const double q = -g / 2 * (std::sin(1.2) - std::sin(2 * release)) + g * std::cos(2 * release) * t - g * t * t / 2;
  CHECK(value(run.samples.back().joints[0].q[0]) == Approx(q).epsilon(1e-12));
}

// ---- all bodies free ----------------------------------------------------------------------------------------------
TEST_CASE("methods in the coordinates of all bodies converge to the pendulum's motion with the order that they claim") {
  Scene scene = hinge_chain({1.0, 0.5}, {0.2, -0.7});
  const auto end = [&](const std::string& method, std::int64_t steps) {
    const Recorded run = record(scene, method, 1, steps, 1);
    REQUIRE(run.outcome.status == Status::ok);
    return std::pair(value(run.samples.back().joints[0].q[0]), value(run.samples.back().joints[1].q[0]));
  };
  const auto exact = end("atwood/dop853", 800);
  const auto error = [&](const std::string& method, std::int64_t steps) {
    const auto at = end(method, steps);
    return std::hypot(at.first - exact.first, at.second - exact.second);
  };
  CHECK(std::log2(error("atwood/rattle", 200) / error("atwood/rattle", 400)) == Approx(2).margin(0.05));
  CHECK(std::log2(error("atwood/rattle4", 100) / error("atwood/rattle4", 200)) == Approx(4).margin(0.1));
  CHECK(std::log2(error("atwood/baumgarte", 1600) / error("atwood/baumgarte", 3200)) == Approx(1).margin(0.05));
  CHECK(error("atwood/dop853{coordinates=maximal}", 100) < 1e-11);
}

// Two formulations that share the constraints' geometry only in part: in the one each joint is a coordinate, in the
// other rows between free bodies. All kinds of joints, frames and axes at random, free roots.
TEST_CASE("random trees move alike, under the same reactions, in the coordinates of joints and of all bodies") {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Scene scene = random_tree(seed, 8);
    const Recorded reduced = record(scene, "atwood/dop853", 0.2, 50, 1);
    const Recorded maximal = record(scene, "atwood/dop853{coordinates=maximal}", 0.2, 50, 1);
    CAPTURE(seed, maximal.outcome.reason);
    REQUIRE(maximal.outcome.status == Status::ok);
    double force = 0, torque = 0;
    for (const JointSample& joint : reduced.samples.front().joints)
      for (int k = 0; k < 3; ++k) {
        force = std::max(force, std::abs(value(joint.force_N[k])));
        torque = std::max(torque, std::abs(value(joint.torque_N_m[k])));
      }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      CHECK(distance(reduced.samples.back().bodies[i].p_m, maximal.samples.back().bodies[i].p_m) < 1e-10);
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const JointSample &a = reduced.samples.front().joints[j], &b = maximal.samples.front().joints[j];
      CAPTURE(scene.joints[j].name, static_cast<int>(scene.joints[j].kind));
      CHECK(b.not_unique == 0u);
      for (int k = 0; k < 3; ++k) {
        CHECK(std::abs(value(a.force_N[k] - b.force_N[k])) < 1e-10 * force);
        CHECK(std::abs(value(a.torque_N_m[k] - b.torque_N_m[k])) < 1e-10 * std::max(force, torque));
      }
      const JointSample &c = reduced.samples.back().joints[j], &d = maximal.samples.back().joints[j];
      for (int k = 0; k < coordinate_count(scene.joints[j].kind); ++k) CHECK(std::abs(value(c.q[k] - d.q[k])) < 1e-10);
      for (int k = 0; k < rate_count(scene.joints[j].kind); ++k) CHECK(std::abs(value(c.u[k] - d.u[k])) < 1e-9);
    }
  }
}

TEST_CASE("RATTLE keeps a closed loop at round-off and its energy near; Baumgarte's step lets it open") {
  const Scene scene = four_bars(1, 2.2, 0.5);
  const auto gap = [&](const std::string& method) {
    const Recorded run = record(scene, method, 2, 200, 1);
    const Joint& last = scene.joints.back();
    return distance(point_of(run.samples.back().bodies[last.parent], last.anchors_body_m[0]),
                    point_of(run.samples.back().bodies[last.child], last.anchors_body_m[1]));
  };
  CHECK(gap("atwood/rattle") < 2e-15);
  CHECK(gap("atwood/baumgarte") > 1e-6);
}

TEST_CASE("constraints are refused by name where they cannot be met") {
  const auto reason = [](const Scene& scene) {
    const Outcome outcome = atwood_engine().run(parse_method_id("atwood/rk4"), scene, {1, 10, 1}, {}, 0);
    CHECK(outcome.status != Status::ok);
    return outcome.reason;
  };
  Scene scene = four_bars(1, 0.3, 1);
  scene.joints.back().driven_rate = 1;
  CHECK(reason(scene).find("joint `close.0.0` closes a loop and is driven") != std::string::npos);
  scene = falling_slider(-1, 0.5);
  CHECK(reason(scene).find("joint `guide` starts beyond its limits") != std::string::npos);
  scene = atwood_machine(1, 2, {pulley(0, 0.3, 0)});
  scene.bodies[0].position_m[1] = 0.1;
  CHECK(reason(scene).find("leaves the plane of") != std::string::npos);
}

}  // namespace
}  // namespace atwood::testing
