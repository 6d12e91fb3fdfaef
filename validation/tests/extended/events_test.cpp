// Events that begin and end inside one step of a truth, with few and many samples: the values do not depend on the
// samples. Random scenes of each kind, judged in 60 digits: validation/tests/truth_fuzz/event_kinds.cpp.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "extended/extended.hpp"
#include "scene/files.hpp"

using namespace atwood;

namespace {

// A scene of the test's, which runs until `t_end_s` with gravity along -z.
Scenario scene_of(double t_end_s, const std::string& bodies, double gravity = 10) {
  const std::string head = "id = \"events\"\ntitle = \"t\"\nclaim = \"c\"\ntags = [\"contact\"]\n[run]\nt_end_s = " +
                           std::to_string(t_end_s) +
                           "\nsteps = [64]\nsamples = 1\n[world]\ngravity_m_per_s2 = [0, 0, " +
                           std::to_string(-gravity) + "]\n[truth]\nkind = \"extended\"\n";
  return read_scenario_text(head + bodies, "events", ".");
}

struct Answer {
  double z_m, bar_m;
  std::size_t events;
};
// The same end with every number of samples, within the bars.
Answer answer(const Scenario& given, std::size_t body) {
  Answer made{};
  Wide z = 0, bar = 0;
  for (const std::int64_t samples : {1, 2, 7, 64}) {
    const Truth truth = extended_truth(given, samples);
    INFO(samples << " samples: " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const Wide now = truth.values.back().bodies[body].p_m[2], own = truth.bars.back().bodies[body].p_m[2];
    if (samples == 1) z = now, bar = own;
    CHECK(fabsq(now - z) <= bar + own);
    if (samples > 1) CHECK(truth.events.size() == made.events);
    made = {static_cast<double>(now), static_cast<double>(own), truth.events.size()};
  }
  return made;
}

const char* const kMaterial = "[material.m]\nrestitution = 1\n";
// A slider along z without friction; `rest`: its further keys.
std::string slider(const std::string& rest) {
  return "[[body]]\nname = \"bead\"\nmass_kg = 1\ninertia_kg_m2 = [0.1, 0.1, 0.1]\n[[joint]]\nname = \"rail\"\nkind = "
         "\"slider\"\nbodies = [\"world\", \"bead\"]\naxis_body = [0, 0, 1]\n" +
         rest;
}

}  // namespace

// By an integration of the test's author in Python with the impact found by brentq: at 1.22726 s.
TEST_CASE("a ball thrown past a peg strikes it, however few samples are taken") {
  const Answer a = answer(
      scene_of(
          2, std::string(kMaterial) +
                 "[[body]]\nname = \"peg\"\nfixed = true\nmaterial = \"m\"\nshape.sphere = {radius_m = 0.2}\n[[body]]\n"
                 "name = \"ball\"\nmaterial = \"m\"\nmass_kg = 1\nshape.sphere = {radius_m = 0.05}\nposition_m = "
                 "[-0.53, 0, -4.5]\nvelocity_m_per_s = [0.38, 0, 10]\n"),
      1);
  CHECK(a.events == 1);
  CHECK(a.z_m == Approx(-1.0707689445).epsilon(1e-9));
  CHECK(a.bar_m < 1e-26);
}

// It would rise to 5 m: with the stop at s the impact comes at t = 1 - sqrt(1 - s / 5), at the speed v = 10 (1 - t).
TEST_CASE("a slider that just reaches its stop is thrown back") {
  const Answer a =
      answer(scene_of(2, slider("rate_m_per_s = 10\nlimits_m = [-100, 4.999999]\nstop_restitution = 0.5\n")), 0);
  const double stop = 4.999999, v = std::sqrt(100 - 20 * stop), t = 1 - v / 10;
  CHECK(a.events == 1);
  CHECK(a.z_m == Approx(stop - v / 2 * (2 - t) - 5 * (2 - t) * (2 - t)).epsilon(1e-9));
}

// m z'' = -10 + F cos(3 t + pi / 2) once the force exceeds the weight, from there in closed form.
double lifted(double force, double t_end) {
  const double pi = 3.14159265358979324, w = 3, lift = (2 * pi - std::acos(10 / force) - pi / 2) / w;
  const double at = w * lift + pi / 2, end = w * t_end + pi / 2, s = t_end - lift;
  return -5 * s * s - force / w * std::sin(at) * s - force / (w * w) * (std::cos(end) - std::cos(at));
}
TEST_CASE("what a force lifts from its stop or its floor for a moment leaves it, within a second of work") {
  const std::string force = "angular_frequency_rad_per_s = 3\nphase_rad = 1.5707963267948966\n";
  const Answer bead = answer(scene_of(1.7, slider("limits_m = [0, 100]\n[[force]]\nkind = \"joint-torque\"\njoint = "
                                                  "\"rail\"\nforce_N = 10.5\n" +
                                                  force)),
                             0);
  CHECK(bead.z_m == Approx(lifted(10.5, 1.7)).epsilon(1e-9));
  CHECK(bead.z_m == Approx(0.008852385577).epsilon(1e-9));
  const Answer ball = answer(
      scene_of(
          2,
          "[material.m]\nrestitution = 0.5\n[[body]]\nname = \"floor\"\nmaterial = \"m\"\nshape.plane = {normal = [0, "
          "0, 1], offset_m = 0}\n[[body]]\nname = \"b\"\nmaterial = \"m\"\nmass_kg = 1\nshape.sphere = {radius_m = "
          "0.1}\nposition_m = [0, 0, 0.1]\n[[force]]\nkind = \"drive\"\nbody = \"b\"\nforce_N = [0, 0, 20]\n" +
              force),
      1);
  CHECK(ball.z_m == Approx(0.1 + lifted(20, 2)).epsilon(1e-9));
  CHECK(ball.bar_m < 1e-26);
}

// The tension is m (g + F cos(3 t + pi) / (2 m)) with equal masses m: it is negative where the drive of 20.1 N pushes.
TEST_CASE("a rope that is slack for a moment ends the truth at that instant") {
  const std::string bodies =
      "[[body]]\nname = \"l\"\nmass_kg = 1\nposition_m = [-0.5, 0, -20]\n[[body]]\nname = \"r\"\nmass_kg = 1\nposition_m = "
      "[0.5, 0, -20]\n[[rope]]\nname = \"rope\"\nbodies = [\"l\", \"r\"]\nover_m = [[-0.5, 0, 0], [0.5, 0, 0]]\n[[force]]\n"
      "kind = \"drive\"\nbody = \"l\"\nforce_N = [0, 0, 20.1]\nangular_frequency_rad_per_s = 3\nphase_rad = "
      "3.141592653589793\n";
  for (const std::int64_t samples : {1, 2, 32}) {
    const Truth truth = extended_truth(scene_of(2, bodies), samples);
    CHECK(truth.outcome.status == Status::unsupported);
    CHECK(truth.outcome.reason.find("rope `rope` is slack at t = 1.01393343916925") == 0);
    CHECK(static_cast<double>(truth.values.size()) == std::floor(1.0139 / 2 * static_cast<double>(samples)) + 1);
  }
}

TEST_CASE("a ball that rests without weight for one instant is refused by name") {
  const Truth truth = extended_truth(
      scene_of(
          2,
          "[material.m]\nrestitution = 0.5\n[[body]]\nname = \"floor\"\nmaterial = \"m\"\nshape.plane = {normal = [0, "
          "0, 1], offset_m = 0}\n[[body]]\nname = \"b\"\nmaterial = \"m\"\nmass_kg = 1\nshape.sphere = {radius_m = "
          "0.1}\nposition_m = [0, 0, 0.1]\n[[force]]\nkind = \"drive\"\nbody = \"b\"\nforce_N = [0, 0, 10]\n"
          "angular_frequency_rad_per_s = 3\nphase_rad = 1.5707963267948966\n"),
      4);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason.find("`b` rests on its plane without weight") == 0);
  CHECK(truth.values.size() == 4);  // at 3/2 pi / 3 = 1.57 s
}
