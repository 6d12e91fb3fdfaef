// Free flight in fused loops: the bits of the general stepper on the general equations, for every explicit method,
// every kind of body, vector width and number of threads.
#include <catch2/catch.hpp>

#include "integrators/free_flight.hpp"
#include "integrators/free_flight_alone.hpp"
#include "many_bodies.hpp"

namespace atwood::testing {
namespace {

Real4 any_attitude(SplitMix64& random) {
  const double w = between(random, -1, 1), x = between(random, -1, 1), y = between(random, -1, 1),
               z = between(random, -1, 1);
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  return {w / length, x / length, y / length, z / length};
}

// Boxes about their axes, bodies about any axes, point masses, spins about one axis, bodies at rest; some held, some
// fixed.
Scene menagerie(int count, std::uint64_t seed) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0.1, -0.2, -9.8};
  SplitMix64 random{seed};
  for (int i = 0; i < count; ++i) {
    const Real3 p = anywhere(random, 10), v = anywhere(random, 3);
    Body body = point("body." + std::to_string(i), between(random, 0.5, 2), p, v);
    const double a = between(random, 1, 2), b = between(random, 1, 2), c = between(random, 1, 1.9);
    body.orientation_wxyz = any_attitude(random);
    const int kind = static_cast<int>(random.next() % 8);
    if (kind != 0) {
      body.inertia_kg_m2 = {a, 0, 0, 0, b, 0, 0, 0, c};
      body.angular_velocity_body_rad_per_s = anywhere(random, 8);
    }
    if (kind == 1) body.inertia_kg_m2 = {a, 0.1, -0.05, 0.1, b, 0.02, -0.05, 0.02, c};
    if (kind == 2) body.angular_velocity_body_rad_per_s = {0, 0, -3};
    if (kind == 3) body.angular_velocity_body_rad_per_s = {-0.0, 0, 0};
    if (kind == 3) body.orientation_wxyz = {-0.0, 1, 0, 0};
    if (i % 11 == 5) body.release_s = 0.01 * static_cast<double>(1 + random.next() % 5);
    if (i % 11 == 5) body.velocity_m_per_s[0] = -0.0;
    body.fixed = i % 17 == 3;
    scene.bodies.push_back(body);
  }
  return scene;
}

template <class S> bool same_scalars(const std::vector<S>& a, const std::vector<S>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(),
                                            [](S u, S v) { return u == v && std::signbit(u) == std::signbit(v); });
}

constexpr int steps = 60;
constexpr double step_s = 0.001;

template <class S> struct End {
  std::vector<S> y;
  std::int64_t evaluations;
};

// Step by step through the general stepper.
template <class S> End<S> generally(const std::string& scheme, const Scene& scene) {
  RigidModel<S> model(scene);
  const auto stepper = stepper_of(scheme, model);
  std::vector<S> y(model.state_size()), y_new(model.state_size());
  model.initial_state(y.data());
  for (int n = 0; n < steps; ++n) {
    const S t_s = S(n) * S(step_s);
    model.select_interval(t_s, t_s + S(step_s));
    REQUIRE(stepper->step(t_s, S(step_s), y.data(), y_new.data()));
    y.swap(y_new);
  }
  return {y, model.system().evaluations};
}

// The same steps by stretches of one law.
template <class S> End<S> fused(const std::string& scheme, const Scene& scene, int threads = 1) {
  ModelOptions options;
  options.threads = threads;
  RigidModel<S> model(scene, options);
  const auto stepper = stepper_of(scheme, model);
  const auto flight = make_free_flight<S>(model, stepper->weights());
  REQUIRE(flight != nullptr);
  std::vector<S> y(model.state_size());
  model.initial_state(y.data());
  for (int from = 0, until; from < steps; from = until) {
    const auto begin_s = [](int n) { return S(n) * S(step_s); };
    model.select_interval(begin_s(from), begin_s(from) + S(step_s));
    for (until = from + 1; until < steps && model.interval_selected(begin_s(until), begin_s(until) + S(step_s));)
      ++until;
    flight->march(S(step_s), until - from, y.data());
  }
  return {y, model.system().evaluations};
}

// One by one, from one state to another, as runs take them that look at each.
template <class S> End<S> singly(const std::string& scheme, const Scene& scene) {
  RigidModel<S> model(scene);
  const auto stepper = stepper_of(scheme, model);
  const auto flight = make_free_flight<S>(model, stepper->weights());
  std::vector<S> y(model.state_size()), y_new(model.state_size());
  model.initial_state(y.data());
  for (int n = 0; n < steps; ++n) {
    const S t_s = S(n) * S(step_s);
    model.select_interval(t_s, t_s + S(step_s));
    flight->step(S(step_s), y.data(), y_new.data());
    y.swap(y_new);
  }
  return {y, model.system().evaluations};
}

template <class S> std::vector<std::string> fused_schemes() {
  std::vector<std::string> schemes;
  const Scene scene = free_box();
  for (const MethodInfo& info : integrator_catalogue()) {
    RigidModel<S> model(scene);
    const auto stepper = make_stepper(info.id.substr(7), model);
    if (stepper && (*stepper)->weights() != nullptr) schemes.push_back(info.id.substr(7));
  }
  return schemes;
}

template <class S> void compare_all(const Scene& scene) {
  for (const std::string& scheme : fused_schemes<S>()) {
    const End<S> general = generally<S>(scheme, scene), fast = fused<S>(scheme, scene);
    INFO(scheme);
    CHECK(same_scalars(general.y, fast.y));
    CHECK(general.evaluations == fast.evaluations);
    const End<S> single = singly<S>(scheme, scene);
    CHECK(same_scalars(general.y, single.y));
    CHECK(general.evaluations == single.evaluations);
  }
}

