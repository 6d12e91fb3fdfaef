// Probes on schemes whose answers are known by hand: an oscillator stepped by Verlet and by explicit Euler, a free
// body.
#include <catch2/catch.hpp>
#include <cmath>

#include "dynamics/state.hpp"
#include "validation/metrics/probes.hpp"

using namespace atwood;

namespace {

// One kilogram on a spring of 1 N/m: x'' = -x in each direction.
Scenario oscillator() {
  Scenario scenario;
  scenario.id = "oscillator";
  scenario.t_end_s = 6;
  scenario.samples = 60;
  Body body;
  body.name = "mass";
  body.mass_kg = 1;
  body.position_m = {1, 0.5, 0};
  body.velocity_m_per_s = {0, 0.25, 0.75};
  scenario.scene.bodies = {body};
  Spring spring;
  spring.bodies = {0};
  spring.stiffness_N_per_m = 1;
  scenario.scene.forces = {spring};
  scenario.scene.materials = {{}};
  scenario.scene.pairs = {{}};
  scenario.invariants = {{"energy"}};
  return scenario;
}

template <class S> Recording step_oscillator(bool verlet, const Scene& scene, const Plan& plan) {
  Recording run;
  std::array<S, 3> x{}, v{};
  for (std::size_t i = 0; i < 3; ++i) {
    x[i] = scene.bodies[0].position_m[i];
    v[i] = scene.bodies[0].velocity_m_per_s[i];
  }
  const S h = static_cast<S>(plan.t_end_s) / static_cast<S>(plan.steps);
  for (std::int64_t n = 0; n <= plan.steps; ++n) {
    if (n % (plan.steps / plan.samples) == 0) {
      Sample s;
      s.t_s = plan.t_end_s * static_cast<double>(n) / static_cast<double>(plan.steps);
      s.bodies.resize(1);
      for (std::size_t i = 0; i < 3; ++i) {
        s.bodies[0].p_m[i] = x[i];
        s.bodies[0].v_m_per_s[i] = v[i];
      }
      run.values.push_back(s);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if (verlet) {
        v[i] -= h / 2 * x[i];
        x[i] += h * v[i];
        v[i] -= h / 2 * x[i];
      } else {
        const S old = x[i];
        x[i] += h * v[i];
        v[i] -= h * old;
      }
    }
  }
  return run;
}

Recording oscillate(const std::string& method, const Scene& scene, const Plan& plan) {
  const bool verlet = method.find("verlet") != std::string::npos;
  if (method.find("@long-double") != std::string::npos) return step_oscillator<long double>(verlet, scene, plan);
  return step_oscillator<double>(verlet, scene, plan);
}

std::vector<Row> ask(Probe probe, const Scenario& scenario, const std::string& method, std::int64_t steps) {
  const Truth none;
  return run_probe(probe, {scenario, method, {scenario.t_end_s, steps, scenario.samples, {}}, none, oscillate});
}

const Row& find(const std::vector<Row>& rows, const std::string& metric) {
  for (const Row& r : rows)
    if (r.metric == metric) return r;
  FAIL("no row " << metric);
  throw 0;
}

}  // namespace

