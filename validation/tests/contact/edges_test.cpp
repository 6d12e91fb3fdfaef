// Edges that cross under `+event`: the motion of their common normal, and impacts by formula.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "contact/event/edges.hpp"
#include "posed_boxes.hpp"

using namespace atwood;
using namespace atwood::posed_boxes;
using namespace atwood::recorded;

TEST_CASE("two crossed bars strike each other's edges as Newton's law says") {
  for (const double e : {0., 0.5, 1.})
    for (const double x : {0., 0.3})
      for (const double y : {0., -0.2}) {
        const double r = kHalf * std::sqrt(2.), long_I = (kHalf * kHalf + kLong * kLong) / 3;
        // Arms to the crossing: (x, 0, r) of the lower bar, (0, -y, -r) of the upper; n = z.
        const double m = 2, M = 1, inverse = 1 / m + x * x / (m * long_I) + 1 / M + y * y / (M * long_I);
        const double p = (1 + e) / inverse;
        for (const int steps : {1, 7, 64}) {
          const Recorded it = run("atwood/rk4+event", crossed_bars(e, 0, x, y), {0.3, steps, 1});
          INFO("e " << e << " x " << x << " y " << y << " steps " << steps << ": " << it.outcome.reason);
          REQUIRE(it.outcome.status == Status::ok);
          REQUIRE(it.count(EventKind::impact) == 1);
          CHECK(time_of(it.events[0]) == Approx(0.2).epsilon(1e-14));
          CHECK(static_cast<double>(it.events[0].impulse_n_N_s) == Approx(p).epsilon(1e-13));
          CHECK(std::abs(static_cast<double>(it.events[0].x_m[2]) - r) < 1e-14);
          if (e == 0) continue;
          CHECK(it.v(0)[2] == Approx(-p / m).epsilon(1e-12));
          CHECK(it.v(1)[2] == Approx(-1 + p / M).margin(1e-13));
        }
      }
}
// ---- two boxes in general position ---------------------------------------------------------------------------------
namespace {

long double first_meeting(const Scene& scene, long double until) {
  const auto gap = [&](long double t) { return meet(place_at(scene.bodies[0], t), place_at(scene.bodies[1], t)).gap; };
  constexpr int kLooks = 4000;
  for (int k = 1; k <= kLooks; ++k) {
    long double high = until * k / kLooks, low = until * (k - 1) / kLooks;
    if (gap(high) > 0) continue;
    for (int i = 0; i < 100; ++i) ((gap((low + high) / 2) > 0) ? low : high) = (low + high) / 2;
    return high;
  }
  return -1;
}

// Boxes of all sizes, with equal moments of inertia, thrown at each other, turning.
Scene thrown_boxes(unsigned seed, double e, double friction) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  Scene scene = world({0, 0, 0}, e, friction);
  for (int i = 0; i < 2; ++i) {
    const Real3 half = {0.2 + 0.15 * any(random), 0.2 + 0.15 * any(random), 0.2 + 0.15 * any(random)};
    const double side = i == 0 ? -1 : 1, I = 0.05 + 0.03 * any(random);
    Body body = moving(i == 0 ? "one" : "other", Box{half}, 1.5 + any(random), {I, I, I},
                       {side, 0.25 * any(random), 0.25 * any(random)},
                       {-side * (1.5 + any(random)), 0.2 * any(random), 0.2 * any(random)},
                       {2 * any(random), 2 * any(random), 2 * any(random)});
    body.orientation_wxyz = about({any(random), any(random), any(random)}, 3 * any(random));
    scene.bodies.push_back(body);
  }
  return scene;
}

struct Motion {
  Vector v[2], w[2];
};
Motion after(const Recorded& it) {
  Motion m;
  for (int i = 0; i < 2; ++i) m.v[i] = vec(it.v(i)), m.w[i] = vec(it.w(i));
  return m;
}
long double energy(const Scene& scene, const Motion& m) {
  long double sum = 0;
  for (int i = 0; i < 2; ++i)
    sum += (scene.bodies[i].mass_kg * dot(m.v[i], m.v[i]) + scene.bodies[i].inertia_kg_m2[0] * dot(m.w[i], m.w[i])) / 2;
  return sum;
}
Motion before(const Scene& scene) {
  Motion m;
  for (int i = 0; i < 2; ++i) m.v[i] = vec(scene.bodies[i].velocity_m_per_s), m.w[i] = spin_W(scene.bodies[i]);
  return m;
}

}  // namespace

