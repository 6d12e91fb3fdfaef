// Scenes as people type them: degrees, unit vectors of a few digits, `body` or `bodies`, a grid by the name of its
// body.
#include <catch2/catch.hpp>
#include <cmath>

#include "scene/orientation.hpp"
#include "text.hpp"

using namespace scene_test;
using atwood::Real3;
using atwood::Real4;
using Catch::Contains;

namespace {

const double kRoot = std::sqrt(0.5);

Real4 orientation(const std::string& keys) { return read_body("mass_kg = 1\n" + keys + "\n").orientation_wxyz; }

// The columns of the rotation matrix, for the convention of euler_xyz_deg.
Real3 turned(const Real4& q, const Real3& v) {
  const auto [w, x, y, z] = q;
  return {(1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y - w * z) * v[1] + 2 * (x * z + w * y) * v[2],
          2 * (x * y + w * z) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z - w * x) * v[2],
          2 * (x * z - w * y) * v[0] + 2 * (y * z + w * x) * v[1] + (1 - 2 * (x * x + y * y)) * v[2]};
}

std::string grid_scene(const std::string& force) {
  return kHead +
         "[[body]]\nname = \"ball\"\nmass_kg = 1\n[[body]]\nname = \"lone\"\nmass_kg = 1\n[[grid]]\nbody = \"ball\"\n"
         "counts = [2, 1, 2]\nspacing_m = [1, 1, 1]\n[[force]]\n" +
         force;
}

}  // namespace

TEST_CASE("quarter turns are exact, whatever full turns are added") {
  CHECK(orientation("axis_angle_deg = { axis = [0, 0, 1], angle_deg = 90 }") == Real4{kRoot, 0, 0, kRoot});
  CHECK(orientation("axis_angle_deg = [0, 0, 2, 90]") == Real4{kRoot, 0, 0, kRoot});
  CHECK(orientation("axis_angle_deg = [1, 0, 0, 180]") == Real4{0, 1, 0, 0});
  CHECK(orientation("axis_angle_deg = [1, 0, 0, -180]") == Real4{0, 1, 0, 0});
  CHECK(orientation("axis_angle_deg = [0, 1, 0, 3690]") == Real4{kRoot, 0, kRoot, 0});
  CHECK(orientation("axis_angle_deg = [0, 1, 0, -90]") == Real4{kRoot, 0, -kRoot, 0});
  CHECK(orientation("axis_angle_deg = [0, 1, 0, 60]")[2] == 0.5);
  CHECK(orientation("axis_angle_deg = [0, 0, 1, 0]") == Real4{1, 0, 0, 0});
  CHECK(orientation("euler_xyz_deg = [90, 0, 0]") == Real4{kRoot, kRoot, 0, 0});
  CHECK(orientation("euler_xyz_deg = [0, 180, 0]") == Real4{0, 0, 1, 0});
  CHECK(orientation("euler_xyz_deg = [90, 90, 0]") == Real4{0.5, 0.5, 0.5, 0.5});
  CHECK(!std::signbit(orientation("axis_angle_deg = [1, 0, 0, 180]")[0]));
  CHECK(orientation("axis_angle_deg = [1e-200, 0, 1e-200, 180]") == Real4{0, kRoot, 0, kRoot});
}

TEST_CASE("degrees agree with radians to the last bit") {
  for (const double degrees : {10.0, 33.3, 45.0, 89.0, 135.0, 271.5, -12.25}) {
    const long double half = static_cast<long double>(degrees) * 3.14159265358979323846264338327950288L / 360;
    Real4 expected{static_cast<double>(std::cos(half)), 0, static_cast<double>(std::sin(half)), 0};
    if (expected[0] < 0) expected[0] = -expected[0], expected[2] = -expected[2];
    const Real4 found = atwood::axis_angle_quaternion({0, 3, 0}, degrees);
    INFO(degrees);
    CHECK(std::abs(found[0] - expected[0]) <= 1.2e-16);
    CHECK(std::abs(found[2] - expected[2]) <= 1.2e-16);
  }
}

TEST_CASE("euler_xyz_deg is intrinsic x-y'-z''") {
  const Real4 q = atwood::euler_xyz_quaternion({20, 30, 40});
  const double d = std::acos(-1.0) / 180;
  const Real3 z = turned(q, {0, 0, 1});  // Rx Ry z: the last turn leaves the body's z
  CHECK(z[0] == Approx(std::sin(30 * d)));
  CHECK(z[1] == Approx(-std::sin(20 * d) * std::cos(30 * d)));
  CHECK(z[2] == Approx(std::cos(20 * d) * std::cos(30 * d)));
  CHECK(turned(q, {1, 0, 0})[0] == Approx(std::cos(30 * d) * std::cos(40 * d)));
}

