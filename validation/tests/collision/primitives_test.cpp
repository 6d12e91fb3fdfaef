// Contacts and gaps of primitive shapes, pair by pair, against numbers worked out by hand; each case both ways round.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <limits>

#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;
using Q = Quat<double>;

namespace {

const double kHalfRoot = std::sqrt(0.5), kPi = std::acos(-1.0);
const Q kOverX{kHalfRoot, kHalfRoot, 0, 0}, kOverY{kHalfRoot, 0, kHalfRoot, 0};
Q about_x(double angle) { return {std::cos(angle / 2), std::sin(angle / 2), 0, 0}; }
const Plane kGround{{0, 0, 1}, 0};

struct Pose {
  V p{};
  Q q{};
};
struct Expected {
  double gap;
  V normal;  // from a to b
  ManifoldType type;
  std::vector<V> points;
  double tolerance = 2e-15;
};

bool same(const V& a, const V& b, double tolerance) {
  return std::abs(a.x - b.x) <= tolerance && std::abs(a.y - b.y) <= tolerance && std::abs(a.z - b.z) <= tolerance;
}

void expect_one_way(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, const Expected& expected) {
  const auto shape_a = make_geometry<double>(a), shape_b = make_geometry<double>(b);
  const auto pose_a = transform(at_a.p, at_a.q), pose_b = transform(at_b.p, at_b.q);
  REQUIRE(missing_contact_test(shape_a.kind, shape_b.kind) == nullptr);

  const auto apart = separation(shape_a, pose_a, shape_b, pose_b);
  CHECK(std::abs(apart.gap - expected.gap) <= expected.tolerance);
  CHECK(same(apart.normal_W, expected.normal, expected.tolerance));
  CHECK(same(apart.on_b_W - apart.on_a_W, expected.gap * expected.normal, 2 * expected.tolerance));

  std::vector<Manifold<double>> found;
  if (expected.gap > 2 * expected.tolerance) {
    find_contacts(shape_a, pose_a, shape_b, pose_b, expected.gap / 2, found);
    CHECK(found.empty());
  }
  const double margin = expected.gap > -expected.tolerance ? expected.gap + expected.tolerance : 0;
  find_contacts(shape_a, pose_a, shape_b, pose_b, margin, found);
  REQUIRE(found.size() == 1);
  const Manifold<double>& m = found[0];
  CHECK(same(m.normal_W, expected.normal, expected.tolerance));
  CHECK(m.type == expected.type);
  REQUIRE(m.count == static_cast<int>(expected.points.size()));
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < m.count; ++i) {
    const auto& point = m.points[static_cast<std::size_t>(i)];
    least = std::min(least, point.gap);
    bool known = false;
    for (const V& x : expected.points) known = known || same(x, point.x_W, expected.tolerance);
    INFO(point.x_W.x << " " << point.x_W.y << " " << point.x_W.z);
    CHECK(known);
  }
  CHECK(std::abs(least - expected.gap) <= expected.tolerance);
}

void expect(const char* what, const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
            const Expected& expected) {
  INFO(what);
  expect_one_way(a, pose_a, b, pose_b, expected);
  Expected swapped = expected;
  swapped.normal = -expected.normal;
  INFO("swapped");
  expect_one_way(b, pose_b, a, pose_a, swapped);
}

}  // namespace

