// The time of the first touch: closed forms, dense bisection, nothing tunnels.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include "collision/time_of_impact.hpp"
#include "math/so3.hpp"
#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

namespace {

Geometry<double> shape(const Shape& s) { return make_geometry<double>(s); }
SweptBody<double> moving(const V& p, const V& v, const Quat<double>& q = {}, const V& w = {}) { return {p, q, v, w}; }

double gap_at(const Geometry<double>& a, const SweptBody<double>& from_a, const Geometry<double>& b,
              const SweptBody<double>& from_b, double t) {
  const auto pose = [t](const SweptBody<double>& s) {
    return transform(s.p_W + t * s.v_W, so3_exp(t * s.w_W) * s.q_WB);
  };
  return separation(a, pose(from_a), b, pose(from_b)).gap;
}

}  // namespace

TEST_CASE("spheres: head on, grazing, far and fast, overlapping, parting") {
  const auto ball = shape(Sphere{0.5});
  const auto hit = time_of_impact(ball, moving({0, 0, 0}, {1, 0, 0}), ball, moving({3, 0, 0}, {-1, 0, 0}), 10.0);
  REQUIRE(hit);
  CHECK(hit->t_s == 1);
  CHECK(hit->normal_W.x == 1);
  CHECK(hit->x_W.x == 1.5);
  // Passing at 0.6 of the sum of radii: the touch is where the centres are 0.8 apart along the way.
  const auto oblique = time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), ball, moving({5, 0.6, 0}, {-2, 0, 0}), 10.0);
  REQUIRE(oblique);
  CHECK(oblique->t_s == Approx((5 - 0.8) / 2).epsilon(1e-15));
  CHECK(oblique->normal_W.x == Approx(0.8).epsilon(1e-15));
  // Grazing: a miss by d short of the sum of radii touches sqrt(2 d - d^2) before the middle, to all digits of d.
  const double d = 0x1p-40;
  const auto grazing =
      time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), ball, moving({5, 1 - d, 0}, {-1, 0, 0}), 10.0);
  REQUIRE(grazing);
  CHECK(5 - grazing->t_s == Approx(std::sqrt(2 * d - d * d)).epsilon(1e-9));
  CHECK_FALSE(time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), ball, moving({5, 1 + d, 0}, {-1, 0, 0}), 10.0));
  // From 1e6 m at 1e6 m/s.
  const auto bullet =
      time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), shape(Sphere{1e-3}), moving({1e6, 0, 0}, {-1e6, 0, 0}), 10.0);
  REQUIRE(bullet);
  CHECK(bullet->t_s == Approx((1e6 - 0.501) / 1e6).epsilon(1e-15));
  CHECK(time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), ball, moving({0.9, 0, 0}, {1, 0, 0}), 10.0)->t_s == 0);
  CHECK(time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), ball, moving({0, 0, 0}, {1, 0, 0}), 10.0)->t_s == 0);
  CHECK_FALSE(time_of_impact(ball, moving({0, 0, 0}, {0, 0, 0}), ball, moving({2, 0, 0}, {1, 0, 0}), 10.0));
  CHECK_FALSE(time_of_impact(ball, moving({0, 0, 0}, {1, 0, 0}), ball, moving({3, 0, 0}, {1, 0, 0}), 10.0));
  CHECK_FALSE(time_of_impact(ball, moving({0, 0, 0}, {1, 0, 0}), ball, moving({12, 0, 0}, {0, 0, 0}), 10.0));
}

TEST_CASE("a sphere and a plane: a line's root; spin changes nothing") {
  const auto plane = shape(Plane{{0, 0.6, 0.8}, 2});
  const auto touch =
      time_of_impact(shape(Sphere{0.25}), moving({1, 6, 8}, {3, 0, -5}, {}, {9, 8, 7}), plane, moving({}, {}), 10.0);
  REQUIRE(touch);
  CHECK(touch->t_s == Approx((10 - 2 - 0.25) / 4).epsilon(1e-15));
  CHECK(touch->normal_W.z == Approx(-0.8).epsilon(1e-15));
  CHECK(0.6 * touch->x_W.y + 0.8 * touch->x_W.z == Approx(2).epsilon(1e-15));
  CHECK(time_of_impact(plane, moving({}, {}), shape(Sphere{0.25}), moving({0, 0, 0}, {0, 0, 1}), 1.0)->t_s == 0);
}