TEST_CASE("at least six explicit methods have loops of free flight, the same in float and double") {
  CHECK(fused_schemes<double>().size() >= 6);
  CHECK(fused_schemes<float>() == fused_schemes<double>());
}

TEST_CASE("fused steps have the bits of general ones") {
  for (const int count : {1, 2, 3, 6, 31, 150}) {
    INFO(count << " bodies");
    compare_all<double>(menagerie(count, static_cast<std::uint64_t>(count)));
    compare_all<float>(menagerie(count, static_cast<std::uint64_t>(count) + 100));
  }
}

TEST_CASE("the number of threads changes no bit") {
  const Scene scene = menagerie(1011, 7);  // enough that stretches of ten steps are shared
  const auto alone = fused<double>("rk4", scene);
  for (const int threads : {2, 3, 5}) {
    INFO(threads << " threads");
    CHECK(same_scalars(fused<double>("rk4", scene, threads).y, alone.y));
  }
}

template <class S>
std::vector<S> flown_at(VectorWidth width, FlightKind kind, const ExplicitWeights<S>& weights, int bodies) {
  FlightLanes<S> lanes{};
  lanes.rates.resize(weights.a.size() * 7 * kFlightLanes);
  SplitMix64 random{3};
  for (int l = 0; l < bodies; ++l) {
    for (int r = 0; r < 3; ++r) {
      lanes.p[r][l] = S(between(random, -1, 1));
      lanes.v[r][l] = S(between(random, -1, 1));
      lanes.half_w[r][l] = S(between(random, -2, 2));
      lanes.inertia.I[4 * r][l] = S(between(random, 1, 2));
      lanes.inertia.twice_I_inverse[4 * r][l] = S(2) / lanes.inertia.I[4 * r][l];
    }
    lanes.q[0][l] = S(1);
  }
  FlightSteps<S> plan(weights);
  plan.set_gravity({S(0), S(1), S(-9.8)});
  plan.set_step(S(1e-2));
  fly<S>(width, kind, bodies, plan, 50, lanes);
  std::vector<S> all;
  for (int r = 0; r < 3; ++r)
    for (int l = 0; l < bodies; ++l)
      all.insert(all.end(), {lanes.p[r][l], lanes.v[r][l], lanes.half_w[r][l], lanes.q[r][l]});
  return all;
}

template <class S> void compare_widths(const std::string& scheme) {
  RigidModel<S> model(free_box());
  const auto stepper = stepper_of(scheme, model);
  for (const VectorWidth width : widths_here())
    for (const FlightKind kind : {FlightKind::about_body_axes, FlightKind::about_any_axes, FlightKind::point_mass})
      for (const int bodies : {1, 7, 8, 9, 29, kFlightLanes})
        CHECK(same_scalars(flown_at<S>(width, kind, *stepper->weights(), bodies),
                           flown_at<S>(VectorWidth::narrow, kind, *stepper->weights(), bodies)));
}

TEST_CASE("the same bits at every vector width") {
  for (const char* scheme : {"rk4", "dopri5"}) {
    compare_widths<double>(scheme);
    compare_widths<float>(scheme);
  }
}

TEST_CASE("many steps of one body in a register have the bits of single ones, at every width") {
  int compared = 0;
  for (const char* scheme : {"heun", "dopri5", "dop853", "verner9"}) {
    RigidModel<double> model(free_box());
    const auto stepper = stepper_of(scheme, model);
    FlightSteps<double> plan(*stepper->weights());
    plan.set_gravity({0, 1, -9.8});
    plan.set_step(1e-2);
    FlightInertia<double, 1> inertia{};
    for (int r = 0; r < 3; ++r) inertia.I[4 * r][0] = 1 + r, inertia.twice_I_inverse[4 * r][0] = 2.0 / (1 + r);
    std::vector<double> start(model.state_size()), single = start, next = start;
    model.initial_state(start.data());
    single = start;
    for (int n = 0; n < 50; ++n) {
      fly_alone(FlightKind::about_body_axes, plan, inertia, single.data(), next.data());
      single.swap(next);
    }
    for (const VectorWidth width : widths_here()) {
      if (!flies_alone(width, FlightKind::about_body_axes, plan)) continue;
      std::vector<double> many = start;
      fly_many_alone(width, plan, inertia, 50, many.data());
      CHECK(same_scalars(many, single));
      ++compared;
    }
  }
  CHECK(compared == 4 * (static_cast<int>(widths_here().size()) - 1));
}

TEST_CASE("forces, bare problems and compensation stay with the general stepper") {
  RigidModel<double> pulled_model(kepler(0.3)), free_model(free_box());
  const auto pulled_stepper = stepper_of("rk4", pulled_model);
  CHECK(make_free_flight(pulled_model, pulled_stepper->weights()) == nullptr);
  CHECK(make_free_flight<double>(free_model, nullptr) == nullptr);
  CHECK(prepare<double>(parse_method_id("atwood/rk4"), free_box()).free_flight != nullptr);
  CHECK(prepare<double>(parse_method_id("atwood/rk4{compensated=true}"), free_box()).free_flight == nullptr);
  CHECK(prepare<double>(parse_method_id("atwood/leapfrog"), free_box()).free_flight == nullptr);
}

}  // namespace
}  // namespace atwood::testing