TEST_CASE("boxes thrown at each other meet when all separating axes say so, and part as Newton's law says") {
  int edges = 0, faces = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const Scene scene = thrown_boxes(seed, 0.75, 0);
    const long double t = first_meeting(scene, 2);
    if (t < 0) continue;
    const Body &a = scene.bodies[0], &b = scene.bodies[1];
    const Placed at_a = place_at(a, t), at_b = place_at(b, t);
    const Meeting met = meet(at_a, at_b);
    for (const int steps : {3, 40}) {
      const Recorded it = run("atwood/dop853+event", scene, {static_cast<double>(t) + 1e-3, steps, 1});
      INFO("seed " << seed << ", " << steps << " steps, edges " << met.edges << ": " << it.outcome.reason);
      REQUIRE(it.outcome.status == Status::ok);
      REQUIRE(it.count(EventKind::impact) == 1);
      const double tolerance = steps == 3 ? 1e-5 : 1e-12;  // the method's, of the boxes' turning
      CHECK(std::abs(time_of(it.events[0]) - static_cast<double>(t)) < tolerance);
      const Vector n = -wide(it.events[0].normal);
      CHECK(static_cast<double>(norm(n - met.n)) < 10 * tolerance);
      const Motion v = before(scene), end = after(it);
      Vector x = met.x;
      if (!met.edges) x = wide(it.events[0].x_m);
      const Vector r[2] = {x - at_a.p, x - at_b.p};
      const long double approach = dot(met.n, v.v[0] + cross(v.w[0], r[0]) - v.v[1] - cross(v.w[1], r[1]));
      const auto inverse = [&](const Body& body, const Vector& arm) {
        const Vector turn = cross(arm, met.n);
        return 1 / static_cast<long double>(body.mass_kg) + dot(turn, turn) / body.inertia_kg_m2[0];
      };
      const long double p = -1.75L * approach / (inverse(a, r[0]) + inverse(b, r[1]));
      CHECK(std::abs(static_cast<double>(static_cast<long double>(it.events[0].impulse_n_N_s) - p)) < 100 * tolerance);
      for (int i = 0; i < 2; ++i) {
        const Body& body = scene.bodies[i];
        const long double sign = i == 0 ? p : -p;
        CHECK(static_cast<double>(norm(end.v[i] - v.v[i] - (sign / body.mass_kg) * met.n)) < 100 * tolerance);
        const Vector w = v.w[i] + (sign / body.inertia_kg_m2[0]) * cross(r[i], met.n);
        const Placed& at = i == 0 ? at_a : at_b;
        const Vector w_B{dot(w, at.axis[0]), dot(w, at.axis[1]), dot(w, at.axis[2])};
        CHECK(static_cast<double>(norm(end.w[i] - w_B)) < 1000 * tolerance);
      }
      CHECK(energy(scene, end) < energy(scene, v));
    }
    ++(met.edges ? edges : faces);
  }
  CHECK(edges > 10);
  CHECK(faces > 10);
}

TEST_CASE("a long bar's corner strikes the face under it, although the bar lies beyond another face") {
  for (const bool sheet : {false, true}) {
    Scene scene = world({0, 0, 0}, 0.5, 0);
    scene.bodies = {sheet ? fixed("under", Rectangle{{0.2, 0.2}}, {0, 0, 0.05}) : fixed("under", Box{{0.2, 0.2, 0.05}}),
                    moving("bar", Box{{1, 0.05, 0.05}}, 1, {0.3, 0.3, 0.3}, {1, 0.02, 0.5}, {0, 0, -1})};
    scene.bodies[1].orientation_wxyz = times(about({0, 1, 0}, -0.2), about({1, 0, 0}, 0.3));
    const Placed bar = place_at(scene.bodies[1], 0);
    const long double lowest = bar.p.z - width(bar, {0, 0, 1}), corner_x = outermost(bar, {0, 0, -1}).x;
    REQUIRE(std::abs(static_cast<double>(corner_x)) < 0.15);
    for (const int steps : {1, 2, 30}) {
      const Recorded it = run("atwood/rk4+event", scene, {0.4, steps, 1});
      INFO((sheet ? "sheet, " : "box, ") << steps << " steps: " << it.outcome.reason);
      REQUIRE(it.outcome.status == Status::ok);
      REQUIRE(it.count(EventKind::impact) == 1);
      CHECK(time_of(it.events[0]) == Approx(static_cast<double>(lowest) - 0.05).epsilon(1e-12));
      CHECK(static_cast<double>(std::abs(wide(it.events[0].normal).z)) == Approx(1).epsilon(1e-14));
      CHECK(static_cast<double>(it.events[0].vn_before_m_per_s) == Approx(-1).epsilon(1e-13));
    }
  }
}

