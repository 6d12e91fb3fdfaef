// Simultaneous contacts: an outcome that depends on a convention is refused by name, or follows the stated convention.
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "closed_form/closed_form.hpp"
#include "cvode/cvode.hpp"
#include "extended/extended.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

using Order = std::vector<int>;

double value(Wide x) { return static_cast<double>(x); }

Truth solve(const char* kind, Scenario given, std::int64_t samples) {
  if (std::string(kind) == "extended") return extended_truth(given, samples);
  if (std::string(kind) == "cvode") return cvode_truth(given, samples);
  given.truth = {TruthKind::closed_form, "ball-flights", ""};
  return closed_form_truth(given, samples);
}

// A ball that hits two others exactly between them at t = 1; bodies in the file in the given order.
Scenario break_shot(const Order& order, SimultaneousImpacts convention, double restitution = 1, double shift_m = 0) {
  Scene scene = scenes::empty_scene();
  scene.simultaneous_impacts = convention;
  scene.pairs[0].restitution = restitution;
  // 3-4-5: centres 0.5 apart at touch, (0.4, +-0.3) from the cue ball.
  const Body all[] = {scenes::point("cue", 1, {-1, 0, 0}, {1, 0, 0}),
                      scenes::point("left", 1, {0.375, 0.5, 0}, {0, 0, 0}),
                      scenes::point("right", 1, {0.375 + shift_m, -0.5, 0}, {0, 0, 0})};
  for (const int at : order) scene.bodies.push_back(all[at]);
  for (Body& body : scene.bodies) body.shape = Sphere{0.3125};  // touch at x = 0: 0.375^2 + 0.5^2 = 0.625^2
  return scenes::scenario(scene, 2);
}

const BodySample& of(const Scenario& given, const Truth& truth, const std::string& name, std::size_t sample) {
  for (std::size_t i = 0; i < given.scene.bodies.size(); ++i)
    if (given.scene.bodies[i].name == name) return truth.values.at(sample).bodies[i];
  throw std::invalid_argument(name);
}

}  // namespace

TEST_CASE("a ball hits two others at once: every truth ends unless the scene states a convention") {
  for (const char* kind : {"extended", "closed-form", "cvode"})
    for (const Order& order : {Order{0, 1, 2}, Order{0, 2, 1}, Order{1, 0, 2}, Order{2, 1, 0}}) {
      const Truth truth = solve(kind, break_shot(order, SimultaneousImpacts::unspecified), 8);
      INFO(kind << ": " << truth.outcome.reason);
      CHECK(truth.outcome.status == Status::unsupported);
      CHECK(truth.outcome.reason.find("simultaneous impacts") != std::string::npos);
      CHECK(truth.outcome.reason.find(" at t = ") != std::string::npos);
      REQUIRE(truth.values.size() == 4);  // t = 0, 1/4, 1/2, 3/4: before the impact all is certified
      REQUIRE(truth.bars.size() == 4);
      CHECK(truth.events.empty());
      CHECK(value(of(break_shot(order, {}), truth, "cue", 3).p_m[0]) == Approx(-0.25));
      CHECK(value(truth.bars[3].bodies[0].p_m[0]) < 1e-9);
    }
}

TEST_CASE("together: the two others leave alike, whatever the order in the file") {
  // Moreau by hand: J on each along (0.6, +-0.8); u_n = -0.6 each; u_n+ = 0.6 = -0.6 + J (1 + 1 + 0.36 - 0.64).
  const double J = 1.2 / 1.72;
  for (const char* kind : {"extended", "closed-form", "cvode"})
    for (const Order& order : {Order{0, 1, 2}, Order{2, 0, 1}, Order{2, 1, 0}}) {
      const Scenario given = break_shot(order, SimultaneousImpacts::together);
      const Truth truth = solve(kind, given, 8);
      INFO(kind << ": " << truth.outcome.reason);
      REQUIRE(truth.outcome.status == Status::ok);
      CHECK(truth.events.size() == 2);
      CHECK(value(of(given, truth, "left", 8).v_m_per_s[1]) == Approx(0.8 * J).epsilon(1e-9));
      CHECK(value(of(given, truth, "right", 8).v_m_per_s[1]) == Approx(-0.8 * J).epsilon(1e-9));
      CHECK(value(of(given, truth, "cue", 8).v_m_per_s[0]) == Approx(1 - 1.2 * J).epsilon(1e-9));
      CHECK(std::fabs(value(of(given, truth, "cue", 8).v_m_per_s[1])) < 1e-9);
    }
}