TEST_CASE("probe: a run that depends on the number of threads, or changes when it is repeated, has other bits") {
  const Scenario scenario = oscillator();
  const Truth none;
  int runs = 0;
  const auto differing = [&](const std::string& method, const std::function<bool(const std::string&)>& differs) {
    runs = 0;
    return run_probe(Probe::determinism, {scenario,
                                          method,
                                          {scenario.t_end_s, 600, scenario.samples, {}},
                                          none,
                                          [&](const std::string& id, const Scene& scene, const Plan& plan) {
                                            Recording run = oscillate(id, scene, plan);
                                            ++runs;
                                            if (differs(id))
                                              run.values[7].bodies[0].v_m_per_s[1] +=
                                                  Wide(0x1p-80);  // lost in a double
                                            return run;
                                          }});
  };
  const auto same = differing("atwood/verlet{threads=2}", [](const std::string&) { return false; });
  CHECK(find(same, "state-differences").value == 0);
  CHECK(runs == 6);
  const auto threads =
      differing("atwood/verlet{threads=2}", [](const std::string& id) { return id.ends_with("=16}"); });
  CHECK(find(threads, "state-differences").value == 1);
  CHECK(find(threads, "state-differences").reason.find("threads=16") != std::string::npos);
  const auto repeated = differing("atwood/verlet", [&](const std::string&) { return runs == 2; });
  CHECK(runs == 2);
  CHECK(find(repeated, "state-differences").value == 1);
  // The hash is of the end state, and of all its bits.
  const double hash = find(same, "state-hash").value;
  CHECK(hash == find(repeated, "state-hash").value);
  CHECK(hash == std::floor(hash));
  CHECK(hash < 0x1p48);
  CHECK(hash != find(ask(Probe::determinism, scenario, "atwood/euler", 600), "state-hash").value);
}

TEST_CASE("probe: Verlet returns to its start, explicit Euler does not") {
  const Scenario scenario = oscillator();
  const auto verlet = ask(Probe::reversal, scenario, "atwood/velocity-verlet", 600),
             euler = ask(Probe::reversal, scenario, "atwood/explicit-euler", 600);
  CHECK(find(verlet, "reversal-over-round-off").value < 3);
  CHECK(find(verlet, "reversal-error-position").value < 1e-13);
  // There and back the radius grows by (1 + h^2)^(1/2) a step; |start| is 1.13.
  const double radius = std::hypot(1, 0.5, 0), grown = std::pow(1 + 1e-4, 600) - 1;
  CHECK(find(euler, "reversal-error-position").value == Approx(radius * grown).epsilon(1e-6));
  CHECK(find(euler, "reversal-over-round-off").value > 1e9);
}

TEST_CASE("probe: a fluid is run back; particles that are not numbers end the probe, and are no return to the start") {
  Scenario scenario;
  scenario.t_end_s = 1;
  Fluid fluid;
  fluid.name = "fluid";
  fluid.particles = {{{0.25, 0, 0}, {0.75, 0, 0}}, {{1, 0, 0}, {-1, 0, 0}}, {1, 1}, {1, 1}, {0, 0}};
  scenario.scene.fluids = {fluid};
  const auto probed = [&](double spoiled) {
    const auto run = [&](const std::string&, const Scene& scene, const Plan& plan) {
      const Particles& all = scene.fluids[0].particles;
      Recording made;
      for (std::int64_t k = 0; k <= plan.samples; ++k) {
        Sample sample;
        for (std::size_t i = 0; i < 2; ++i) {
          ParticleSample particle;
          particle.p_m[0] = all.position_m[i][0] + (k > 0 ? all.velocity_m_per_s[i][0] + spoiled : 0);
          particle.v_m_per_s[0] = all.velocity_m_per_s[i][0];
          particle.density_kg_per_m3 = 1;
          sample.particles.push_back(particle);
        }
        made.values.push_back(sample);
      }
      return made;
    };
    return run_probe(Probe::reversal, {scenario, "mine/one", {.t_end_s = 1, .steps = 1, .samples = 1}, {}, run});
  };
  const std::vector<Row> exact = probed(0), drifted = probed(0.125), spoiled = probed(std::nan(""));
  REQUIRE(exact.size() == 2);
  CHECK((exact[0].metric == "reversal-error-position" && exact[0].value == 0));
  CHECK((exact[1].metric == "reversal-error-velocity" && exact[1].value == 0));
  CHECK(drifted[0].value == 0.25);
  REQUIRE(spoiled.size() == 1);
  CHECK(spoiled[0].status == Status::not_finite);
}