TEST_CASE("neither the order of the bodies, nor units, nor the world's axes change where edges meet") {
  for (const unsigned seed : {2u, 5u, 9u, 14u}) {
    const Scene scene = thrown_boxes(seed, 0.5, 0.25);
    const Plan plan{1, 200, 1};
    const Recorded it = run("atwood/dop853+event{restitution=stronge}", scene, plan);
    Scene permuted = scene, larger = scene, turned = scene;
    std::swap(permuted.bodies[0], permuted.bodies[1]);
    const Real4 q = about({1, 2, -1}, 0.7);
    for (int i = 0; i < 2; ++i) {  // metres as millimetres
      Body &body = larger.bodies[i], &other = turned.bodies[i];
      for (double& x : std::get<Box>(body.shape).half_extents_m) x *= 1000;
      for (int k = 0; k < 3; ++k) body.position_m[k] *= 1000, body.velocity_m_per_s[k] *= 1000;
      for (double& I : body.inertia_kg_m2) I *= 1e6;
      const auto turn = [&](Real3& v) {
        Body frame;
        frame.orientation_wxyz = q;
        const Vector w = v[0] * body_axis(frame, 0) + v[1] * body_axis(frame, 1) + v[2] * body_axis(frame, 2);
        v = {static_cast<double>(w.x), static_cast<double>(w.y), static_cast<double>(w.z)};
      };
      turn(other.position_m);
      turn(other.velocity_m_per_s);
      other.orientation_wxyz = times(q, other.orientation_wxyz);
    }
    REQUIRE(it.outcome.status == Status::ok);
    for (const Scene& other : {permuted, larger, turned}) {
      const Recorded same = run("atwood/dop853+event{restitution=stronge}", other, plan);
      INFO("seed " << seed << ", " << other.bodies[0].name << ": " << same.outcome.reason);
      REQUIRE(same.outcome.status == Status::ok);
      REQUIRE(same.events.size() == it.events.size());
      for (std::size_t i = 0; i < it.events.size(); ++i)
        CHECK(std::abs(time_of(same.events[i]) - time_of(it.events[i])) < 1e-11);
      const int first = other.bodies[0].name == "one" ? 0 : 1;
      for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 3; ++k) CHECK(std::abs(same.w(i == 0 ? first : 1 - first)[k] - it.w(i)[k]) < 1e-9);
    }
  }
}

TEST_CASE("boxes that strike each other with friction keep both momenta and never gain energy") {
  for (const char* law : {"poisson", "stronge"})
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const Scene scene = thrown_boxes(seed, 0.6, 0.5);
      const Recorded it = run(std::string("atwood/dop853+event{restitution=") + law + "}", scene, {2, 100, 100});
      INFO("seed " << seed << ", " << law << ": " << it.outcome.reason);
      REQUIRE(it.outcome.status == Status::ok);
      long double last = energy(scene, before(scene));
      for (const Sample& sample : it.samples) {
        Vector p{}, L{}, p0{}, L0{};
        long double now = 0;
        for (int i = 0; i < 2; ++i) {
          const Body& body = scene.bodies[i];
          const auto& s = sample.bodies[i];
          const Vector x = wide(s.p_m), v = wide(s.v_m_per_s), w = wide(s.w_rad_per_s);
          Body at = body;
          for (int k = 0; k < 4; ++k) at.orientation_wxyz[k] = static_cast<double>(s.q_wxyz[k]);
          const Vector w_W = w.x * body_axis(at, 0) + w.y * body_axis(at, 1) + w.z * body_axis(at, 2);
          const long double m = body.mass_kg, I = body.inertia_kg_m2[0];
          now += (m * dot(v, v) + I * dot(w, w)) / 2;
          p += m * v;
          L += m * cross(x, v) + I * w_W;
          p0 += m * vec(body.velocity_m_per_s);
          L0 += m * cross(vec(body.position_m), vec(body.velocity_m_per_s)) + I * spin_W(body);
        }
        CHECK(static_cast<double>(norm(p - p0)) < 1e-12);
        CHECK(static_cast<double>(norm(L - L0)) < 1e-10);
        CHECK(now <= last * (1 + 1e-12L));
        last = now;
      }
    }
}