TEST_CASE("one orientation a body, of a shape that is named") {
  const auto error = [](const std::string& keys) {
    return message(kHead + "[[body]]\nname = \"b\"\nmass_kg = 1\n" + keys);
  };
  CHECK_THAT(
      error("orientation_wxyz = [1, 0, 0, 0]\neuler_xyz_deg = [0, 0, 0]\n"),
      Contains("t.toml:11:1: `euler_xyz_deg` in [[body]] `b` is given beside `orientation_wxyz`; expected one of"));
  CHECK_THAT(error("euler_xyz_deg = [0, 0, 0]\naxis_angle_deg = [0, 0, 1, 0]\n"),
             Contains("11:1") && Contains("beside"));
  CHECK_THAT(error("axis_angle_deg = [0, 0, 0, 90]\n"), Contains("expected an axis that is not 0"));
  CHECK_THAT(error("axis_angle_deg = [0, 0, 1]\n"), Contains("expected { axis = [x, y, z], angle_deg = ... } or"));
  CHECK_THAT(error("axis_angle_deg = { axis = [0, 0, 1], angle = 90 }\n"),
             Contains("unknown key `angle`") && Contains("angle_deg"));
  CHECK_THAT(error("axis_angle_deg = [0, 0, 1, nan]\n"), Contains("a finite number"));
  CHECK_THAT(
      message(kHead + "[[body]]\nname = \"p\"\nshape.plane = { normal = [0, 0, 1] }\neuler_xyz_deg = [0, 0, 0]\n"),
      Contains("is given for a plane"));
  CHECK_THAT(
      error("shape.compound.boxes = [{ half_extents_m = [1, 1, 1], euler_xyz_deg = [0, 0, 0], axis_angle_deg = [0, "
            "0, 1, 0] }]\n"),
      Contains("is given beside `euler_xyz_deg`"));
}

TEST_CASE("unit vectors of three digits are normalised with a note, of nine in silence") {
  const auto plane = [](const std::string& normal) {
    return read(kHead + "[[body]]\nname = \"p\"\nshape.plane = { normal = " + normal + " }\n");
  };
  const auto rough = plane("[0.577, 0.577, 0.577]");
  const Real3 n = std::get<atwood::Plane>(rough.scene.bodies.front().shape).normal;
  CHECK(std::abs(std::hypot(n[0], n[1], n[2]) - 1) < 1e-15);
  REQUIRE(rough.notes.size() == 1);
  CHECK_THAT(rough.notes.front(), Contains("t.toml:9:26: `normal` in shape plane of [[body]] `p` has length 0.99939") &&
                                      Contains("; it was normalised"));
  CHECK(plane("[0.5773502692, 0.5773502692, 0.5773502692]").notes.empty());
  CHECK_THAT(message(kHead + "[[body]]\nname = \"p\"\nshape.plane = { normal = [0.57, 0.57, 0.57] }\n"),
             Contains("has length 0.98726") && Contains("of length 1 (a deviation up to 1e-3 is normalised)"));
  const auto turned = read(kHead + "[[body]]\nname = \"b\"\nmass_kg = 1\norientation_wxyz = [0.7071, 0.7071, 0, 0]\n");
  CHECK(turned.notes.size() == 1);
  // What engines read is the normalised one, and reading it again changes no bit.
  const atwood::Scene again = atwood::scene_from_json(atwood::scene_to_json(turned.scene));
  CHECK(again.bodies.front().orientation_wxyz == turned.scene.bodies.front().orientation_wxyz);
}

TEST_CASE("`body` and `bodies` mean the same, and a grid's body all its copies") {
  const auto drag = [](const std::string& key) {
    const auto scene = read(grid_scene("kind = \"drag\"\nmodel = \"linear\"\ncoefficient_kg_per_s = 1\n" + key)).scene;
    return std::get<atwood::LinearDrag>(scene.forces.at(0)).bodies;
  };
  CHECK(drag("bodies = [\"ball\"]\n") == std::vector<int>{0, 1, 2, 3});
  CHECK(drag("bodies = \"ball\"\n") == std::vector<int>{0, 1, 2, 3});
  CHECK(drag("body = \"ball\"\n") == std::vector<int>{0, 1, 2, 3});
  CHECK(drag("body = \"lone\"\n") == std::vector<int>{4});
  CHECK(drag("body = [\"lone\", \"ball.1.0.0\"]\n") == std::vector<int>{4, 2});
  CHECK(drag("bodies = \"all\"\n") == std::vector<int>{0, 1, 2, 3, 4});
  const auto thrusters = [](const std::string& key) {
    const auto scene = read(grid_scene("kind = \"thruster\"\nthrust_N = 1\ndirection_body = [0, 0, 1]\n" + key)).scene;
    std::vector<int> bodies;
    for (const atwood::Force& force : scene.forces) bodies.push_back(std::get<atwood::Thruster>(force).body);
    return bodies;
  };
  CHECK(thrusters("body = \"lone\"\n") == std::vector<int>{4});
  CHECK(thrusters("bodies = [\"lone\"]\n") == std::vector<int>{4});
  CHECK(thrusters("body = \"ball\"\n") == std::vector<int>{0, 1, 2, 3});
  CHECK(thrusters("bodies = [\"lone\", \"ball.0.0.1\"]\n") == std::vector<int>{4, 1});
  const auto error = [](const std::string& key) {
    return message(grid_scene("kind = \"point-force\"\nforce_N = [1, 0, 0]\n" + key));
  };
  CHECK_THAT(error("body = \"lone\"\nbodies = \"lone\"\n"), Contains("is given beside `body`"));
  CHECK_THAT(error("bodies = [\"ball\", \"ball.0.0.0\"]\n"), Contains("each body once"));
  CHECK_THAT(error("body = \"bal\"\n"), Contains("the name of a body"));
  CHECK_THAT(error("bodies = [\"bal\"]\n"), Contains("(did you mean ball?)"));
  CHECK_THAT(error(""), Contains("missing key `body`"));
}
