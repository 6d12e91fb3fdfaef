// Convex pairs by their support functions: cases by hand.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include "collision/convex_contacts.hpp"
#include "collision/nearest_features.hpp"
#include "convex_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

namespace {

const double kPi = std::acos(-1.0);

std::vector<Manifold<double>> meet(const Shape& a, const Transform<double>& pose_a, const Shape& b,
                                   const Transform<double>& pose_b, double margin = 0) {
  std::vector<Manifold<double>> out;
  convex_contacts(shape(a), pose_a, shape(b), pose_b, margin, out);
  return out;
}
double apart(const V& a, const V& b) { return norm(a - b); }

struct Pose {
  V p;
  Quat<double> q;
};

}  // namespace

TEST_CASE("a hull has whole faces, and no points that lie within faces or edges") {
  std::vector<Real3> points = box_corners({1, 2, 3});
  points.insert(points.end(), {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0.3, -2, 0.7}, {1, 2, 3}});
  const Hull<double> hull = make_hull<double>(points);
  CHECK(hull.vertices.size() == 8);
  CHECK(hull.faces.size() == 6);
  CHECK(hull.edges.size() == 12);
  for (const auto& face : hull.faces) {
    CHECK(face.count == 4);
    CHECK(norm(face.normal) == 1);
    CHECK(face.offset == std::abs(face.normal.x) + 2 * std::abs(face.normal.y) + 3 * std::abs(face.normal.z));
  }
  CHECK(make_hull<double>({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 0, 0}, {1, 1, 0}}).faces.size() == 2);
  CHECK(make_hull<double>({{0, 0, 0}, {2, 0, 0}, {1, 0, 0}}).edges.size() == 1);
  CHECK(make_hull<double>(std::vector<Real3>{{1, 2, 3}, {1, 2, 3}}).vertices.size() == 1);
}

TEST_CASE("the search for the closest points says how it ended") {
  Random random(3);
  const std::vector<Shape> shapes{Box{{1, 0.5, 0.2}}, Cylinder{0.4, 0.7}, Capsule{0.3, 0.5},
                                  Convex{boulder(random, 40, {1, 0.6, 0.3})}};
  int apart = 0, most = 0;
  double converged = 0, stagnated = 0;  // largest residuals, of the shapes' extent
  for (int n = 0; n < 4000; ++n) {
    const Geometry<double> a = shape(shapes[static_cast<std::size_t>(n % 4)]),
                           b = shape(shapes[static_cast<std::size_t>(n / 4 % 4)]);
    ConvexPart<double> part_a, part_b;
    REQUIRE(convex_part(a, part_a));
    REQUIRE(convex_part(b, part_b));
    const V direction = unit_vector(narrow3<double>(gauss3(random)));
    const Quat<double> tilt = turn(uniform(random, 0, 3), unit_vector(narrow3<double>(gauss3(random))));
    const auto closest = closest_points(part_a, part_b, transform(uniform(random, 0.1, 4) * direction, tilt), 1e300);
    REQUIRE(closest.solve.ended != SolveEnd::capped);
    REQUIRE(closest.solve.iterations >= 1);
    double& largest = closest.solve.ended == SolveEnd::converged ? converged : stagnated;
    largest = std::max(largest, closest.solve.residual);
    apart += closest.apart;
    most = std::max(most, static_cast<int>(closest.solve.iterations));
  }
  CHECK(converged < 2e-15);
  CHECK(stagnated < 1e-10);
  CHECK(apart > 1000);
  CHECK(most > 4);
  CHECK(most < 100);
}

TEST_CASE("every vertex of a hull lies behind every face, Euler's formula holds, climbing finds the farthest") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const double flat = std::pow(10.0, -uniform(random, 0, 11)), thin = seed % 3 == 0 ? flat : 1;
    const auto points = boulder(random, 5 + static_cast<int>(seed % 90), {1, thin, flat});
    const Hull<double> hull = make_hull<double>(points);
    RC_ASSERT(static_cast<int>(hull.vertices.size() + hull.faces.size()) == static_cast<int>(hull.edges.size()) + 2);
    for (const auto& face : hull.faces)
      for (const Real3& p : points) RC_ASSERT(dot(face.normal, narrow3<double>(p)) <= face.offset + 1e-14);
    for (int i = 0; i < 20; ++i) {
      const V d = narrow3<double>(gauss3(random));
      double most = -1e300;
      for (const Real3& p : points) most = std::max(most, dot(d, narrow3<double>(p)));
      RC_ASSERT(dot(d, hull.vertices[farthest_vertex(hull, d, i % static_cast<int>(hull.vertices.size()))]) >=
                most - 1e-14);
    }
  }));
}