TEST_CASE("sphere against sphere") {
  expect("overlapping", Sphere{1}, {}, Sphere{0.5}, {{1.25, 0, 0}},
         {-0.25, {1, 0, 0}, ManifoldType::point, {{0.875, 0, 0}}});
  expect("touching exactly", Sphere{1}, {}, Sphere{2}, {{0, 3, 0}}, {0, {0, 1, 0}, ManifoldType::point, {{0, 1, 0}}});
  expect("apart", Sphere{1}, {}, Sphere{1}, {{0, 3, 4}}, {3, {0, 0.6, 0.8}, ManifoldType::point, {{0, 1.5, 2}}});
  expect("one within the other", Sphere{2}, {}, Sphere{0.5}, {{0, 0, -0.5}},
         {-2, {0, 0, -1}, ManifoldType::point, {{0, 0, -1}}});
  expect("far from the origin", Sphere{1}, {{1e9, 0, 0}}, Sphere{1}, {{1e9, 1.5, 0}},
         {-0.5, {0, 1, 0}, ManifoldType::point, {{1e9, 0.75, 0}}});
  expect("of atoms' size", Sphere{1e-9}, {}, Sphere{1e-9}, {{0, 1.5e-9, 0}},
         {-0.5e-9, {0, 1, 0}, ManifoldType::point, {{0, 0.75e-9, 0}}, 1e-15});
  expect("concentric", Sphere{1}, {{1, 2, 3}}, Sphere{0.25}, {{1, 2, 3}},
         {-1.25, {0, 0, 1}, ManifoldType::point, {{1, 2, 3.375}}});
}

TEST_CASE("sphere against plane") {
  expect("resting", Sphere{1}, {{3, 4, 1}}, kGround, {}, {0, {0, 0, -1}, ManifoldType::point, {{3, 4, 0}}});
  expect("sunk", Sphere{1}, {{3, 4, 0.75}}, kGround, {}, {-0.25, {0, 0, -1}, ManifoldType::point, {{3, 4, -0.125}}});
  expect("its centre below", Sphere{1}, {{3, 4, -0.5}}, kGround, {},
         {-1.5, {0, 0, -1}, ManifoldType::point, {{3, 4, -0.75}}});
  expect("under a plane turned over", Sphere{0.75}, {{0, 0, 0.5}}, Plane{{0, 0, -1}, -1}, {},
         {-0.25, {0, 0, 1}, ManifoldType::point, {{0, 0, 1.125}}});
  expect("a tilted plane", Sphere{5}, {{6, 8, 0}}, Plane{{0.6, 0.8, 0}, 4}, {},
         {1, {-0.6, -0.8, 0}, ManifoldType::point, {{2.7, 3.6, 0}}, 4e-15});
}

TEST_CASE("sphere against rectangle: both sides, edges, corners") {
  const Rectangle plate{{1, 2}};
  expect("above", Sphere{1}, {{0.5, 0, 0.75}}, plate, {}, {-0.25, {0, 0, -1}, ManifoldType::point, {{0.5, 0, -0.125}}});
  expect("below", Sphere{1}, {{0.5, 0, -0.75}}, plate, {}, {-0.25, {0, 0, 1}, ManifoldType::point, {{0.5, 0, 0.125}}});
  expect("its centre in the plate", Sphere{1}, {{0.5, 0, 0}}, plate, {},
         {-1, {0, 0, -1}, ManifoldType::point, {{0.5, 0, -0.5}}});
  expect("beside an edge", Sphere{1}, {{1.5, 1, 0}}, plate, {},
         {-0.5, {-1, 0, 0}, ManifoldType::point, {{0.75, 1, 0}}});
  expect("over an edge", Sphere{5}, {{4, 0, 4}}, plate, {}, {0, {-0.6, 0, -0.8}, ManifoldType::point, {{1, 0, 0}}});
  expect("off a corner", Sphere{3}, {{3, 4, 1}}, plate, {},
         {0, {-2 / 3., -2 / 3., -1 / 3.}, ManifoldType::point, {{1, 2, 0}}});
  expect("a turned plate", Sphere{1}, {{0, -0.5, 1}}, plate, {{}, kOverX},
         {-0.5, {0, 1, 0}, ManifoldType::point, {{0, 0.25, 1}}});
}

