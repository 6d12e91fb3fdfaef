// Scenes of bodies and forces round-trip through JSON bit for bit.
#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numeric>

#include "scene/files.hpp"

using namespace atwood;

namespace {

// Any finite double, by its bits: denormals, both zeros and the largest included.
double any_finite() {
  for (;;) {
    const auto bits = *rc::gen::arbitrary<std::uint64_t>();
    double x;
    std::memcpy(&x, &bits, sizeof x);
    if (std::isfinite(x)) return x;
  }
}
double any_positive() {
  const double x = std::abs(any_finite());
  return x > 0 ? x : 1;
}
Real3 any_vector() { return {any_finite(), any_finite(), any_finite()}; }

Shape any_shape() {
  switch (*rc::gen::inRange(0, 9)) {
    case 0: return Sphere{any_positive()};
    case 1: return Rectangle{{any_positive(), any_positive()}};
    case 2: return Box{{any_positive(), any_positive(), any_positive()}};
    case 3: return Capsule{any_positive(), any_positive()};
    case 4: return Cylinder{any_positive(), any_positive()};
    case 5: return Convex{{any_vector(), any_vector(), any_vector(), any_vector()}};
    case 6: return Mesh{"m.obj", {any_vector(), any_vector(), any_vector()}, {{0, 1, 2}}};
    case 7: return Compound{{{{any_positive(), any_positive(), any_positive()}, any_vector(), {0, 0, 1, 0}}}};
    default: return std::monostate{};
  }
}

Force any_force(int bodies) {
  const std::vector<int> some{*rc::gen::inRange(0, bodies)};
  const std::vector<Interval> on_s = {{0.25, 1.0 + std::abs(*rc::gen::inRange(0, 5))}, {7, 8}};
  switch (*rc::gen::inRange(0, 12)) {
    case 0: return MutualGravity{some, any_positive(), any_positive()};
    case 1: return Attractor{some, any_vector(), any_positive()};
    case 2: return LinearDrag{some, any_positive(), any_vector(), any_positive()};
    case 3: return QuadraticDrag{some, any_positive(), any_positive(), any_positive(), any_vector(), any_positive()};
    case 4: return Spring{some, any_vector(), any_positive(), any_positive(), any_positive(), {any_vector()}};
    case 5: return Drive{some, any_vector(), any_finite(), any_finite()};
    case 6: return Lorentz{some, any_vector(), any_vector()};
    case 7: return Coulomb{some, any_positive()};
    case 8: return Thruster{some[0], any_vector(), {0.6, 0, -0.8}, any_positive(), on_s};
    case 9: return PointForce{some[0], any_vector(), any_vector(), {}};
    case 10: return Potential{some, "henon-heiles", {{"lambda", any_finite()}}};
    default: return Drive{some, any_vector(), 0, -0.0};
  }
}

Scene any_scene() {
  Scene scene;
  scene.gravity_m_per_s2 = any_vector();
  scene.simultaneous_impacts = static_cast<SimultaneousImpacts>(*rc::gen::inRange(0, 3));
  const int materials = *rc::gen::inRange(1, 4), bodies = *rc::gen::inRange(1, 5);
  for (int m = 0; m < materials; ++m)
    scene.materials.push_back({"m \\ ü" + std::to_string(m), 0.1 * m, any_positive(), any_positive()});
  for (int a = 0; a < materials; ++a)
    for (int b = a; b < materials; ++b) {
      PairLaw law{a, b, 1 / (1.0 + a + b), any_positive(), any_positive()};
      law.contact_law = static_cast<ContactLaw>(*rc::gen::inRange(0, 3));
      if (law.contact_law == ContactLaw::linear) {
        law.stiffness_N_per_m = any_positive();
        law.damping_N_s_per_m = any_positive();
        law.pull = *rc::gen::arbitrary<bool>();
      } else if (law.contact_law == ContactLaw::hertz) {
        law.modulus_Pa = any_positive();
        law.damping_s_per_m = any_positive();
      }
      scene.pairs.push_back(law);
    }
  for (int b = 0; b < bodies; ++b) {
    Body body;
    body.name = "body " + std::to_string(b);
    body.mass_kg = any_positive();
    body.inertia_kg_m2 = {1, 0.1, -0.2, 0.1, 1.1, 0.3, -0.2, 0.3, 1.3};
    body.material = *rc::gen::inRange(0, materials);
    body.shape = any_shape();
    body.position_m = any_vector();
    // A last bit short of unit length: a resolved scene is not normalised again.
    body.orientation_wxyz = {std::sqrt(0.5), -std::nextafter(std::sqrt(0.5), 1.0), 0, -0.0};
    body.velocity_m_per_s = any_vector();
    body.angular_velocity_body_rad_per_s = any_vector();
    body.charge_C = any_finite();
    body.release_s = any_positive();
    scene.bodies.push_back(body);
  }
  Body ground;
  ground.name = "ground";
  ground.fixed = true;
  ground.shape = Plane{{0, 0.6, 0.8}, any_finite()};
  scene.bodies.push_back(ground);
  for (int f = *rc::gen::inRange(0, 5); f > 0; --f) scene.forces.push_back(any_force(bodies));
  return scene;
}

template <class T> bool same_bits(const T& a, const T& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool same_body(const Body& a, const Body& b) {
  return a.name == b.name && same_bits(a.mass_kg, b.mass_kg) && same_bits(a.inertia_kg_m2, b.inertia_kg_m2) &&
         a.material == b.material && a.shape.index() == b.shape.index() && same_bits(a.position_m, b.position_m) &&
         same_bits(a.orientation_wxyz, b.orientation_wxyz) && same_bits(a.velocity_m_per_s, b.velocity_m_per_s) &&
         same_bits(a.angular_velocity_body_rad_per_s, b.angular_velocity_body_rad_per_s) &&
         same_bits(a.charge_C, b.charge_C) && a.fixed == b.fixed && same_bits(a.release_s, b.release_s);
}

}  // namespace

TEST_CASE("scenes of bodies and forces survive JSON to the bit") {
  REQUIRE(rc::check("scene_from_json(scene_to_json(s)) == s", [] {
    const Scene scene = any_scene();
    const std::string json = scene_to_json(scene);
    const Scene back = scene_from_json(json);
    RC_ASSERT(scene_to_json(back) == json);  // shapes, forces, materials and pairs: each double's text is its own
    RC_ASSERT(same_bits(back.gravity_m_per_s2, scene.gravity_m_per_s2));
    RC_ASSERT(back.simultaneous_impacts == scene.simultaneous_impacts);
    RC_ASSERT(back.bodies.size() == scene.bodies.size());
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) RC_ASSERT(same_body(back.bodies[i], scene.bodies[i]));
    RC_ASSERT(back.forces.size() == scene.forces.size());
    for (std::size_t i = 0; i < scene.forces.size(); ++i) RC_ASSERT(back.forces[i].index() == scene.forces[i].index());
    RC_ASSERT(back.pairs.size() == scene.pairs.size());
    for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
      const PairLaw &a = back.pairs[i], &b = scene.pairs[i];
      RC_ASSERT(same_bits(a.friction, b.friction));
      RC_ASSERT((a.contact_law == b.contact_law && a.pull == b.pull));
      RC_ASSERT(
          (same_bits(a.stiffness_N_per_m, b.stiffness_N_per_m) && same_bits(a.damping_N_s_per_m, b.damping_N_s_per_m)));
      RC_ASSERT((same_bits(a.modulus_Pa, b.modulus_Pa) && same_bits(a.damping_s_per_m, b.damping_s_per_m)));
    }
  }));
}

