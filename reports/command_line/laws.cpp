// Figures that a formula predicts. Each formula is derived at its function; the report prints prediction and figure.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"

namespace atwood {

namespace {

double norm(const Real3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

const Scenario* find_scenario(const std::vector<Scenario>& scenarios, const std::string& id) {
  const auto found = std::find_if(scenarios.begin(), scenarios.end(), [&](const Scenario& s) { return s.id == id; });
  return found == scenarios.end() ? nullptr : &*found;
}

bool only_gravity(const Scene& scene) {
  return scene.problem.empty() && scene.forces.empty() && scene.bodies.size() == 1 && norm(scene.gravity_m_per_s2) > 0;
}

// Explicit Euler on a parabola: x_n is exact, z_n = exact + g t h / 2, i.e. the exact parabola of a later landing by
// one step: with v_z0 = g T / 2, z(t) = v_z0 t - g t (t - h) / 2 = 0 at t = T + h. So the landing is v_x h far.
// Symplectic Euler is the mirror image, t = T - h: v_x h short.
void euler_landing(const Scenario& scenario, const Row& row, std::vector<Law>& laws) {
  if (row.metric != "landing-range-error" || row.steps == 0) return;
  const bool is_explicit = row.method == "atwood/explicit-euler";
  const bool is_symplectic = row.method == "atwood/symplectic-euler";
  if (!is_explicit && !is_symplectic) return;
  const auto& v = scenario.scene.bodies[0].velocity_m_per_s;
  laws.push_back(
      {scenario.id, row.method, row.metric,
       fmt::format("one step {} on its own parabola: {}v_x h", is_explicit ? "late" : "early", is_explicit ? "" : "-"),
       row.steps, (is_explicit ? 1 : -1) * v[0] * row.h_s, row.value, row.unit});
}

// Semi-implicit Euler under uniform gravity: z_n = exact - g t h / 2 (sum of n (n + 1) / 2 steps of g h^2).
void semi_implicit_fall(const Scenario& scenario, const Row& row, std::vector<Law>& laws) {
  if (row.metric != "error-position-end" || row.steps == 0 || !only_gravity(scenario.scene)) return;
  const std::string engine = engine_of(row.method);
  const bool semi_implicit =
      row.method == "atwood/symplectic-euler" || engine == "bullet64" || engine == "bullet32" || engine == "ode";
  if (!semi_implicit) return;
  const double predicted = norm(scenario.scene.gravity_m_per_s2) * scenario.t_end_s * row.h_s / 2;
  laws.push_back({scenario.id, row.method, row.metric, "semi-implicit Euler falls too far: g t h / 2", row.steps,
                  predicted, row.value, row.unit});
}

// The error by float: the same engine and step in both precisions.
void cost_of_float(const std::vector<Row>& rows, std::vector<Law>& laws) {
  std::map<std::tuple<std::string, std::int64_t, std::string>, const Row*> wide;
  for (const auto& row : rows) {
    if (row.steps > 0 && row.body.empty() && !row.t_s && engine_of(row.method) == "bullet64") {
      wide[{row.scenario, row.steps, row.metric + row.method.substr(row.method.find('/'))}] = &row;
    }
  }
  for (const auto& row : rows) {
    if (row.steps == 0 || engine_of(row.method) != "bullet32" || !row.body.empty() || row.t_s) continue;
    if (row.metric != "error-position-end" && row.metric != "error-attitude-end") continue;
    const auto found = wide.find({row.scenario, row.steps, row.metric + row.method.substr(row.method.find('/'))});
    if (found == wide.end() || !std::isfinite(row.value) || !std::isfinite(found->second->value)) continue;
    if (row.scenario != "free-box-complex" && row.scenario != "ballistic" && row.scenario != "free-box-simple")
      continue;
    laws.push_back({row.scenario, row.method, row.metric,
                    "what float costs: measured in float, beside the same engine in double", row.steps,
                    found->second->value, row.value, row.unit});
  }
}

}  // namespace

std::vector<Law> find_laws(const std::vector<Scenario>& scenarios, const std::vector<Row>& rows) {
  std::vector<Law> laws;
  for (const auto& row : rows) {
    if (row.status != Status::ok || !row.body.empty() || row.t_s) continue;
    const Scenario* scenario = find_scenario(scenarios, row.scenario);
    if (!scenario || scenario->scene.bodies.empty()) continue;
    if (row.scenario == "ballistic") euler_landing(*scenario, row, laws);
    if (row.scenario == "ballistic" || row.scenario == "free-box-complex") semi_implicit_fall(*scenario, row, laws);
  }
  cost_of_float(rows, laws);
  return laws;
}

}  // namespace atwood
