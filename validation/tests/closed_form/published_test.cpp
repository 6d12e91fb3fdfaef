// Reference values: certified in quad by two other methods, or published.
#include <catch2/catch.hpp>

#include "closed_form/elliptic.hpp"
#include "scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

double distance(Wide value, const char* kDigits) { return static_cast<double>(fabsq(value - quad(kDigits))); }

}  // namespace

TEST_CASE("Kepler, e = 0.6, at t = 10 and 50") {
  for (const auto& [t, kDigits] : std::vector<std::pair<double, std::vector<const char*>>>{
           {10,
            {"-1.53502359190981369430580688531817", "-2.83668406499780861856428531945996e-01",
             "2.27150732077498337689395655190845e-01", "-4.79187758203219565290706789039627e-01"}},
           {50,
            {"2.20545956874554525182553205364045e-01", "-4.57264445261564034744519106076833e-01",
             "1.12588458116767934159900916229862", "1.29303214443426760043341254601242"}}}) {
    // The digits are of exact decimals; the double nearest to 0.4 is not 0.4. The neighbouring double tells how the end
    // depends on it: what is left after that first order is (1e-14)^2.
    Scenario given = scenario("kepler", t);
    given.scene.bodies = {point("planet", 1, {0.4, 0, 0}, {0, 2, 0})};
    given.scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
    const Truth truth = closed_form_truth(given, 4);
    REQUIRE(truth.outcome.reason == "");
    const double neighbour = std::nextafter(0.4, 1);
    given.scene.bodies[0].position_m[0] = neighbour;
    const BodySample end = truth.values.back().bodies[0], near = closed_form_truth(given, 4).values.back().bodies[0];
    const Wide share = (Wide(0.4) - quad("0.4")) / (Wide(neighbour) - Wide(0.4));
    for (int k = 0; k < 2; ++k) {
      CHECK(distance(end.p_m[k] - share * (near.p_m[k] - end.p_m[k]), kDigits[k]) < 1e-25);
      CHECK(distance(end.v_m_per_s[k] - share * (near.v_m_per_s[k] - end.v_m_per_s[k]), kDigits[2 + k]) < 1e-25);
    }
    CHECK(truth.bars.back().bodies[0].p_m[0] > 0);
    CHECK(static_cast<double>(truth.bars.back().bodies[0].p_m[0]) < 1e-28);
  }
}

