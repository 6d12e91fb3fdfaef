// Boxes (rectangles and capsules, which are boxes without some of their sides) against each other: cases by hand, and
// over hostile poses certificates in long double that share nothing with the engine's arithmetic.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <set>

#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;
using Q = Quat<double>;
using Long = long double;

namespace {

const double kPi = std::acos(-1.0), kHalfRoot = std::sqrt(0.5);
Q turn(double angle, const V& axis) {
  const V half = std::sin(angle / 2) * axis;
  return {std::cos(angle / 2), half.x, half.y, half.z};
}

struct Posed {
  Geometry<double> shape;
  Transform<double> pose;
};
Posed posed(const Shape& shape, const V& p, const Q& q = {}) { return {make_geometry<double>(shape), transform(p, q)}; }

std::vector<Manifold<double>> contacts(const Posed& a, const Posed& b, double margin = 0) {
  std::vector<Manifold<double>> out;
  find_contacts(a.shape, a.pose, b.shape, b.pose, margin, out);
  return out;
}
Manifold<double> contact(const Posed& a, const Posed& b, double margin = 0) {
  const auto found = contacts(a, b, margin);
  REQUIRE(found.size() == 1);
  return found[0];
}
Separation<double> gap(const Posed& a, const Posed& b) { return separation(a.shape, a.pose, b.shape, b.pose); }
double deepest(const Manifold<double>& m) {
  double least = m.points[0].gap;
  for (int i = 1; i < m.count; ++i) least = std::min(least, m.points[static_cast<std::size_t>(i)].gap);
  return least;
}

// ---- certificates -------------------------------------------------------------------------------------------------
struct Wide3 {
  Vec3<Long> p, axis[3];
  Long h[3], radius;
};
Vec3<Long> wide(const V& v) { return {v.x, v.y, v.z}; }
Wide3 wide(const Posed& body) {
  const bool capsule = body.shape.kind == ShapeKind::capsule;
  const auto* axis = body.pose.axis_W;
  return {wide(body.pose.p_W),
          {wide(axis[0]), wide(axis[1]), wide(axis[2])},
          {body.shape.half_extents.x, body.shape.half_extents.y,
           capsule ? body.shape.half_length : body.shape.half_extents.z},
          capsule ? body.shape.radius : 0};
}
Long reach(const Wide3& body, const Vec3<Long>& n) {
  Long sum = body.radius;
  for (int k = 0; k < 3; ++k) sum += body.h[k] * std::abs(dot(body.axis[k], n));
  return sum;
}
Long gap_along(const Wide3& a, const Wide3& b, const Vec3<Long>& n) {
  return dot(b.p - a.p, n) - reach(a, n) - reach(b, n);
}

Long greatest_of_fifteen(const Wide3& a, const Wide3& b) {
  Long best = -std::numeric_limits<Long>::infinity();
  const auto look = [&](const Vec3<Long>& n) { best = std::max({best, gap_along(a, b, n), gap_along(a, b, -n)}); };
  for (int i = 0; i < 3; ++i) {
    look(a.axis[i]), look(b.axis[i]);
    for (int j = 0; j < 3; ++j) {
      Vec3<Long> c = cross(a.axis[i], b.axis[j]);
      if (norm(c) < 1e-15L) continue;
      c = (1 / norm(c)) * c;
      c = c - dot(c, a.axis[i]) * a.axis[i];
      look((1 / norm(c)) * c);
    }
  }
  return best;
}
// The least angle between an axis of one and an axis of the other that are not parallel to round-off.
Long nearly_parallel(const Wide3& a, const Wide3& b) {
  Long least = 1;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (const Long sine = norm(cross(a.axis[i], b.axis[j])); sine > 1e-15L) least = std::min(least, sine);
  return least;
}
// Signed distance of a point from the surface.
Long off_surface(const Wide3& body, const V& x_W) {
  const Vec3<Long> x = wide(x_W) - body.p;
  Long outside = 0, inside = -std::numeric_limits<Long>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Long beyond = std::abs(dot(x, body.axis[k])) - body.h[k];
    inside = std::max(inside, beyond);
    if (beyond > 0) outside += beyond * beyond;
  }
  return (inside > 0 ? std::sqrt(outside) : inside) - body.radius;
}
double size_of(const Wide3& a, const Wide3& b) {
  return static_cast<double>(a.h[0] + a.h[1] + a.h[2] + a.radius + b.h[0] + b.h[1] + b.h[2] + b.radius);
}

