// Located impacts against answers by hand: edges on floors, corners of rooms, rows of balls, series of bounces with
// friction, bodies held until their release; and the order of constrained motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double g = 9.81, r = 0.1;

// Routh's construction in the plane: x along the floor, z up, K of the point that touches; everything straight in p,
// piece by piece.
struct Planar {
  double Kxx, Kzz, Kxz;
};
struct Routh {
  double p = 0, j = 0, ux = 0, uz = 0;
};
enum class Law { newton, poisson, stronge };

Routh routh(const Planar& K, double ux, double uz, double mu, double e, Law law) {
  Routh at{0, 0, ux, uz};
  const double uz0 = uz;
  double work = 0, p_compression = 0, work_compression = 0;
  for (bool compression = true;;) {
    double d = 0;  // friction for 1 N s of normal impulse
    if (at.ux != 0) d = at.ux > 0 ? -mu : mu;
    else d = std::clamp(-K.Kxz / K.Kxx, -mu, mu);
    const double along = K.Kxx * d + K.Kxz, up = K.Kzz + K.Kxz * d;
    double dp = 0;
    if (compression) dp = -at.uz / up;
    else if (law == Law::newton) dp = (-e * uz0 - at.uz) / up;
    else if (law == Law::poisson) dp = (1 + e) * p_compression - at.p;
    else if (const double root = at.uz * at.uz + 2 * up * ((1 - e * e) * work_compression - work); root >= 0)
      dp = (-at.uz + std::sqrt(root)) / up;
    else dp = -1;  // slip stops before
    const bool stops = at.ux * along < 0 && (dp < 0 || -at.ux / along < dp);
    if (stops) dp = -at.ux / along;
    work += at.uz * dp + up * dp * dp / 2;
    at.p += dp;
    at.j += d * dp;
    at.uz += up * dp;
    at.ux = stops ? 0 : at.ux + along * dp;
    if (stops) continue;
    if (!compression || e == 0) return at;
    compression = false;
    p_compression = at.p;
    work_compression = work;
  }
}

double energy_of(const Body& body, const Real3& v, const Real3& w) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += body.mass_kg * v[k] * v[k] + body.inertia_kg_m2[4 * k] * w[k] * w[k];
  return sum / 2;
}

}  // namespace

TEST_CASE("a box that lands on an edge obeys each hypothesis as one point does") {
  std::mt19937 random(3);
  const auto any = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const double a = 0.3, c = 0.2, at_s = 0.1, m = 2;
  const char* names[] = {"newton", "poisson", "stronge"};
  int met = 0, lost = 0;
  for (int i = 0; i < 120; ++i) {
    const double mu = std::array{0., 0.1, 0.4, 1., 3.}[i % 5], e = std::array{0.3, 0.8, 1.}[i % 3];
    const Law law = static_cast<Law>(i / 3 % 3);
    const double tilt = any(0.1, 1.4), vx = any(-3, 3), vz = any(-3, -0.5), w = any(-4, 4);
    double low_x = 0, low_z = 0;  // from the centre to the edge that is lowest at at_s; +y turns z towards x
    for (const double x : {-a, a})
      for (const double z : {-c, c})
        if (-std::sin(tilt) * x + std::cos(tilt) * z < low_z) {
          low_x = std::cos(tilt) * x + std::sin(tilt) * z;
          low_z = -std::sin(tilt) * x + std::cos(tilt) * z;
        }
    const double ux = vx + w * low_z, uz = vz - w * low_x;
    if (uz > -0.3) continue;
    Scene scene = world({}, e, mu);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}),
                    box("box", m, {a, 0.25, c}, {-vx * at_s, 0, -low_z - vz * at_s}, {vx, 0, vz})};
    Body& body = scene.bodies[1];
    body.angular_velocity_body_rad_per_s = {0, w, 0};
    const double half = (tilt - w * at_s) / 2;
    body.orientation_wxyz = {std::cos(half), 0, std::sin(half), 0};
    const Recorded it = run(std::string("atwood/rk4+event{restitution=") + names[static_cast<int>(law)] + "}", scene,
                            {at_s + 1e-3, 40, 1});
    if (it.events.size() != 1 || std::abs(time_of(it.events[0]) - at_s) > 1e-7) continue;  // another edge came first
    ++met;
    const double I = body.inertia_kg_m2[4];
    const Routh by_hand =
        routh({1 / m + low_z * low_z / I, 1 / m + low_x * low_x / I, -low_x * low_z / I}, ux, uz, mu, e, law);
    INFO(names[static_cast<int>(law)] << " mu " << mu << " e " << e << " tilt " << tilt);
    const Event& event = it.events[0];
    CHECK(static_cast<double>(event.impulse_n_N_s) == Approx(by_hand.p).epsilon(1e-8));  // RK4's attitude at 400 Hz
    CHECK(std::abs(static_cast<double>(event.impulse_t_N_s) - std::abs(by_hand.j)) < 1e-8 * by_hand.p);
    CHECK(static_cast<double>(event.vn_after_m_per_s) == Approx(by_hand.uz).epsilon(1e-7));
    CHECK(std::abs(static_cast<double>(event.x_m[1])) < 1e-12);  // midway along the edge
    CHECK(it.v(1)[0] == Approx(vx + by_hand.j / m).margin(1e-7));
    CHECK(it.v(1)[2] == Approx(vz + by_hand.p / m).margin(1e-7));
    CHECK(it.w(1)[1] == Approx(w + (low_z * by_hand.j - low_x * by_hand.p) / I).margin(1e-6));
    const double before = energy_of(body, body.velocity_m_per_s, {0, w, 0}), after = energy_of(body, it.v(1), it.w(1));
    if (law != Law::newton) CHECK(after <= before * (1 + 1e-12));
    lost += after < before;
  }
  CHECK(met > 40);
  CHECK(lost > 20);
}

