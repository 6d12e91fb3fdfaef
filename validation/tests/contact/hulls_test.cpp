// Balls and convex hulls under `+event`: impacts on faces, edges and vertices, and contacts that last.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>

#include "collision/contacts.hpp"
#include "contact/event/features.hpp"
#include "posed_boxes.hpp"

using namespace atwood;
using namespace atwood::posed_boxes;
using namespace atwood::recorded;

namespace {

using Random = std::mt19937;

double uniform(Random& random) { return std::uniform_real_distribution<double>(-1, 1)(random); }

Convex cube(const Real3& half) {
  Convex hull;
  for (int i = 0; i < 8; ++i)
    hull.points_m.push_back({i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]});
  return hull;
}

// A hull of few corners, with a spin about any axis, and a ball thrown at it. Both have equal moments of inertia.
Scene thrown_ball(unsigned seed, double e) {
  Random random(seed);
  Scene scene = world({0, 0, 0}, e, 0);
  Convex hull;
  const int corners = 4 + static_cast<int>(seed % 9);
  for (int i = 0; i < corners; ++i)
    hull.points_m.push_back({0.3 * uniform(random), 0.3 * uniform(random), 0.3 * uniform(random)});
  Body stone = moving("stone", hull, 2, {0.02, 0.02, 0.02}, {}, {0.1 * uniform(random), 0, 0},
                      {2 * uniform(random), 2 * uniform(random), 2 * uniform(random)});
  stone.orientation_wxyz = about({uniform(random), uniform(random), uniform(random)}, 3 * uniform(random));
  const double r = 0.02 + 0.1 * std::abs(uniform(random));
  scene.bodies = {ball("ball", 0.5, r, {-1, 0.15 * uniform(random), 0.15 * uniform(random)}, {2, 0, 0}), stone};
  if (seed % 2 == 0) std::swap(scene.bodies[0], scene.bodies[1]);
  return scene;
}

Transform<long double> transform_at(const Body& body, long double t) {
  Transform<long double> place;
  place.p_W = vec(body.position_m) + t * vec(body.velocity_m_per_s);
  for (int k = 0; k < 3; ++k) place.axis_W[k] = rotated(body_axis(body, k), spin_W(body), t);
  return place;
}
Separation<long double> separation_at(const Scene& scene, long double t) {
  const auto a = make_geometry<long double>(scene.bodies[0].shape),
             b = make_geometry<long double>(scene.bodies[1].shape);
  return separation(a, transform_at(scene.bodies[0], t), b, transform_at(scene.bodies[1], t));
}
// By the general distance query, which knows neither facets nor triangles. -1: they miss each other.
long double first_touch(const Scene& scene, long double until) {
  constexpr int kTimes = 1000;
  for (int k = 1; k <= kTimes; ++k) {
    long double high = until * k / kTimes, low = until * (k - 1) / kTimes;
    if (separation_at(scene, high).gap > 0) continue;
    for (int i = 0; i < 80; ++i) ((separation_at(scene, (low + high) / 2).gap > 0) ? low : high) = (low + high) / 2;
    return high;
  }
  return -1;
}

}  // namespace