TEST_CASE("cylinder against box: standing, lying, hanging over, beside a corner") {
  const auto box = Box{{1, 1, 1}};
  const auto cylinder = Cylinder{0.5, 2};
  SECTION("standing") {
    const auto m = meet(box, placed_at<double>({}), cylinder, placed_at<double>({0.1, 0.2, 2.99}));
    REQUIRE(m.size() == 1);
    CHECK(m[0].type == ManifoldType::face);
    CHECK(m[0].count == 4);
    CHECK(m[0].normal_W.z == 1);
    for (int i = 0; i < 4; ++i) {
      CHECK(m[0].points[i].gap == Approx(-0.01).epsilon(1e-13));
      CHECK(m[0].points[i].x_W.z == Approx(0.995).epsilon(1e-15));
      CHECK(apart(m[0].points[i].x_W, {0.1, 0.2, 0.995}) == Approx(0.5).epsilon(1e-14));
    }
  }
  SECTION("lying, and cut off at the box's side") {
    const auto m =
        meet(box, placed_at<double>({}), cylinder, placed_at<double>({0.5, 0, 1.4375}, turn(kPi / 2, {0, 1, 0})));
    REQUIRE(m.size() == 1);
    CHECK(m[0].type == ManifoldType::edge);
    REQUIRE(m[0].count == 2);
    CHECK(m[0].normal_W.z == Approx(1).epsilon(1e-15));
    for (int i = 0; i < 2; ++i) CHECK(m[0].points[i].gap == Approx(-0.0625).epsilon(1e-13));
    CHECK(std::abs(m[0].points[0].x_W.x - m[0].points[1].x_W.x) == Approx(2).epsilon(1e-14));
  }
  SECTION("side against a vertical edge: 1 - (0.5 sqrt 2 - ...)") {
    // The edge at (1, 1) and an axis at (1.3, 1.3): the distance is 0.3 sqrt 2 less the radius.
    const auto s =
        convex_separation(shape(box), placed_at<double>({}), shape(cylinder), placed_at<double>({1.3, 1.3, 0.5}));
    CHECK(s.gap == Approx(0.3 * std::sqrt(2.0) - 0.5).epsilon(1e-14));
    CHECK(s.normal_W.x == Approx(std::sqrt(0.5)).epsilon(1e-15));
    CHECK(s.normal_W.y == Approx(std::sqrt(0.5)).epsilon(1e-15));
  }
  SECTION("rim above an edge") {
    // A cylinder along x, tipped about y: its lowest rim point is known, the box's top is below it.
    const double a = 0.3;
    const V down{std::sin(a), 0, std::cos(a)};  // its axis
    const double lowest = 2 * std::cos(a) + 0.5 * std::sin(a);
    const auto s = convex_separation(shape(box), placed_at<double>({}), shape(cylinder),
                                     placed_at<double>({0.2, 0.1, 1.25 + lowest}, turn(a, {0, 1, 0})));
    CHECK(s.gap == Approx(0.25).epsilon(1e-14));
    CHECK(s.normal_W.z == 1);
    const V rim = V{0.2, 0.1, 1.25 + lowest} - 2.0 * down + 0.5 * V{std::cos(a), 0, -std::sin(a)};
    CHECK(apart(s.on_b_W, rim) < 1e-14);
  }
}

TEST_CASE("a cylinder that stands on a face but for a hair keeps its cap's points on the cap") {
  for (int power = -16; power <= -7; ++power) {
    for (const double sign : {1.0, -3.0}) {
      const double tilt = sign * std::pow(10.0, power);
      const Quat<double> q = normalised(Quat<double>{1, tilt / 2, tilt / 3, 0});
      std::vector<Manifold<double>> m;
      convex_contacts(shape(Box{{1, 1, 1}}), placed_at<double>({}), shape(Cylinder{0.5, 0.25}),
                      placed_at<double>({0, 0, 1.125}, q), 0.0, m);
      REQUIRE(m.size() == 1);
      CHECK(m[0].count == 4);
      INFO(tilt);
      for (int i = 0; i < m[0].count; ++i)  // half a metre of the tilt's rise
        CHECK(std::abs(m[0].points[static_cast<std::size_t>(i)].gap + 0.125) <= 0.7 * std::abs(tilt) + 1e-15);
    }
  }
}

