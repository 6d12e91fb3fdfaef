// Compounds of oriented boxes, and contacts of whole scenes.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include "collision/box_edge_crossings.hpp"
#include "collision/query.hpp"
#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

namespace {

Compound random_compound(Random& random, int boxes) {
  Compound compound;
  for (int i = 0; i < boxes; ++i) {
    const Quat<double> q = any_turn(random);
    compound.boxes.push_back({{uniform(random, 0.1, 0.5), uniform(random, 0.1, 0.5), uniform(random, 0.1, 0.5)},
                              {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)},
                              {q.w, q.x, q.y, q.z}});
  }
  return compound;
}
std::vector<Manifold<double>> contacts(const Geometry<double>& a, const Transform<double>& pose_a,
                                       const Geometry<double>& b, const Transform<double>& pose_b, double margin = 0) {
  std::vector<Manifold<double>> out;
  find_contacts(a, pose_a, b, pose_b, margin, out);
  return out;
}
// The compound's boxes as separate bodies.
struct Part {
  Geometry<double> shape;
  Transform<double> pose;
};
std::vector<Part> boxes_of(const Compound& compound, const V& p_WB, const Quat<double>& q_WB) {
  std::vector<Part> out;
  for (const auto& box : compound.boxes) {
    const Real4& q = box.orientation_wxyz;
    const V at = p_WB + rotate(q_WB, narrow3<double>(box.position_body_m));
    out.push_back(
        {make_geometry<double>(Box{box.half_extents_m}), transform(at, q_WB * Quat<double>{q[0], q[1], q[2], q[3]})});
  }
  return out;
}
bool same_contact(const Manifold<double>& a, const Manifold<double>& b) {
  if (a.count != b.count || norm(a.normal_W - b.normal_W) > 1e-10) return false;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i) {
    bool found = false;
    for (std::size_t k = 0; k < static_cast<std::size_t>(b.count); ++k)
      found = found ||
              (norm(a.points[i].x_W - b.points[k].x_W) < 1e-9 && std::abs(a.points[i].gap - b.points[k].gap) < 1e-12);
    if (!found) return false;
  }
  return true;
}
Body body(const std::string& name, const Shape& shape, const Real3& position, bool fixed = false) {
  Body out;
  out.name = name;
  out.shape = shape;
  out.position_m = position;
  out.fixed = fixed;
  out.mass_kg = fixed ? 0 : 1;
  return out;
}

}  // namespace

TEST_CASE("a compound touches what its boxes touch, with one manifold for each box") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Compound compound = random_compound(random, 6);
    const V p{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    const Quat<double> q = any_turn(random);
    const auto whole = make_geometry<double>(compound);
    using Kind = ShapeKind;
    for (const Kind kind : {Kind::sphere, Kind::plane, Kind::rectangle, Kind::box, Kind::capsule}) {
      const Shape shape = kind == Kind::plane ? Shape(Plane{{0, 0.6, 0.8}, 0.1}) : random_shape(kind, random);
      const auto other = make_geometry<double>(shape);
      const auto pose = transform(V{uniform(random, -1, 1), uniform(random, -1, 1), 0.5}, any_turn(random));
      const auto found = contacts(other, pose, whole, transform(p, q));
      std::size_t expected = 0;
      double least = std::numeric_limits<double>::infinity();
      const auto boxes = boxes_of(compound, p, q);
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const double gap = separation(other, pose, boxes[i].shape, boxes[i].pose).gap;
        least = std::min(least, gap);
        const auto alone = contacts(other, pose, boxes[i].shape, boxes[i].pose);
        if (std::abs(gap) < 1e-12) return;  // touching to round-off: either answer is right
        expected += alone.size();
        for (const auto& m : found)
          if (m.part_b == static_cast<int>(i)) RC_ASSERT(same_contact(m, alone.at(0)));
      }
      RC_ASSERT(found.size() == expected);
      RC_ASSERT(std::abs(separation(other, pose, whole, transform(p, q)).gap - least) < 1e-12);
    }
  }));
}

TEST_CASE("compounds against compounds: every pair of parts, named on both sides") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Compound one = random_compound(random, 4), two = random_compound(random, 5);
    const auto a = make_geometry<double>(one), b = make_geometry<double>(two);
    const V p{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    const Quat<double> q = any_turn(random);
    const auto here = transform(V{}, {}), there = transform(p, q);
    const auto found = contacts(a, here, b, there), swapped = contacts(b, there, a, here);
    RC_ASSERT(found.size() == swapped.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      RC_ASSERT(found[i].part_a == swapped[i].part_b);
      RC_ASSERT(found[i].part_b == swapped[i].part_a);
      RC_ASSERT(norm(found[i].normal_W + swapped[i].normal_W) == 0);
    }
    std::size_t expected = 0;
    for (const auto& x : boxes_of(one, {}, {}))
      for (const auto& y : boxes_of(two, p, q)) expected += separation(x.shape, x.pose, y.shape, y.pose).gap <= 0;
    RC_ASSERT(found.size() == expected);
  }));
}

