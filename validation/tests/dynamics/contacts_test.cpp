// Gaps of balls to walls, and impacts with friction, by hand.
#include <catch2/catch.hpp>

#include "dynamics/arithmetic.hpp"
#include "dynamics/contacts.hpp"

using namespace atwood;
using namespace atwood::dynamics;

namespace {

double narrow(Wide x) { return static_cast<double>(x); }

// A ball of 2 kg and radius 1/2 (I = 0.2) beside a fixed body.
Scene beside(Shape shape, Real3 p, double e = 0, double mu = 0) {
  Scene scene;
  scene.materials = {{"all", e, mu, 0}};
  scene.pairs = {{0, 0, e, mu, 0}};
  Body wall, ball;
  wall.name = "wall";
  wall.fixed = true;
  wall.shape = std::move(shape);
  ball.name = "ball";
  ball.mass_kg = 2;
  ball.shape = Sphere{0.5};
  ball.inertia_kg_m2 = {0.2, 0, 0, 0, 0.2, 0, 0, 0, 0.2};
  ball.position_m = p;
  scene.bodies = {wall, ball};
  return scene;
}

Gap<Wide> gap_of(const Scene& scene) {
  return gap(scene, layout(scene), contact_pairs(scene).pairs.at(0), pack<Wide>(scene).data());
}

void check3(const std::array<Wide, 3>& is, Real3 should) {
  for (int k = 0; k < 3; ++k) CHECK(narrow(is[k]) == Approx(should[k]).margin(1e-15));
}

struct Struck {
  std::vector<Wide> y;
  Impulse<Wide> impulse;
};
Struck struck(const Scene& scene) {
  Struck made{pack<Wide>(scene), {}};
  made.impulse = apply_impact_law(scene, layout(scene), contact_pairs(scene).pairs.at(0), made.y.data());
  return made;
}

}  // namespace

TEST_CASE("a ball over the face, the edge and the corner of a box") {
  const Box box{{1, 2, 3}};
  Gap<Wide> at = gap_of(beside(box, {0.5, -1, 4}));
  CHECK(narrow(at.gap_m) == 0.5);
  check3(at.normal, {0, 0, 1});
  check3(at.x_m, {0.5, -1, 3.25});
  at = gap_of(beside(box, {4, 0, 7}));  // 3-4-5 from the edge x = 1, z = 3
  CHECK(narrow(at.gap_m) == 4.5);
  check3(at.normal, {0.6, 0, 0.8});
  at = gap_of(beside(box, {1.25, 2.5, 3.5}));  // a quarter of (1, 2, 2) from the corner: distance 3/4
  CHECK(narrow(at.gap_m) == 0.25);
  check3(at.normal, {1.0 / 3, 2.0 / 3, 2.0 / 3});
  at = gap_of(beside(box, {-0.75, 0, 0}));  // the centre within: out through the nearest face
  CHECK(narrow(at.gap_m) == -0.75);
  check3(at.normal, {-1, 0, 0});
}