TEST_CASE("forces that name too many bodies together, and too many intervals, are refused in JSON too") {
  Scene scene;
  scene.materials = {{"default", 0, 0, 0}};
  scene.pairs = {{0, 0, 0, 0, 0}};
  for (int i = 0; i < 2000; ++i) {
    Body body;
    body.name = "b" + std::to_string(i), body.mass_kg = 1;
    scene.bodies.push_back(body);
  }
  std::vector<int> all(scene.bodies.size());
  std::iota(all.begin(), all.end(), 0);
  scene.forces.assign(500, Drive{all, {1, 0, 0}, 1, 0});
  CHECK(scene_from_json(scene_to_json(scene)).forces.size() == 500);
  scene.forces.push_back(Drive{{0}, {1, 0, 0}, 1, 0});
  CHECK_THROWS_WITH(scene_from_json(scene_to_json(scene)), Catch::Contains("1000001 with this one"));
  std::vector<Interval> often;
  for (int i = 0; i < 4096; ++i) often.push_back({2.0 * i, 2.0 * i + 1});
  scene.forces.assign(245, Thruster{0, {}, {0, 0, 1}, 1, often});
  CHECK_THROWS_WITH(scene_from_json(scene_to_json(scene)), Catch::Contains("more than 1000000 intervals"));
}

TEST_CASE("JSON that does not describe a scene is refused with a message") {
  using Catch::Contains;
  const std::string good = scene_to_json(scene_from_json(
      R"({"materials":[{"name":"m"}],"pairs":[{"between":["m","m"],"restitution":0,"friction":0,"rolling_friction_m":0}],)"
      R"("bodies":[{"name":"b","mass_kg":1,"material":"m"}]})"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string json = good;
    const auto at = json.find(from);
    REQUIRE(at != std::string::npos);
    json.replace(at, from.size(), to);
    return json;
  };
  CHECK_THROWS_WITH(scene_from_json("{\"a\""), Contains("not valid JSON: "));
  CHECK_THROWS_WITH(scene_from_json("[]"), Contains("expected a table"));
  CHECK_THROWS_WITH(scene_from_json(changed("mass_kg", "mas_kg")), Contains("unknown key `mas_kg` in bodies[0]"));
  CHECK_THROWS_WITH(scene_from_json(changed("\"mass_kg\":1", "\"mass_kg\":1e999")), Contains("not valid JSON"));
  CHECK_THROWS_WITH(scene_from_json(changed("\"mass_kg\":1", "\"mass_kg\":\"NaN\"")), Contains("expected a number"));
  CHECK_THROWS_WITH(scene_from_json(changed("\"mass_kg\":1", "\"mass_kg\":0")), Contains("mass"));
  CHECK_THROWS_WITH(scene_from_json(changed("[\"m\",\"m\"]", "[\"m\",\"x\"]")), Contains("the name of a material"));
  CHECK_THROWS_WITH(scene_from_json(std::string(5000, '[') + std::string(5000, ']')), Contains("nesting deeper"));
}