TEST_CASE("bounds and bounding spheres hold every shape") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const auto pose =
        transform(V{uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -9, 9)}, any_turn(random));
    std::vector<Shape> shapes{random_compound(random, 5)};
    for (const ShapeKind kind : kConvexKinds) shapes.push_back(random_shape(kind, random, 1e3));
    for (const Shape& shape : shapes) {
      const auto g = make_geometry<double>(shape);
      const auto box = bounds(g, pose);
      const double low[] = {box.low.x, box.low.y, box.low.z}, high[] = {box.high.x, box.high.y, box.high.z};
      for (int k = 0; k < 3; ++k) {  // a plane at the box's side touches the shape, to round-off, and does not cut it
        for (const double side : {-1.0, 1.0}) {
          Plane plane{{0, 0, 0}, side > 0 ? -high[k] : low[k]};
          plane.normal[static_cast<std::size_t>(k)] = -side;
          const double gap = separation(make_geometry<double>(plane), transform(V{}, {}), g, pose).gap;
          RC_ASSERT(std::abs(gap) < 1e-14 * (10 + g.bounding_radius));
        }
      }
      const Plane beyond{{0.6, 0, 0.8}, 0};
      const double gap = separation(make_geometry<double>(beyond), transform(V{}, {}), g, pose).gap;
      RC_ASSERT(gap >= 0.6 * pose.p_W.x + 0.8 * pose.p_W.z - g.bounding_radius * (1 + 1e-14) - 1e-14);
    }
  }));
}

TEST_CASE("a scene's contacts: each pair once, fixed pairs left out, touching counts") {
  Scene scene;
  scene.bodies = {body("ground", Plane{{0, 0, 1}, 0}, {}, true), body("wall", Plane{{1, 0, 0}, 0}, {}, true),
                  body("ball", Sphere{1}, {1, 0, 0.75}), body("box", Box{{1, 1, 1}}, {3, 0, 1}),
                  body("far", Box{{1, 1, 1}}, {9, 0, 9})};
  const ContactAnswer answer = find_scene_contacts(scene, {});
  CHECK(answer.outcome.status == Status::ok);
  std::vector<std::pair<int, int>> pairs;
  for (const auto& c : answer.contacts) pairs.emplace_back(c.body_a, c.body_b);
  CHECK(pairs == std::vector<std::pair<int, int>>{{0, 2}, {0, 3}, {0, 3}, {0, 3}, {0, 3}, {1, 2}, {2, 3}});
  CHECK(answer.contacts[0].depth_m == Wide(0.25));
  CHECK(answer.contacts[0].normal[2] == Wide(1));
  for (std::size_t i : {1u, 2u, 3u, 4u, 5u, 6u}) CHECK(answer.contacts[i].depth_m == Wide(0));
  CHECK(answer.contacts[6].normal[0] == Wide(1));
  ContactQuery swept;
  swept.swept = true;
  swept.t_end_s = 8;
  scene.bodies[4].velocity_m_per_s = {0, 0, -2};
  const ContactAnswer touches = find_scene_contacts(scene, swept);
  CHECK(touches.contacts.empty());
  REQUIRE(touches.touches.size() == 5);
  CHECK(touches.touches[0].toi_s == Wide(0));  // the ball is in the ground
  CHECK(touches.touches[2].body_b == 4);
  CHECK(static_cast<double>(touches.touches[2].toi_s) == Approx(4).epsilon(1e-12));  // 8 m to fall at 2 m/s
  CHECK(find_pair_gap(scene, 2, 4).gap_m > Wide(9));
  CHECK_THROWS_AS(find_pair_gap(scene, 0, 1), std::invalid_argument);
}

TEST_CASE("edges against faces: a hit where they cross, not the way out; blind to containment") {
  Scene scene;
  scene.bodies = {body("a", Box{{1, 1, 1}}, {}), body("b", Box{{1, 1, 1}}, {1.5, 0.5, 0.25})};
  const ContactAnswer crossing = find_contacts_by_box_edges(scene, {});
  CHECK(!crossing.contacts.empty());
  for (const auto& c : crossing.contacts) CHECK(c.depth_m >= Wide(0.5));  // the least way out, along x
  const auto blind = [&scene](const Shape& shape, const Real3& at) {
    scene.bodies[1] = body("b", shape, at);
    return find_contacts_by_box_edges(scene, {}).contacts.empty() && !find_scene_contacts(scene, {}).contacts.empty();
  };
  CHECK(blind(Box{{0.5, 0.5, 0.5}}, {0.25, 0, 0}));
  CHECK(blind(Box{{0.5, 0.5, 0.5}}, {0.25, 0, 0.5}));  // even flush with a face from within
  scene.bodies[1].shape = Sphere{1};
  CHECK(find_contacts_by_box_edges(scene, {}).outcome.status == Status::unsupported);
}