TEST_CASE("both sides of a rectangle, its edge, and the turned one") {
  const Rectangle plate{{1, 2}};
  check3(gap_of(beside(plate, {0.5, 1, 2})).normal, {0, 0, 1});
  Gap<Wide> at = gap_of(beside(plate, {0.5, 1, -2}));
  CHECK(narrow(at.gap_m) == 1.5);
  check3(at.normal, {0, 0, -1});
  CHECK(narrow(gap_of(beside(plate, {4, 0, 4})).gap_m) == 4.5);
  CHECK(narrow(gap_of(beside(plate, {0, 0, 0})).gap_m) == -0.5);
  Scene turned = beside(plate, {3, 0.5, 0});  // a quarter turn about y: the normal is +x
  turned.bodies[0].orientation_wxyz = {std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  turned.bodies[0].position_m = {1, 0, 0};
  at = gap_of(turned);
  CHECK(narrow(at.gap_m) == Approx(1.5));
  check3(at.normal, {1, 0, 0});
}

TEST_CASE("friction that slips: mu J against the slip, and the spin that it gives") {
  // v = (4, 0, -3), e = 1/3: J = 2 (4/3) 3 = 8; mu J = 0.8 < 4 / (1/2 + 1/4 / 0.2) = 16/7.
  Scene scene = beside(Plane{}, {0, 0, 0.5}, 1.0 / 3, 0.1);
  scene.bodies[1].velocity_m_per_s = {4, 0, -3};
  const Struck hit = struck(scene);
  CHECK(narrow(hit.impulse.normal_N_s) == Approx(8));
  CHECK(narrow(hit.impulse.tangential_N_s) == Approx(0.8));
  CHECK(narrow(hit.y[3]) == Approx(4 - 0.4));
  CHECK(narrow(hit.y[5]) == Approx(1));
  CHECK(narrow(hit.y[11]) == Approx(0.5 * 0.8 / 0.2));  // w_y = r J / I: it starts to roll along +x
  CHECK(narrow(hit.y[10]) == Approx(0).margin(1e-15));
}

TEST_CASE("friction that sticks: the slip ends, whatever the spin, also on a turned ball") {
  Scene scene = beside(Plane{}, {0, 0, 0.5}, 0.5, 10);
  scene.bodies[1].velocity_m_per_s = {4, 1, -3};
  scene.bodies[1].orientation_wxyz = {0.5, 0.5, -0.5, 0.5};
  scene.bodies[1].angular_velocity_body_rad_per_s = {3, -2, 7};
  const ContactPair pair = contact_pairs(scene).pairs.at(0);
  const Layout map = layout(scene);
  const std::vector<Wide> before = pack<Wide>(scene);
  const std::array<Wide, 3> sliding = slip(scene, map, pair, before.data());
  CHECK(narrow(dot(sliding, sliding)) > 1);
  const Struck hit = struck(scene);
  const std::array<Wide, 3> after = slip(scene, map, pair, hit.y.data());
  CHECK(narrow(dot(after, after)) < 1e-60);
  // Angular momentum about the point of contact passes through unchanged: m p x v + R I w.
  const auto about = [&](const std::vector<Wide>& y) {
    std::array<Wide, 4> q{y[6], y[7], y[8], y[9]};
    return Wide(2) * cross(std::array<Wide, 3>{0, 0, 0.5}, read3(&y[3])) + Wide(0.2) * rotate(q, read3(&y[10]));
  };
  for (int k = 0; k < 3; ++k) CHECK(narrow(about(hit.y)[k]) == Approx(narrow(about(before)[k])).margin(1e-15));
}

TEST_CASE("two rough balls: momentum passes over, energy only falls, the slip keeps its direction") {
  Scene scene = beside(Sphere{0.25}, {0.6, 0.4499999, 0}, 0.8, 0.1);
  scene.bodies[0].fixed = false;
  scene.bodies[0].mass_kg = 1;
  scene.bodies[0].inertia_kg_m2 = {0.025, 0, 0, 0, 0.025, 0, 0, 0, 0.025};
  scene.bodies[0].velocity_m_per_s = {2, 1, 0.5};
  scene.bodies[0].angular_velocity_body_rad_per_s = {0, 4, 9};
  scene.bodies[1].angular_velocity_body_rad_per_s = {1, -3, 2};
  const ContactPair pair = contact_pairs(scene).pairs.at(0);
  const Layout map = layout(scene);
  const std::vector<Wide> before = pack<Wide>(scene);
  const Struck hit = struck(scene);
  CHECK(narrow(hit.impulse.tangential_N_s) == Approx(0.1 * narrow(hit.impulse.normal_N_s)));
  for (int k = 0; k < 3; ++k)
    CHECK(narrow(hit.y[6 + k] + 2 * hit.y[9 + k]) == Approx(narrow(before[6 + k] + 2 * before[9 + k])).margin(1e-15));
  const auto a = slip(scene, map, pair, before.data()), b = slip(scene, map, pair, hit.y.data());
  CHECK(narrow(dot(a, b)) > 0);
  CHECK(narrow(dot(cross(a, b), cross(a, b))) < 1e-50);
}

TEST_CASE("possible contacts without a list of all pairs; friction that is not covered") {
  Scene scene = beside(Plane{}, {0, 0, 2}, 0, 0.5);
  CHECK(contacts_possible(scene));
  CHECK(impact_unsupported(scene, contact_pairs(scene).pairs.at(0)).empty());
  scene.bodies[1].inertia_kg_m2[0] = 0.3;
  CHECK(impact_unsupported(scene, contact_pairs(scene).pairs.at(0)).find("`ball`") != std::string::npos);
  scene.bodies[1].fixed = true;
  CHECK_FALSE(contacts_possible(scene));
  CHECK_FALSE(has_gap(beside(Capsule{1, 2}, {0, 0, 9}), {0, 1, 0, 0}));
}