TEST_CASE("sphere against box") {
  const Box box{{1, 2, 3}};
  expect("on a face", Sphere{1}, {{1.5, 0.5, 0.5}}, box, {},
         {-0.5, {-1, 0, 0}, ManifoldType::point, {{0.75, 0.5, 0.5}}});
  expect("on an edge", Sphere{5}, {{4, 6, 0}}, box, {}, {0, {-0.6, -0.8, 0}, ManifoldType::point, {{1, 2, 0}}});
  expect("on a corner", Sphere{2}, {{2, 4, 5}}, box, {},
         {1, {-1 / 3., -2 / 3., -2 / 3.}, ManifoldType::point, {{1 + 1 / 6., 2 + 1 / 3., 3 + 1 / 3.}}});
  expect("its centre inside", Sphere{0.5}, {{0.25, 1.5, 0}}, box, {},
         {-1, {0, -1, 0}, ManifoldType::point, {{0.25, 1.5, 0}}});
  expect("wholly inside", Sphere{0.25}, {{0, 0, -2.5}}, box, {},
         {-0.75, {0, 0, 1}, ManifoldType::point, {{0, 0, -2.625}}});
  expect("at its centre", Sphere{0.5}, {}, box, {}, {-1.5, {-1, 0, 0}, ManifoldType::point, {{0.25, 0, 0}}});
  expect("a turned box", Sphere{1}, {{0, 0, 2.5}}, box, {{}, kOverX},
         {-0.5, {0, 0, -1}, ManifoldType::point, {{0, 0, 1.75}}});
}

TEST_CASE("sphere against capsule") {
  const Capsule capsule{0.5, 2};
  expect("on the side", Sphere{1}, {{1.25, 0, 1}}, capsule, {},
         {-0.25, {-1, 0, 0}, ManifoldType::point, {{0.375, 0, 1}}});
  expect("on a cap", Sphere{1}, {{0, 0, 3.25}}, capsule, {}, {-0.25, {0, 0, -1}, ManifoldType::point, {{0, 0, 2.375}}});
  expect("aslant on a cap", Sphere{4.5}, {{3, 0, 6}}, capsule, {},
         {0, {-0.6, 0, -0.8}, ManifoldType::point, {{0.3, 0, 2.4}}});
  expect("on the axis", Sphere{1}, {{0, 0, 1}}, capsule, {}, {-1.5, {-1, 0, 0}, ManifoldType::point, {{-0.25, 0, 1}}});
}

TEST_CASE("sphere against cylinder") {
  const Cylinder drum{2, 1};
  expect("on the side", Sphere{1}, {{0, 2.5, 0.5}}, drum, {},
         {-0.5, {0, -1, 0}, ManifoldType::point, {{0, 1.75, 0.5}}});
  expect("on a disc", Sphere{1}, {{1, 0, 1.5}}, drum, {}, {-0.5, {0, 0, -1}, ManifoldType::point, {{1, 0, 0.75}}});
  expect("on the rim", Sphere{5}, {{5, 0, -5}}, drum, {}, {0, {-0.6, 0, 0.8}, ManifoldType::point, {{2, 0, -1}}});
  expect("inside, near the side", Sphere{0.25}, {{0, -1.75, 0}}, drum, {},
         {-0.5, {0, 1, 0}, ManifoldType::point, {{0, -1.75, 0}}});
  expect("inside, near a disc", Sphere{0.25}, {{0, -1, -0.75}}, drum, {},
         {-0.5, {0, 0, 1}, ManifoldType::point, {{0, -1, -0.75}}});
}