TEST_CASE("fast and small against thin: a ball through paper stops at the paper") {
  const auto paper = shape(Box{{1, 1, 5e-5}}), sheet = shape(Rectangle{{1, 1}});
  for (const double speed : {1.0, 1e3, 1e6}) {
    const auto touch =
        time_of_impact(paper, moving({}, {}), shape(Sphere{1e-3}), moving({0.3, -0.2, 5}, {0, 0, -speed}), 10.0);
    REQUIRE(touch);
    CHECK(touch->t_s * speed == Approx(5 - 1e-3 - 5e-5).epsilon(1e-14));
    const auto at_sheet = time_of_impact(sheet, moving({}, {}), shape(Sphere{1e-3}),
                                         moving({0.3, -0.2, 5}, {0, 0.1 * speed, -speed}), 10.0);
    REQUIRE(at_sheet);
    CHECK(at_sheet->t_s * speed == Approx(5 - 1e-3).epsilon(1e-14));
    CHECK(at_sheet->normal_W.z == Approx(1).epsilon(1e-12));
    Mesh wall{"", {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    const auto at_mesh =
        time_of_impact(shape(wall), moving({}, {}), shape(Sphere{1e-3}), moving({0.3, 0.3, 5}, {0, 0, -speed}), 10.0);
    REQUIRE(at_mesh);
    CHECK(at_mesh->t_s * speed == Approx(5 - 1e-3).epsilon(1e-14));
    const auto box_at_mesh = time_of_impact(shape(wall), moving({}, {}), shape(Box{{1e-3, 1e-3, 1e-3}}),
                                            moving({0.3, 0.3, 5}, {0, 0, -speed}), 10.0);
    REQUIRE(box_at_mesh);
    CHECK(box_at_mesh->t_s * speed == Approx(5 - 1e-3).epsilon(1e-14));
  }
}

TEST_CASE("a spinning rod meets a plane when its end comes down") {
  // Centre at height 1, half-length 2 along x, turning about y with w: its end is at 1 - 2 sin(w t).
  const auto rod = shape(Capsule{0.1, 1.9});
  const Quat<double> lying{std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  const auto touch = time_of_impact(shape(Plane{{0, 0, 1}, 0}), moving({}, {}), rod,
                                    moving({0, 0, 1}, {0, 0, 0}, lying, {0, 0.7, 0}), 10.0);
  REQUIRE(touch);
  CHECK(touch->t_s == Approx(std::asin(0.9 / 1.9) / 0.7).epsilon(1e-13));
}

TEST_CASE("the touch is the first zero of the gap, and never past it") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Geometry<double> a = shape(random_shape(kConvexKinds[random() % 6], random)),
                           b = shape(random_shape(kConvexKinds[random() % 6], random));
    const V at = narrow3<double>(gauss3(random));
    const SweptBody<double> from_a =
        moving({}, 0.3 * narrow3<double>(gauss3(random)), any_turn(random), narrow3<double>(gauss3(random)));
    const SweptBody<double> from_b = moving((4 / norm(at)) * at, -1 * at + 0.3 * narrow3<double>(gauss3(random)),
                                            any_turn(random), narrow3<double>(gauss3(random)));
    const double t_end = 6;
    const auto touch = time_of_impact(a, from_a, b, from_b, t_end);
    const double end = touch ? touch->t_s : t_end;
    constexpr int kSamples = 400;
    for (int i = 0; i < kSamples; ++i) RC_ASSERT(gap_at(a, from_a, b, from_b, end * i / kSamples) > -1e-13);
    if (touch) {
      const double gap = gap_at(a, from_a, b, from_b, touch->t_s);
      RC_ASSERT(std::abs(gap) < 1e-13);
      const auto swapped = time_of_impact(b, from_b, a, from_a, t_end);
      RC_ASSERT(swapped.has_value());
      RC_ASSERT(std::abs(gap_at(a, from_a, b, from_b, swapped->t_s)) < 1e-13);
    }
  }));
}