TEST_CASE("boxes that land flat or on edges, sliding and spinning, gain no energy and keep to the cone") {
  std::mt19937 random(17);
  const auto any = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  for (int i = 0; i < 90; ++i) {
    const double mu = std::array{0.1, 0.5, 2.}[i % 3], e = std::array{0., 0.5, 1.}[i / 3 % 3];
    Scene scene = world({}, e, mu);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}),
                    box("box", 1.5, {0.2, 0.3, 0.1}, {0, 0, 0.2}, {3 * any(), 3 * any(), -1})};
    Body& body = scene.bodies[1];
    body.angular_velocity_body_rad_per_s = {0, 0, i % 2 ? 6 * any() : 0};
    for (const char* law : {"poisson", "stronge"}) {
      const Recorded it = run(std::string("atwood/rk4+event{restitution=") + law + "}", scene, {0.11, 11, 1});
      INFO(i << " " << law << " e " << e << " mu " << mu);
      REQUIRE(!it.events.empty());
      CHECK(time_of(it.events[0]) == Approx(0.1).epsilon(1e-13));
      CHECK(it.events[0].impulse_t_N_s <= mu * it.events[0].impulse_n_N_s * (1 + 1e-9));
      const double before = energy_of(body, body.velocity_m_per_s, body.angular_velocity_body_rad_per_s),
                   after = energy_of(body, it.v(1), it.w(1));
      CHECK(after <= before * (1 + 1e-10));
    }
  }
}

TEST_CASE("a ball into the corner of a room, every octant: each wall reverses its own part") {
  for (int octant = 0; octant < 8; ++octant)
    for (const double e : {0., 0.5, 1.})
      for (const char* method : {"atwood/rk4+event", "atwood/rk4+event{simultaneous=together}"}) {
        INFO("octant " << octant << " e " << e << " " << method);
        Scene scene = world({}, e, 0);
        Real3 v{2, 1, 3}, at{};
        for (int k = 0; k < 3; ++k) {
          const double sign = octant >> k & 1 ? 1 : -1;
          Real3 n{};
          n[k] = -sign;
          scene.bodies.push_back(fixed("wall" + std::to_string(k), Plane{n, -1}));
          v[k] *= sign;
          at[k] = sign * (1 - r) - 0.3 * v[k];
        }
        scene.bodies.push_back(ball("ball", 1, r, at, v));
        for (const int steps : {1, 6}) {
          const Recorded it = run(method, scene, {1, steps, 1});
          CHECK(it.count(EventKind::impact) == 3);
          CHECK(it.count(EventKind::rest) == (e > 0 ? 0 : 3));
          for (const Event& event : it.events) CHECK(time_of(event) == Approx(0.3).epsilon(1e-13));
          for (int k = 0; k < 3; ++k) CHECK(it.v(3)[k] == Approx(-e * v[k]).margin(1e-12));
        }
      }
}