TEST_CASE("plane against box and rectangle") {
  const V up{0, 0, 1};
  expect("flat", kGround, {}, Box{{1, 2, 3}}, {{0, 0, 2.5}},
         {-0.5, up, ManifoldType::face, {{1, 2, -0.25}, {-1, 2, -0.25}, {1, -2, -0.25}, {-1, -2, -0.25}}});
  expect("resting exactly", kGround, {}, Box{{1, 2, 3}}, {{0, 0, 3}},
         {0, up, ManifoldType::face, {{1, 2, 0}, {-1, 2, 0}, {1, -2, 0}, {-1, -2, 0}}});
  expect("on an edge", kGround, {}, Box{{1, 1, 1}}, {{0, 0, std::sqrt(2.) - 0.25}, about_x(kPi / 4)},
         {-0.25, up, ManifoldType::edge, {{1, 0, -0.125}, {-1, 0, -0.125}}});
  const double lean = std::acos(1 / std::sqrt(3.)), s = std::sin(lean / 2) * kHalfRoot;
  expect("on a corner", kGround, {}, Box{{1, 1, 1}}, {{0, 0, std::sqrt(3.) - 0.25}, {std::cos(lean / 2), s, -s, 0}},
         {-0.25, up, ManifoldType::point, {{0, 0, -0.125}}});
  expect("through the plane", kGround, {}, Box{{1, 1, 1}}, {{0, 0, -3}},
         {-4, up, ManifoldType::face, {{1, 1, -2}, {-1, 1, -2}, {1, -1, -2}, {-1, -1, -2}}});
  expect("a plate lying", kGround, {}, Rectangle{{1, 2}}, {{0, 0, -0.5}},
         {-0.5, up, ManifoldType::face, {{1, 2, -0.25}, {-1, 2, -0.25}, {1, -2, -0.25}, {-1, -2, -0.25}}});
  expect("a plate standing", kGround, {}, Rectangle{{1, 2}}, {{0, 0, 1.75}, kOverX},
         {-0.25, up, ManifoldType::edge, {{1, 0, -0.125}, {-1, 0, -0.125}}});
}

TEST_CASE("plane against capsule and cylinder") {
  const V up{0, 0, 1};
  expect("capsule upright", kGround, {}, Capsule{0.5, 2}, {{1, 0, 2.25}},
         {-0.25, up, ManifoldType::point, {{1, 0, -0.125}}});
  expect("capsule lying", kGround, {}, Capsule{0.5, 2}, {{0, 0, 0.25}, kOverY},
         {-0.25, up, ManifoldType::edge, {{2, 0, -0.125}, {-2, 0, -0.125}}});
  expect("capsule lying, touching", kGround, {}, Capsule{0.5, 2}, {{0, 0, 0.5}, kOverY},
         {0, up, ManifoldType::edge, {{2, 0, 0}, {-2, 0, 0}}});
  expect("drum on its disc", kGround, {}, Cylinder{2, 1}, {{0, 0, 0.5}},
         {-0.5, up, ManifoldType::face, {{2, 0, -0.25}, {-2, 0, -0.25}, {0, 2, -0.25}, {0, -2, -0.25}}});
  expect("drum on its other disc", kGround, {}, Cylinder{2, 1}, {{0, 0, 1}, {0, 1, 0, 0}},
         {0, up, ManifoldType::face, {{2, 0, 0}, {-2, 0, 0}, {0, 2, 0}, {0, -2, 0}}});
  expect("drum lying", kGround, {}, Cylinder{2, 1}, {{0, 0, 1.5}, kOverY},
         {-0.5, up, ManifoldType::edge, {{1, 0, -0.25}, {-1, 0, -0.25}}});
  expect("drum on its rim", kGround, {}, Cylinder{1, 1}, {{0, 0, std::sqrt(2.) - 0.25}, about_x(kPi / 4)},
         {-0.25, up, ManifoldType::point, {{0, 0, -0.125}}});
}

TEST_CASE("box against rectangle, rectangle against rectangle") {
  const V up{0, 0, 1}, down{0, 0, -1};
  expect("box on plate", Box{{1, 1, 1}}, {{0, 0, 0.75}}, Rectangle{{3, 3}}, {},
         {-0.25, down, ManifoldType::face, {{1, 1, -0.125}, {1, -1, -0.125}, {-1, 1, -0.125}, {-1, -1, -0.125}}});
  expect("box under plate", Box{{1, 1, 1}}, {{0, 0, -0.75}}, Rectangle{{3, 3}}, {},
         {-0.25, up, ManifoldType::face, {{1, 1, 0.125}, {1, -1, 0.125}, {-1, 1, 0.125}, {-1, -1, 0.125}}});
  expect("box over the plate's edge", Box{{1, 1, 1}}, {{3, 0, 1}}, Rectangle{{3, 3}}, {},
         {0, down, ManifoldType::face, {{3, 1, 0}, {3, -1, 0}, {2, 1, 0}, {2, -1, 0}}});
  expect("box beside the plate", Box{{1, 1, 1}}, {{3.75, 0, 0}}, Rectangle{{3, 3}}, {},
         {-0.25, {-1, 0, 0}, ManifoldType::edge, {{2.875, 1, 0}, {2.875, -1, 0}}});
  expect("plate over plate", Rectangle{{1, 1}}, {}, Rectangle{{1, 1}}, {{0.5, 0, 0.25}},
         {0.25, up, ManifoldType::face, {{1, 1, 0.125}, {1, -1, 0.125}, {-0.5, 1, 0.125}, {-0.5, -1, 0.125}}});
}

