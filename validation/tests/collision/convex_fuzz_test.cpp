// Hulls, cylinders, meshes, and sweeps of all shapes, on degenerate inputs: all values are finite, normals are unit
// vectors, the deepest point has the gap, swapping changes only signs, and every query ends soon. Runs
// under the sanitizers too. (The other pairs: fuzz_test.cpp.)
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <chrono>

#include "collision/time_of_impact.hpp"
#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

const ShapeKind kAll[] = {ShapeKind::sphere, ShapeKind::plane,   ShapeKind::rectangle,
                          ShapeKind::box,    ShapeKind::capsule, ShapeKind::cylinder,
                          ShapeKind::convex, ShapeKind::mesh,    ShapeKind::compound};

// Extents down to a `thinnest` part of the largest, some of them equal; points that coincide, lie on a line or in a
// plane.
Shape hostile_shape(ShapeKind kind, Random& random, double scale, double thinnest) {
  const auto size = [&] {
    const auto how = random() % 6;
    return how == 0 ? scale * std::pow(10, uniform(random, std::log10(thinnest), 0))
                    : scale * (how == 1 ? 0.5 : uniform(random, 0.1, 1));
  };
  const double x = size(), y = size(), z = size();
  const auto points = [&](int n) {
    std::vector<Real3> out = random() % 3 == 0 ? box_corners({x, y, z}) : boulder(random, n, {x, y, z});
    const auto how = random() % 6;
    for (Real3& p : out)
      if (how < 2) p[2] = 0, p[1] = how == 1 ? 0 : p[1];
    if (how == 2) out.insert(out.end(), out.begin(), out.begin() + 3);
    if (how == 3)
      out.push_back({(out[0][0] + out[1][0]) / 2, (out[0][1] + out[1][1]) / 2, (out[0][2] + out[1][2]) / 2});
    return out;
  };
  switch (kind) {
    case ShapeKind::sphere: return Sphere{x};
    case ShapeKind::plane: {
      const Quat<double> q = any_turn(random);
      const Vec3<double> n = rotate(q, Vec3<double>{0, 0, 1});
      return Plane{{n.x, n.y, n.z}, y};
    }
    case ShapeKind::rectangle: return Rectangle{{x, y}};
    case ShapeKind::box: return Box{{x, y, z}};
    case ShapeKind::capsule: return Capsule{x, y};
    case ShapeKind::cylinder: return Cylinder{x, y};
    case ShapeKind::convex: return Convex{points(random() % 5 == 0 ? 60 : 9)};
    case ShapeKind::mesh: {
      Mesh mesh{"", points(6), {}};
      const int n = static_cast<int>(mesh.points_m.size());
      for (int t = 0; t < 6; ++t) mesh.triangles.push_back({t % n, (t + 1) % n, (t + 2 + t / 3) % n});
      return mesh;
    }
    default: {  // a compound
      const Quat<double> q = any_turn(random);
      return Compound{{{{x, y, z}, {x, 0, 0}, {1, 0, 0, 0}}, {{y, y, z}, {-y, z, 0}, {q.w, q.x, q.y, q.z}}}};
    }
  }
}

template <class S> bool is_unit(const Vec3<S>& n) { return real::abs(norm(n) - S(1)) < S(64) * real::epsilon<S>(); }

struct Pose {
  Shape a, b;
  Vec3<double> between;
  Quat<double> q_a, q_b;
  double scale;
};
Pose hostile_pose(ShapeKind kind_a, ShapeKind kind_b, std::uint64_t seed, double thinnest) {
  Random random(seed);
  const double scale = random() % 4 ? uniform(random, 0.1, 1) : std::pow(10, uniform(random, -9, 9));
  Pose pose{hostile_shape(kind_a, random, scale, thinnest),
            hostile_shape(kind_b, random, scale, thinnest),
            {},
            {},
            {},
            scale};
  pose.q_a = random() % 2 ? any_turn(random) : Quat<double>{};
  const double angle = std::pow(10, uniform(random, -17, 0));
  const Quat<double> quarter[] = {{}, {1, 1, 0, 0}, {1, 0, 1, 0}, {1, 1, 1, 1}};
  pose.q_b = random() % 3 ? pose.q_a * normalised(Quat<double>{1, angle, -angle, 0}) * normalised(quarter[random() % 4])
                          : any_turn(random);
  pose.between = {scale * uniform(random, -1, 1), scale * uniform(random, -1, 1), scale * uniform(random, -1, 1)};
  if (random() % 6 == 0) pose.between = {};
  if (random() % 6 == 0) pose.between = std::pow(10, uniform(random, -30, 0)) * pose.between;
  return pose;
}

