// Contact queries of a scene, as the command `contacts` makes them: every pair is answered or refused by name, rounded
// decimals that touch do touch, each point is reported once, and contacts do not depend on the world's pose or the
// order of bodies.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include "collision/convex_part.hpp"
#include "collision/query.hpp"
#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

namespace {

Mesh cube_mesh(double h) {
  Mesh mesh{"", box_corners({h, h, h}), {}};
  for (const auto& q : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4}, std::array{2, 6, 7, 3},
                        std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

Body body(const Shape& shape, const Real3& p = {}, const Quat<double>& q = {}) {
  Body made;
  made.shape = shape;
  made.position_m = p;
  made.orientation_wxyz = {q.w, q.x, q.y, q.z};
  return made;
}
Scene scene_of(const Body& a, const Body& b) {
  Scene scene;
  scene.bodies = {a, b};
  return scene;
}

// One of each kind, about half a metre in size, all round the origin.
std::vector<Shape> one_of_each() {
  return {std::monostate{},
          Sphere{0.5},
          Plane{{0, 0, 1}, 0.125},
          Rectangle{{0.5, 0.5}},
          Box{{0.5, 0.5, 0.5}},
          Capsule{0.25, 0.25},
          Cylinder{0.5, 0.5},
          Convex{box_corners({0.5, 0.5, 0.5})},
          cube_mesh(0.5),
          Compound{{{{0.25, 0.5, 0.5}, {-0.25, 0, 0}, {1, 0, 0, 0}}, {{0.25, 0.5, 0.5}, {0.25, 0, 0}, {1, 0, 0, 0}}}}};
}

double near(const std::array<Wide, 3>& x, const V& y) {
  return norm(V{static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])} - y);
}

}  // namespace

TEST_CASE("an answer says how the searches for the least overlap and for the touch ended") {
  const Quat<double> tilt = normalised(Quat<double>{0.9, 0.2, 0.3, 0.1});
  Scene scene = scene_of(body(Cylinder{0.5, 0.5}), body(Cylinder{0.5, 0.5}, {0.6, 0.3, 0.2}, tilt));
  const SolveTally depth = find_scene_contacts(scene, {}).outcome.solvers.at("expanding-polytope");
  CHECK(depth.solves() == 1);
  CHECK(depth.iterations_max > 1);
  CHECK(depth.residual_max < 1e-2);  // of the shapes' size; round shapes have no finite certificate
  scene =
      scene_of(body(Convex{box_corners({0.5, 0.5, 0.5})}), body(Convex{box_corners({0.5, 0.5, 0.5})}, {0.9, 0.2, 0}));
  const SolveTally hulls = find_scene_contacts(scene, {}).outcome.solvers.at("expanding-polytope");
  CHECK(hulls.converged == 1);
  CHECK(hulls.residual_max < 1e-14);
  CHECK(find_scene_contacts(scene_of(body(Sphere{0.5}), body(Sphere{0.5}, {0.9, 0, 0})), {}).outcome.solvers.empty());

  scene = scene_of(body(Box{{0.5, 0.5, 0.5}}), body(Box{{0.5, 0.5, 0.5}}, {3, 0, 0}, tilt));
  scene.bodies[1].velocity_m_per_s = {-2, 0, 0};
  scene.bodies[1].angular_velocity_body_rad_per_s = {1, 2, 3};
  const ContactAnswer swept = find_scene_contacts(scene, {true, 2});
  REQUIRE(swept.touches.size() == 1);
  const SolveTally& touch = swept.outcome.solvers.at("conservative-advancement");
  CHECK(touch.converged == 1);
  CHECK(touch.iterations_max > 2);
  CHECK(touch.residual_max < 1e-14);
}