// ---- bodies that are not convex: the nearest part says nothing of the wall ahead ----------------------------------
namespace {

const Compound kFloorAndWall{{{{5, 5, 0.5}, {0, 0, -0.5}, {1, 0, 0, 0}}, {{0.5, 5, 2}, {3.5, 0, 1}, {1, 0, 0, 0}}}};
const Mesh kFloorAndWallMesh{"",
                             {{-5, -5, 0}, {3, -5, 0}, {3, 5, 0}, {-5, 5, 0}, {3, -5, 5}, {3, 5, 5}},
                             {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}}};
Mesh cube_mesh(double h) {
  Mesh mesh{"", box_corners({h, h, h}), {}};
  for (const auto& q : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4}, std::array{2, 6, 7, 3},
                        std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

}  // namespace

TEST_CASE("what flies close above a floor meets the wall, whatever the two are made of") {
  const std::vector<Shape> flyers = {Sphere{0.25},           Box{{0.25, 0.25, 0.25}},
                                     Capsule{0.125, 0.125},  Cylinder{0.25, 0.25},
                                     cube_mesh(0.25),        Convex{box_corners({0.25, 0.25, 0.25})},
                                     Rectangle{{0.25, 0.1}}, Compound{{{{0.25, 0.25, 0.25}, {0, 0, 0}, {1, 0, 0, 0}}}}};
  for (const Shape& room : {Shape(kFloorAndWall), Shape(kFloorAndWallMesh)}) {
    for (const Shape& flyer : flyers) {
      const double half = std::holds_alternative<Capsule>(flyer) ? 0.125 : 0.25;
      INFO(room.index() << " " << flyer.index());
      const auto touch = time_of_impact(shape(room), moving({}, {}), shape(flyer), moving({0, 0, 0.3}, {1, 0, 0}), 5.0);
      REQUIRE(touch);
      CHECK(touch->t_s == Approx(3 - half).epsilon(1e-14));
      CHECK(norm(touch->normal_W - V{-1, 0, 0}) < 1e-12);
      const auto swapped =
          time_of_impact(shape(flyer), moving({0, 0, 0.3}, {1, 0, 0}), shape(room), moving({}, {}), 5.0);
      REQUIRE(swapped);
      CHECK(swapped->t_s == Approx(3 - half).epsilon(1e-14));
      CHECK_FALSE(time_of_impact(shape(room), moving({}, {}), shape(flyer), moving({0, 0, 0.3}, {1, 0, 0}), 2.7));
    }
  }
}

TEST_CASE("a compound's arm sweeps round") {
  const Compound arms{{{{0.25, 0, 0}, {2, 0, 0}, {1, 0, 0, 0}}, {{0.25, 0, 0}, {-2, 0, 0}, {1, 0, 0, 0}}}};
  // The arm is a segment of the radius, the ball's centre at radius 2: it touches where sin(angle between) = 0.25 / 2.
  const auto touch =
      time_of_impact(shape(arms), moving({}, {}, {}, {0, 0, 0.5}), shape(Sphere{0.25}), moving({0, 2, 0}, {}), 10.0);
  REQUIRE(touch);
  CHECK(touch->t_s == Approx((std::acos(-1.0) / 2 - std::asin(0.125)) / 0.5).epsilon(1e-13));
}

