// Files and the resolved scenes made from them.
#include <catch2/catch.hpp>
#include <cmath>

#include "scene/split_mix.hpp"
#include "text.hpp"

using namespace atwood;
using namespace scene_test;

TEST_CASE("SplitMix64 gives its published numbers") {
  // The first outputs for the seed 1234567 (Vigna's reference program).
  SplitMix64 random{1234567};
  for (const std::uint64_t expected :
       {6457827717110365317u, 3203168211198807973u, 9817491932198370423u, 4593380528125082431u, 16408922859458223821u})
    REQUIRE(random.next() == expected);
  SplitMix64 zero{0};
  REQUIRE(zero.next() == 0xe220a8397b1dcdafu);
  REQUIRE(SplitMix64{0}.next_unit() == static_cast<double>(0xe220a8397b1dcdafu >> 11) / 9007199254740992.0);
}

TEST_CASE("ladders") {
  const auto steps = [](const std::string& ladder) {
    return read("id = \"t\"\n[run]\nt_end_s = 1\nsteps = " + ladder +
                "\nsamples = 4\n[[body]]\nname = \"b\"\nmass_kg = 1\n")
        .steps;
  };
  REQUIRE(steps("[4, 8, 32]") == std::vector<std::int64_t>{4, 8, 32});
  REQUIRE(steps("{ from = 64, rungs = 4, ratio = 2 }") == std::vector<std::int64_t>{64, 128, 256, 512});
  REQUIRE(steps("{ from = 4, rungs = 3, ratio = 3 }") == std::vector<std::int64_t>{4, 12, 36});
}

TEST_CASE("pairs of materials: the geometric mean, unless a contact says otherwise") {
  const Scene scene = read(kHead +
                           "[material.wood]\nrestitution = 0.5\nfriction = 0.3\n"
                           "[material.steel]\nrestitution = 0.72\nfriction = 0.2\n"
                           "[[contact]]\nbetween = [\"steel\", \"wood\"]\nrestitution = 0.25\n"
                           "contact_law = \"linear\"\nstiffness_N_per_m = 1000\ndamping_N_s_per_m = 2\npull = true\n"
                           "[[body]]\nname = \"a\"\nmass_kg = 1\nmaterial = \"wood\"\n"
                           "[[body]]\nname = \"b\"\nmass_kg = 1\nmaterial = \"steel\"\n"
                           "[[body]]\nname = \"c\"\nmass_kg = 1\n")
                          .scene;
  REQUIRE(scene.materials.size() == 3);
  REQUIRE(scene.materials[0].name == "default");
  REQUIRE(scene.pairs.size() == 6);
  REQUIRE(pair_law(scene, 0, 1).restitution == 0.25);
  REQUIRE(pair_law(scene, 0, 1).contact_law == ContactLaw::linear);
  REQUIRE(pair_law(scene, 0, 1).stiffness_N_per_m == 1000);
  REQUIRE(pair_law(scene, 0, 1).damping_N_s_per_m == 2);
  REQUIRE(pair_law(scene, 0, 1).pull);
  REQUIRE(pair_law(scene, 0, 0).contact_law == ContactLaw::rigid);
  REQUIRE(pair_law(scene, 1, 0).friction == Approx(std::sqrt(0.06)).epsilon(1e-15));
  REQUIRE(pair_law(scene, 0, 0).restitution == 0.5);  // exactly: no rounding of sqrt(e e)
  REQUIRE(pair_law(scene, 1, 1).friction == 0.2);
  REQUIRE(pair_law(scene, 0, 2).restitution == 0);
}