TEST_CASE("every pair of shapes is answered, or refused by the names of both") {
  const char* names[] = {"point",   "sphere",   "plane",  "rectangle", "box",
                         "capsule", "cylinder", "convex", "mesh",      "compound"};
  const std::vector<Shape> shapes = one_of_each();
  REQUIRE(shapes.size() == std::size(names));
  int refused = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = 0; j < shapes.size(); ++j) {
      INFO(names[i] << " against " << names[j]);
      const char* why = missing_contact_test(static_cast<ShapeKind>(i), static_cast<ShapeKind>(j));
      // The second sunk into the first by about a half, so that an answer without contacts would be a wrong one.
      const Scene scene =
          scene_of(body(shapes[i]), body(shapes[j], {0.1, 0.05, 0.11}, normalised(Quat<double>{1, 0.1, 0.2, 0.3})));
      ContactQuery swept;
      swept.swept = true;
      swept.t_end_s = 1;
      const ContactAnswer now = find_scene_contacts(scene, {}), first = find_scene_contacts(scene, swept);
      if (i == 0 || j == 0) {  // bodies without a shape touch nothing
        REQUIRE(why);
        CHECK(now.outcome.status == Status::ok);
        CHECK(now.contacts.empty());
        CHECK(first.touches.empty());
      } else if (why) {
        ++refused;
        CHECK(std::string(why) == std::string(names[i]) + " against " + names[j]);
        for (const ContactAnswer* answer : {&now, &first}) {
          CHECK(answer->outcome.status == Status::unsupported);
          CHECK(answer->outcome.reason == "atwood has no contact test of " + std::string(why));
          CHECK(answer->contacts.empty());
          CHECK(answer->touches.empty());
        }
        CHECK_THROWS_WITH(find_pair_gap(scene, 0, 1), "atwood has no contact test of " + std::string(why));
      } else {
        CHECK(now.outcome.status == Status::ok);
        CHECK_FALSE(now.contacts.empty());
        REQUIRE(first.touches.size() == 1);
        CHECK(first.touches[0].toi_s == Wide(0));
        CHECK(find_pair_gap(scene, 0, 1).gap_m < Wide(0));
      }
    }
  }
  CHECK(refused == 1);  // plane against plane
}

TEST_CASE("what touches by its decimals is in contact at depth 0, however it is turned") {
  Random random(11);
  struct Touching {
    Shape a, b;
    Real3 at;
    std::size_t points;
  };
  const std::vector<Touching> cases = {{Sphere{0.1}, Sphere{0.7}, {0.8, 0, 0}, 1},
                                       {Box{{0.1, 0.1, 0.1}}, Box{{0.7, 0.7, 0.7}}, {0, 0, 0.8}, 4},
                                       {Convex{box_corners({0.1, 0.1, 0.1})}, Box{{0.7, 0.7, 0.7}}, {0, 0, 0.8}, 4},
                                       {Box{{0.1, 0.1, 0.1}}, Rectangle{{0.7, 0.7}}, {0, 0, -0.1}, 4},
                                       {Capsule{0.1, 0.2}, Capsule{0.1, 0.3}, {0, 0, 0.7}, 1},
                                       {Cylinder{0.1, 0.2}, Cylinder{0.7, 0.2}, {0.8, 0, 0}, 2},
                                       {Sphere{0.1}, cube_mesh(0.7), {0.8, 0.3, 0.2}, 1}};
  for (std::size_t which = 0; which < cases.size(); ++which) {
    const Touching& c = cases[which];
    for (int k = 0; k < 50; ++k) {
      const Quat<double> turn = k == 0 ? Quat<double>{} : any_turn(random);
      const V at = rotate(turn, narrow3<double>(c.at));
      const double far = k % 5 == 4 ? 1e3 : k % 2;
      const V base{far * 0.3, -far * 0.7, far * 0.11};
      const auto pose = [&](const V& p) { return Real3{p.x, p.y, p.z}; };
      const Scene scene = scene_of(body(c.a, pose(base), turn), body(c.b, pose(base + at), turn));
      const ContactAnswer answer = find_scene_contacts(scene, {});
      INFO(which << " " << k);
      REQUIRE(answer.contacts.size() == c.points);
      for (const FoundContact& found : answer.contacts) CHECK(found.depth_m < Wide(1e-12));
      // A nanometre off it is none.
      const V away = (1 + 1e-9 / norm(at)) * at;
      CHECK(find_scene_contacts(scene_of(body(c.a, pose(base), turn), body(c.b, pose(base + away), turn)), {})
                .contacts.empty());
    }
  }
}

TEST_CASE("a contact point found by several triangles or parts is reported once") {
  const auto corners = [](const ContactAnswer& answer) {
    int count = 0;
    for (const FoundContact& c : answer.contacts)
      for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5}) count += near(c.x_m, {x, y, 0.4375}) < 1e-14;
    return count;
  };
  // The mesh's top lies all under the box: its corners, found by the triangles of top and sides, are the four points.
  const ContactAnswer under =
      find_scene_contacts(scene_of(body(Box{{1, 1, 0.5}}, {0, 0, 0.875}), body(cube_mesh(0.5))), {});
  CHECK(under.contacts.size() == 4);
  CHECK(corners(under) == 4);
  for (const FoundContact& c : under.contacts) {
    CHECK(near(c.normal, {0, 0, -1}) < 1e-15);
    CHECK(c.depth_m == Wide(0.125));
  }
  // Pieces of a compound side by side share two corners.
  const ContactAnswer parts =
      find_scene_contacts(scene_of(body(Box{{1, 1, 0.5}}, {0, 0, 0.875}), body(one_of_each().back())), {});
  CHECK(parts.contacts.size() == 6);
}