TEST_CASE("the first zero of the gap with compounds and meshes in it, too") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const auto part = [&] {
      const Quat<double> q = any_turn(random);
      const Real3 p = gauss3(random);
      return Compound::Part{{uniform(random, 0.1, 0.5), uniform(random, 0.1, 0.5), uniform(random, 0.1, 0.5)},
                            {0.5 * p[0], 0.5 * p[1], 0.5 * p[2]},
                            {q.w, q.x, q.y, q.z}};
    };
    const auto any = [&]() -> Shape {
      const auto how = random() % 3;
      if (how == 0) return Compound{{part(), part(), part()}};
      if (how == 1)
        return Mesh{"", {gauss3(random), gauss3(random), gauss3(random), gauss3(random)}, {{0, 1, 2}, {0, 3, 1}}};
      return random_shape(kConvexKinds[random() % 6], random);
    };
    const Geometry<double> a = shape(any()), b = shape(any());
    const V at = narrow3<double>(gauss3(random));
    const auto from_a =
        moving({}, 0.3 * narrow3<double>(gauss3(random)), any_turn(random), narrow3<double>(gauss3(random)));
    const auto from_b = moving((6 / norm(at)) * at, -1 * at + 0.3 * narrow3<double>(gauss3(random)), any_turn(random),
                               narrow3<double>(gauss3(random)));
    const auto touch = time_of_impact(a, from_a, b, from_b, 6.0);
    const double end = touch ? touch->t_s : 6;
    constexpr int kSamples = 200;
    for (int i = 0; i < kSamples; ++i) RC_ASSERT(gap_at(a, from_a, b, from_b, end * i / kSamples) > -1e-12);
    if (touch) RC_ASSERT(std::abs(gap_at(a, from_a, b, from_b, touch->t_s)) < 1e-12);
  }));
}

