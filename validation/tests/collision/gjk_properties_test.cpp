// Convex pairs by their support functions: certificates that no direction does better, symmetries, extreme inputs.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include "collision/convex_contacts.hpp"
#include "collision/nearest_features.hpp"
#include "convex_shapes.hpp"
#include "scene/pair_sweep.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

TEST_CASE("no direction tells two shapes apart better than the normal does") {
  // The gap is the greatest, over all directions, of the distance of the two supporting planes.
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const double spread = seed % 3 == 0 ? 1e3 : 1;
    const auto kind = [&] { return kConvexKinds[random() % 6]; };
    const Geometry<double> a = shape(random_shape(kind(), random, spread)),
                           b = shape(random_shape(kind(), random, spread));
    const double near = uniform(random, 0, 2);
    const Transform<double> pose_a = placed_at<double>({}, any_turn(random));
    const Transform<double> pose_b = placed_at<double>(near * narrow3<double>(gauss3(random)), any_turn(random));
    const Separation<double> s = convex_separation(a, pose_a, b, pose_b);
    ConvexPart<double> part_a, part_b;
    convex_part(a, part_a), convex_part(b, part_b);
    const Transform<double> b_in_a = relative_transform(pose_a, pose_b);
    const double size = a.bounding_radius + b.bounding_radius + norm(b_in_a.p_W), radii = part_a.radius + part_b.radius;
    const auto gap_along = [&](const V& n) { return -overlap_along(part_a, part_b, b_in_a, n) - radii; };
    RC_ASSERT(std::abs(norm(s.normal_W) - 1) < 1e-14);
    RC_ASSERT(std::abs(gap_along(to_body(pose_a, s.normal_W)) - s.gap) <= 1e-14 * size);
    for (int i = 0; i < 200; ++i) {
      const V d = s.normal_W + std::pow(10.0, 1 - i % 12) * narrow3<double>(gauss3(random));
      RC_ASSERT(gap_along(to_body(pose_a, (1 / norm(d)) * d)) <= s.gap + 1e-14 * size);
    }
    RC_ASSERT(norm(s.on_b_W - s.on_a_W - s.gap * s.normal_W) <= 1e-13 * size);
  }));
}

TEST_CASE("faces that lie nearly over each other keep the deepest vertex, although it is a neighbouring face's") {
  const Scene scene = sweep_scene("convex-convex", 42, 50803, false);
  const auto pose = [&](std::size_t i) {
    const Body& body = scene.bodies[i];
    const auto& q = body.orientation_wxyz;
    return transform(narrow3<double>(body.position_m), Quat<double>{q[0], q[1], q[2], q[3]});
  };
  const Geometry<double> a = shape(scene.bodies[0].shape), b = shape(scene.bodies[1].shape);
  std::vector<Manifold<double>> m;
  convex_contacts(a, pose(0), b, pose(1), 0.0, m);
  REQUIRE(m.size() == 1);
  double deepest = 1;
  for (int i = 0; i < m[0].count; ++i) deepest = std::min(deepest, m[0].points[static_cast<std::size_t>(i)].gap);
  CHECK(std::abs(deepest - convex_separation(a, pose(0), b, pose(1)).gap) < 1e-16);  // 2e-8 without it
}

TEST_CASE("the expanding polytope agrees with every axis of two polyhedra") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Geometry<double> a = shape(random_shape(ShapeKind::convex, random)),
                           b = shape(random_shape(ShapeKind::box, random));
    ConvexPart<double> part_a, part_b;
    convex_part(a, part_a), convex_part(b, part_b);
    const Transform<double> b_in_a =
        placed_at<double>(uniform(random, 0, 0.5) * narrow3<double>(gauss3(random)), any_turn(random));
    const NearestFeatures<double> meeting = nearest_features(part_a, part_b, b_in_a, 1e300);
    const double all = least_overlap_of_all_axes(part_a, part_b, b_in_a).overlap;
    if (meeting.gap < 0) RC_ASSERT(std::abs(meeting.gap + all) < 4e-15);
    if (meeting.gap >= 0) RC_ASSERT(all <= 1e-15 && -all <= meeting.gap + 1e-15);
  }));
}