TEST_CASE("capsule against capsule, box and rectangle") {
  const Capsule capsule{0.5, 2};
  expect("crossing over", capsule, {}, capsule, {{0.75, 0, 0.5}, kOverX},
         {-0.25, {1, 0, 0}, ManifoldType::point, {{0.375, 0, 0.5}}});
  expect("side by side", capsule, {}, capsule, {{0.75, 0, 1}},
         {-0.25, {1, 0, 0}, ManifoldType::edge, {{0.375, 0, 2}, {0.375, 0, -1}}});
  expect("end to end", capsule, {}, capsule, {{0, 0, 4.75}}, {-0.25, {0, 0, 1}, ManifoldType::point, {{0, 0, 2.375}}});
  expect("end to end, aslant", capsule, {}, capsule, {{0.6, 0, 4.8}},
         {0, {0.6, 0, 0.8}, ManifoldType::point, {{0.3, 0, 2.4}}});
  expect("lying on a box", Box{{1, 1, 1}}, {}, capsule, {{0, 0, 1.25}, kOverX},
         {-0.25, {0, 0, 1}, ManifoldType::edge, {{0, 1, 0.875}, {0, -1, 0.875}}});
  expect("standing on a box", Box{{1, 1, 1}}, {}, capsule, {{0.5, 0.5, 3.25}},
         {-0.25, {0, 0, 1}, ManifoldType::point, {{0.5, 0.5, 0.875}}});
  expect("across a box's edge", Box{{1, 1, 1}}, {{0, 0, 0}, about_x(kPi / 4)}, capsule,
         {{0.25, 0, std::sqrt(2.) + 0.25}, kOverX},
         {-0.25, {0, 0, 1}, ManifoldType::point, {{0.25, 0, std::sqrt(2.) - 0.125}}});
  expect("through a box", Box{{1, 1, 1}}, {}, Capsule{0.25, 3}, {{0.5, 0, 0}},
         {-0.75, {1, 0, 0}, ManifoldType::edge, {{0.625, 0, 1}, {0.625, 0, -1}}});
  expect("lying on a plate", Rectangle{{1, 1}}, {}, capsule, {{0, 0, 0.5}, kOverY},
         {0, {0, 0, 1}, ManifoldType::edge, {{1, 0, 0}, {-1, 0, 0}}});
  expect("beside a plate", Rectangle{{1, 1}}, {}, capsule, {{1.25, 0, 0}},
         {-0.25, {1, 0, 0}, ManifoldType::point, {{0.875, 0, 0}}});
}

TEST_CASE("capsules side by side keep both ends of their stretch, however the world is turned") {
  Random random(5);
  const auto capsule = make_geometry<double>(Capsule{0.25, 1});
  for (int k = 0; k < 400; ++k) {
    const auto a = transform(V{}, any_turn(random));
    Transform<double> beside = a;
    beside.p_W = to_world(a, V{0.375, 0, 0.5});
    std::vector<Manifold<double>> found;
    find_contacts(capsule, a, capsule, beside, 0.0, found);
    REQUIRE(found.size() == 1);
    REQUIRE(found[0].count == 2);
    double low = 2, high = -2;
    for (int i = 0; i < 2; ++i) {
      CHECK(found[0].points[static_cast<std::size_t>(i)].gap == Approx(-0.125).epsilon(1e-14));
      const double along = dot(found[0].points[static_cast<std::size_t>(i)].x_W, a.axis_W[2]);
      low = std::min(low, along), high = std::max(high, along);
    }
    CHECK(low == Approx(-0.5).epsilon(1e-14));
    CHECK(high == Approx(1).epsilon(1e-14));
  }
}

