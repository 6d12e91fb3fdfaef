// The exact geometry against answers by hand, and against certificates that no formula of its own enters: any direction
// bounds the gap from below, and the reported normal reaches it.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <span>

#include "geometry/geometry.hpp"
#include "scene/pair_sweep.hpp"

using namespace atwood;
using geometry::Real;
using geometry::Vector;

namespace {

constexpr Real kRound = 1e-17L;

Scene scene_of(const Shape& a, const Real3& p_a, const Shape& b, const Real3& p_b, const Real4& q_b = {1, 0, 0, 0}) {
  Scene scene;
  scene.bodies.resize(2);
  scene.bodies[0].shape = a, scene.bodies[0].position_m = p_a;
  scene.bodies[1].shape = b, scene.bodies[1].position_m = p_b, scene.bodies[1].orientation_wxyz = q_b;
  return scene;
}

void check(const Scene& scene, Real gap, const Vector& normal) {
  const auto found = geometry::separation_between(scene, 0, 1);
  CHECK(std::fabs(found.gap_m - gap) <= kRound);
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(found.normal[i] - normal[i]) <= kRound);
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(found.on_b[i] - found.on_a[i] - gap * normal[i]) <= 4 * kRound);
  const Scene other = [&] {
    Scene s = scene;
    std::swap(s.bodies[0], s.bodies[1]);
    return s;
  }();
  const auto back = geometry::separation_between(other, 0, 1);
  CHECK(std::fabs(back.gap_m - gap) <= kRound);
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(back.normal[i] + normal[i]) <= kRound);
}

Real dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The largest n . x over the body, by its definition, in its own axes.
Real reach(const Body& body, const Vector& n) {
  const auto& q = body.orientation_wxyz;
  const Real w = q[0], x = q[1], y = q[2], z = q[3], s = 2 / (w * w + x * x + y * y + z * z);
  const Vector axis_x{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)};
  const Vector axis_y{s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)};
  const Vector axis_z{s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)};
  const Vector m{dot(axis_x, n), dot(axis_y, n), dot(axis_z, n)};
  const auto of_points = [&](const std::vector<Real3>& points) {
    Real most = -HUGE_VALL;
    for (const Real3& p : points) most = std::max(most, dot(m, {p[0], p[1], p[2]}));
    return most;
  };
  struct Support {
    const Vector& m;
    const decltype(of_points)& points;
    Real operator()(const std::monostate&) const { return 0; }
    Real operator()(const Plane&) const { return HUGE_VALL; }
    Real operator()(const Mesh& b) const { return points(b.points_m); }
    Real operator()(const Compound&) const { return HUGE_VALL; }
    Real operator()(const Sphere& b) const { return b.radius_m; }
    Real sides(std::span<const double> half) const {
      Real sum = 0;
      for (std::size_t i = 0; i < half.size(); ++i) sum += std::fabs(m[i]) * half[i];
      return sum;
    }
    Real operator()(const Rectangle& b) const { return sides(b.half_extents_m); }
    Real operator()(const Box& b) const { return sides(b.half_extents_m); }
    Real operator()(const Capsule& b) const { return b.radius_m + std::fabs(m[2]) * b.half_length_m; }
    Real operator()(const Cylinder& b) const {
      return std::hypot(m[0], m[1]) * b.radius_m + std::fabs(m[2]) * b.half_length_m;
    }
    Real operator()(const Convex& b) const { return points(b.points_m); }
  };
  const auto& p = body.position_m;
  return dot(n, {p[0], p[1], p[2]}) + std::visit(Support{m, of_points}, body.shape);
}

Real rounding(const Shape& shape) {
  if (const auto* ball = std::get_if<Sphere>(&shape)) return ball->radius_m;
  if (const auto* bar = std::get_if<Capsule>(&shape)) return bar->radius_m;
  return 0;
}

// The gap between the two support planes orthogonal to n; negative: overlap.
Real between(const Scene& scene, const Vector& n) {
  return -reach(scene.bodies[1], {-n[0], -n[1], -n[2]}) - reach(scene.bodies[0], n);
}

}  // namespace