// Slabs, needles, plates, sizes from 1e-9 to 1e9; aligned, nearly aligned by any power of ten, concentric.
Posed hostile_body(Random& random, double scale, const V& p, const Q& q) {
  const auto length = [&] {
    const auto kind = random() % 8;
    return scale * (kind == 0 ? std::pow(10, uniform(random, -9, 0)) : kind == 1 ? 1 : uniform(random, 0.1, 1));
  };
  const double x = length(), y = length(), z = length();
  const auto kind = random() % 4;
  if (kind == 0) return posed(Rectangle{{x, y}}, p, q);
  if (kind == 1) return posed(Capsule{x, y}, p, q);
  return posed(Box{{x, y, z}}, p, q);
}
std::pair<Posed, Posed> hostile_pair(std::uint64_t seed) {
  Random random(seed);
  const double scale = std::pow(10, random() % 4 ? uniform(random, -1, 1) : uniform(random, -9, 9));
  const Q first = random() % 2 ? any_turn(random) : Q{};
  Q second = any_turn(random);
  if (random() % 4) {
    const double angle = random() % 4 ? std::pow(10, uniform(random, -17, -1)) : 0;
    const Real3 g = gauss3(random);
    const Q quarter[] = {{}, {kHalfRoot, kHalfRoot, 0, 0}, {kHalfRoot, 0, 0, kHalfRoot}};
    second = first * normalised(Q{1, angle * g[0], angle * g[1], angle * g[2]}) * quarter[random() % 3];
  }
  V between{1.2 * scale * uniform(random, -1, 1), 1.2 * scale * uniform(random, -1, 1),
            1.2 * scale * uniform(random, -1, 1)};
  if (random() % 6 == 0) between = {};
  if (random() % 6 == 0) between = rotate(first, V{between.x, 0, 0});
  return {hostile_body(random, scale, {}, first), hostile_body(random, scale, between, second)};
}

}  // namespace

TEST_CASE("gap and normal are the best of all directions, the points lie on both surfaces") {
  CHECK(rc::check([](std::uint64_t seed) {
    for (std::uint64_t k = 0; k < 500; ++k) {
      const auto [body_a, body_b] = hostile_pair(seed * 1000 + k);
      const Wide3 a = wide(body_a), b = wide(body_b);
      const auto found = gap(body_a, body_b);
      const Vec3<Long> n = wide(found.normal_W);
      // A direction of two cores that nearly touch is known to eps size / distance: 1e-12 leaves room for that alone.
      const Long round_off = 1e-12L * (size_of(a, b) + std::max(0.0, found.gap));
      RC_ASSERT(std::abs(norm(n) - 1) < 1e-15L * 4);
      // Apart, n shows the gap, so no smaller distance exists; overlapping, moving by -gap along n parts them.
      // ... but for one pose in some 50 000: edges parallel to 1e-6 leave the direction across them to eps / angle,
      // 2e-12 seen.
      const Long off = std::abs(gap_along(a, b, n) - found.gap);
      RC_ASSERT(off <= 10 * round_off);
      if (off > round_off) RC_ASSERT(nearly_parallel(a, b) < 1e-5L);
      if (found.gap + body_a.shape.radius + body_b.shape.radius <= 0)
        RC_ASSERT(std::abs(greatest_of_fifteen(a, b) - found.gap) <= 1e-14L * size_of(a, b));
      // ... and the points show that it is no more.
      RC_ASSERT(std::abs(off_surface(a, found.on_a_W)) <= round_off);
      RC_ASSERT(std::abs(off_surface(b, found.on_b_W)) <= round_off);

      const auto manifolds = contacts(body_a, body_b);
      if (std::abs(found.gap) > round_off) RC_ASSERT(manifolds.size() == (found.gap <= 0 ? 1u : 0u));
      for (const auto& m : manifolds) {
        RC_ASSERT(m.count >= 1);
        RC_ASSERT(m.count <= 4);
        RC_ASSERT(std::abs(deepest(m) - found.gap) <= round_off);
        std::set<std::uint32_t> ids;
        for (int i = 0; i < m.count; ++i) {
          const auto& point = m.points[static_cast<std::size_t>(i)];
          ids.insert(point.id);
          RC_ASSERT(std::abs(off_surface(a, point.x_W - (point.gap / 2) * m.normal_W)) <= round_off);
          RC_ASSERT(std::abs(off_surface(b, point.x_W + (point.gap / 2) * m.normal_W)) <= round_off);
        }
        RC_ASSERT(static_cast<int>(ids.size()) == m.count);
      }
    }
  }));
}

