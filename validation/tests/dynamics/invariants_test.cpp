#include "dynamics/invariants.hpp"

#include <catch2/catch.hpp>

#include "dynamics/contacts.hpp"
#include "dynamics/state.hpp"
#include "force_scenes.hpp"

using namespace atwood;
using namespace atwood::dynamics;

namespace {

Sample initial(const Scene& scene) { return unpack<Wide>(scene, Wide(0), pack<Wide>(scene).data()); }
double narrow(Wide value) { return static_cast<double>(value); }

Scene two_points() {
  Scene scene = force_scenes::bodies(2, false);
  scene.bodies[0].mass_kg = 2;
  scene.bodies[1].mass_kg = 3;
  scene.bodies[0].position_m = {0, 0, 0};
  scene.bodies[1].position_m = {3, 4, 0};
  scene.bodies[0].velocity_m_per_s = {1, 0, 0};
  scene.bodies[1].velocity_m_per_s = {0, 2, 0};
  scene.bodies[0].charge_C = 2;
  scene.bodies[1].charge_C = -1;
  return scene;
}

}  // namespace

TEST_CASE("energies agree with values derived by hand") {
  Scene scene = two_points();
  CHECK(narrow(energy(scene, initial(scene)).kinetic_J) == 7);  // 1/2 2 1 + 1/2 3 4
  CHECK(narrow(energy(scene, initial(scene)).potential_J) == 0);
  SECTION("gravity: m g h") {
    scene.gravity_m_per_s2 = {0, -10, 0};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == 120);
  }
  SECTION("mutual gravity: -G m1 m2 / r, r = 5") {
    scene.forces = {MutualGravity{{0, 1}, 10, 0}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == -12);
  }
  SECTION("softened: r^2 + 12^2 = 13^2") {
    scene.forces = {MutualGravity{{0, 1}, 13, 12}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == -6);
  }
  SECTION("attractor: -mu m / r") {
    scene.forces = {Attractor{{1}, {0, 0, 0}, 10}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == -6);
  }
  SECTION("spring: 1/2 k (5 - 3)^2") {
    scene.forces = {Spring{{0, 1}, {0, 0, 0}, 7, 0, 3, {}}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == 14);
  }
  SECTION("Coulomb: k q1 q2 / r") {
    scene.forces = {Coulomb{{0, 1}, 10}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == -4);
  }
  SECTION("electric field: -q E . r") {
    scene.forces = {Lorentz{{0, 1}, {1, 1, 0}, {0, 0, 9}}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == 7);
  }
  SECTION("rotating frame: -1/2 m W^2 r^2 = -1/2 3 4 25") {
    scene.forces = {RotatingFrame{{0, 0, 2}}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == -150);
    CHECK(conserves(scene, "jacobi-constant"));
  }
  SECTION("Henon and Heiles at (3, 4): 25/2 + 36 - 64/3") {
    scene.forces = {Potential{{1}, "henon-heiles", {}}};
    CHECK(narrow(energy(scene, initial(scene)).potential_J) == Approx(163.0 / 6).epsilon(1e-15));
  }
  SECTION("rotation: 1/2 w I w") {
    Scene top = force_scenes::bodies(1, true);
    top.bodies[0].velocity_m_per_s = {0, 0, 0};
    top.bodies[0].angular_velocity_body_rad_per_s = {1, 2, 3};
    CHECK(narrow(energy(top, initial(top)).kinetic_J) == Approx(0.3 + 1.6 + 4.5).epsilon(1e-15));
  }
}

TEST_CASE("momenta and centre of mass agree with values derived by hand") {
  const Scene scene = two_points();
  const Sample at = initial(scene);
  CHECK(narrow(momentum(scene, at)[0]) == 2);
  CHECK(narrow(momentum(scene, at)[1]) == 6);
  CHECK(narrow(angular_momentum(scene, at)[2]) == 18);  // 3 (3 * 2)
  CHECK(narrow(center_of_mass(scene, at)[0]) == Approx(1.8));
  CHECK(narrow(center_of_mass(scene, at)[1]) == Approx(2.4));
  // reduced mass 6/5, r = (3, 4), u = (-1, 2): 6/5 (3 * 2 + 4) = 12
  CHECK(narrow(angular_momentum_about_center(scene, at)[2]) == Approx(12).epsilon(1e-15));
}