TEST_CASE("together: the row of balls that Newton's law at once gives, not Mariotte's") {
  // n touching balls, k of them arrive at speed 1, e = 1: contacts at rest stay closed, the struck one opens at speed
  // 1, so the k leave it at c and the others at c + 1:  k c + (n - k)(c + 1) = k,  c = 2 k / n - 1.
  for (int n = 2; n <= 7; ++n)
    for (int k = 1; k < n; ++k) {
      Scene scene = world({}, 1, 0);
      for (int i = 0; i < n; ++i)
        scene.bodies.push_back(ball("b" + std::to_string(i), 1, 0.125, {0.25 * i, 0, 0}, {i < k ? 1. : 0., 0, 0}));
      const Recorded at_once = run("atwood/rk4+event{simultaneous=together}", scene, {1, 7, 1}),
                     in_turn = run("atwood/rk4+event", scene, {1, 7, 1});
      for (int i = 0; i < n; ++i) {
        INFO(n << " balls, " << k << " of them move, ball " << i);
        CHECK(at_once.v(i)[0] == Approx(2. * k / n - 1 + (i < k ? 0 : 1)).margin(1e-13));
        CHECK(in_turn.v(i)[0] == Approx(i < n - k ? 0 : 1).margin(1e-13));
      }
    }
}

TEST_CASE("together: a run says how the impulses of an instant were solved") {
  Scene scene = world({}, 1, 0);
  for (int i = 0; i < 4; ++i)
    scene.bodies.push_back(ball("b" + std::to_string(i), 1, 0.125, {0.25 * i, 0, 0}, {i == 0 ? 1. : 0., 0, 0}));
  const Recorded r = run("atwood/rk4+event{simultaneous=together}", scene, {1, 7, 1});
  REQUIRE(r.outcome.status == Status::ok);
  const SolveTally& tally = r.outcome.solvers.at("simultaneous-impacts");
  CHECK(tally.converged >= 1);
  CHECK(tally.capped == 0);
  CHECK(tally.iterations_max > 2);
  CHECK(tally.residual_max <= 4 * 2.3e-16);
}

TEST_CASE("together: symmetric approaches give symmetric velocities") {
  for (const double e : {0., 0.5, 1.}) {
    Scene scene = world({}, e, 0);
    scene.bodies = {ball("left", 1, r, {-0.7, 0, 0}, {1, 0, 0}), ball("middle", 3, r, {0, 0, 0}),
                    ball("right", 1, r, {0.7, 0, 0}, {-1, 0, 0})};
    const Recorded it = run("atwood/rk4+event{simultaneous=together}", scene, {1, 20, 1});
    CHECK(it.v(0)[0] == Approx(-e).margin(1e-14));
    CHECK(it.v(1)[0] == Approx(0).margin(1e-14));
    CHECK(it.v(2)[0] == Approx(e).margin(1e-14));
  }
}

TEST_CASE("a series of bounces ends when it should, from small heights too") {
  for (const double e : {0.3, 0.5, 0.8, 0.95})
    for (const double h : {1e-3, 0.7}) {
      const double end = std::sqrt(2 * h / g) * (1 + e) / (1 - e);
      Scene scene = world({0, 0, -g}, e, 0);
      scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), ball("ball", 1, r, {0, 0, r + h})};
      for (const int steps : {1, 3, 60}) {
        INFO("e " << e << " h " << h << " steps " << steps);
        const Recorded it = run("atwood/rk4+event", scene, {2 * end, steps, steps});
        REQUIRE(it.count(EventKind::rest) == 1);
        REQUIRE(it.events.back().kind == EventKind::rest);
        CHECK(time_of(it.events.back()) == Approx(end).epsilon(1e-11));
        CHECK(std::abs(it.p(1)[2] - r) < 1e-14);
        CHECK(std::abs(it.v(1)[2]) < 1e-14);
      }
    }
}