TEST_CASE("probe: Verlet is symplectic; explicit Euler stretches by (1 + h^2) a step and plane of motion") {
  const Scenario scenario = oscillator();
  const Row verlet = find(ask(Probe::symplecticity, scenario, "atwood/velocity-verlet", 600), "symplecticity-defect");
  CHECK(verlet.value + verlet.truth_bar < 1e-9);
  const Row euler = find(ask(Probe::symplecticity, scenario, "atwood/explicit-euler", 600), "symplecticity-defect");
  // M^T J M = (1 + h^2)^N J; |J| = sqrt(6).
  CHECK(euler.value == Approx((std::pow(1 + 1e-4, 600) - 1) * std::sqrt(6)).epsilon(1e-8));
  CHECK(euler.truth_bar < 1e-8);
}

TEST_CASE("probe: twins on a linear spring stay together, their exponent is none") {
  const Scenario scenario = oscillator();
  const auto rows = ask(Probe::lyapunov, scenario, "atwood/velocity-verlet", 600);
  CHECK(find(rows, "horizon").value == scenario.t_end_s);
  const Row& exponent = find(rows, "lyapunov-exponent");
  CHECK(std::fabs(exponent.value) <= exponent.truth_bar + 0.05);
  const auto grown = [](double t_end_s) {
    Scenario longer = oscillator();
    longer.t_end_s = t_end_s;
    const auto steps = static_cast<std::int64_t>(std::lround(10 * t_end_s));
    return find(ask(Probe::lyapunov, longer, "atwood/explicit-euler", steps), "lyapunov-exponent");
  };
  const Row far = grown(120);
  CHECK(far.value ==
        Approx(std::log1p(0.01) / 2 / 0.1).margin(far.truth_bar + 1e-3));  // the radius, (1 + h^2)^(1/2) a step
  const Row near = grown(6);                                               // 0.3 e-foldings
  CHECK(std::isnan(near.value));
  CHECK_THAT(near.reason,
             Catch::StartsWith("inconclusive: no exponent is resolved: the separation grows by e^0.26, like "
                               "t^2 it would by e^4.6; mean rate 0.0485"));
}

TEST_CASE("probe: an ensemble's round-off is beside wider arithmetic") {
  const Scenario scenario = oscillator();
  const auto rows = ask(Probe::ensemble, scenario, "atwood/velocity-verlet", 6000);
  const Row& rms = find(rows, "round-off-rms-position");
  CHECK(rms.value > 1e-16);
  CHECK(rms.value < 1e-12);
  const Row& position = find(rows, "growth-exponent-round-off-position");
  CHECK(position.reason.find("96 runs beside atwood/velocity-verlet@long-double") != std::string::npos);
}

TEST_CASE("probe: an ensemble of an engine without wider arithmetic is refused; the truth is no substitute") {
  const Scenario scenario = oscillator();
  Truth truth;
  truth.values = step_oscillator<long double>(true, scenario.scene, {6, 60000, 60, {}}).values;
  truth.bars = truth.values;
  const auto probed = [&](const std::string& method) {
    const auto run = [&](const std::string& id, const Scene& scene, const Plan& plan) {
      Recording made = oscillate(id, scene, plan);
      if (id.find("@long-double") != std::string::npos && method == "atwood/rk4") {
        made.outcome.status = Status::unsupported;
        made.outcome.reason = "not in long double";
      }
      return made;
    };
    return run_probe(Probe::ensemble, {scenario, method, {6, 600, 60, {}}, truth, run});
  };
  for (const char* method : {"mine/verlet", "atwood/verlet@quad"}) {
    const auto rows = probed(method);
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].status == Status::unsupported);
    CHECK_THAT(rows[0].reason, Catch::Contains(std::string("`") + method + "` has no wider arithmetic"));
  }
  const auto rows = probed("atwood/rk4");
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].status == Status::unsupported);
  CHECK_THAT(rows[0].reason, Catch::StartsWith("`atwood/rk4@long-double` has no run to compare with (not in long "
                                               "double): round-off cannot be told"));
}