TEST_CASE("spin is turned into world axes") {
  Scene top = force_scenes::bodies(1, true);
  top.bodies[0].position_m = {0, 0, 0};
  top.bodies[0].orientation_wxyz = {0.5, 0.5, 0.5, 0.5};  // x -> y
  top.bodies[0].angular_velocity_body_rad_per_s = {2, 0, 0};
  const Wide3 L = angular_momentum(top, initial(top));
  CHECK(narrow(L[0]) == Approx(0).margin(1e-16));
  CHECK(narrow(L[1]) == Approx(1.2).epsilon(1e-15));
}

TEST_CASE("Laplace-Runge-Lenz of a perihelion is mu e along x") {
  Scene scene = force_scenes::bodies(1, false);
  scene.bodies[0].position_m = {0.4, 0, 0};
  scene.bodies[0].velocity_m_per_s = {0, 2, 0};
  scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
  const Wide3 A = laplace_runge_lenz(scene, initial(scene), 0);
  CHECK(narrow(A[0]) == Approx(0.6).epsilon(1e-15));
  CHECK(narrow(A[1]) == 0);
  CHECK(conserves(scene, "laplace-runge-lenz"));
  scene.forces.push_back(Attractor{{0}, {1, 0, 0}, 1});
  CHECK_FALSE(conserves(scene, "laplace-runge-lenz"));
}

TEST_CASE("magnetic moment leaves the drift out") {
  Scene scene = force_scenes::bodies(1, false);
  scene.bodies[0].mass_kg = 2;
  scene.bodies[0].velocity_m_per_s = {5, 0, 7};
  scene.forces = {Lorentz{{0}, {0, 4, 0}, {0, 0, 2}}};  // drift E x B / B^2 = (2, 0, 0): m 3^2 / (2 2)
  CHECK(narrow(magnetic_moment(scene, initial(scene), 0)) == 4.5);
  CHECK(conserves(scene, "magnetic-moment"));
}

TEST_CASE("conserved quantities of each force") {
  Scene scene = two_points();
  CHECK(conserves(scene, "momentum"));
  scene.forces = {MutualGravity{{0, 1}, 1, 0}};
  for (const char* kept :
       {"energy", "momentum", "angular-momentum", "angular-momentum-center", "center-of-mass", "laplace-runge-lenz"})
    CHECK(conserves(scene, kept));
  scene.bodies[0].fixed = true;
  CHECK(conserves(scene, "energy"));
  CHECK_FALSE(conserves(scene, "momentum"));
  scene.bodies[0].fixed = false;
  scene.gravity_m_per_s2 = {0, 0, -1};
  CHECK_FALSE(conserves(scene, "momentum"));
  CHECK(conserves(scene, "angular-momentum-center"));
  scene.forces.push_back(LinearDrag{{0}, 0.1, {0, 0, 0}, 0});
  CHECK_FALSE(conserves(scene, "energy"));
  CHECK_FALSE(conserves(scene, "entropy"));
}

TEST_CASE("a smooth impact of unequal spheres agrees with values derived by hand") {
  Scene scene = two_points();  // masses 2 and 3, along (3, 4) / 5
  scene.bodies[0].shape = Sphere{2};
  scene.bodies[1].shape = Sphere{3};
  scene.bodies[0].velocity_m_per_s = {3, 4, 0};
  scene.bodies[1].velocity_m_per_s = {0, 0, 0};
  scene.pairs[0].restitution = 0.5;
  const ContactPairs pairs = contact_pairs(scene);
  REQUIRE(pairs.pairs.size() == 1);
  std::vector<Wide> y = pack<Wide>(scene);
  const Layout map = layout(scene);
  const Gap<Wide> touching = gap(scene, map, pairs.pairs[0], y.data());
  CHECK(narrow(touching.gap_m) == Approx(0).margin(1e-30));
  CHECK(narrow(touching.rate_m_per_s) == -5);
  CHECK(narrow(touching.x_m[0]) == Approx(1.2).epsilon(1e-15));
  CHECK(narrow(apply_impact_law(scene, map, pairs.pairs[0], y.data()).normal_N_s) ==
        Approx(9).epsilon(1e-15));  // 1.5 * 5 * 6/5
  CHECK(narrow(gap(scene, map, pairs.pairs[0], y.data()).rate_m_per_s) == Approx(2.5).epsilon(1e-15));
  CHECK(narrow(apply_impact_law(scene, map, pairs.pairs[0], y.data()).normal_N_s) == 0);  // apart already
  CHECK_FALSE(conserves(scene, "energy"));
  CHECK(conserves(scene, "momentum"));
}
