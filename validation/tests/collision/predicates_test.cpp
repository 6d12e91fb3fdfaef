// Exact signs, and triangles that meet or miss by them.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <algorithm>

#include "collision/convex_part.hpp"
#include "collision/nearest_features.hpp"
#include "collision/predicates.hpp"
#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

namespace {

// Integer coordinates: the determinant in 128-bit integers is exact.
int sign_of_integers(const V& a, const V& b, const V& c, const V& d) {
  using I = __int128;
  const auto part = [](double x, double y) { return static_cast<I>(x) - static_cast<I>(y); };
  const I ux = part(a.x, d.x), uy = part(a.y, d.y), uz = part(a.z, d.z), vx = part(b.x, d.x), vy = part(b.y, d.y),
          vz = part(b.z, d.z), wx = part(c.x, d.x), wy = part(c.y, d.y), wz = part(c.z, d.z);
  const I det = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx);
  return det > 0 ? 1 : det < 0 ? -1 : 0;
}

V lattice(Random& random, double size) {
  const auto one = [&] { return std::floor(uniform(random, -size, size + 1)); };
  return {one(), one(), one()};
}

}  // namespace

TEST_CASE("the sign of a determinant is exact where rounding is not") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < 200; ++i) {
      const double size = i % 2 ? 3 : 1e12;
      const V a = lattice(random, size), b = lattice(random, size), c = lattice(random, size);
      // A point on the plane of the three (a combination with whole weights), or one unit off it.
      const double s = std::floor(uniform(random, -3, 4)), t = std::floor(uniform(random, -3, 4));
      V d = a + s * (b - a) + t * (c - a);
      if (i % 3 == 1) d.x += 1;
      if (i % 3 == 2) d = lattice(random, size);
      RC_ASSERT(orient3d(a, b, c, d) == sign_of_integers(a, b, c, d));
      RC_ASSERT(orient3d(b, a, c, d) == -orient3d(a, b, c, d));
    }
  }));
  CHECK(orient3d<double>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}) == 1);
  // One ulp off a plane far from the origin: the rounded determinant is 0 or has any sign.
  const double x = 1e6 + 1.0 / 3;
  CHECK(orient3d<double>({x, 0, x}, {x, 1, x}, {x + 1, 0, x}, {x + 0.3, 0.3, std::nextafter(x, 2e6)}) == 1);
  CHECK(orient3d<double>({x, 0, x}, {x, 1, x}, {x + 1, 0, x}, {x + 0.3, 0.3, x}) == 0);
  CHECK(orient2d<double>({0, 0}, {1e-30, 1}, {2e-30, 2}) == 0);
  CHECK(orient2d<double>({0, 0}, {1, 0}, {0.5, 1e-300}) == 1);
  CHECK(orient3d<float>({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3f, 0.3f, 1e-30f}) == -1);
}

TEST_CASE("triangles: crossing, touching, sharing, in one plane") {
  const Corners<double> floor{V{0, 0, 0}, V{4, 0, 0}, V{0, 4, 0}};
  const auto meets = [&](const V& a, const V& b, const V& c) {
    const bool one = triangles_intersect(floor, {a, b, c});
    CHECK(one == triangles_intersect({b, c, a}, floor));
    CHECK(one == triangles_intersect(floor, {c, b, a}));
    return one;
  };
  CHECK(meets({1, 1, -1}, {1, 1, 1}, {2, 1, 1}));  // through
  CHECK(meets({1, 1, 0}, {1, 1, 1}, {2, 1, 1}));   // a corner on the face
  CHECK_FALSE(meets({1, 1, 1e-300}, {1, 1, 1}, {2, 1, 1}));
  CHECK(meets({0, 0, 0}, {4, 0, 0}, {0, 0, 4}));    // an edge in common
  CHECK(meets({0, 0, 0}, {-1, 0, 0}, {0, 0, 4}));   // a corner in common
  CHECK(meets({-1, 2, 1}, {5, 2, 1}, {2, 2, -9}));  // edges through edges
  CHECK_FALSE(meets({5, 5, -1}, {5, 5, 1}, {6, 5, 1}));
  CHECK_FALSE(meets({2.5, 2.5, -1}, {2.5, 2.5, 1}, {9, 9, 0}));  // past the long edge
  CHECK(meets({2, 2, -1}, {2, 2, 1}, {9, 9, 0}));                // touches the long edge
  CHECK(meets({1, 1, 0}, {1.5, 1, 0}, {1, 1.5, 0}));             // within, in the plane
  CHECK(meets({-9, -9, 0}, {99, -9, 0}, {-9, 99, 0}));           // around, in the plane
  CHECK(meets({4, 0, 0}, {5, 0, 0}, {5, 5, 0}));                 // corners touch in the plane
  CHECK(meets({2, 2, 0}, {5, 2, 0}, {5, 5, 0}));                 // a corner on an edge in the plane
  CHECK_FALSE(meets({2.5, 2, 0}, {5, 2, 0}, {5, 5, 0}));
  CHECK(meets({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));  // itself
  CHECK_FALSE(meets({0, 0, 1}, {4, 0, 1}, {0, 4, 1}));
  CHECK(meets({1, 0, 0}, {3, 0, 0}, {2, 0, 5}));   // an edge within an edge
  CHECK(meets({-1, 1, 0}, {5, 1, 0}, {2, 1, 7}));  // an edge in the plane, across, both ends outside
}

TEST_CASE("triangles on a small lattice: signs say what distances say") {
  // Distances there are 0 or far above round-off, and every kind of degeneracy comes up often.
  Random random(5);
  int hits = 0, misses = 0;
  for (int i = 0; i < 60000; ++i) {
    Corners<double> p, q;
    for (int k = 0; k < 3; ++k) p[k] = lattice(random, 2), q[k] = lattice(random, 2);
    const V n = cross(p[1] - p[0], p[2] - p[0]), m = cross(q[1] - q[0], q[2] - q[0]);
    if (!(dot(n, n) > 0) || !(dot(m, m) > 0)) continue;
    const auto a = triangle_part(p[0], p[1], p[2], unit_vector(n)), b = triangle_part(q[0], q[1], q[2], unit_vector(m));
    const Closest<double> closest = closest_points(a, b, Transform<double>{}, 1e300);
    const bool meet = triangles_intersect(p, q);
    REQUIRE(meet == !(closest.apart && closest.distance > 1e-9));
    (meet ? hits : misses)++;
  }
  CHECK(hits > 10000);
  CHECK(misses > 10000);
}