TEST_CASE("double and extended precision give the same gap and normal for the same doubles") {
  Random random(7);
  double worst = 0, worst_turn = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shape a = random_shape(kConvexKinds[random() % 6], random),
                b = random_shape(kConvexKinds[random() % 6], random);
    const V p = uniform(random, 0, 2) * narrow3<double>(gauss3(random));
    const Quat<double> q_a = any_turn(random), q_b = any_turn(random);
    const auto s = convex_separation(shape(a), placed_at<double>({}, q_a), shape(b), placed_at<double>(p, q_b));
    const auto t = convex_separation(make_geometry<long double>(a), placed_at<long double>({}, q_a),
                                     make_geometry<long double>(b), placed_at<long double>(p, q_b));
    worst = std::max(worst, static_cast<double>(std::abs(s.gap - t.gap)));
    const V d{s.normal_W.x - double(t.normal_W.x), s.normal_W.y - double(t.normal_W.y),
              s.normal_W.z - double(t.normal_W.z)};
    worst_turn = std::max(worst_turn, norm(d));
  }
  CHECK(worst < 2e-14);
  CHECK(worst_turn < 1e-12);
}

TEST_CASE("swapping two shapes, or moving the world, changes nothing else") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Geometry<double> a = shape(random_shape(kConvexKinds[random() % 6], random)),
                           b = shape(random_shape(kConvexKinds[random() % 6], random));
    const V p = uniform(random, 0, 1.5) * narrow3<double>(gauss3(random)), shift = narrow3<double>(gauss3(random));
    const Quat<double> q_a = any_turn(random), q_b = any_turn(random), world = any_turn(random);
    const auto s = convex_separation(a, placed_at<double>({}, q_a), b, placed_at<double>(p, q_b));
    const auto t = convex_separation(b, placed_at<double>(p, q_b), a, placed_at<double>({}, q_a));
    RC_ASSERT(std::abs(s.gap - t.gap) < 1e-14);
    const auto u = convex_separation(a, placed_at<double>(shift, world * q_a), b,
                                     placed_at<double>(shift + rotate(world, p), world * q_b));
    RC_ASSERT(std::abs(s.gap - u.gap) < 2e-14);
    std::vector<Manifold<double>> m, n;
    convex_contacts(a, placed_at<double>({}, q_a), b, placed_at<double>(p, q_b), 1e-3, m);
    convex_contacts(b, placed_at<double>(p, q_b), a, placed_at<double>({}, q_a), 1e-3, n);
    RC_ASSERT(m.size() == n.size());
    RC_ASSERT(m.empty() == (s.gap > 1e-3));
    if (m.empty()) return;
    double deepest = 1e300;
    for (int i = 0; i < m[0].count; ++i) deepest = std::min(deepest, m[0].points[i].gap);
    RC_ASSERT(std::abs(deepest - s.gap) < 1e-13);
  }));
}

TEST_CASE("a hull of a box's corners is that box; a hull of many points on a sphere comes near the sphere") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Real3 h{uniform(random, 0.1, 1), uniform(random, 0.1, 1), uniform(random, 0.1, 1)};
    const Geometry<double> other = shape(random_shape(kConvexKinds[random() % 6], random));
    const Transform<double> pose_a = placed_at<double>({}, any_turn(random));
    const Transform<double> pose_b = placed_at<double>(narrow3<double>(gauss3(random)), any_turn(random));
    const auto s = convex_separation(shape(Box{h}), pose_a, other, pose_b);
    const auto t = convex_separation(shape(Convex{box_corners(h)}), pose_a, other, pose_b);
    RC_ASSERT(std::abs(s.gap - t.gap) < 5e-15);
  }));
  Random random(3);
  const auto ball = shape(Convex{boulder(random, 2000, {1, 1, 1})});
  const auto s = convex_separation(ball, placed_at<double>({}), shape(Box{{0.3, 0.4, 0.5}}),
                                   placed_at<double>({1.2, 1.1, 0.7}, any_turn(random)));
  const auto t = convex_separation(shape(Sphere{1}), placed_at<double>({}), shape(Box{{0.3, 0.4, 0.5}}),
                                   placed_at<double>({1.2, 1.1, 0.7}));
  CHECK(std::isfinite(t.gap));
  CHECK(s.gap > -2.5);
}