TEST_CASE("sequential: equal approaches in the order of the bodies, pair by pair until none approaches") {
  for (const char* kind : {"extended", "closed-form", "cvode"})
    for (const Order& order : {Order{0, 1, 2}, Order{2, 0, 1}, Order{2, 1, 0}}) {
      const Scenario given = break_shot(order, SimultaneousImpacts::sequential);
      // By hand, with unit masses and e = 1: exchange the parts along the line of centres.
      std::vector<std::array<double, 2>> v(3);
      v[std::find(order.begin(), order.end(), 0) - order.begin()] = {1, 0};
      const auto n_of = [&](int i, int j) {
        const Real3 &a = given.scene.bodies[i].position_m, &b = given.scene.bodies[j].position_m;
        const double ax = order[i] == 0 ? 0 : a[0], bx = order[j] == 0 ? 0 : b[0];
        return std::array<double, 2>{(bx - ax) / 0.625, (b[1] - a[1]) / 0.625};
      };
      for (bool struck = true; struck;) {
        int first = -1, second = -1;
        double fastest = 1e-9;
        for (int i = 0; i < 3; ++i)
          for (int j = i + 1; j < 3; ++j) {
            if (order[i] != 0 && order[j] != 0) continue;  // left and right do not touch
            const auto n = n_of(i, j);
            const double closing = (v[i][0] - v[j][0]) * n[0] + (v[i][1] - v[j][1]) * n[1];
            if (closing > fastest * (1 + 1e-9)) fastest = closing, first = i, second = j;
          }
        struck = first >= 0;
        for (int c = 0; c < 2 && struck; ++c) {
          v[first][c] -= fastest * n_of(first, second)[c];
          v[second][c] += fastest * n_of(first, second)[c];
        }
      }
      const Truth truth = solve(kind, given, 8);
      INFO(kind << ": " << truth.outcome.reason);
      REQUIRE(truth.outcome.status == Status::ok);
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 2; ++c)
          CHECK(value(truth.values.back().bodies[i].v_m_per_s[c]) == Approx(v[i][c]).margin(1e-8));
    }
}

TEST_CASE("impacts at slightly different times have an order, down to the resolution of a truth") {
  for (const double shift : {1e-9, 1e-13, -1e-13}) {
    const Truth truth = extended_truth(break_shot({0, 1, 2}, SimultaneousImpacts::unspecified, 1, shift), 8);
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(truth.events.front().body_b == (shift > 0 ? 1 : 2));
  }
  // CVODE does not resolve 1e-13.
  CHECK(cvode_truth(break_shot({0, 1, 2}, SimultaneousImpacts::unspecified, 1, 1e-13), 8).outcome.status ==
        Status::unsupported);
}

TEST_CASE("a ball in a corner: smooth walls at right angles commute, a V does not") {
  for (const bool square : {true, false})
    for (const char* kind : {"extended", "cvode", "closed-form"}) {
      Scene scene = scenes::empty_scene();
      scene.pairs[0].restitution = 0.5;
      const Real3 one = square ? Real3{1, 0, 0} : Real3{0.6, 0.8, 0},
                  other = square ? Real3{0, 1, 0} : Real3{-0.6, 0.8, 0};
      scene.bodies = {scenes::point("wall", 0, {0, 0, 0}, {0, 0, 0}),
                      scenes::point("other-wall", 0, {0, 0, 0}, {0, 0, 0}),
                      scenes::point("ball", 1, square ? Real3{2, 2, 0} : Real3{0, 3, 0},
                                    square ? Real3{-1, -1, 0} : Real3{0, -1, 0})};
      scene.bodies[0].shape = Plane{one, 0};
      scene.bodies[1].shape = Plane{other, 0};
      scene.bodies[0].fixed = scene.bodies[1].fixed = true;
      scene.bodies[2].shape = Sphere{1};
      const Truth truth = solve(kind, scenes::scenario(scene, 4), 8);
      INFO(kind << (square ? ", square: " : ", V: ") << truth.outcome.reason);
      CHECK((truth.outcome.status == Status::ok) == square);
      if (!square || truth.outcome.status != Status::ok) continue;
      CHECK(truth.events.size() == 2);
      CHECK(value(truth.values.back().bodies[2].v_m_per_s[0]) == Approx(0.5));
      CHECK(value(truth.values.back().bodies[2].v_m_per_s[1]) == Approx(0.5));
    }
}

// The length of the tilted normal is 1 + 2.4e-17: that puts one impact 4e-18 s before the other.
TEST_CASE("the rounding of a wall's normal decides no order of impacts") {
  Scene scene = scenes::empty_scene();
  scene.pairs[0].restitution = 0.7;
  scene.bodies = {scenes::point("ball", 1, {0, 0, 0}, {1, 1, 0}), scenes::point("wall", 0, {0, 0, 0}, {0, 0, 0}),
                  scenes::point("tilted", 0, {0, 0, 0}, {0, 0, 0})};
  scene.bodies[0].shape = Sphere{0.25};
  scene.bodies[1].shape = Plane{{-1, 0, 0}, -0.75};
  scene.bodies[2].shape = Plane{{-0.5403023058681398, -0.8414709848078965, 0}, -0.9408866453380181};
  scene.bodies[1].fixed = scene.bodies[2].fixed = true;
  for (const char* kind : {"extended", "cvode", "closed-form"}) {
    const Truth truth = solve(kind, scenes::scenario(scene, 1), 4);
    INFO(kind << ": " << truth.outcome.reason);
    CHECK(truth.outcome.status == Status::unsupported);
    CHECK(truth.values.size() < 4);
  }
}

TEST_CASE("a ball dropped on a ball that rests ends the truth there") {
  for (const char* kind : {"extended", "cvode"}) {
    Scenario given = scenes::bounce(0.5, 0, false, 1);
    Body dropped = given.scene.bodies[1];
    dropped.name = "dropped";
    dropped.position_m = {0, 0, 1};
    given.scene.bodies.push_back(dropped);
    const Truth truth = solve(kind, given, 64);
    INFO(kind << ": " << truth.outcome.reason);
    CHECK(truth.outcome.status == Status::unsupported);
    CHECK(truth.outcome.reason.find("while it rests on") != std::string::npos);
    CHECK(truth.values.size() > 20);  // sqrt(2 * 0.625 / 9.81) = 0.357 s
    CHECK(truth.values.size() < 24);
  }
}
