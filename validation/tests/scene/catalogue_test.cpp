// Every file of the catalogue reads, survives JSON, and keeps the catalogue's own rules.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "scene/files.hpp"
#include "scene/named_metric.hpp"

using namespace atwood;
namespace fs = std::filesystem;

namespace {

std::vector<Scenario> catalogue() {
  std::vector<Scenario> all;
  for (const auto& entry : fs::directory_iterator(std::string(ATWOOD_SOURCE_DIR) + "/validation/scenarios"))
    if (entry.path().extension() == ".toml") all.push_back(read_scenario(entry.path().string()));
  std::sort(all.begin(), all.end(), [](const Scenario& a, const Scenario& b) { return a.id < b.id; });
  return all;
}

bool has(const Scenario& s, const std::string& tag) {
  return std::find(s.tags.begin(), s.tags.end(), tag) != s.tags.end();
}

void require_switches_on_steps(const Scenario& s, const std::vector<Interval>& on_s) {
  for (const Interval& interval : on_s)
    for (const double t : {interval.from_s, interval.to_s}) {
      const double steps = t / s.t_end_s * static_cast<double>(s.steps.front());
      INFO("switch at " << t << " s falls on step " << steps);
      REQUIRE(std::abs(steps - std::round(steps)) < 1e-9);
    }
}

}  // namespace

TEST_CASE("the catalogue has its rows") {
  std::set<std::string> ids;
  for (const Scenario& s : catalogue()) ids.insert(s.id);
  for (const char* id : {"ballistic",
                         "projectile-linear-drag",
                         "projectile-quadratic-drag",
                         "terminal-velocity",
                         "oscillator",
                         "oscillator-damped",
                         "oscillator-driven",
                         "kepler-e0",
                         "kepler-e0.3",
                         "kepler-e0.6",
                         "kepler-e0.8",
                         "kepler-e0.9",
                         "kepler-e0.99",
                         "burrau",
                         "kepler-10-periods",
                         "kepler-1000-periods",
                         "two-body",
                         "figure-eight",
                         "pleiades",
                         "outer-solar-system",
                         "arenstorf",
                         "henon-heiles",
                         "charge-in-b",
                         "charge-in-e-cross-b",
                         "coulomb-scattering",
                         "lorenz",
                         "free-box-simple",
                         "free-box-complex",
                         "symmetric-top",
                         "dzhanibekov",
                         "asymmetric-top",
                         "thrusters",
                         "thrusters-spin",
                         "force-at-a-point",
                         "force-at-a-point-body",
                         "frame-rate-30",
                         "frame-rate-60",
                         "frame-rate-144",
                         "bounce-e0",
                         "bounce-e0.5",
                         "bounce-e0.8",
                         "bounce-e1",
                         "bounce-drag",
                         "head-on",
                         "oblique",
                         "bullet-through-paper",
                         "oblique-phase",
                         "oblique-rough-dead",
                         "oblique-rough-graze",
                         "oblique-rough-roll",
                         "oblique-rough-spin",
                         "slopes",
                         "mesh-floor-roll",
                         "mesh-floor-slide",
                         "penalty-hertz",
                         "penalty-linear",
                         "penalty-linear-pair",
                         "penalty-linear-pull",
                         "cradle-apart-1",
                         "cradle-apart-2",
                         "cradle-apart-3",
                         "cradle-touching-1",
                         "cradle-touching-2",
                         "cradle-touching-3",
                         "cradle-unequal",
                         "cradle-unequal-apart",
                         "friction-cone-0",
                         "friction-cone-60",
                         "roll",
                         "roll-cylinder",
                         "roll-hollow",
                         "roll-slip",
                         "slide-10",
                         "slide-20",
                         "slide-3",
                         "slide-30",
                         "slide-40",
                         "slip-to-roll",
                         "slip-to-roll-backspin",
                         "stop-distance",
                         "stop-distance-0",
                         "stop-distance-30",
                         "stop-distance-45",
                         "stop-distance-60",
                         "struck-rod",
                         "struck-rod-box",
                         "struck-rod-rough",
                         "rod-on-rough-floor",
                         "bouncing-49",
                         "pile-216",
                         "elastic-216",
                         "balls-overlapping",
                         "stack-10",
                         "wall",
                         "card-house",
                         "settling-100",
                         "settling-1000",
                         "settling-8000",
                         "settling-10000",
                         "settling-100000",
                         "settling-boxes-100",
                         "settling-boxes-1000",
                         "settling-boxes-8000",
                         "settling-boxes-10000"}) {
    INFO(id);
    REQUIRE(ids.count(id) == 1);
  }
}