TEST_CASE("separations agree with values derived by hand") {
  const Sphere ball{0.5};
  check(scene_of(ball, {0, 0, 0}, Sphere{0.25}, {0, 0.5, 0}), -0.25L, {0, 1, 0});
  check(scene_of(ball, {0, 0, 0}, Sphere{0.25}, {0, 0, -1}), 0.25L, {0, 0, -1});
  check(scene_of(ball, {1, 2, 0.25}, Plane{{0, 0, 2}, 0}, {}), -0.25L, {0, 0, -1});
  check(scene_of(ball, {0, 0, 4}, Plane{{0, 0, 2}, 2}, {}), 2.5L, {0, 0, -1});
  const Box box{{1, 2, 3}};
  check(scene_of(box, {0, 0, 0}, ball, {1.25, 0, 0}), -0.25L, {1, 0, 0});  // a face
  check(scene_of(box, {0, 0, 0}, ball, {1.75, 0, 0}), 0.25L, {1, 0, 0});
  check(scene_of(box, {0, 0, 0}, ball, {4, 6, 0}), 4.5L, {0.6L, 0.8L, 0});                   // an edge: (3, 4) away
  check(scene_of(box, {0, 0, 0}, ball, {3, 4, 4}), 2.5L, {2 / 3.0L, 2 / 3.0L, 1 / 3.0L});    // a corner: (2, 2, 1) away
  check(scene_of(box, {0, 0, 0}, ball, {0.75, 0, 0}), -0.75L, {1, 0, 0});                    // the centre inside
  check(scene_of(box, {0, 0, 0}, Box{{0.25, 0.25, 0.25}}, {0.5, 0, 0}), -0.75L, {1, 0, 0});  // one within the other
  check(scene_of(box, {0, 0, 0}, Box{{1, 1, 1}}, {2.5, 0, 0}), 0.5L, {1, 0, 0});
  check(scene_of(box, {0, 0, 0}, Box{{1, 1, 1}}, {5, 7, 0}), 5, {0.6L, 0.8L, 0});
  check(scene_of(box, {0, 0, 5.5}, Plane{{0, 0, 1}, 2}, {}), 0.5L, {0, 0, -1});
  const Capsule bar{0.5, 1};
  check(scene_of(bar, {0, 0, 0}, ball, {0, 0.75, 0.5}), -0.25L, {0, 1, 0});
  check(scene_of(bar, {0, 0, 0}, ball, {3, 0, 5}), 4, {0.6L, 0, 0.8L});
  check(scene_of(bar, {0, 0, 0}, Capsule{0.25, 1}, {2, 0, 0}), 1.25L, {1, 0, 0});  // parallel
  const Cylinder drum{1, 2};
  check(scene_of(drum, {0, 0, 0}, ball, {0, 1.25, 1}), -0.25L, {0, 1, 0});   // the side
  check(scene_of(drum, {0, 0, 0}, ball, {0.5, 0, 2.75}), 0.25L, {0, 0, 1});  // a cap
  check(scene_of(drum, {0, 0, 0}, ball, {4, 0, 6}), 4.5L, {0.6L, 0, 0.8L});  // a rim
  const Rectangle sheet{{1, 2}};
  check(scene_of(sheet, {0, 0, 0}, ball, {0.5, 1, 0.25}), -0.25L, {0, 0, 1});
  check(scene_of(sheet, {0, 0, 0}, ball, {4, 0, 4}), 4.5L, {0.6L, 0, 0.8L});
  check(scene_of(sheet, {0, 0, 0}, ball, {4, 6, 0}), 4.5L, {0.6L, 0.8L, 0});  // beside a corner, in its plane
  const Convex wedge{{{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-1, 1, 1}}};
  check(scene_of(wedge, {0, 0, 0}, ball, {-1.25, 0, 0}), -0.25L, {-1, 0, 0});
  const Mesh triangle{"", {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
  check(scene_of(triangle, {0, 0, 0}, ball, {1, 1, 0.75}), 0.25L, {0, 0, 1});
  check(scene_of(triangle, {0, 0, 0}, ball, {7, 0, 4}), 4.5L, {0.6L, 0, 0.8L});
  check(scene_of(triangle, {0, 0, 0}, triangle, {7, 0, 4}), 5, {0.6L, 0, 0.8L});
  const Compound pair{{{{1, 1, 1}, {-2, 0, 0}, {1, 0, 0, 0}}, {{1, 1, 1}, {2, 0, 0}, {1, 0, 0, 0}}}};
  check(scene_of(pair, {0, 0, 0}, ball, {0.75, 0, 0}), -0.25L, {-1, 0, 0});  // the second box is the nearer
}

TEST_CASE("no direction parts two shapes further than the gap; the normal of an overlap does part them that far") {
  for (const char* pair :
       {"sphere-box", "sphere-capsule", "sphere-cylinder", "sphere-convex", "sphere-rectangle", "box-box",
        "box-rectangle", "capsule-box", "capsule-capsule", "convex-box", "convex-convex", "triangle-triangle"}) {
    int overlapping = 0;
    for (int k = 0; k < 300; ++k) {
      const Scene scene = sweep_scene(pair, 7, k, false);
      const auto found = geometry::separation_between(scene, 0, 1);
      INFO(pair << " " << k);
      // Of two points d apart the direction is as good as their round-off over d; of an edge or a face, over its
      // length, which in slabs and needles is down to a ten-thousandth of the body's size (a thousand times thinner,
      // extents half a decade either way).
      const Real d = found.gap_m + rounding(scene.bodies[0].shape) + rounding(scene.bodies[1].shape);
      const Real extent = std::min<Real>(d > 0 ? d : HUGE_VALL, 1e-4L * static_cast<Real>(pair_size_m(scene)));
      const Real turned = std::min<Real>(1, found.bar_m / extent) * largest_radius_m(scene);
      CHECK(std::fabs(between(scene, found.normal) - found.gap_m) <= 8 * (found.bar_m + turned));
      if (found.gap_m >= 0) {
        const Vector across{found.on_b[0] - found.on_a[0], found.on_b[1] - found.on_a[1],
                            found.on_b[2] - found.on_a[2]};
        CHECK(std::fabs(std::sqrt(dot(across, across)) - found.gap_m) <= 8 * found.bar_m);
      }
      overlapping += found.gap_m < 0 ? 1 : 0;
      // Directions near the normal and all around.
      for (int i = 0; i < 60; ++i) {
        const Real turn = i < 40 ? std::pow(10.0L, -static_cast<Real>(i) / 5) : 2;
        Vector n = found.normal;
        for (std::size_t c = 0; c < 3; ++c) n[c] += turn * std::sin(Real(1 + 12 * i) + 2.3L * c + k);
        const Real length = std::sqrt(dot(n, n));
        for (Real& c : n) c /= length;
        CHECK(between(scene, n) <= found.gap_m + 8 * found.bar_m);
      }
    }
    CHECK(overlapping > 20);
    CHECK(overlapping < 280);
  }
}

TEST_CASE("the depth of an overlap is that of the separation, and 0 where there is none") {
  for (const char* pair : {"sphere-box", "capsule-box", "capsule-capsule", "box-box", "convex-convex"})
    for (int k = 0; k < 300; ++k) {
      const Scene scene = sweep_scene(pair, 11, k, false);
      Sample sample;
      for (const Body& body : scene.bodies) {
        BodySample& at = sample.bodies.emplace_back();
        std::copy(body.position_m.begin(), body.position_m.end(), at.p_m.begin());
        std::copy(body.orientation_wxyz.begin(), body.orientation_wxyz.end(), at.q_wxyz.begin());
      }
      INFO(pair << " " << k);
      const Real gap = geometry::separation_between(scene, sample, 0, 1).gap_m;
      CHECK(geometry::overlap_depth(scene, sample, 0, 1) == std::max<Real>(0, -gap));
    }
}

TEST_CASE("first touches agree with values derived by hand") {
  Scene scene = scene_of(Sphere{1}, {0, 0, 0}, Sphere{1}, {7, 0, 0});
  scene.bodies[1].velocity_m_per_s = {-10, 0, 0};
  auto touch = geometry::first_touch(scene, 0, 1, 1);
  REQUIRE(touch);
  CHECK(std::fabs(touch->t_s - 0.5L) <= kRound);
  CHECK(touch->normal[0] == 1);
  CHECK(!geometry::first_touch(scene, 0, 1, 0.25));
  scene.bodies[1].position_m = {7, 2.0000001, 0};  // passes by
  CHECK(!geometry::first_touch(scene, 0, 1, 1));
  // A spinning box's corner, sqrt(2) from its middle, reaches a plane 1.2 away once sqrt(2) cos(45 deg - w t) is 1.2.
  Scene spun = scene_of(Box{{1, 1, 1}}, {0, 0, 0}, Plane{{1, 0, 0}, -1.2}, {});
  spun.bodies[0].angular_velocity_body_rad_per_s = {0, 0, 1};
  touch = geometry::first_touch(spun, 0, 1, 1);
  REQUIRE(touch);
  const Real due = std::acos(-1.0L) / 4 - std::acos(Real(1.2) / std::sqrt(2.0L));
  CHECK(std::fabs(touch->t_s - due) <= touch->bar_s + kRound);
  CHECK(touch->bar_s < 1e-16L);
}

TEST_CASE("first touches of bodies that are not convex: the part in the way, not the nearest") {
  const Compound room{{{{5, 5, 0.5}, {0, 0, -0.5}, {1, 0, 0, 0}}, {{0.5, 5, 2}, {3.5, 0, 1}, {1, 0, 0, 0}}}};
  const Mesh sheets{"",
                    {{-5, -5, 0}, {3, -5, 0}, {3, 5, 0}, {-5, 5, 0}, {3, -5, 5}, {3, 5, 5}},
                    {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}}};
  for (const Shape& walls : {Shape(room), Shape(sheets)})
    for (const Shape& flyer : {Shape(Sphere{0.25}), Shape(Box{{0.25, 0.25, 0.25}})}) {
      Scene scene = scene_of(walls, {0, 0, 0}, flyer, {0, 0, 0.375});
      scene.bodies[1].velocity_m_per_s = {1, 0, 0};
      const auto touch = geometry::first_touch(scene, 0, 1, 5);
      REQUIRE(touch);
      CHECK(std::fabs(touch->t_s - 2.75L) <= touch->bar_s + kRound);
      CHECK(touch->bar_s < 1e-15L);
      CHECK(touch->normal[0] == -1);
      CHECK(!geometry::first_touch(scene, 0, 1, 2.7));
    }
}

TEST_CASE("a graze is found, and a miss by a small gap is a miss") {
  // A rod of half-length 1 turns about its middle, 1 + d above the plane less its radius.
  Scene scene = scene_of(Capsule{0.25, 1}, {0, 0, 1.25}, Plane{{0, 0, 1}, 0}, {});
  scene.bodies[0].orientation_wxyz = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  scene.bodies[0].angular_velocity_body_rad_per_s = {0, 1, 0};
  const auto touch = geometry::first_touch(scene, 0, 1, 3);
  REQUIRE(touch);
  CHECK(std::fabs(touch->t_s - std::acos(-1.0L) / 2) < 1e-7L);
  scene.bodies[0].position_m[2] = 1.25 + 1e-12;
  CHECK(!geometry::first_touch(scene, 0, 1, 3));
}

TEST_CASE("a body that rotates close to a floor for a long time does not touch it") {
  const Mesh square{"", {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  for (const Shape& top : {Shape(Box{{0.5, 0.5, 0.5}}), Shape(Cylinder{0.5, 0.5})})
    for (const Shape& floor : {Shape(Plane{{0, 0.6, 0.8}, 0}), Shape(Rectangle{{5, 5}}), Shape(square)}) {
      if (top.index() == 6 && floor.index() != 2) continue;
      const double half = std::acos(0.8) / 2, height = 0.5 + 1e-9;
      Scene scene = scene_of(top, {0, 0.6 * height, 0.8 * height}, floor, {});
      for (auto& body : scene.bodies)
        body.orientation_wxyz = {std::cos(half), -std::sin(half), 0, 0};  // z to (0, 0.6, 0.8)
      scene.bodies[0].angular_velocity_body_rad_per_s = {0, 0, 1e3};
      INFO(top.index() << " over " << floor.index());
      CHECK(!geometry::first_touch(scene, 0, 1, 1e6));
      ContactQuery swept;
      swept.swept = true, swept.t_end_s = 1e6;
      CHECK(geometry::find_contacts(scene, swept).touches.empty());
    }
}

TEST_CASE("bodies with a tiny gap are separated, also with nearly parallel edges") {
  // A capsule beside a rectangle's side, its axis off the side's by an ulp; a box's edge along another's.
  Scene beside = scene_of(Rectangle{{0.5, 0.25}}, {0, 0, 0}, Capsule{0.25, 0.5}, {0, 0.5 + 1e-10, 0});
  beside.bodies[1].orientation_wxyz = {std::sqrt(0.5), 0, std::sqrt(0.5) * (1 + 0x1p-50), 0};
  const auto apart = geometry::separation_between(beside, 0, 1);
  CHECK(std::fabs(apart.gap_m - 1e-10L) < 1e-16L);
  CHECK(apart.bar_m < 1e-16L);
  CHECK(geometry::find_contacts(beside, {}).contacts.empty());
  for (const double angle : {1e-15, 1e-12, 1e-9}) {
    Scene boxes = scene_of(Box{{0.5, 0.5, 0.5}}, {0, 0, 0}, Box{{0.5, 0.5, 0.5}}, {1.001, 1.001, 0});
    boxes.bodies[1].orientation_wxyz = {1, angle, 0.3 * angle, 0};
    const auto corner = geometry::separation_between(boxes, 0, 1);
    INFO(angle);
    CHECK(corner.bar_m < 1e-16L);
    CHECK(std::fabs(corner.gap_m - 0.001L * std::sqrt(2.0L)) < 2 * angle);
    CHECK(geometry::find_contacts(boxes, {}).contacts.empty());
  }
}

TEST_CASE("a separating direction is more accurate than the difference of two close points") {
  // A rectangle beside a square of two triangles, 1e-10 apart in one plane that is turned by a hair.
  const Mesh square{"", {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  Scene scene = scene_of(Rectangle{{2, 2}}, {0, 0, 0}, square, {0, -3.0000000001, 0});
  for (const double angle : {0.0, 1e-15, 5.7564543623575585e-09, 1e-6}) {
    for (auto& body : scene.bodies) body.orientation_wxyz = {1, 0, angle, 0};
    const auto apart = geometry::separation_between(scene, 0, 1);
    INFO(angle);
    CHECK(std::fabs(apart.gap_m - 1e-10L) < 1e-15L);
    CHECK(apart.bar_m < 1e-16L);
    CHECK(geometry::find_contacts(scene, {}).contacts.empty());
  }
}

TEST_CASE("decimals that touch do, though their doubles leave a gap") {
  Scene scene = scene_of(Sphere{0.1}, {0, 0, 0}, Sphere{0.7}, {0.8, 0, 0});
  REQUIRE(geometry::separation_between(scene, 0, 1).gap_m > geometry::separation_between(scene, 0, 1).bar_m);
  CHECK(geometry::find_contacts(scene, {}).contacts.size() == 1);
  ContactQuery swept;
  swept.swept = true, swept.t_end_s = 0.7;
  CHECK(geometry::find_contacts(scene, swept).touches.size() == 1);
  scene.bodies[1].position_m[0] += 1e-13;
  CHECK(geometry::find_contacts(scene, {}).contacts.empty());
  Scene falling = scene_of(Sphere{0.1}, {0, 0, 0.8}, Plane{{0, 0, 1}, 0}, {});
  falling.bodies[0].velocity_m_per_s = {0, 0, -1};
  CHECK(geometry::find_contacts(falling, swept).touches.size() == 1);
  swept.t_end_s = 0.7 - 1e-12;
  CHECK(geometry::find_contacts(falling, swept).touches.empty());
}

TEST_CASE("a closed mesh is solid") {
  Mesh cube{"",
            {},
            {{0, 2, 3},
             {0, 3, 1},
             {4, 5, 7},
             {4, 7, 6},
             {0, 1, 5},
             {0, 5, 4},
             {2, 6, 7},
             {2, 7, 3},
             {0, 4, 6},
             {0, 6, 2},
             {1, 3, 7},
             {1, 7, 5}}};
  for (int i = 0; i < 8; ++i) cube.points_m.push_back({i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
  check(scene_of(cube, {0, 0, 0}, Sphere{0.5}, {0.75, 0, 0}), -0.75L, {1, 0, 0});
  check(scene_of(cube, {0, 0, 0}, Box{{0.25, 0.25, 0.25}}, {0.5, 0, 0}), -0.75L, {1, 0, 0});
  check(scene_of(cube, {0, 0, 0}, Box{{0.25, 0.25, 1}}, {0, 0, 1.5}), -0.5L, {0, 0, 1});
  check(scene_of(cube, {0, 0, 0}, cube, {0.25, 0.125, 1.5}), -0.5L, {0, 0, 1});
  check(scene_of(cube, {0, 0, 0}, Sphere{0.5}, {1.75, 0, 0}), 0.25L, {1, 0, 0});
  // A dent in the top down to the middle makes it no longer convex: a ball inside still finds the nearest way out.
  Mesh dented = cube;
  dented.points_m.push_back({0, 0, 0});
  dented.triangles[2] = {4, 5, 8}, dented.triangles[3] = {5, 7, 8};
  dented.triangles.push_back({7, 6, 8}), dented.triangles.push_back({6, 4, 8});
  check(scene_of(dented, {0, 0, 0}, Sphere{0.125}, {0, 0, -0.75}), -0.375L, {0, 0, -1});
  CHECK(geometry::separation_between(scene_of(dented, {0, 0, 0}, Sphere{0.125}, {0, 0, 0.5}), 0, 1).gap_m > 0);
  CHECK_THROWS_AS(geometry::separation_between(scene_of(dented, {0, 0, 0}, Box{{0.1, 0.1, 0.1}}, {0, 0, -0.75}), 0, 1),
                  std::invalid_argument);
}