// Meshes without a triangle with area and shapes without points have no gap: it is infinite.
template <class S> void check_pair(const Pose& pose) {
  const Geometry<S> a = make_geometry<S>(pose.a), b = make_geometry<S>(pose.b);
  if (missing_contact_test(a.kind, b.kind)) return;
  const auto empty = [](const Geometry<S>& g) { return g.kind == ShapeKind::mesh && g.bounding_radius == S(0); };
  if (empty(a) || empty(b)) return;
  const Transform<S> pose_a = placed_at<S>({}, pose.q_a), pose_b = placed_at<S>(pose.between, pose.q_b);
  const Separation<S> found = separation(a, pose_a, b, pose_b), back = separation(b, pose_b, a, pose_a);
  const auto flat_mesh = [](const Geometry<S>& g, const Separation<S>& s) {
    return g.kind == ShapeKind::mesh && !real::is_finite(s.gap);  // all its triangles are lines
  };
  if (flat_mesh(a, found) || flat_mesh(b, found)) return;
  RC_ASSERT(real::is_finite(found.gap));
  RC_ASSERT(is_unit(found.normal_W));
  RC_ASSERT(finite(found.on_a_W));
  RC_ASSERT(finite(found.on_b_W));
  const S round_off = S(1e5) * real::epsilon<S>() * S(pose.scale);
  RC_ASSERT(real::abs(found.gap - back.gap) <= round_off);
  RC_ASSERT(real::abs(dot(found.on_b_W - found.on_a_W, found.normal_W) - found.gap) <= round_off);
  std::vector<Manifold<S>> manifolds;
  const S margin = S(0.125) * S(pose.scale);
  find_contacts(a, pose_a, b, pose_b, margin, manifolds);
  if (found.gap < margin - round_off) RC_ASSERT(!manifolds.empty());
  if (found.gap > margin + round_off) RC_ASSERT(manifolds.empty());
  S least = std::numeric_limits<S>::infinity();
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
  const bool surfaces = a.kind == ShapeKind::mesh || b.kind == ShapeKind::mesh;  // their depth is per triangle
  if (!manifolds.empty() && !surfaces) RC_ASSERT(real::abs(least - found.gap) <= round_off);
}

// A limit for every pose: a thousand times the usual time of a query, for builds with sanitizers.
constexpr double kSoon_s = 10;

template <class S> void check_swept(const Pose& pose, Random& random) {
  const Geometry<S> a = make_geometry<S>(pose.a), b = make_geometry<S>(pose.b);
  if (missing_contact_test(a.kind, b.kind)) return;
  const auto motion = [&](double speed) {
    const Real3 v = gauss3(random);
    return Vec3<S>{S(speed * v[0]), S(speed * v[1]), S(speed * v[2])};
  };
  const auto narrowed = [](const Quat<double>& q) { return normalised(Quat<S>{S(q.w), S(q.x), S(q.y), S(q.z)}); };
  const auto rate = [&]() -> double { return random() % 3 == 0 ? 0 : std::pow(10, uniform(random, -9, 2)); };
  const double away = random() % 2 ? 1 : 4,
               speed = random() % 4 == 0 ? 0 : pose.scale * std::pow(10, uniform(random, -3, 3));
  const Vec3<S> p{S(away * pose.between.x), S(away * pose.between.y), S(away * pose.between.z)};
  const SweptBody<S> from_a{{}, narrowed(pose.q_a), motion(speed), motion(rate())};
  SweptBody<S> from_b{p, narrowed(pose.q_b), motion(speed), motion(rate())};
  if (random() % 3 == 0 && norm(p) > S(0)) from_b.v_W = from_a.v_W - (S(speed) / norm(p)) * p;  // head on
  const S t_end = S(1);
  const auto began = std::chrono::steady_clock::now();
  const auto touch = time_of_impact(a, from_a, b, from_b, t_end), back = time_of_impact(b, from_b, a, from_a, t_end);
  RC_ASSERT(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() < kSoon_s);
  for (const auto& found : {touch, back}) {
    if (!found) continue;
    RC_ASSERT(real::is_finite(found->t_s));
    RC_ASSERT(found->t_s >= S(0));
    RC_ASSERT(found->t_s <= t_end);
    RC_ASSERT(finite(found->x_W));
    RC_ASSERT(is_unit(found->normal_W));
  }
}

template <class Check> void each_pair(const Check& check, bool (*wanted)(ShapeKind, ShapeKind)) {
  for (const ShapeKind a : kAll) {
    for (const ShapeKind b : kAll) {
      if (!wanted(a, b)) continue;
      DYNAMIC_SECTION(static_cast<int>(a) << " against " << static_cast<int>(b)) {
        CHECK(rc::check([&](std::uint64_t seed) {
          for (std::uint64_t k = 0; k < 4; ++k) check(a, b, 100 * seed + k);
        }));
      }
    }
  }
}

bool by_support(ShapeKind a, ShapeKind b) {
  const auto is = [&](ShapeKind kind) { return a == kind || b == kind; };
  return is(ShapeKind::convex) || is(ShapeKind::cylinder) || is(ShapeKind::mesh);
}

}  // namespace

TEST_CASE("queries of hulls, cylinders and meshes are finite in every pose") {
  each_pair(
      [](ShapeKind a, ShapeKind b, std::uint64_t seed) {
        check_pair<double>(hostile_pose(a, b, seed, 1e-5));
        check_pair<float>(hostile_pose(a, b, seed, 1e-2));
        check_pair<long double>(hostile_pose(a, b, seed, 1e-5));
      },
      by_support);
}

TEST_CASE("swept queries of every pair of shapes are finite and end soon") {
  each_pair(
      [](ShapeKind a, ShapeKind b, std::uint64_t seed) {
        Random random(seed);
        check_swept<double>(hostile_pose(a, b, seed, 1e-5), random);
        check_swept<float>(hostile_pose(a, b, seed, 1e-2), random);
      },
      [](ShapeKind, ShapeKind) { return true; });
}