TEST_CASE("probe: cells to which it does not apply are refused by name; a run that fails ends it with the reason") {
  Scenario scenario = oscillator();
  std::get<Spring>(scenario.scene.forces[0]).damping_N_s_per_m = 0.1;
  CHECK(find(ask(Probe::reversal, scenario, "atwood/rk4", 60), "reversal-over-round-off").status ==
        Status::unsupported);
  scenario.scene.forces.push_back(Drive{{0}, {1, 0, 0}, 1, 0});
  CHECK(find(ask(Probe::lyapunov, scenario, "atwood/rk4", 60), "lyapunov-exponent").reason.find("time") !=
        std::string::npos);
  const Truth none;
  const Scenario whole = oscillator();
  const auto fails = [](const std::string&, const Scene&, const Plan&) {
    Recording run;
    run.outcome.status = Status::diverged;
    run.outcome.reason = "no";
    return run;
  };
  const auto rows = run_probe(Probe::symplecticity, {whole, "x/y", {6, 60, 60, {}}, none, fails});
  CHECK(rows.at(0).status == Status::diverged);
  CHECK(rows.at(0).reason == "no");
  CHECK_THROWS_AS(run_probe(Probe::tolerance, {whole, "x/y", {6, 60, 60, {}}, none, fails}), std::logic_error);
}

TEST_CASE("ladder: without a truth three steps tell the error; the V is seen on both sides; tolerances have a slope") {
  const Scenario scenario = oscillator();
  std::vector<LadderEnd> ends;
  std::vector<Row> cells;
  for (const std::int64_t steps : {300, 600, 1200, 2400}) {
    const Recording run = oscillate("verlet", scenario.scene, {6, steps, 60, {}});
    ends.push_back({steps, 6.0 / static_cast<double>(steps), copy_of(run.values.back())});
    Row row;
    row.method = "atwood/velocity-verlet";
    row.metric = "error-position-end";
    row.steps = steps;
    double squares = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double x0 = scenario.scene.bodies[0].position_m[i], v0 = scenario.scene.bodies[0].velocity_m_per_s[i];
      squares += std::pow(
          static_cast<double>(run.values.back().bodies[0].p_m[i]) - x0 * std::cos(6.0) - v0 * std::sin(6.0), 2);
    }
    row.value = std::sqrt(squares);
    cells.push_back(row);
  }
  const auto rows = fit_ends(scenario, ends, cells);
  CHECK(find(rows, "richardson-order-position").value == Approx(2).margin(0.01));
  CHECK(find(rows, "gci-position").reason.find("; asymptotic: orders 2") != std::string::npos);
  const auto of_three = fit_ends(scenario, std::span(ends).last(3), cells);
  CHECK(find(of_three, "gci-position").reason.ends_with("asymptotic range not tested: three steps cannot"));
  for (LadderEnd& end : ends) end.formal_order = 4;
  CHECK(find(fit_ends(scenario, ends, cells), "gci-position").reason.find("; not asymptotic: ") != std::string::npos);
  CHECK(find(rows, "gci-effectivity").value == Approx(0.8).margin(0.01));  // the index is 1.25 of the error
  for (int k = 0; k < 3; ++k) {
    Row row = cells.back();
    row.steps *= 2 << k;
    row.h_s = 6.0 / static_cast<double>(row.steps);
    row.value = 1e-9 * (k + 1);
    cells.push_back(row);
  }
  CHECK(find(fit_round_off_v(cells), "round-off-best-error").value == 1e-9);
  CHECK(fit_round_off_v(std::span(cells).first(6)).empty());  // one finer step alone shows no V
  std::vector<Row> tolerances;
  for (int k = 3; k <= 9; ++k)
    for (const auto& [metric, value] :
         {std::pair{"error-position-max", 40 * std::pow(10.0, -k)}, std::pair{"size-position", 2.0}}) {
      Row row;
      row.method = "atwood/dopri5:1e-" + std::to_string(k);
      row.metric = metric;
      row.value = value;
      row.steps = 60;
      tolerances.push_back(row);
    }
  const auto slopes = fit_tolerances(tolerances);
  CHECK(find(slopes, "tolerance-ratio").value == Approx(20));
  CHECK(find(slopes, "tolerance-exponent").value == Approx(1));
  CHECK(find(slopes, "tolerance-exponent").method == "atwood/dopri5");
}