TEST_CASE("swapping the bodies flips the normal and changes no other bit") {
  CHECK(rc::check([](std::uint64_t seed) {
    for (std::uint64_t k = 0; k < 200; ++k) {
      const auto [a, b] = hostile_pair(seed * 1000 + k);
      const auto one = contacts(a, b, 0.1), other = contacts(b, a, 0.1);
      RC_ASSERT(one.size() == other.size());
      for (std::size_t m = 0; m < one.size(); ++m) {
        RC_ASSERT(one[m].count == other[m].count);
        RC_ASSERT(norm(one[m].normal_W + other[m].normal_W) == 0);
        for (std::size_t i = 0; i < static_cast<std::size_t>(one[m].count); ++i) {
          RC_ASSERT(one[m].points[i].gap == other[m].points[i].gap);
          RC_ASSERT(one[m].points[i].id == other[m].points[i].id);
          RC_ASSERT(norm(one[m].points[i].x_W - other[m].points[i].x_W) == 0);
        }
      }
    }
  }));
}

TEST_CASE("turning and moving the world turns and moves the contact") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    for (int k = 0; k < 200; ++k) {
      const Q q_a = any_turn(random), q_b = any_turn(random), world = any_turn(random);
      const V away{uniform(random, -8, 8), uniform(random, -8, 8), uniform(random, -8, 8)};
      const V between{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
      const Shape shape_a = random_shape(ShapeKind::box, random), shape_b = random_shape(ShapeKind::box, random);
      const auto here = gap(posed(shape_a, {}, q_a), posed(shape_b, between, q_b));
      const auto there =
          gap(posed(shape_a, away, world * q_a), posed(shape_b, away + rotate(world, between), world * q_b));
      RC_ASSERT(std::abs(here.gap - there.gap) < 4e-14);
      if (std::abs(here.gap) < 1e-3) continue;  // nearer than that the normal is worth fewer digits
      const auto m = contacts(posed(shape_a, {}, q_a), posed(shape_b, between, q_b));
      const auto n =
          contacts(posed(shape_a, away, world * q_a), posed(shape_b, away + rotate(world, between), world * q_b));
      RC_ASSERT(m.size() == n.size());
      // Two directions may be as good as each other: only then may the choice change.
      if (!m.empty() && norm(rotate(world, m[0].normal_W) - n[0].normal_W) < 1e-10) RC_ASSERT(m[0].type == n[0].type);
    }
  }));
}

TEST_CASE("edge-edge contacts are told apart from faces") {
  const Q ridge = turn(kPi / 4, {1, 0, 0}), across = turn(kPi / 2, {0, 0, 1}) * ridge;
  const V above{0.25, 0.5, 2 * std::sqrt(2.) - 0.25};
  const auto m = contact(posed(Box{{1, 1, 1}}, {}, ridge), posed(Box{{1, 1, 1}}, above, across));
  CHECK(m.type == ManifoldType::edge_edge);
  CHECK(m.count == 1);
  CHECK(m.points[0].gap == Approx(-0.25).epsilon(1e-14));
  CHECK(norm(m.normal_W - V{0, 0, 1}) < 1e-15);
  CHECK(norm(m.points[0].x_W - V{0.25, 0, std::sqrt(2.) - 0.125}) < 1e-15);
}

