// What an engine says of itself, what it takes, what it refuses.
#include <catch2/catch.hpp>

#include <cmath>

#include "rivals/tuned.hpp"
#include "under_test.hpp"

namespace atwood::test {
namespace {

const MethodInfo& method_info(const Engine& engine, const std::string& scheme) {
  for (const auto& info : engine.methods) {
    if (info.id == engine.name + "/" + scheme) return info;
  }
  FAIL("no method " << scheme);
  return engine.methods.front();
}

std::string refusal_of(const MethodId& id, const Scene& scene) {
  const Run result = try_run(engine_under_test(), id, scene, Plan{1, 10, 10});
  CHECK(to_string(result.outcome.status) == "unsupported");
  CHECK(result.samples.empty());
  return result.outcome.reason;
}

}  // namespace

TEST_CASE("every preset prints what decides accuracy") {
  const Engine engine = engine_under_test();
  std::vector<std::string> names{"scalar",   "substeps", "linear_damping", "angular_damping", "forces",
                                 "pair_law", "step"};
  const std::map<std::string, std::vector<std::string>> own{
      {"bullet",
       {"iterations", "erp", "cfm", "gyroscopic", "split_impulse", "restitution_velocity_threshold_m_per_s",
        "contact_processing_threshold_m", "collision_margin_m", "solver", "friction_directions"}},
      {"ode", {"iterations", "erp", "cfm", "gyroscopic", "bounce_velocity_m_per_s", "friction_model", "max_contacts"}},
      {"dart",
       {"collision_detector", "lcp_solver", "secondary_lcp_solver", "error_allowance_m", "erp", "max_erv_m_per_s",
        "cfm", "split_impulse", "bouncing_velocity_m_per_s", "friction_model", "friction_direction", "gyroscopic"}},
      {"mujoco",
       {"integrator", "solver", "iterations", "tolerance", "cone", "impratio", "solref_time_constant_s",
        "solref_damping_ratio", "solimp_least", "solimp_most", "restitution", "contacts_per_body"}}};
  const auto& of_engine = own.at(is_bullet(engine) ? "bullet" : engine.name);
  names.insert(names.end(), of_engine.begin(), of_engine.end());
  for (const auto& info : engine.methods) {
    CHECK_FALSE(info.doc.empty());
    for (const auto& name : names) CHECK((info.settings.count(name) ? "" : name) == "");
    CHECK(std::get<std::string>(info.settings.at("scalar")) == engine.scalar);
    CHECK(std::get<double>(info.settings.at("linear_damping")) == 0);
    CHECK(std::get<double>(info.settings.at("angular_damping")) == 0);
    // Nobody sleeps.
    const std::string sleep = engine.name == "ode" ? "auto_disable" : "sleeping";
    const SettingValue& sleeps = info.settings.at(sleep);
    const auto* word = std::get_if<std::string>(&sleeps);
    CHECK((word ? word->rfind("none", 0) == 0 : !std::get<bool>(sleeps)));
  }
  CHECK(method_info(engine, "default").settings != method_info(engine, "tuned").settings);
}

TEST_CASE("an override reaches the engine") {
  const Engine engine = engine_under_test();
  const Plan plan{1, 240, 24};
  const Run plain = run(engine, method(engine, "default"), free_box_complex(), plan);
  const Run same = run(engine, method(engine, "default"), free_box_complex(), plan);
  const Run finer = run(engine, method(engine, "default", {{"substeps", std::int64_t{4}}}), free_box_complex(), plan);
  REQUIRE(finer.outcome.status == Status::ok);
  CHECK(plain.p(0, 2) == same.p(0, 2));
  // Four inner steps leave a quarter of the height g t h / 2 that the engine falls short of.
  const double exact = 8 * 1 - 0.5 * 9.8;
  CHECK((exact - finer.p(0, 2)) / (exact - plain.p(0, 2)) == Approx(0.25).epsilon(in_float(engine) ? 0.05 : 1e-6));
  if (engine.name == "mujoco" || engine.name == "dart") return;  // these have no damping
  const Run damped = run(engine, method(engine, "default", {{"linear_damping", 0.5}}), free_box_complex(), plan);
  CHECK(std::abs(damped.v(0, 0)) < 1.9);
}

TEST_CASE("unknown settings and unsupported scenes are refused by name") {
  const Engine engine = engine_under_test();
  const MethodId plain = method(engine, "default");
  CHECK_THAT(refusal_of(method(engine, "default", {{"erpp", 0.1}}), free_box_complex()),
             Catch::Contains("erpp") && Catch::Contains("expected one of") && Catch::Contains("substeps"));
  CHECK_THAT(refusal_of(method(engine, "default", {{"substeps", std::string("many")}}), free_box_complex()),
             Catch::Contains("substeps") && Catch::Contains("whole number"));
  CHECK_THAT(refusal_of(method(engine, "default", {{"scalar", std::string("quad")}}), free_box_complex()),
             Catch::Contains("scalar"));
  CHECK_THAT(refusal_of(method(engine, "default", {{"substeps", std::int64_t{0}}}), free_box_complex()),
             Catch::Contains("substeps"));
  CHECK_THAT(refusal_of(method(engine, "fast"), free_box_complex()), Catch::Contains("fast"));

  MethodId adaptive = plain;
  adaptive.rtol = 1e-6;
  CHECK_THAT(refusal_of(adaptive, free_box_complex()), Catch::Contains("tolerance"));
  MethodId wide = plain;
  wide.scalar = "quad";
  CHECK_THAT(refusal_of(wide, free_box_complex()), Catch::Contains("quad"));

  Scene lorenz = free_box_complex();
  lorenz.problem = "lorenz";
  CHECK_THAT(refusal_of(plain, lorenz), Catch::Contains("lorenz"));
  if (engine.name == "mujoco") {
    CHECK_THAT(refusal_of(plain, bounce(0.5, 1)), Catch::Contains("MuJoCo has no restitution"));
    Scene plate = bounce(0, 1);
    plate.bodies[1].shape = Rectangle{{1, 1}};
    CHECK_THAT(refusal_of(plain, plate), Catch::Contains("rectangle") && Catch::Contains("ball"));
    Scene mesh = bounce(0, 1);
    mesh.bodies[1].shape = Mesh{};
    CHECK_THAT(refusal_of(plain, mesh), Catch::Contains("mesh") && Catch::Contains("ball"));
  } else {
    Scene flat = bounce(0.5, 1);
    flat.bodies[1].shape = is_bullet(engine) ? Shape{Mesh{}} : Shape{Convex{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}};
    const std::string why = is_bullet(engine) ? "mesh" : engine.name == "dart" ? "no convex hull" : "flat hull";
    CHECK_THAT(refusal_of(plain, flat), Catch::Contains(why) && Catch::Contains("ball"));
  }
  Scene springy = bounce(0, 1);
  springy.pairs[0].contact_law = ContactLaw::linear;
  springy.pairs[0].stiffness_N_per_m = 1e5;
  CHECK_THAT(refusal_of(plain, springy), Catch::Contains("compliant"));
  Scene potential = free_box_complex();
  potential.forces.push_back(Potential{{0}, "moon", {}});
  CHECK_THAT(refusal_of(plain, potential), Catch::Contains("moon"));
}

TEST_CASE("a scene's convention for simultaneous impacts is refused, or the cell says that it is not followed") {
  const Engine engine = engine_under_test();
  const MethodId plain = method(engine, "default");
  Scene scene = bounce(0, 1);
  scene.simultaneous_impacts = SimultaneousImpacts::together;
  const auto reason = [&] { return engine.run(plain, scene, {0.125, 8, 1}, {}, 0).reason; };
  CHECK_THAT(reason(), !Catch::Contains("simultaneous"));  // one pair
  Body second = scene.bodies[1];
  second.name = "second";
  second.position_m[0] += 10;
  scene.bodies.push_back(second);
  CHECK_THAT(refusal_of(plain, scene), Catch::Contains("the scene's simultaneous_impacts is together"));
  scene.simultaneous_impacts = SimultaneousImpacts::sequential;
  CHECK_THAT(reason(), Catch::Contains("simultaneous_impacts = sequential is not followed"));
  scene.simultaneous_impacts = SimultaneousImpacts::unspecified;
  CHECK_THAT(reason(), !Catch::Contains("simultaneous"));
}

TEST_CASE("every setting is declared with what it takes and means, and the tuned presets are in range") {
  const Engine engine = engine_under_test();
  for (const MethodInfo& info : engine.methods) {
    for (const auto& [name, standard] : info.settings) {
      INFO(info.id << " " << name);
      REQUIRE(info.rules.count(name) == 1);
      const SettingRule& rule = info.rules.at(name);
      CHECK_FALSE(rule.doc.empty());
      CHECK(checked_value(info.id, name, standard, &rule, standard));
      const bool flag = std::holds_alternative<bool>(standard);
      const bool bounded = std::isfinite(rule.range.least) || std::isfinite(rule.range.most);
      CHECK((flag || bounded || !rule.range.choices.empty()));
    }
    for (const rivals::SceneClass each : rivals::all_scene_classes())
      CHECK(merged_settings(info, rivals::tuned_changes(engine.name, each)));
  }
}

TEST_CASE("a value outside its range is refused with the range, and nothing runs") {
  const Engine engine = engine_under_test();
  const auto why = [&](const char* name, const SettingValue& value) {
    return refusal_of(method(engine, "default", {{name, value}}), free_box_complex());
  };
  const std::string who = engine.name + "/default: ";
  CHECK(why("substeps", std::int64_t{1001}) == who + "`substeps` is `1001`; expected a whole number from 1 to 1000");
  CHECK_THAT(why("step", std::string("leap")), Catch::StartsWith(who + "`step` is `leap`; expected "));
  CHECK_THAT(why("pair_law", std::string("mine")),
             Catch::StartsWith(who + "`pair_law` is `mine`; expected the scene's"));
  if (engine.name == "mujoco") {
    CHECK(why("cone", std::string("round")) == who + "`cone` is `round`; expected pyramidal or elliptic");
    CHECK(why("impratio", 0.0) == who + "`impratio` is `0`; expected a number above 0 and at most 1000000");
  } else {
    CHECK(why("erp", 1.5) == who + "`erp` is `1.5`; expected a number from 0 to 1");
    CHECK_THAT(why("cfm", -1.0), Catch::StartsWith(who + "`cfm` is `-1`; expected a number from "));
  }
}

TEST_CASE("a state that is not a number ends the run as such") {
  Scene scene = free_box_complex();
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1});  // the box starts in its centre: 0 / 0
  const Engine engine = engine_under_test();
  const Run result = try_run(engine, method(engine, "default"), scene, Plan{1, 10, 10});
  CHECK(to_string(result.outcome.status) == "not finite");
  CHECK_THAT(result.outcome.reason, Catch::Contains("box"));
  CHECK(result.samples.size() < 11);
}