TEST_CASE("each scenario is complete and follows the rules") {
  for (const Scenario& s : catalogue()) {
    INFO(s.path);
    REQUIRE(fs::path(s.path).filename() == s.id + ".toml");
    REQUIRE(!s.title.empty());
    REQUIRE(!s.claim.empty());
    REQUIRE(!s.source.empty());
    REQUIRE(!named_metric(s).empty());    // what reports open it with
    if (has(s, "statistics")) continue;   // for statistics only: a truth or a ladder may be missing
    if (has(s, "many-bodies")) continue;  // its studies look at sums and conservation, not along a ladder
    if (has(s, "geometry")) continue;     // poses, not motion
    if (has(s, "hypotheses")) continue;   // scenes on which impact laws differ
    if (has(s, "pile")) {                 // many bodies in contact: cost, overlap and rest, no ladder of errors
      REQUIRE(std::all_of(s.steps.begin(), s.steps.end(), [&](std::int64_t steps) { return steps % s.samples == 0; }));
      REQUIRE((s.truth.kind == TruthKind::closed_form) == has(s, "rest"));
      continue;
    }
    REQUIRE((has(s, "section-a") + has(s, "section-b") + has(s, "section-d") + has(s, "section-g")) == 1);
    REQUIRE(has(s, "smooth") + has(s, "contact") + has(s, "response") + has(s, "mechanism") + has(s, "orbit") == 1);
    REQUIRE(has(s, "mechanism") == !(s.scene.joints.empty() && s.scene.ropes.empty()));
    // no truth joins contact and joints: such scenes are judged by what they conserve, gaps, overlap and rest
    REQUIRE((s.truth.kind == TruthKind::none) == has(s, "touching"));
    REQUIRE((s.samples >= (has(s, "mechanism") ? 8 : 60) || !s.frame_ends_s.empty()));
    for (const std::int64_t steps : s.steps) REQUIRE(steps % s.samples == 0);
    if (!s.frame_ends_s.empty()) continue;  // recorded frames: switches fall inside them
    for (const Force& force : s.scene.forces) {
      if (const auto* thruster = std::get_if<Thruster>(&force)) require_switches_on_steps(s, thruster->on_s);
      if (const auto* push = std::get_if<PointForce>(&force)) require_switches_on_steps(s, push->on_s);
    }
    for (const JointForce& force : s.scene.joint_forces)
      if (const auto* motor = std::get_if<JointTorque>(&force)) require_switches_on_steps(s, motor->on_s);
  }
}

TEST_CASE("each scenario survives JSON to the byte") {
  for (const Scenario& s : catalogue()) {
    INFO(s.path);
    const std::string json = scenario_to_json(s);
    REQUIRE(json.find('\n') == std::string::npos);
    REQUIRE(scenario_to_json(scenario_from_json(json)) == json);
    const std::string scene = scene_to_json(s.scene);
    REQUIRE(scene_to_json(scene_from_json(scene)) == scene);
  }
}

TEST_CASE("digits of the catalogue are those of their sources") {
  for (const Scenario& s : catalogue()) {
    const Body& first = s.scene.bodies.front();
    if (s.id == "free-box-complex") {
      REQUIRE(first.inertia_kg_m2[0] == Approx(0.97 / 1.2).epsilon(1e-15));
      REQUIRE(first.inertia_kg_m2[4] == Approx(0.82 / 1.2).epsilon(1e-15));
      REQUIRE(first.inertia_kg_m2[8] == Approx(0.17 / 1.2).epsilon(1e-15));
      REQUIRE(first.velocity_m_per_s == Real3{-2, 2, 8});
    }
    if (s.id == "figure-eight")
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double sum = 0;
        for (const Body& body : s.scene.bodies) sum += body.velocity_m_per_s[axis];
        REQUIRE(sum == 0);
      }
    if (s.id == "arenstorf") REQUIRE(first.velocity_m_per_s[1] == -2.00158510637908252240537862224);
    if (s.id == "asymmetric-top")
      REQUIRE(first.inertia_kg_m2[0] * first.angular_velocity_body_rad_per_s[0] == Approx(1.8).epsilon(1e-15));
  }
}
