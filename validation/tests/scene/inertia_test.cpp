// Inertia from shapes against the tables of any textbook, and polyhedra against the shapes they are.
#include "scene/inertia.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "text.hpp"

using namespace atwood;
using namespace scene_test;

namespace {

void require_diagonal(const Real33& found, double x, double y, double z) {
  const Real33 expected{x, 0, 0, 0, y, 0, 0, 0, z};
  const double size = x + y + z;
  for (std::size_t i = 0; i < 9; ++i) {
    INFO("entry " << i << ": " << found[i] << " against " << expected[i]);
    REQUIRE(std::abs(found[i] - expected[i]) <= 4e-15 * size);
  }
}

const double kPi = std::numbers::pi;

}  // namespace

TEST_CASE("inertia of solid shapes, by hand") {
  require_diagonal(read_body("mass_kg = 5\nshape.sphere.radius_m = 2\n").inertia_kg_m2, 8, 8, 8);
  // 10 kg, 0.1 x 0.4 x 0.9 m: m / 12 (b^2 + c^2).
  require_diagonal(read_body("mass_kg = 10\nshape.box.half_extents_m = [0.05, 0.2, 0.45]\n").inertia_kg_m2,
                   10 * 0.97 / 12, 10 * 0.82 / 12, 10 * 0.17 / 12);
  require_diagonal(read_body("mass_kg = 12\nshape.rectangle.half_extents_m = [1, 2]\n").inertia_kg_m2, 16, 4, 20);
  // m r^2 / 2 about the axis, m (3 r^2 + (2 h)^2) / 12 across.
  require_diagonal(read_body("mass_kg = 12\nshape.cylinder = { radius_m = 1, half_length_m = 2 }\n").inertia_kg_m2, 19,
                   19, 6);
}

TEST_CASE("a capsule is a cylinder and two half balls") {
  // r = 1, h = 1: volumes 2 pi and 4 pi / 3, so of 10 kg 6 are the tube and 4 the balls.
  const Body capsule = read_body("mass_kg = 10\nshape.capsule = { radius_m = 1, half_length_m = 1 }\n");
  const double across = 6 * (3 + 4) / 12.0 + 4 * (2.0 / 5 + 1 + 3.0 / 4);
  require_diagonal(capsule.inertia_kg_m2, across, across, 6 / 2.0 + 4 * 2.0 / 5);
  // Without a straight part it is nearly a ball.
  const Body ball = read_body("mass_kg = 5\nshape.capsule = { radius_m = 1, half_length_m = 1e-17 }\n");
  require_diagonal(ball.inertia_kg_m2, 2, 2, 2);
}

TEST_CASE("a mass follows from a density") {
  REQUIRE(read_body("density_kg_per_m3 = 3\nshape.box.half_extents_m = [0.5, 1, 1.5]\n").mass_kg ==
          Approx(18).epsilon(1e-15));
  REQUIRE(read_body("density_kg_per_m3 = 3\nshape.sphere.radius_m = 1\n").mass_kg == Approx(4 * kPi).epsilon(1e-15));
  REQUIRE(read_body("density_kg_per_m3 = 1\nshape.cylinder = { radius_m = 2, half_length_m = 1 }\n").mass_kg ==
          Approx(8 * kPi).epsilon(1e-15));
  REQUIRE(read_body("density_kg_per_m3 = 1\nshape.capsule = { radius_m = 1, half_length_m = 1 }\n").mass_kg ==
          Approx(10 * kPi / 3).epsilon(1e-15));
}

TEST_CASE("the hull of a box's corners has the box's inertia, with points inside and on its faces") {
  std::string points;
  for (const char* x : {"-1", "1"})
    for (const char* y : {"-2", "2"})
      for (const char* z : {"-3", "3"}) points += std::string("[") + x + "," + y + "," + z + "],";
  const Body hull =
      read_body("density_kg_per_m3 = 2\nshape.convex.points_m = [[0,0,0],[1,0,0],[0.5,2,1]," + points + "]\n");
  REQUIRE(hull.mass_kg == Approx(96).epsilon(1e-14));
  require_diagonal(hull.inertia_kg_m2, 96 * 13 / 3.0, 96 * 10 / 3.0, 96 * 5 / 3.0);
}

TEST_CASE("a regular tetrahedron: m a^2 / 20 about any axis") {
  // Edge 2 sqrt 2, so m 8 / 20.
  const Body body = read_body("mass_kg = 5\nshape.convex.points_m = [[1,1,1],[1,-1,-1],[-1,1,-1],[-1,-1,1]]\n");
  require_diagonal(body.inertia_kg_m2, 2, 2, 2);
}

TEST_CASE("two boxes side by side are one box; a turned cube is a cube") {
  const Body pair = read_body(
      "mass_kg = 6\nshape.compound.boxes = [{ half_extents_m = [1,1,1], position_body_m = [1,0,0] },"
      "{ half_extents_m = [1,1,1], position_body_m = [-1,0,0], orientation_wxyz = [0.6, 0, 0.8, 0] }]\n");
  require_diagonal(pair.inertia_kg_m2, 6 * 2 / 3.0, 6 * 5 / 3.0, 6 * 5 / 3.0);
  // A quarter turn about z swaps x and y.
  const Body turned = read_body(
      "mass_kg = 3\nshape.compound.boxes = [{ half_extents_m = [1,2,3], "
      "orientation_wxyz = [0.7071067811865476, 0, 0, 0.7071067811865476] }]\n");
  require_diagonal(turned.inertia_kg_m2, 10, 13, 5);
}