TEST_CASE("a rough ball bounces, slides on where its bounces end, and rolls") {
  struct Throw {
    double v, w, mu;
  };
  for (const Throw& thrown : {Throw{2, 0, 0.1}, {2, 0, 0.02}, {0, 30, 0.05}, {1, -40, 0.08}, {3, 0, 0.5}}) {
    const double e = 0.5, h = 0.4, mu = thrown.mu;
    // Impact by impact: j_n = (1 + e) v_n for 1 kg, friction up to mu j_n or to the end of slip (2/7 of it); free
    // flights between.
    double t = std::sqrt(2 * h / g), vn = g * t, v = thrown.v, w = thrown.w, x = v * t;
    while (vn > 1e-13) {
      const double u = v - r * w, j = std::min(mu * (1 + e) * vn, std::abs(u) / 3.5) * (u > 0 ? 1 : -1);
      v -= j;
      w += j / (0.4 * r);
      vn *= e;
      x += v * 2 * vn / g;
      t += 2 * vn / g;
    }
    const double u = v - r * w, slides_s = std::abs(u) > 1e-9 ? std::abs(u) / (3.5 * mu * g) : 0,
                 braking = u > 0 ? mu * g : -mu * g;
    const double end_s = t + 3;
    x += v * slides_s - braking * slides_s * slides_s / 2;
    v -= braking * slides_s;
    x += v * (end_s - t - slides_s);
    Scene scene = world({0, 0, -g}, e, mu);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}),
                    ball("ball", 1, r, {0, 0, r + h}, {thrown.v, 0, 0}, {0, thrown.w, 0})};
    for (const int steps : {50, 333}) {
      INFO("v " << thrown.v << " w " << thrown.w << " mu " << mu << " steps " << steps);
      const Recorded it = run("atwood/rk4+event", scene, {end_s, steps, 1});
      REQUIRE(it.count(EventKind::rest) == 1);
      CHECK(it.count(EventKind::roll) == (slides_s > 0 ? 1 : 0));
      for (const Event& event : it.events) {
        CHECK(event.impulse_t_N_s <= mu * event.impulse_n_N_s * (1 + 1e-14));
        if (event.kind == EventKind::rest) CHECK(time_of(event) == Approx(t).epsilon(1e-11));
        if (event.kind == EventKind::roll) CHECK(time_of(event) == Approx(t + slides_s).epsilon(1e-10));
      }
      CHECK(it.v(1)[0] == Approx(v).margin(1e-10));
      CHECK(it.w(1)[1] == Approx(v / r).margin(1e-9));
      CHECK(it.p(1)[0] == Approx(x).margin(1e-9));
      CHECK(std::abs(it.p(1)[2] - r) < 1e-14);
    }
  }
}

TEST_CASE("a body held until its release: a wall to others, then free") {
  Scene falls = world({0, 0, -g}, 0.5, 0);
  falls.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), ball("ball", 1, r, {0, 0, r + 0.5})};
  falls.bodies[1].release_s = 0.5;
  for (const int steps : {4, 16, 64}) {
    const Recorded it = run("atwood/rk4+event", falls, {1, steps, 4});
    REQUIRE(!it.events.empty());
    CHECK(time_of(it.events[0]) == Approx(0.5 + std::sqrt(1 / g)).epsilon(1e-13));
    CHECK(static_cast<double>(it.samples[2].bodies[1].p_m[2]) == r + 0.5);
  }
  Scene struck = world({}, 1, 0);  // struck while held, and not moved by it; then released with its own velocity
  struck.bodies = {ball("a", 1, r, {-1, 0, 0}, {1, 0, 0}), ball("b", 1, r, {0, 0, 0}, {0, 2, 0})};
  struck.bodies[1].release_s = 1.5;
  for (const int steps : {4, 40}) {
    const Recorded it = run("atwood/rk4+event", struck, {2, steps, 4});
    REQUIRE(it.events.size() == 1);
    CHECK(time_of(it.events[0]) == Approx(0.8).epsilon(1e-13));
    CHECK(static_cast<double>(it.events[0].impulse_n_N_s) == Approx(2).epsilon(1e-13));
    CHECK(it.v(0)[0] == Approx(-1).epsilon(1e-13));
    CHECK(static_cast<double>(it.samples[3].bodies[1].p_m[1]) == 0);
    CHECK(it.p(1)[1] == Approx(1).epsilon(1e-13));
  }
  Scene slope = world({-0.6 * g, 0, -0.8 * g}, 0, 0.2);  // on a slope: it slides off when let go
  slope.bodies = {fixed("slope", Plane{{0, 0, 1}, 0}), box("box", 1, {0.2, 0.2, 0.05}, {0, 0, 0.05})};
  slope.bodies[1].release_s = 0.5;
  const Recorded it = run("atwood/rk4+event", slope, {1.5, 60, 3});
  CHECK(static_cast<double>(it.samples[1].bodies[1].p_m[0]) == 0);
  CHECK(it.p(1)[0] == Approx(-(0.6 - 0.2 * 0.8) * g / 2).epsilon(1e-11));
}