TEST_CASE("Kepler's orbit from exact doubles, e = 1/2: twice the formula of textbooks") {
  // r0 = 1/2, v0^2 = 3: sqrt(3) is not a double, so mu is chosen: v0 = 1.5, mu = v0^2 r0 / (1 + e) = 0.75, a = 1.
  Scenario given = scenario("kepler", 37);
  given.scene.bodies = {point("planet", 1, {0.5, 0, 0}, {0, 1.5, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, 0.75}};
  const Truth truth = closed_form_truth(given, 16);
  for (const SampleView sample : truth.values) {
    const Wide M = sqrtq(Wide(0.75)) * sample.t_s;
    Wide E = M;
    for (int k = 0; k < 60; ++k) E -= (E - Wide(0.5) * sinq(E) - M) / (1 - Wide(0.5) * cosq(E));
    CHECK(static_cast<double>(fabsq(sample.bodies[0].p_m[0] - (cosq(E) - Wide(0.5)))) < 1e-30);
    CHECK(static_cast<double>(fabsq(sample.bodies[0].p_m[1] - sqrtq(Wide(0.75)) * sinq(E))) < 1e-30);
  }
}

TEST_CASE("Dzhanibekov's top and the asymmetric top: certified digits") {
  // Decimals are rounded to double in the scene; the flow of the first magnifies that 1e4 fold.
  Scenario given = scenario("free-rigid-body", 10);
  given.scene.bodies = {solid("top", 1, {0.6, 0.8, 1.0}, {3, 0.5, -0.9})};
  const BodySample end = closed_form_truth(given, 8).values.back().bodies[0];
  CHECK(distance(Wide(0.6) * end.w_rad_per_s[0], "1.7659625085182075357271504818409") < 3e-15);
  CHECK(distance(Wide(0.8) * end.w_rad_per_s[1], "-6.9546419703308911949949275682166e-01") < 3e-15);
  CHECK(distance(end.w_rad_per_s[2], "7.7955498148187108610074177384983e-01") < 3e-15);
  const char* q[] = {"-7.3606136416079393616124114735656e-01", "-5.7078695124035073325462124618645e-01",
                     "-2.9938857183079009374376694332244e-01", "-2.0683908610467319248311710810332e-01"};
  for (int k = 0; k < 4; ++k) CHECK(distance(end.q_wxyz[k], q[k]) < 3e-15);

  Scenario flips = scenario("free-rigid-body", 100);
  flips.scene.bodies = {solid("wing nut", 1, {0.6, 0.8, 1.0}, {1e-3, 1, 1e-3})};
  const BodySample after = closed_form_truth(flips, 8).values.back().bodies[0];
  const char* L[] = {"4.8774388842437116514871015263340e-01", "-7.4944589391978066138928082014664e-02",
                     "6.2967496998494578913387500580013e-01"};
  const Wide I[] = {0.6, 0.8, 1.0};
  for (int k = 0; k < 3; ++k) CHECK(distance(I[k] * after.w_rad_per_s[k], L[k]) < 1e-12);
  const char* attitude[] = {"-8.5270054075037232961331964778310e-03", "-4.4560711881034979251247779442337e-01",
                            "-6.7258048099517914818112445354431e-01", "-5.9075975017651013548023289843188e-01"};
  for (int k = 0; k < 4; ++k) CHECK(distance(after.q_wxyz[k], attitude[k]) < 1e-12);
}

TEST_CASE("The tumbling box of the public benchmark at t = 10, near the separatrix") {
  Scenario given = scenario("free-rigid-body", 10);
  const double m = 10, a = 0.1, b = 0.4, c = 0.9;
  given.scene.bodies = {
      solid("box", m, {m / 12 * (b * b + c * c), m / 12 * (a * a + c * c), m / 12 * (a * a + b * b)}, {0.1, 5, 0.1})};
  given.scene.bodies[0].velocity_m_per_s = {-2, 2, 8};
  given.scene.gravity_m_per_s2 = {0, 0, -9.8};
  const Truth truth = closed_form_truth(given, 10);
  const BodySample& end = truth.values.back().bodies[0];
  const char* w[] = {"2.75584040514685", "-3.73596351921622", "-3.16180900346752"};
  const char* q[] = {"0.225164563413958", "-0.619927562499452", "-0.277029150687195", "0.69874572364031"};
  for (int k = 0; k < 3; ++k) CHECK(distance(end.w_rad_per_s[k], w[k]) < 1e-13);
  for (int k = 0; k < 4; ++k) CHECK(distance(end.q_wxyz[k], q[k]) < 1e-13);
  CHECK(static_cast<double>(truth.bars.back().bodies[0].q_wxyz[0]) < 1e-26);
  CHECK(distance(end.p_m[2], "-410") < 1e-12);
}

TEST_CASE("Carlson's integrals: published values, and elementary cases to the last digits") {
  using namespace atwood::closed_form;
  // Carlson 1995, section 3.
  CHECK(distance(carlson_rf(Wide(2), Wide(3), Wide(4)), "0.58408284167715") < 1e-14);
  CHECK(distance(carlson_rj(Wide(2), Wide(3), Wide(4), Wide(5)), "0.14297579667157") < 1e-14);
  // Two arguments 0: the integral diverges, and duplication never ends.
  for (const Wide& x : {carlson_rf(Wide(0), Wide(0), Wide(1)), carlson_rj(Wide(0), Wide(0), Wide(1), Wide(1))})
    CHECK(x != x);
  CHECK(distance(carlson_rc(Wide(0), Wide(0.25)), "3.1415926535897932384626433832795028842") < 1e-32);
  for (const double y : {1.25, 2.0, 7.0, 0.5}) {
    const Wide x = 1, c = carlson_rc(x, Wide(y));
    CHECK(static_cast<double>(fabsq(carlson_rf(x, Wide(y), Wide(y)) - c)) < 1e-33);
    const Wide d = Wide(3) / (2 * (Wide(y) - x)) * (c - 1 / Wide(y));  // R_J(x, y, y, y)
    CHECK(static_cast<double>(fabsq(carlson_rj(x, Wide(y), Wide(y), Wide(y)) - d) / d) < 3e-32);
  }
}