TEST_CASE("a grid replaces its body, with x as the slowest index and jitter within bounds") {
  const Scene scene =
      read(kHead +
           "[[body]]\nname = \"first\"\nmass_kg = 1\n"
           "[[body]]\nname = \"ball\"\nmass_kg = 2\nposition_m = [1, 2, 3]\nshape.sphere.radius_m = 0.1\n"
           "[[body]]\nname = \"last\"\nmass_kg = 1\n"
           "[[grid]]\nbody = \"ball\"\ncounts = [2, 1, 3]\nspacing_m = [10, 20, 30]\njitter_m = 0.5\nseed = 42\n")
          .scene;
  REQUIRE(scene.bodies.size() == 8);
  REQUIRE(scene.bodies[1].name == "ball.0.0.0");
  REQUIRE(scene.bodies[2].name == "ball.0.0.1");
  REQUIRE(scene.bodies[4].name == "ball.1.0.0");
  REQUIRE(scene.bodies[7].name == "last");
  SplitMix64 random{42};
  for (int n = 0; n < 6; ++n) {
    const Body& ball = scene.bodies[static_cast<std::size_t>(n) + 1];
    const Real3 grid{1 + 10.0 * (n / 3), 2, 3 + 30.0 * (n % 3)};
    for (std::size_t axis = 0; axis < 3; ++axis)
      REQUIRE(ball.position_m[axis] == grid[axis] + 0.5 * (2 * random.next_unit() - 1));
    REQUIRE(ball.inertia_kg_m2 == scene.bodies[1].inertia_kg_m2);
  }
}

TEST_CASE("\"all\" means bodies that are not fixed; fixed charges count for coulomb") {
  const Scene scene =
      read(kHead +
           "[[body]]\nname = \"floor\"\nshape.plane.normal = [0, 0, 1]\n"
           "[[body]]\nname = \"a\"\nmass_kg = 1\ncharge_C = 1\n"
           "[[body]]\nname = \"nail\"\nfixed = true\ncharge_C = 1\n"
           "[[force]]\nkind = \"drag\"\nmodel = \"linear\"\nbodies = \"all\"\ncoefficient_kg_per_s = 1\n"
           "[[force]]\nkind = \"coulomb\"\nbodies = \"all\"\nconstant_N_m2_per_C2 = 1\n"
           "[[force]]\nkind = \"coulomb\"\nbodies = [\"nail\", \"a\"]\nconstant_N_m2_per_C2 = 1\n")
          .scene;
  REQUIRE(scene.bodies[0].fixed);
  REQUIRE(std::get<LinearDrag>(scene.forces[0]).bodies == std::vector<int>{1});
  REQUIRE(std::get<Coulomb>(scene.forces[1]).bodies == std::vector<int>{1, 2});
  REQUIRE(std::get<Coulomb>(scene.forces[2]).bodies == std::vector<int>{2, 1});
}

TEST_CASE("inertia in its three spellings; a near unit quaternion is normalised") {
  const Real33 diagonal{1, 0, 0, 0, 2, 0, 0, 0, 2.5};
  REQUIRE(read_body("mass_kg = 1\ninertia_kg_m2 = [1, 2, 2.5]\n").inertia_kg_m2 == diagonal);
  REQUIRE(read_body("mass_kg = 1\ninertia_kg_m2 = [[1, 0, 0], [0, 2, 0], [0, 0, 2.5]]\n").inertia_kg_m2 == diagonal);
  REQUIRE(read_body("mass_kg = 1\ninertia_kg_m2 = [1, 0, 0, 0, 2, 0, 0, 0, 2.5]\n").inertia_kg_m2 == diagonal);
  const Real4 q = read_body("mass_kg = 1\norientation_wxyz = [0.7071067812, 0, 0.7071067812, 0]\n").orientation_wxyz;
  REQUIRE(std::abs(q[0] * q[0] + q[2] * q[2] - 1) < 4e-16);
  REQUIRE(q[0] == Approx(std::sqrt(0.5)).epsilon(1e-15));
}

TEST_CASE("a spring gets a point on each body; the lorenz problem gets its body") {
  const Scene scene =
      read(kHead +
           "[[body]]\nname = \"a\"\nmass_kg = 1\n[[body]]\nname = \"b\"\nmass_kg = 1\nposition_m = [1, 0, 0]\n"
           "[[force]]\nkind = \"spring\"\nbodies = [\"a\", \"b\"]\nstiffness_N_per_m = 3\n")
          .scene;
  REQUIRE(std::get<Spring>(scene.forces[0]).points_body_m == std::vector<Real3>(2));
  const Scene lorenz = read("problem = \"lorenz\"\n" + kHead).scene;
  REQUIRE(lorenz.bodies.size() == 1);
  REQUIRE(lorenz.bodies[0].name == "lorenz");
  REQUIRE(lorenz.bodies[0].position_m == Real3{1, 0, 0});
  REQUIRE(lorenz.bodies[0].velocity_m_per_s == Real3{-10, 28, 0});
}