TEST_CASE("lasting contact keeps the method's order under forces that vary") {
  const auto order = [](const Scene& scene, double end_s, int steps, double expected, auto&& value) {
    double error[3]{};
    for (int i = 0; i < 3; ++i) {
      const Recorded it = run("atwood/rk4+event", scene, {end_s, steps << i, 1});
      error[i] = std::abs(value(it) - expected);
    }
    INFO("errors " << error[0] << " " << error[1] << " " << error[2]);
    for (int i = 0; i < 2; ++i) CHECK(std::log2(error[i] / error[i + 1]) == Approx(4).margin(0.15));
  };
  SECTION("a ball rolls to and fro on a spring") {  // 7/5 m x'' = -k x
    const double k = 60, x0 = 0.3, w = std::sqrt(5 * k / (7 * 2.)), end_s = 1.3;
    Scene scene = world({0, 0, -g}, 0, 2);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), ball("ball", 2, r, {x0, 0, r})};
    scene.forces.push_back(Spring{{1}, {0, 0, r}, k, 0, 0, {{0, 0, 0}}});
    order(scene, end_s, 120, x0 * std::cos(w * end_s), [](const Recorded& it) { return it.p(1)[0]; });
    order(scene, end_s, 120, -x0 * w * std::sin(w * end_s) / r, [](const Recorded& it) { return it.w(1)[1]; });
  }
  SECTION("a box slides against friction and drag") {  // v' = -mu g - c v / m
    const double mu = 0.2, c = 6, m = 2, v0 = 5, end_s = 0.4, k = c / m, A = mu * g / k;
    Scene scene = world({0, 0, -g}, 0, mu);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}),
                    box("box", m, {0.3, 0.3, 0.02}, {0, 0, 0.02}, {v0 * 0.6, v0 * 0.8, 0})};
    scene.forces.push_back(LinearDrag{{1}, c, {}, 0});
    order(scene, end_s, 10, 0.6 * ((v0 + A) / k * (1 - std::exp(-k * end_s)) - A * end_s),
          [](const Recorded& it) { return it.p(1)[0]; });
  }
}

TEST_CASE(
    "a single collision does not depend on the order of the bodies, nor on position and orientation of the world") {
  std::mt19937 random(29);
  const auto any = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  const auto turned = [](const Real3& v) {
    return Real3{v[1], v[2], v[0]};
  };  // by a third about (1, 1, 1), exact in doubles
  int met = 0;
  for (int i = 0; i < 60; ++i) {
    Scene scene = world({}, 0.5 * (1 + any()), std::array{0., 0.2, 1.}[i % 3]);
    scene.bodies = {ball("a", 1.5 + any(), 0.15, {-0.5, 0.2 * any(), 0.1 * any()}, {1, 0.2 * any(), 0.2 * any()},
                         {5 * any(), 5 * any(), 5 * any()}),
                    ball("b", 1.5 + any(), 0.1, {0.5, 0, 0}, {-1, 0.2 * any(), 0}, {5 * any(), 5 * any(), 5 * any()})};
    Scene swapped = scene, rotated = scene;
    std::swap(swapped.bodies[0], swapped.bodies[1]);
    for (Body& body : rotated.bodies) {
      for (Real3* x : {&body.position_m, &body.velocity_m_per_s, &body.angular_velocity_body_rad_per_s})
        *x = turned(*x);
      for (int k = 0; k < 3; ++k) body.position_m[k] += k + 1;
    }
    const Plan plan{0.8, 16, 1};
    const Recorded plain = run("atwood/rk4+event", scene, plan), other = run("atwood/rk4+event", swapped, plan),
                   moved = run("atwood/rk4+event", rotated, plan);
    INFO(i);
    if (plain.events.empty()) continue;
    ++met;
    REQUIRE(plain.events.size() == 1);
    REQUIRE(other.events.size() == 1);
    REQUIRE(moved.events.size() == 1);
    CHECK(time_of(other.events[0]) == Approx(time_of(plain.events[0])).epsilon(1e-13));
    CHECK(time_of(moved.events[0]) == Approx(time_of(plain.events[0])).epsilon(1e-12));
    for (int k = 0; k < 3; ++k) {
      CHECK(static_cast<double>(other.events[0].normal[k] + plain.events[0].normal[k]) == Approx(0).margin(1e-13));
      double momentum = 0;
      for (int b = 0; b < 2; ++b) {
        CHECK(other.v(1 - b)[k] == Approx(plain.v(b)[k]).margin(1e-12));
        CHECK(moved.v(b)[k] == Approx(turned(plain.v(b))[k]).margin(1e-12));
        CHECK(moved.w(b)[k] == Approx(turned(plain.w(b))[k]).margin(1e-9));  // body axes: RK4's attitude
        momentum += scene.bodies[b].mass_kg * (plain.v(b)[k] - scene.bodies[b].velocity_m_per_s[k]);
      }
      CHECK(std::abs(momentum) < 1e-14);
    }
    CHECK(plain.events[0].impulse_t_N_s <= scene.pairs[0].friction * plain.events[0].impulse_n_N_s * (1 + 1e-14));
  }
  CHECK(met > 30);
}