// ---- the common normal's own motion ---------------------------------------------------------------------------------
namespace {

struct Mover {
  Vector p, v, a, w, axis[3];  // a: acceleration; w: constant
  event::Pose<long double> at(long double t) const {
    event::Pose<long double> pose;
    pose.p = p + t * v + (t * t / 2) * a;
    pose.v = v + t * a;
    pose.w = w;
    for (int k = 0; k < 3; ++k) pose.axis[k] = rotated(axis[k], w, t);
    return pose;
  }
};

}  // namespace

TEST_CASE("the gap of two crossing edges has the derivatives that finite differences have") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto vector = [&] { return Vector{any(random), any(random), any(random)}; };
  for (int trial = 0; trial < 40; ++trial) {
    Mover mover[2];
    for (Mover& m : mover) {
      Body body;
      body.orientation_wxyz = about({any(random), any(random), any(random)}, 3 * any(random));
      m = {vector(), vector(), vector(), vector(), {}};
      for (int k = 0; k < 3; ++k) m.axis[k] = body_axis(body, k);
    }
    const auto a = event::edges_of<long double>(Box{{0.3, 0.4, 0.5}})[static_cast<std::size_t>(trial) % 12];
    const auto b = event::edges_of<long double>(Rectangle{{0.6, 0.7}})[static_cast<std::size_t>(trial) % 4];
    const event::Facet<long double> facet{1, b.middle_B, trial % 2 ? b.along_B : -b.along_B};
    const auto kinematics_at = [&](long double t) {
      event::GapKinematics<long double> kinematics;
      edge_kinematics(event::edge_feature(a), mover[0].at(t), facet, mover[1].at(t), true, kinematics);
      return kinematics;
    };
    const auto kinematics = kinematics_at(0);
    const Vector ea = mover[0].axis[trial % 12 / 4],
                 eb = b.along_B.x * mover[1].axis[0] + b.along_B.y * mover[1].axis[1];
    if (norm(cross(ea, eb)) < 0.2L) continue;  // its higher derivatives are large
    const long double h = 0x1p-11L;
    const auto first = [&](const auto& f) { return (1 / (12 * h)) * (f(-2 * h) - f(2 * h) + 8 * (f(h) - f(-h))); };
    INFO("trial " << trial);
    CHECK(std::abs(static_cast<double>(first([&](long double t) { return kinematics_at(t).gap; }) - kinematics.rate)) <
          1e-8);
    CHECK(static_cast<double>(
              norm(first([&](long double t) { return kinematics_at(t).normal; }) - kinematics.normal_dot)) < 1e-8);
    CHECK(static_cast<double>(norm(first([&](long double t) { return kinematics_at(t).x; }) - kinematics.x_dot)) <
          1e-7);
    // g'' = n . u' + n' . u, u' with the way of the geometric point.
    Vector u{}, u_dot{};
    for (int side = 0; side < 2; ++side) {
      const Mover& m = mover[side];
      const Vector arm = kinematics.x - m.p, v = m.v + cross(m.w, arm),
                   v_dot = m.a + cross(m.w, kinematics.x_dot - m.v);
      u = side == 0 ? v : u - v;
      u_dot = side == 0 ? v_dot : u_dot - v_dot;
    }
    const long double second = dot(kinematics.normal, u_dot) + dot(kinematics.normal_dot, u);
    CHECK(std::abs(static_cast<double>(first([&](long double t) { return kinematics_at(t).rate; }) - second)) < 1e-7);
  }
}