TEST_CASE("cylinders: crossed, in line, side by side") {
  const auto cylinder = Cylinder{0.5, 2};
  const auto crossed = convex_separation(shape(cylinder), placed_at<double>({}), shape(cylinder),
                                         placed_at<double>({0.1, 1.25, 0.3}, turn(kPi / 3, {0, 1, 0})));
  CHECK(crossed.gap == Approx(0.25).epsilon(1e-14));
  CHECK(crossed.normal_W.y == Approx(1).epsilon(1e-15));
  CHECK(std::abs(crossed.on_a_W.x) < 1e-14);
  const auto m =
      meet(cylinder, placed_at<double>({}), cylinder, placed_at<double>({0, 0.98, 0}, turn(kPi / 3, {0, 1, 0})));
  REQUIRE(m.size() == 1);
  CHECK(m[0].type == ManifoldType::edge_edge);
  CHECK(m[0].points[0].gap == Approx(-0.02).epsilon(1e-12));
  const auto ends = meet(cylinder, placed_at<double>({}), cylinder, placed_at<double>({0.4, 0, 3.99}));
  REQUIRE(ends.size() == 1);
  CHECK(ends[0].type == ManifoldType::face);
  for (int i = 0; i < ends[0].count; ++i) {
    const V x = ends[0].points[i].x_W;
    CHECK(ends[0].points[i].gap == Approx(-0.01).epsilon(1e-12));
    CHECK(std::hypot(x.x, x.y) < 0.5 + 1e-14);
    CHECK(std::hypot(x.x - 0.4, x.y) < 0.5 + 1e-14);
  }
  const auto beside = meet(cylinder, placed_at<double>({}), cylinder, placed_at<double>({0.6, 0.8, 1}), 0.01);
  REQUIRE(beside.size() == 1);
  CHECK(beside[0].type == ManifoldType::edge);
  REQUIRE(beside[0].count == 2);
  CHECK(std::abs(beside[0].points[0].x_W.z - beside[0].points[1].x_W.z) == Approx(3).epsilon(1e-14));
  for (int i = 0; i < 2; ++i) CHECK(std::abs(beside[0].points[i].gap) < 1e-14);
}

TEST_CASE("what lies on a cap touches it at two points, once each") {
  const Quat<double> lying = turn(kPi / 2, {0, 1, 0});
  const Shape drum = Cylinder{1, 0.5};
  for (const double length : {0.5, 1.5}) {  // within the cap, and past its rim
    const auto found = meet(drum, placed_at<double>({}), Capsule{0.25, length}, placed_at<double>({0, 0, 0.7}, lying));
    REQUIRE(found.size() == 1);
    CHECK(found[0].count == 2);
    CHECK(found[0].type == ManifoldType::edge);
    const auto flipped =
        meet(Capsule{0.25, length}, placed_at<double>({0, 0, 0.7}, lying), drum, placed_at<double>({}));
    REQUIRE(flipped.size() == 1);
    CHECK(flipped[0].count == 2);
  }
}