TEST_CASE("a ball thrown at a hull meets it when their distance says so, and both part as Newton's law says") {
  int met = 0, dimensions[3] = {};
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const Scene scene = thrown_ball(seed, 0.75);
    const long double t = first_touch(scene, 1);
    if (t < 0) continue;
    ++met;
    const Recorded it = run("atwood/dop853+event", scene, {static_cast<double>(t) + 1e-4, 50, 1});
    INFO("seed " << seed);
    REQUIRE(it.count(EventKind::impact) == 1);
    CHECK(std::abs(time_of(it.events[0]) - static_cast<double>(t)) < 1e-12);
    const Separation<long double> at = separation_at(scene, t);
    const Vector n = at.normal_W, x = at.on_a_W;
    CHECK(static_cast<double>(norm(wide(it.events[0].normal) - n)) < 1e-8);
    Vector r[2], v[2], w[2];
    long double inverse = 0, approach = 0;
    for (int i = 0; i < 2; ++i) {
      const Body& body = scene.bodies[static_cast<std::size_t>(i)];
      const Transform<long double> place = transform_at(body, t);
      r[i] = x - place.p_W;
      v[i] = vec(body.velocity_m_per_s);
      w[i] = spin_W(body);
      const Vector turn = cross(r[i], n);
      inverse += 1 / static_cast<long double>(body.mass_kg) + dot(turn, turn) / body.inertia_kg_m2[0];
      approach += (i == 0 ? -1 : 1) * dot(n, v[i] + cross(w[i], r[i]));
    }
    REQUIRE(approach < 0);
    const long double p = -1.75L * approach / inverse;
    CHECK(static_cast<double>(it.events[0].impulse_n_N_s) == Approx(static_cast<double>(p)).epsilon(1e-8));
    for (int i = 0; i < 2; ++i) {
      const long double sign = i == 0 ? -p : p, m = scene.bodies[static_cast<std::size_t>(i)].mass_kg;
      CHECK(static_cast<double>(norm(vec(it.v(i)) - v[i] - (sign / m) * n)) < 1e-8);
    }
    // Which facets were met: a vertex of the hull, an edge, or a face.
    const int hull = scene.bodies[0].name == "stone" ? 0 : 1;
    const Transform<long double> stone = transform_at(scene.bodies[static_cast<std::size_t>(hull)], t);
    const Vector on_B = to_body(stone, (hull == 0 ? at.on_a_W : at.on_b_W) - stone.p_W);
    long double nearest = 1;
    for (const Real3& corner : std::get<Convex>(scene.bodies[static_cast<std::size_t>(hull)].shape).points_m)
      nearest = std::min(nearest, norm(vec(corner) - on_B));
    ++dimensions[nearest < 1e-9L ? 0 : 1];
  }
  CHECK(met > 30);
  CHECK(dimensions[0] > 3);
  CHECK(dimensions[1] > 10);
}

TEST_CASE("on a hull of a box's corners a ball rolls, slides and leaves over an edge as on the box") {
  for (const double friction : {0., 0.4})
    for (const double speed : {0.3, 1.5}) {
      Scene scene = world({0, 0, -9.81}, 0.5, friction);
      const Real3 half = {0.5, 0.4, 0.1};
      scene.bodies = {fixed("under", Box{half}), ball("ball", 1, 0.06, {0.3, 0.02, 0.2}, {speed, 0.05, 0}, {0, 3, 1})};
      for (const Real4& q : {Real4{1, 0, 0, 0}, about({0, 1, 0}, 0.1)}) {
        scene.bodies[0].orientation_wxyz = q;
        const Recorded on_box = run("atwood/rk4+event", scene, {1, 400, 20});
        Scene other = scene;
        other.bodies[0].shape = cube(half);
        const Recorded on_hull = run("atwood/rk4+event", other, {1, 400, 20});
        INFO("mu " << friction << ", " << speed << " m/s");
        REQUIRE(on_hull.events.size() == on_box.events.size());
        REQUIRE(!on_box.events.empty());
        for (std::size_t i = 0; i < on_box.events.size(); ++i) {
          CHECK(on_hull.events[i].kind == on_box.events[i].kind);
          CHECK(std::abs(time_of(on_hull.events[i]) - time_of(on_box.events[i])) < 1e-10);
        }
        for (int k = 0; k < 3; ++k) CHECK(std::abs(on_hull.p(1)[k] - on_box.p(1)[k]) < 1e-9);
      }
    }
}

TEST_CASE("a ball that overlaps a hull from the start is pushed out of the nearest face, not in") {
  Scene scene = world({0, 0, -9.81}, 0, 0);
  const Real3 half = {0.5, 0.4, 0.1};
  scene.bodies = {fixed("under", cube(half)), ball("ball", 1, 0.06, {0.1, 0.02, 0.1 - 0.01})};  // its centre is inside
  const Recorded it = run("atwood/rk4+event", scene, {0.5, 50, 1});
  CHECK(it.p(1)[2] == Approx(0.1 - 0.01).epsilon(1e-12));  // held where it is, not let through
}
