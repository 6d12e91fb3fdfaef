#include "reports/command_line/program.hpp"

#include <fmt/format.h>

#include "reports/command_line/program_solvers.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

// ---- the problem: y = (p, v), or (x, y, z) -----------------------------------------------------------------------
struct Written {
  int size = 6;
  std::string rate, start, end;
};

std::string list(const std::vector<std::string>& numbers) { return fmt::format("{{{}}}", fmt::join(numbers, ", ")); }
std::string list(const Real3& v) { return list({format_double(v[0]), format_double(v[1]), format_double(v[2])}); }

std::string acceleration(const Force& force, const Body& body, const std::string& scene) {
  const std::string mass = format_double(body.mass_kg);
  if (const auto* pull = std::get_if<Attractor>(&force)) {
    return fmt::format(
        "  {{ const real c[3] = {}, d[3] = {{p[0] - c[0], p[1] - c[1], p[2] - c[2]}};\n"
        "    const real r = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);\n"
        "    for (int i = 0; i < 3; ++i) a[i] -= real({}) * d[i] / (r * r * r); }}\n",
        list(pull->center_m), format_double(pull->mu_m3_per_s2));
  }
  if (const auto* spring = std::get_if<Spring>(&force);
      spring && spring->bodies.size() == 1 && spring->rest_length_m == 0) {
    return fmt::format(
        "  {{ const real c[3] = {}, d[3] = {{p[0] - c[0], p[1] - c[1], p[2] - c[2]}};\n"
        "    const real dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], dv = d[0] * v[0] + d[1] * v[1] + d[2] * v[2];\n"
        "    for (int i = 0; i < 3; ++i) a[i] -= (real({}) * d[i] + real({}) * dv / dd * d[i]) / real({}); }}\n",
        list(spring->anchor_m), format_double(spring->stiffness_N_per_m), format_double(spring->damping_N_s_per_m),
        mass);
  }
  if (const auto* drive = std::get_if<Drive>(&force)) {
    return fmt::format(
        "  {{ const real F[3] = {};\n"
        "    for (int i = 0; i < 3; ++i) a[i] += F[i] * std::cos(real({}) * t + real({})) / real({}); }}\n",
        list(drive->force_N), format_double(drive->angular_frequency_rad_per_s), format_double(drive->phase_rad), mass);
  }
  if (const auto* field = std::get_if<Lorentz>(&force)) {
    return fmt::format(
        "  {{ const real E[3] = {}, B[3] = {}, s = real({}) / real({});\n"
        "    for (int i = 0; i < 3; ++i) {{ const int j = (i + 1) % 3, k = (i + 2) % 3; a[i] += s * (E[i] + v[j] * "
        "B[k] - v[k] * B[j]); }} }}\n",
        list(field->electric_V_per_m), list(field->magnetic_T), format_double(body.charge_C), mass);
  }
  throw InputError(fmt::format(
      "--program: `{}` has a force that the printed program does not know; it knows attractor, spring to an "
      "anchor, drive and lorentz",
      scene));
}

std::string digits(Wide value, bool wide) { return format_number(value, wide ? 21 : 17) + (wide ? "L" : ""); }

Written write_problem(const Scenario& scenario, const Truth& truth, bool wide) {
  const Scene& scene = scenario.scene;
  Written made;
  if (scene.bodies.size() != 1 || rotates(scene.bodies[0]) || scene.bodies[0].fixed || truth.values.empty()) {
    throw InputError(fmt::format("--program: `{}` is not one moving point mass", scenario.id));
  }
  const Body& body = scene.bodies[0];
  const BodySample& last = checked(truth.values.back().bodies, 0);
  std::vector<std::string> start, end;
  for (const Real3* v : {&body.position_m, &body.velocity_m_per_s})
    for (int i = 0; i < 3; ++i) start.push_back(format_double((*v)[static_cast<std::size_t>(i)]));
  for (const auto* v : {&last.p_m, &last.v_m_per_s})
    for (int i = 0; i < 3; ++i) end.push_back(digits((*v)[static_cast<std::size_t>(i)], wide));
  if (!scene.problem.empty()) {
    made.size = 3;
    start.resize(3);
    end.resize(3);
    made.rate =
        "  (void)t;\n  dydt[0] = 10 * (y[1] - y[0]);\n  dydt[1] = y[0] * (28 - y[2]) - y[1];\n  dydt[2] = y[0] * y[1] "
        "- real(8) / 3 * y[2];\n";
  } else {
    made.rate = fmt::format(
        "  (void)t;\n  const real *p = y, *v = y + 3, g[3] = {};\n  real* a = dydt + 3;\n"
        "  for (int i = 0; i < 3; ++i) {{ dydt[i] = v[i]; a[i] = g[i]; }}\n",
        list(scene.gravity_m_per_s2));
    for (const Force& force : scene.forces) made.rate += acceleration(force, body, scenario.id);
  }
  made.start = list(start);
  made.end = list(end);
  return made;
}

