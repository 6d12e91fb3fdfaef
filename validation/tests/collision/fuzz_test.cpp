// Pairs of primitives and compounds, in every scalar, on degenerate inputs: all values are finite, normals are unit
// vectors, the deepest point has the gap, bodies far apart have no contact. Runs under the sanitizers
// too. (Hulls, and cylinders but against spheres and planes, go by support functions: gjk_test.cpp.)
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

const ShapeKind kAll[] = {ShapeKind::sphere,  ShapeKind::plane,    ShapeKind::rectangle, ShapeKind::box,
                          ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::compound};

// Sizes with ratios from 1e-9 to 1e9, and sizes of 0.
Shape hostile_shape(ShapeKind kind, Random& random, double scale) {
  const auto size = [&] {
    const auto how = random() % 8;
    return how == 0 ? 0.0 : how == 1 ? scale * std::pow(10, uniform(random, -9, 0)) : scale * uniform(random, 0.1, 1);
  };
  const double x = size(), y = size(), z = size();
  switch (kind) {
    case ShapeKind::sphere: return Sphere{x};
    case ShapeKind::plane: {
      const Real3 n = gauss3(random);
      const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      return Plane{{n[0] / length, n[1] / length, n[2] / length}, y};
    }
    case ShapeKind::rectangle: return Rectangle{{x, y}};
    case ShapeKind::box: return Box{{x, y, z}};
    case ShapeKind::capsule: return Capsule{x, y};
    case ShapeKind::cylinder: return Cylinder{x, y};
    default: {  // a compound
      const Quat<double> q = any_turn(random);
      return Compound{{{{x, y, z}, {x, 0, 0}, {1, 0, 0, 0}}, {{y, y, z}, {-y, z, 0}, {q.w, q.x, q.y, q.z}}}};
    }
  }
}

template <class S> bool is_unit(const Vec3<S>& n) { return real::abs(norm(n) - S(1)) < S(16) * real::epsilon<S>(); }

template <class S>
void check_pair(const Shape& shape_a, const Shape& shape_b, const Transform<S>& pose_a, const Transform<S>& pose_b,
                double scale) {
  const Geometry<S> a = make_geometry<S>(shape_a), b = make_geometry<S>(shape_b);
  if (missing_contact_test(a.kind, b.kind)) return;
  const Separation<S> found = separation(a, pose_a, b, pose_b), back = separation(b, pose_b, a, pose_a);
  RC_ASSERT(real::is_finite(found.gap));
  RC_ASSERT(is_unit(found.normal_W));
  RC_ASSERT(finite(found.on_a_W));
  RC_ASSERT(finite(found.on_b_W));
  const S round_off = S(1e4) * real::epsilon<S>() * S(scale);
  RC_ASSERT(real::abs(found.gap - back.gap) <= round_off);
  RC_ASSERT(real::abs(dot(found.on_b_W - found.on_a_W, found.normal_W) - found.gap) <= round_off);
  std::vector<Manifold<S>> manifolds, swapped;
  const S margin = S(0.125) * S(scale);
  find_contacts(a, pose_a, b, pose_b, margin, manifolds);
  find_contacts(b, pose_b, a, pose_a, margin, swapped);
  if (found.gap < margin - round_off) RC_ASSERT(!manifolds.empty());
  if (found.gap > margin + round_off) RC_ASSERT(manifolds.empty());
  if (found.gap < margin - round_off) RC_ASSERT(manifolds.size() == swapped.size());
  S least = found.gap + S(10) * S(scale);
  for (const Manifold<S>& m : manifolds) {
    RC_ASSERT(is_unit(m.normal_W));
    RC_ASSERT(m.count >= 1);
    RC_ASSERT(m.count <= 4);
    for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
      RC_ASSERT(finite(m.points[i].x_W));
      RC_ASSERT(real::is_finite(m.points[i].gap));
      least = real::min(least, m.points[i].gap);
    }
  }
  if (!manifolds.empty()) RC_ASSERT(real::abs(least - found.gap) <= round_off);
}

template <class S> void check_poses(ShapeKind kind_a, ShapeKind kind_b, std::uint64_t seed) {
  Random random(seed);
  const double scale = random() % 4 ? uniform(random, 0.1, 1) : std::pow(10, uniform(random, -9, 9));
  const Shape a = hostile_shape(kind_a, random, scale), b = hostile_shape(kind_b, random, scale);
  const Quat<double> q = random() % 2 ? any_turn(random) : Quat<double>{};
  const double angle = std::pow(10, uniform(random, -17, 0));
  const Quat<double> turned = random() % 3 ? q * normalised(Quat<double>{1, angle, -angle, 0}) : any_turn(random);
  Vec3<double> between{scale * uniform(random, -1, 1), scale * uniform(random, -1, 1), scale * uniform(random, -1, 1)};
  if (random() % 6 == 0) between = {};
  if (random() % 6 == 0) between = std::pow(10, uniform(random, -30, 0)) * between;
  check_pair(a, b, placed_at<S>({}, q), placed_at<S>(between, turned), scale);
}

}  // namespace

TEST_CASE("queries of every pair of shapes are finite in every pose") {
  for (const ShapeKind a : kAll) {
    for (const ShapeKind b : kAll) {
      const bool drum = a == ShapeKind::cylinder || b == ShapeKind::cylinder;
      const auto simple = [](ShapeKind kind) { return kind == ShapeKind::sphere || kind == ShapeKind::plane; };
      if (drum && !simple(a) && !simple(b)) continue;
      DYNAMIC_SECTION(static_cast<int>(a) << " against " << static_cast<int>(b)) {
        const std::string pair =
            std::to_string(static_cast<int>(a)) + " against " + std::to_string(static_cast<int>(b));
        CHECK(rc::check(pair, [&](std::uint64_t seed) {
          for (std::uint64_t k = 0; k < 10; ++k) {
            check_poses<double>(a, b, seed + k);
            check_poses<float>(a, b, seed + k);
            check_poses<long double>(a, b, seed + k);
          }
        }));
      }
    }
  }
}