TEST_CASE("a graze ends: steps shrink with the root of the gap, not with the gap") {
  // A rod's end comes down to the plane, or to within d of it, and goes up again.
  const Quat<double> lying{std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  const auto plane = shape(Plane{{0, 0, 1}, 0}), rod = shape(Capsule{0.25, 1}), sheet = shape(Rectangle{{5, 5}});
  const double down = std::acos(-1.0) / 2;
  for (const auto& ground : {plane, sheet}) {
    for (const double d : {0.0, 1e-15, 1e-12, 1e-9}) {
      for (const bool swapped : {false, true}) {
        const auto spun = moving({0, 0, 1.25 + d}, {}, lying, {0, 1, 0});
        const auto touch = swapped ? time_of_impact(rod, spun, ground, moving({}, {}), 3.0)
                                   : time_of_impact(ground, moving({}, {}), rod, spun, 3.0);
        INFO(d);
        CHECK((d > 1e-14) != touch.has_value());  // within round-off it touches
        if (touch)
          CHECK(std::abs(touch->t_s - down) < 4e-7);  // the root of twice the gap's round-off, 4e-14 for the sheet
      }
    }
  }
}

TEST_CASE("a touch at the very end, or at the very start, as decimals round") {
  const auto tenth = shape(Sphere{0.1}), plane = shape(Plane{{0, 0, 1}, 0}), box = shape(Box{{0.1, 0.1, 0.1}});
  const auto still = moving({}, {});
  CHECK(time_of_impact(tenth, moving({0, 0, 0.8}, {0, 0, -1}), plane, still, 0.7));  // (0.8 - 0.1) / 1 > 0.7
  CHECK_FALSE(time_of_impact(tenth, moving({0, 0, 0.8}, {0, 0, -1}), plane, still, 0.7 - 1e-12));
  CHECK(time_of_impact(box, moving({0, 0, 0.8}, {0, 0, -1}), plane, still, 0.7));
  CHECK(time_of_impact(box, moving({0, 0, 0.9}, {0, 0, -0.3}), shape(Box{{1, 1, 0.2}}), still, 2.0));
  CHECK(time_of_impact(tenth, moving({0, 0, 0.9}, {0, 0, -0.3}), shape(Sphere{0.2}), still, 2.0));
  CHECK_FALSE(time_of_impact(tenth, moving({0, 0, 0.9}, {0, 0, -0.3}), shape(Sphere{0.2}), still, 2.0 - 1e-12));
  const auto parting =
      time_of_impact(tenth, moving({0, 0, 0.8}, {0, 0, 1}), shape(Sphere{0.7}), still, 1.0);  // 0.1 + 0.7 < 0.8
  REQUIRE(parting);
  CHECK(parting->t_s == 0);
  CHECK_FALSE(time_of_impact(tenth, moving({0, 0, 0.8 + 1e-14}, {0, 0, 1}), shape(Sphere{0.7}), still, 1.0));
}

TEST_CASE("far from each other for long, and spinning fast about what moves nothing") {
  const double t_end = 1e6;
  const auto touch = time_of_impact(shape(Box{{1, 1, 1}}), moving({}, {}), shape(Cylinder{0.5, 0.5}),
                                    moving({0, 0, 1e5}, {0, 0, -1}, {}, {0, 0, 1e3}), t_end);
  REQUIRE(touch);
  CHECK(touch->t_s == Approx(1e5 - 1.5).epsilon(1e-14));
  CHECK_FALSE(time_of_impact(shape(Box{{1, 1, 1}}), moving({}, {}), shape(Box{{1, 1, 1}}),
                             moving({0, 0, 2 + 1e-9}, {}, {}, {0, 0, 1e3}), t_end));
}

TEST_CASE("what spins low over a floor or close beside a wall never touches it, for ever so many turns") {
  const Mesh square{"", {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const std::vector<Shape> grounds = {Box{{5, 5, 0.5}}, Rectangle{{5, 5}}, square,
                                      Compound{{{{5, 5, 0.5}, {0, 0, 0}, {1, 0, 0, 0}}}}};
  const std::vector<Shape> tops = {
      Box{{0.5, 0.5, 0.5}}, cube_mesh(0.5), Convex{box_corners({0.5, 0.5, 0.5})}, Cylinder{0.5, 0.5},
      Compound{{{{0.25, 0.5, 0.5}, {-0.25, 0, 0}, {1, 0, 0, 0}}, {{0.25, 0.5, 0.5}, {0.25, 0, 0}, {1, 0, 0, 0}}}}};
  const double radius = std::sqrt(0.5), rate = 50;
  for (const Quat<double>& world : {Quat<double>{}, normalised(Quat<double>{0.9, 0.1, 0.3, -0.2})}) {
    const auto in_world = [&](const V& p, const V& v, const V& w, const Quat<double>& q = {}) {
      return moving(rotate(world, p), rotate(world, v), world * q, rotate(world, w));
    };
    const V up = rotate(world, V{0, 0, 1});
    const Geometry<double> plane = shape(Plane{{up.x, up.y, up.z}, 0});
    const Quat<double> upright = normalised(Quat<double>{1, 0, 1, 0});  // a ground as a wall across x
    for (const Shape& top : tops) {
      const Geometry<double> body = shape(top);
      for (const double gap : {1e-6, 1e-9, 1e-12}) {
        const auto low = in_world({0.1, 0.2, 0.5 + gap}, {}, {0, 0, 1e3});
        INFO("over a floor: " << top.index() << " gap " << gap);
        CHECK_FALSE(time_of_impact(plane, moving({}, {}), body, low, 1e6));
        for (const Shape& ground : grounds) {
          const bool thick = ground.index() == 4 || ground.index() == 9;
          INFO("ground " << ground.index());
          CHECK_FALSE(time_of_impact(shape(ground), in_world({0, 0, thick ? -0.5 : 0}, {}, {}), body, low, 1e6));
        }
      }
      if (std::holds_alternative<Cylinder>(top)) continue;
      for (const Shape& ground : grounds) {
        const double at = ground.index() == 4 || ground.index() == 9 ? 0.5 : 0, gap = 1e-9;
        const auto spun = in_world({}, {}, {0, 0, rate});
        INFO("beside a wall: " << top.index() << " ground " << ground.index());
        CHECK_FALSE(
            time_of_impact(shape(ground), in_world({radius + gap + at, 0, 0}, {}, {}, upright), body, spun, 1e3));
        const auto touch =
            time_of_impact(shape(ground), in_world({radius - gap + at, 0, 0}, {}, {}, upright), body, spun, 1e3);
        REQUIRE(touch);  // the corner that starts at 45 degrees
        CHECK(touch->t_s == Approx((std::acos(-1.0) / 4 - std::acos(1 - gap / radius)) / rate).epsilon(1e-7));
      }
    }
  }
}

TEST_CASE("two that spin at their own rates, their circles a hair apart") {
  const auto box = shape(Box{{0.5, 0.5, 0.5}});
  const double reach = 2 * std::sqrt(0.5) + 1e-9;
  CHECK_FALSE(time_of_impact(box, moving({}, {}, {}, {0, 0, 50}), box,
                             moving({0.6 * reach, 0.8 * reach, 0.3}, {}, {}, {0, 0, -37}), 100.0));
}