TEST_CASE("points of a manifold are told once, and lie on faces that are a hair off each other") {
  // A tetrahedron's upper edge lies across a cap and crosses the rim at two of its points.
  const Shape spike = Convex{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
  const auto across = meet(Cylinder{1, 0.25}, placed_at<double>({}), spike, placed_at<double>({0, 0, 1.249999}));
  REQUIRE(across.size() == 1);
  CHECK(across[0].count == 2);
  // A prism tilted by less than the angle that still counts as parallel.
  std::vector<Real3> corners;
  for (int k = 0; k < 8; ++k)
    for (const double z : {-0.25, 0.25})
      corners.push_back({0.5 * std::cos(k * kPi / 4), 0.5 * std::sin(k * kPi / 4), z});
  const double tilt = 6e-7;
  const Shape drum = Cylinder{1, 0.25};
  const auto resting = meet(drum, placed_at<double>({}), Convex{corners},
                            placed_at<double>({0, 0, 0.5 + 0.5 * tilt - 1e-8}, turn(tilt, {0, 1, 0})));
  REQUIRE(resting.size() == 1);
  for (int i = 0; i < resting[0].count; ++i) {
    const auto& p = resting[0].points[i];
    CHECK(p.gap == Approx(0.5 * tilt - 1e-8 - tilt * p.x_W.x).margin(1e-13));
  }
  // Coincident: the middle is on no face.
  const Quat<double> askew = normalised(Quat<double>{0.66, 0.29, -0.24, 0.65});
  const auto within =
      meet(Convex{corners}, placed_at<double>({}, askew), Convex{corners}, placed_at<double>({}, askew));
  REQUIRE(within.size() == 1);
  for (int i = 0; i < within[0].count; ++i) CHECK(std::abs(dot(within[0].points[i].x_W, within[0].normal_W)) < 1e-15);
}

TEST_CASE(
    "the point where two edges have gone through each other is where they pass, a corner's under a side is the "
    "corner") {
  // Tetrahedra on alternate corners of cubes: the edge from (-1, 1, -1) to (1, -1, -1) passes (1, 1, 1) to (-1, -1, 1),
  // which is moved by y. Along x = -y and x = y - 0.5 they pass at (-0.25, 0.25).
  const Shape spike = Convex{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
  const auto crossed = meet(spike, placed_at<double>({}), spike, placed_at<double>({0, 0.5, -2 + 0.0625}));
  REQUIRE(crossed.size() == 1);
  REQUIRE(crossed[0].count == 1);
  CHECK(apart(crossed[0].normal_W, {0, 0, -1}) < 1e-15);
  CHECK(apart(crossed[0].points[0].x_W, {-0.25, 0.25, -1 + 0.0625 / 2}) < 1e-14);
  // An octahedron's corner sunk into a cylinder's side, off its middle.
  const Shape diamond = Convex{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  const auto sunk = meet(Cylinder{0.5, 2}, placed_at<double>({}), diamond, placed_at<double>({1.5 - 0.0625, 0, 1.25}));
  REQUIRE(sunk.size() == 1);
  REQUIRE(sunk[0].count == 1);
  CHECK(apart(sunk[0].points[0].x_W, {0.5 - 0.0625 / 2, 0, 1.25}) < 1e-14);
}

namespace {

// How far x lies outside of a hull or a cylinder.
double outside(const Geometry<double>& g, const Transform<double>& pose, const V& x_W) {
  const V x = to_body(pose, x_W - pose.p_W);
  if (g.kind == ShapeKind::cylinder) return std::max(std::hypot(x.x, x.y) - g.radius, std::abs(x.z) - g.half_length);
  double most = -1e300;
  for (const auto& face : g.hull->faces) most = std::max(most, dot(face.normal, x) - face.offset);
  return most;
}

}  // namespace

TEST_CASE("the points that meet lie on both shapes, where many features tie, too") {
  const std::vector<Shape> shapes = {Convex{box_corners({0.5, 0.5, 0.5})},
                                     Convex{box_corners({0.5, 0.25, 1})},
                                     Convex{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}},
                                     Convex{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}},
                                     Cylinder{0.5, 0.25},
                                     Cylinder{0.25, 1}};
  const std::vector<Quat<double>> turns = {{},
                                           turn(kPi / 2, {1, 0, 0}),
                                           turn(kPi / 2, {0, 1, 0}),
                                           turn(kPi / 4, {1, 0, 0}),
                                           turn(kPi / 4, {0, 0, 1}),
                                           turn(kPi, {0, 1, 0})};
  const std::vector<V> ways = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}};
  for (const Shape& s : shapes)
    for (const Shape& t : shapes)
      for (const auto& q : turns)
        for (const auto& r : turns)
          for (const V& way : ways)
            for (const double aside : {0.0, 0.2, 0.4}) {
              const Geometry<double> a = shape(s), b = shape(t);
              const Transform<double> at = placed_at<double>({}, q), turned_b = placed_at<double>({}, r);
              const auto reach = [&](const Geometry<double>& g, const Transform<double>& pose, const V& d) {
                ConvexPart<double> part;
                int vertex = 0;
                convex_part(g, part);
                return dot(d, to_world(pose, support(part, to_body(pose, d), vertex)));
              };
              for (const double gap : {-0.0625, 0.0, 0.0625}) {
                Transform<double> pose_b = turned_b;
                pose_b.p_W =
                    (reach(a, at, way) + reach(b, turned_b, -way) + gap) * way + aside * V{way.y, way.z, way.x};
                const Separation<double> found = separation(a, at, b, pose_b);
                INFO(s.index() << t.index() << ' ' << q.x << q.y << q.z << ' ' << r.x << r.y << r.z << " gap " << gap);
                CHECK(outside(a, at, found.on_a_W) < 1e-12);
                CHECK(outside(b, pose_b, found.on_b_W) < 1e-12);
              }
            }
}

TEST_CASE("convex against plane: the vertices below, at most four that span them") {
  Geometry<double> ground = shape(Plane{{0, 0, 1}, 0.5});
  const Geometry<double> hull = shape(Convex{box_corners({1, 2, 3})});
  std::vector<Manifold<double>> m;
  hull_plane_contacts(ground, hull, placed_at<double>({7, 8, 3.375}), 0.0, m);
  REQUIRE(m.size() == 1);
  CHECK(m[0].count == 4);
  CHECK(m[0].type == ManifoldType::face);
  for (int i = 0; i < 4; ++i) CHECK(m[0].points[i].gap == -0.125);
  CHECK(hull_plane_separation(ground, hull, placed_at<double>({7, 8, 4}, turn(kPi / 2, {1, 0, 0}))).gap ==
        Approx(1.5).epsilon(1e-15));
}