// ---- the frame: rate, ladder, verdict ------------------------------------------------------------------------------
constexpr const char* kFrame = R"frame(// @WHAT@
// claims order @CLAIM@ (@FROM@); this shows the order it executes on `@SCENE@`, t = 0 to @T@.
// @COMPILE@
#include <algorithm>
#include <cmath>
#include <cstdio>
@INCLUDES@
typedef @REAL@ real;
static const int n = @N@;
static const real t_end = @T@, start[n] = @START@,
                  exact[n] = @END@;  // at t_end: @SOURCE@

static void f(real t, const real* y, real* dydt) {
@RATE@}

@SOLVE@
int main() {
  const double claimed = @CLAIMED@;
  const long ladder[] = {@LADDER@};
  double x[4], e[4], last_h = 0, last_error = 0;
  int rungs = 0;
  for (const long steps : ladder) {
    real y[n];
    std::copy(start, start + n, y);
    solve(steps, y);
    real sum = 0;
    for (int i = 0; i < (n == 3 ? 3 : n / 2); ++i) sum += (y[i] - exact[i]) * (y[i] - exact[i]);
    const double h = double(t_end / steps), error = double(std::sqrt(sum));
    const double slope = std::log(last_error / error) / std::log(last_h / h);
    const bool counts = std::isfinite(error) && error > @FLOOR@;  // above round-off
    std::printf("%8ld steps  error %.3e%s", steps, error, counts ? "" : "  (round-off, not counted)");
    if (rungs > 0 && counts) std::printf("  slope %.2f", slope);
    std::printf("\n");
    if (counts) {
      if (rungs >= 4) for (int i = 0; i < 3; ++i) { x[i] = x[i + 1]; e[i] = e[i + 1]; }
      x[std::min(rungs, 3)] = std::log(h);
      e[std::min(rungs, 3)] = std::log(error);
      ++rungs;
      last_h = h;
      last_error = error;
    }
  }
  if (rungs < 4) return std::printf("claimed %g, executed ?: inconclusive\n", claimed), 0;
  double mx = 0, me = 0, sxx = 0, sxe = 0;  // least squares over the four finest
  for (int i = 0; i < 4; ++i) { mx += x[i] / 4; me += e[i] / 4; }
  for (int i = 0; i < 4; ++i) { sxx += (x[i] - mx) * (x[i] - mx); sxe += (x[i] - mx) * (e[i] - me); }
  const double order = sxe / sxx;
  const bool whole = std::fabs(order - std::round(order)) <= 0.25;
  std::printf("claimed %g, executed %.2f: %s\n", claimed, order, std::fabs(order - claimed) <= 0.25 ? "as claimed"
              : !whole ? "inconclusive" : order < claimed ? "lower" : "higher");
}
)frame";