TEST_CASE("a closed mesh has the mass of its solid") {
  const auto folder = std::filesystem::temp_directory_path() / "atwood-scene-test-mesh";
  std::filesystem::create_directories(folder);
  const std::string corners = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
  std::ofstream(folder / "cube.obj")
      << "# cube\n"
      << corners << "f 4 3 2 1\nf 5/1 6/2 7/3 8/4\nf 1//1 2//1 6//1 5//1\nf 2 3 7 6\nf 3 4 8 7\nf -8 -4 -1 -5\n";
  std::ofstream(folder / "open.obj") << corners << "f 4 3 2 1\n";
  std::ofstream(folder / "inside-out.obj")
      << corners << "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 5 1 4 8\n";
  std::ofstream(folder / "broken.obj") << "v 0 0 0\nv 1 0 x\n";
  const auto text = [](const std::string& file) {
    return kHead + "[[body]]\nname = \"b\"\nmass_kg = 3\nshape.mesh.file = \"" + file + "\"\n";
  };
  const Scenario scenario = read(text("cube.obj"), folder.string());
  require_diagonal(scenario.scene.bodies[0].inertia_kg_m2, 2, 2, 2);
  REQUIRE(std::get<Mesh>(scenario.scene.bodies[0].shape).triangles.size() == 12);
  REQUIRE_THAT(message(text("open.obj"), folder.string()),
               Catch::Contains("t.toml:10:1: ") && Catch::Contains("not closed"));
  REQUIRE_THAT(message(text("inside-out.obj"), folder.string()), Catch::Contains("inside out"));
  REQUIRE_THAT(message(text("broken.obj"), folder.string()), Catch::Contains("broken.obj:2:1: found `v 1 0 x`"));
  REQUIRE_THAT(message(text("none.obj"), folder.string()), Catch::StartsWith("t.toml:10:19: `file`"));
  REQUIRE_THAT(message(text("../cube.obj"), folder.string()),
               Catch::StartsWith("t.toml:10:19: `file`") && Catch::Contains("inside the scene's folder"));
  REQUIRE_THAT(message(text("/etc/passwd"), folder.string()), Catch::Contains("inside the scene's folder"));
  std::filesystem::create_symlink("/etc/passwd", folder / "link.obj");
  REQUIRE_THAT(message(text("link.obj"), folder.string()), Catch::Contains("inside the scene's folder"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("principal moments and axes of a full matrix") {
  // Eigenvalues of [[2,1,0],[1,2,0],[0,0,2.5]]: 1, 2.5, 3.
  Real3 moments = diagonalise({2, 1, 0, 1, 2, 0, 0, 0, 2.5}).moments;
  std::sort(moments.begin(), moments.end());
  REQUIRE(moments[0] == Approx(1).epsilon(1e-15));
  REQUIRE(moments[1] == Approx(2.5).epsilon(1e-15));
  REQUIRE(moments[2] == Approx(3).epsilon(1e-15));
  // Also of equal diagonal entries coupled by a negative one, of a needle, and in other units.
  for (const double unit : {1.0, 1e-30, 1e30})
    for (const Real33& m : {Real33{3, -0.5, 0.2, -0.5, 2, 0.1, 0.2, 0.1, 4}, Real33{1, -0.5, 0, -0.5, 1, 0, 0, 0, 2},
                            Real33{1, 1e-12, 0, 1e-12, 1e-18, 1e-20, 0, 1e-20, 1}}) {
      Real33 given = m;
      for (double& x : given) x *= unit;
      const Diagonalised made = diagonalise(given);
      const auto& r = made.axes;
      CHECK(r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                r[2] * (r[3] * r[7] - r[4] * r[6]) ==
            Approx(1).epsilon(1e-15));
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          double sum = 0;
          for (int k = 0; k < 3; ++k) sum += r[3 * i + k] * made.moments[k] * r[3 * j + k];
          CHECK(sum / unit == Approx(m[3 * i + j]).margin(1e-15));
        }
    }
}

TEST_CASE("a needle's small moment is known to its own round-off, a diagonal matrix keeps its bits and order") {
  // [1 1/2; 1/2 1] on the outside; its coupling c = 1e-12 (1, 1) to the small moment takes c^T A^-1 c = 4/3 1e-24 off.
  // By QR iteration that moment is -1.3e-24: a body would be refused that is one.
  const Diagonalised needle = diagonalise({1, 1e-12, 0.5, 1e-12, 1e-20, 1e-12, 0.5, 1e-12, 1});
  CHECK(needle.moments[1] == Approx(1e-20 - 4e-24 / 3).epsilon(1e-14));
  const Diagonalised kept = diagonalise({3, 0, 0, 0, 1, 0, 0, 0, 1.0 / 3});
  CHECK(kept.moments == Real3{3, 1, 1.0 / 3});
  CHECK(kept.axes == Real33{1, 0, 0, 0, 1, 0, 0, 0, 1});
}