TEST_CASE("a box within another is pushed out the shortest way") {
  const auto m = contact(posed(Box{{3, 4, 5}}, {}), posed(Box{{0.5, 0.5, 0.5}}, {0, -2, 1}));
  CHECK(norm(m.normal_W - V{0, -1, 0}) == 0);
  CHECK(deepest(m) == -2.5);
  CHECK(m.count == 4);
  const auto concentric = contact(posed(Box{{3, 4, 5}}, {}), posed(Box{{0.5, 0.25, 0.5}}, {}));
  CHECK(deepest(concentric) == -3.5);
}

TEST_CASE("boxes that touch exactly are in contact, an ulp apart they are not") {
  const Posed a = posed(Box{{1, 1, 1}}, {});
  CHECK(deepest(contact(a, posed(Box{{1, 1, 1}}, {0.5, 0, 2}))) == 0);
  CHECK(contact(a, posed(Box{{1, 1, 1}}, {0.5, 0, 2})).count == 4);
  CHECK(contact(a, posed(Box{{1, 1, 1}}, {2, 2, 0})).type == ManifoldType::edge);
  CHECK(contact(a, posed(Box{{1, 1, 1}}, {2, 2, 2})).type == ManifoldType::point);
  CHECK(contacts(a, posed(Box{{1, 1, 1}}, {0, 0, std::nextafter(2., 3.)})).empty());
}

TEST_CASE("an octagon of contact keeps four corners that span it, with the deepest among them") {
  const auto m = contact(posed(Box{{1, 1, 1}}, {}), posed(Box{{1, 1, 1}}, {0, 0, 1.875}, turn(kPi / 4, {0, 0, 1})));
  REQUIRE(m.count == 4);
  const auto at = [&](std::size_t i) { return m.points[i].x_W; };
  const double square = 2 / (std::cos(kPi / 8) * std::cos(kPi / 8));
  CHECK(std::abs(cross(at(2) - at(0), at(3) - at(1)).z) / 2 == Approx(square).epsilon(1e-12));
  const Q lean = turn(kPi / 4, {0, 0, 1}) * turn(0.01, {0.6, 0.8, 0});
  const Posed a = posed(Box{{1, 1, 1}}, {}), tilted = posed(Box{{1, 1, 1}}, {0, 0, 1.875}, lean);
  CHECK(contact(a, tilted).count == 4);
  CHECK(deepest(contact(a, tilted)) == gap(a, tilted).gap);
}

TEST_CASE("stacked boxes keep the names of their points while they tremble") {
  Random random(7);
  for (const V at : {V{0, 0, 1.9999}, V{0.25, 0.125, 1.9999}}) {
    std::set<std::uint32_t> first;
    for (int k = 0; k < 200; ++k) {
      const auto tremble = [&] {
        const Real3 turned = gauss3(random);
        return normalised(Q{1, 1e-7 * turned[0], 1e-7 * turned[1], 1e-7 * turned[2]});
      };
      const Real3 g = gauss3(random);
      const V moved = at + 1e-7 * V{g[0], g[1], g[2]};
      const auto m = contact(posed(Box{{1, 1, 1}}, {}, tremble()), posed(Box{{1, 1, 1}}, moved, tremble()));
      std::set<std::uint32_t> ids;
      for (int i = 0; i < m.count; ++i) ids.insert(m.points[static_cast<std::size_t>(i)].id);
      if (k == 0) first = ids;
      CHECK(ids == first);
      CHECK(ids.size() == 4);
    }
  }
}

TEST_CASE("points beyond the margin are left out, those within are kept") {
  const Posed a = posed(Box{{2, 2, 1}}, {}), b = posed(Box{{1, 1, 1}}, {0, 0, 2}, turn(0.02, {0, 1, 0}));
  CHECK(contact(a, b).type == ManifoldType::edge);
  CHECK(contact(a, b, 0.05).count == 4);
  CHECK(contacts(a, posed(Box{{1, 1, 1}}, {0, 0, 2.25}), 0.2).empty());
  CHECK(contact(a, posed(Box{{1, 1, 1}}, {0, 0, 2.25}), 0.3).count == 4);
}