TEST_CASE("inputs that break others: coincident, flat, needles, tiny, huge, touching exactly") {
  const auto finite = [](const Separation<double>& s) {
    return std::isfinite(s.gap) && std::abs(norm(s.normal_W) - 1) < 1e-12 && std::isfinite(norm(s.on_a_W)) &&
           std::isfinite(norm(s.on_b_W));
  };
  const auto box = Box{{0.5, 0.5, 0.5}};
  for (const double scale : {1e-9, 1.0, 1e9}) {
    const auto cube = shape(Convex{box_corners({scale, scale, scale})});
    const auto same = convex_separation(cube, placed_at<double>({}), cube, placed_at<double>({}));
    CHECK(same.gap == Approx(-2 * scale).epsilon(1e-14));
    const auto touching = convex_separation(cube, placed_at<double>({}), cube, placed_at<double>({2 * scale, 0, 0}));
    CHECK(std::abs(touching.gap) <= 1e-15 * scale);
    CHECK(touching.normal_W.x == 1);
    const auto cylinder = shape(Cylinder{scale, scale});
    CHECK(convex_separation(cylinder, placed_at<double>({}), cylinder, placed_at<double>({})).gap ==
          Approx(-2 * scale).epsilon(1e-14));
    const auto plate = shape(Rectangle{{scale, scale}});
    CHECK(std::abs(convex_separation(plate, placed_at<double>({}), plate, placed_at<double>({scale, 0, 0})).gap) <=
          1e-15 * scale);
  }
  const auto needle = shape(Cylinder{1e-9, 1e3});
  CHECK(finite(
      convex_separation(needle, placed_at<double>({}), needle, placed_at<double>({0, 0, 0}, turn(1e-9, {1, 0, 0})))));
  const auto crossing =
      convex_separation(needle, placed_at<double>({}), needle, placed_at<double>({0, 1e-6, 0}, turn(0.5, {0, 1, 0})));
  CHECK(crossing.gap == Approx(1e-6 - 2e-9).epsilon(1e-6));
  const auto slab = shape(Box{{1e3, 1e3, 1e-6}});
  const auto on_slab =
      convex_separation(slab, placed_at<double>({}), shape(box), placed_at<double>({10, 20, 0.5 + 1e-6 - 1e-7}));
  CHECK(on_slab.gap == Approx(-1e-7).epsilon(1e-6));
  CHECK(on_slab.normal_W.z == 1);
  const auto flat = shape(Convex{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}});
  CHECK(convex_separation(flat, placed_at<double>({}), shape(box), placed_at<double>({0, 0, 0.25})).gap ==
        Approx(-0.25).epsilon(1e-15));
  const auto line = shape(Convex{{{0, 0, -1}, {0, 0, 1}}});
  CHECK(convex_separation(line, placed_at<double>({}), shape(Sphere{0.25}), placed_at<double>({0.5, 0, 0})).gap ==
        Approx(0.25).epsilon(1e-15));
  const auto nearly = convex_separation(shape(box), placed_at<double>({}), shape(box),
                                        placed_at<double>({0, 0, 1}, turn(1e-10, {1, 0, 0})));
  CHECK(nearly.gap == Approx(-0.5e-10).epsilon(1e-4));
  CHECK(finite(nearly));
}

TEST_CASE("convex pairs in float stay finite and right to its round-off") {
  Random random(11);
  for (int i = 0; i < 20000; ++i) {
    const double scale = i % 3 == 0 ? 1e-6 : i % 3 == 1 ? 1.0 : 1e6;
    Shape a = random_shape(kConvexKinds[random() % 6], random), b = random_shape(kConvexKinds[random() % 6], random);
    const V p = (uniform(random, 0, 2)) * narrow3<double>(gauss3(random));
    const Quat<double> q = any_turn(random);
    const auto sized = [&](Shape& s) {
      std::visit(
          [&](auto& t) {
            if constexpr (requires { t.half_extents_m; })
              for (double& x : t.half_extents_m) x *= scale;
            if constexpr (requires { t.radius_m; }) t.radius_m *= scale;
            if constexpr (requires { t.half_length_m; }) t.half_length_m *= scale;
            if constexpr (requires { t.points_m; })
              for (auto& x : t.points_m)
                for (double& y : x) y *= scale;
          },
          s);
    };
    sized(a), sized(b);
    const auto s = convex_separation(make_geometry<float>(a), placed_at<float>({}), make_geometry<float>(b),
                                     placed_at<float>(scale * p, q));
    const auto t = convex_separation(shape(a), placed_at<double>({}), shape(b), placed_at<double>(scale * p, q));
    REQUIRE(std::abs(static_cast<double>(s.gap) - t.gap) < 1e-5 * scale);
  }
}