// The same for a method that chooses its steps: the error ought to follow the tolerance.
constexpr const char* kToleranceMain = R"frame(int main() {
  const double tolerances[] = {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};
  const int m = 6;
  double mx = 0, me = 0, sxx = 0, sxe = 0, x[m], e[m], least = HUGE_VAL, most = 0;
  for (int k = 0; k < m; ++k) {
    double error[2] = {0, 0};
    for (int cure = 0; cure < @CURES@; ++cure) {
      real y[n];
      std::copy(start, start + n, y);
      solve(tolerances[k], cure, y);
      for (int i = 0; i < (n == 3 ? 3 : n / 2); ++i) error[cure] += double((y[i] - exact[i]) * (y[i] - exact[i]));
      error[cure] = std::sqrt(error[cure]);
    }
    std::printf("rtol %.0e  error %.2e (%.0f rtol)", tolerances[k], error[0], error[0] / tolerances[k]);
    if (@CURES@ > 1) std::printf("   @CURE_NAME@: error %.2e (%.0f rtol)", error[1], error[1] / tolerances[k]);
    std::printf("\n");
    least = std::min(least, error[0] / tolerances[k]);
    most = std::max(most, error[0] / tolerances[k]);
    mx += (x[k] = std::log(tolerances[k])) / m;
    me += (e[k] = std::log(error[0])) / m;
  }
  for (int k = 0; k < m; ++k) { sxx += (x[k] - mx) * (x[k] - mx); sxe += (x[k] - mx) * (e[k] - me); }
  std::printf("claimed: error ~ rtol^1, executed: error ~ rtol^%.2f, %.1f to %.1f times it: %s\n", sxe / sxx, least, most,
              most > 100 && (sxe / sxx < 0.5 || most > 1000 * least) ? "lower" : "as claimed");
}
)frame";

// Coarse to fine, from the catalogue's first rung: ratios that a method of order 8 in double and one of order 1 can
// both use.
std::string ladder(const Scenario& scenario) {
  const std::int64_t first = scenario.steps.empty() ? 240 : scenario.steps.front();
  std::vector<std::int64_t> rungs;
  for (const std::int64_t quarters : {4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 256, 512})
    rungs.push_back(first * quarters / 4);
  return fmt::format("{}", fmt::join(rungs, ", "));
}

// The frame up to its main, then the other main.
std::string tolerance_frame() {
  const std::string frame = kFrame;
  return replaced(frame.substr(0, frame.find("int main() {")),
                  "claims order @CLAIM@ (@FROM@); this shows the order it executes",
                  "is given tolerances; this shows whether its error follows them") +
         kToleranceMain;
}

}  // namespace

std::string evidence_program(const MethodId& id, const MethodInfo& info, const std::string& version,
                             const Scenario& scenario, const Truth& truth) {
  const bool is_odeint = id.engine == "odeint", wide = id.scalar == "long-double";
  if (!is_odeint && id.engine != "arkode")
    throw InputError(fmt::format("--program: {} is not a method of ARKODE or odeint", to_string(id)));
  const bool tolerance = id.rtol.has_value();
  if (tolerance && is_odeint)
    throw InputError("--program: found an odeint method with a tolerance; expected one with equal steps");
  const Written problem = write_problem(scenario, truth, wide);
  const Solver solver = is_odeint ? odeint(id, info) : arkode(info, tolerance);
  const std::string claim = setting(info, "claim");
  const bool newton = !setting(info, "implicit_table").empty();
  std::string text = tolerance ? tolerance_frame() : kFrame;
  for (const auto& [from, to] : std::initializer_list<std::pair<std::string, std::string>>{
           {"@WHAT@", fmt::format("{} {}{}", is_odeint ? "Boost.odeint," : "SUNDIALS ARKODE", version,
                                  ": " + to_string(id).substr(id.engine.size() + 1))},
           {"@CLAIM@", fmt::format("{}", info.claimed_order.empty() ? 0.0 : info.claimed_order.begin()->second)},
           {"@FROM@", is_odeint ? claim : "the q of its table"},
           {"@COMPILE@", solver.compile},
           {"@INCLUDES@", solver.includes},
           {"@SOLVE@", solver.solve},
           {"@CLAIMED@", solver.claimed},
           {"@CURES@", newton ? "2" : "1"},
           {"@CURE_NAME@", "with ARKStepSetNonlinCRDown(memory, 1)"},
           {"@SCENE@", scenario.id},
           {"@T@", format_double(scenario.t_end_s)},
           {"@REAL@", wide ? "long double" : "double"},
           {"@N@", fmt::format("{}", problem.size)},
           {"@START@", problem.start},
           {"@END@", problem.end},
           {"@SOURCE@", truth.source},
           {"@RATE@", problem.rate},
           {"@LADDER@", ladder(scenario)},
           {"@FLOOR@", wide ? "1e-15" : "2e-12"}}) {
    text = replaced(text, from, to);
  }
  return text;
}

}  // namespace atwood