TEST_CASE("the timed pass observes nothing and times every repeat") {
  const Engine engine = engine_under_test();
  Observer observer;
  int seen = 0;
  observer.sample = [&](const Sample&) { ++seen; };
  observer.event = [&](const Event&) { ++seen; };
  const Scene scene = bounce(bounces(engine) ? 0.8 : 0, 0.2);
  const Outcome outcome = engine.run(method(engine, "tuned"), scene, Plan{1, 240, 240}, observer, 3);
  CHECK(outcome.status == Status::ok);
  CHECK(outcome.busy_ns.size() == 3);
  for (auto ns : outcome.busy_ns) CHECK(ns > 0);
  CHECK(outcome.steps_taken == 240);
  CHECK(seen == 0);
}

TEST_CASE("forces that the adapter evaluates for the engine are reported") {
  Scene scene = free_box_complex();
  scene.forces.push_back(LinearDrag{{0}, 0.1, {}, 0});
  const Engine engine = engine_under_test();
  CHECK_THAT(run(engine, method(engine, "default"), scene, Plan{1, 10, 10}).outcome.reason,
             Catch::Contains(engine.name == "mujoco" ? "at every rate call: drag" : "once a step: drag"));
  CHECK(run(engine, method(engine, "default"), free_box_complex(), Plan{1, 10, 10}).outcome.reason.empty());
}

}  // namespace atwood::test