// ---- one contact, whoever is named first and wherever the world lies ----------------------------------------------
TEST_CASE(
    "swapping two bodies, turning or moving the world changes a gap by round-off alone, for every pair of shapes") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const auto any = [&](std::size_t kind) -> Shape {
      const Real3 h{uniform(random, 0.2, 1), uniform(random, 0.2, 1), uniform(random, 0.2, 1)};
      const Quat<double> q = any_turn(random);
      if (kind == 2) {
        const V n = unit_vector(narrow3<double>(gauss3(random)));
        return Plane{{n.x, n.y, n.z}, uniform(random, -1, 1)};
      }
      if (kind == 8)
        return Mesh{"", {gauss3(random), gauss3(random), gauss3(random), gauss3(random)}, {{0, 1, 2}, {0, 3, 1}}};
      if (kind == 9) return Compound{{{h, {0.5, 0, 0}, {1, 0, 0, 0}}, {h, {-0.5, 0.25, 0}, {q.w, q.x, q.y, q.z}}}};
      return random_shape(static_cast<ShapeKind>(kind), random);
    };
    for (std::size_t i = 1; i < 10; ++i) {
      for (std::size_t j = 1; j < 10; ++j) {
        if (i == 2 && j == 2) continue;
        const Shape a = any(i), b = any(j);
        const V p = narrow3<double>(gauss3(random));
        const Quat<double> q_a = any_turn(random), q_b = any_turn(random), turn = any_turn(random);
        const V shift{uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -9, 9)};
        const auto moved = [&](const Shape& shape) -> Shape {
          const auto* plane = std::get_if<Plane>(&shape);
          if (!plane) return shape;
          const V n = rotate(turn, narrow3<double>(plane->normal));
          return Plane{{n.x, n.y, n.z}, plane->offset_m + dot(n, shift)};
        };
        const auto at = [](const V& x) { return Real3{x.x, x.y, x.z}; };
        const PairGap here = find_pair_gap(scene_of(body(a, {}, q_a), body(b, at(p), q_b)), 0, 1);
        const PairGap swapped = find_pair_gap(scene_of(body(b, at(p), q_b), body(a, {}, q_a)), 0, 1);
        const PairGap there = find_pair_gap(
            scene_of(body(moved(a), at(shift), turn * q_a), body(moved(b), at(rotate(turn, p) + shift), turn * q_b)), 0,
            1);
        const double round_off = 2e-13;
        RC_ASSERT(std::abs(static_cast<double>(here.gap_m - swapped.gap_m)) <= round_off);
        RC_ASSERT(std::abs(static_cast<double>(here.gap_m - there.gap_m)) <= round_off);
        // The direction is that of a gap's feature, or of points so far apart.
        const double slack = round_off / std::min(1.0, std::abs(static_cast<double>(here.gap_m)) + 1e-9);
        const V n{static_cast<double>(here.normal[0]), static_cast<double>(here.normal[1]),
                  static_cast<double>(here.normal[2])};
        RC_ASSERT(near(swapped.normal, -n) <= slack);
        RC_ASSERT(near(there.normal, rotate(turn, n)) <= slack);
      }
    }
  }));
}

TEST_CASE("a capsule that shortens comes to the sphere's contact, against every shape") {
  Random random(3);
  const std::vector<Shape> shapes = one_of_each();
  for (std::size_t kind = 1; kind < shapes.size(); ++kind) {
    for (int k = 0; k < 40; ++k) {
      const V p = unit_vector(narrow3<double>(gauss3(random)));
      const Quat<double> q_a = any_turn(random), q_b = any_turn(random);
      const Body other =
          body(shapes[kind], {uniform(random, 0.2, 1) * p.x, uniform(random, 0.2, 1) * p.y, 0.7 * p.z}, q_b);
      const PairGap ball = find_pair_gap(scene_of(body(Sphere{0.25}, {}, q_a), other), 0, 1);
      for (const double half_length : {1e-3, 1e-6, 1e-9, 1e-15}) {
        const PairGap capsule = find_pair_gap(scene_of(body(Capsule{0.25, half_length}, {}, q_a), other), 0, 1);
        INFO(kind << " " << k << " " << half_length);
        CHECK(std::abs(static_cast<double>(capsule.gap_m - ball.gap_m)) <= half_length + 2e-15);
      }
    }
  }
}