TEST_CASE("cylinder against box, rectangle, cylinder and capsule") {
  const Cylinder drum{0.5, 1};
  const V up{0, 0, 1};
  expect("on a box", Box{{1, 1, 1}}, {}, drum, {{0, 0, 1.75}},
         {-0.25, up, ManifoldType::face, {{0.5, 0, 0.875}, {-0.5, 0, 0.875}, {0, 0.5, 0.875}, {0, -0.5, 0.875}}});
  expect("lying on a box", Box{{2, 2, 1}}, {}, drum, {{0, 0, 1.25}, kOverX},
         {-0.25, up, ManifoldType::edge, {{0, 1, 0.875}, {0, -1, 0.875}}});
  expect("lying on a plate", Rectangle{{2, 2}}, {}, drum, {{0, 0, 0.25}, kOverY},
         {-0.25, up, ManifoldType::edge, {{1, 0, -0.125}, {-1, 0, -0.125}}});
  expect("side by side", drum, {}, drum, {{0.75, 0, 1}},
         {-0.25, {1, 0, 0}, ManifoldType::edge, {{0.375, 0, 1}, {0.375, 0, 0}}});
  expect("a capsule across", Capsule{0.5, 2}, {}, drum, {{0.75, 0, 0}, kOverX},
         {-0.25, {1, 0, 0}, ManifoldType::edge_edge, {{0.375, 0, 0}}});
}

// A capsule without length is a sphere; a box, a rectangle, a cylinder without extents is a point, a sphere without
// radius.
TEST_CASE("the sphere is the limit of the other shapes") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    using enum ShapeKind;
    for (const ShapeKind kind : {sphere, plane, rectangle, box, capsule}) {
      const Shape partner = kind == ShapeKind::plane ? Shape(Plane{{0.6, 0, 0.8}, 0.25}) : random_shape(kind, random);
      const double radius = uniform(random, 0.1, 1);
      const auto other = make_geometry<double>(partner);
      const auto pose =
          transform(V{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}, any_turn(random));
      const auto here =
          transform(V{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}, any_turn(random));
      const auto agree = [&](const Shape& shape, double sphere_radius) {
        const auto limit = separation(make_geometry<double>(shape), here, other, pose);
        const auto ball = separation(make_geometry<double>(Sphere{sphere_radius}), here, other, pose);
        RC_ASSERT(std::abs(limit.gap - ball.gap) < 2e-15);
        if (std::abs(ball.gap + sphere_radius) > 1e-2) RC_ASSERT(norm(limit.normal_W - ball.normal_W) < 1e-13);
        std::vector<Manifold<double>> one, two;
        find_contacts(make_geometry<double>(shape), here, other, pose, 0.01, one);
        find_contacts(make_geometry<double>(Sphere{sphere_radius}), here, other, pose, 0.01, two);
        if (std::abs(ball.gap - 0.01) < 1e-12) return;
        RC_ASSERT(one.size() == two.size());
        if (!one.empty()) RC_ASSERT(one[0].count == 1);
      };
      agree(Capsule{radius, 0}, radius);
      agree(Box{{0, 0, 0}}, 0);
      agree(Rectangle{{0, 0}}, 0);
      if (kind == ShapeKind::sphere) agree(Cylinder{0, 0}, 0);
    }
  }));
}

TEST_CASE("a pair of shapes without a test is refused by name") {
  CHECK(std::string(missing_contact_test(ShapeKind::plane, ShapeKind::plane)) == "plane against plane");
  CHECK(std::string(missing_contact_test(ShapeKind::none, ShapeKind::box)) == "point against box");
  CHECK(missing_contact_test(ShapeKind::compound, ShapeKind::plane) == nullptr);
}
