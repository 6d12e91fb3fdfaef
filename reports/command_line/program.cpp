#include "reports/command_line/program.hpp"

#include <fmt/format.h>

#include "scene/files.hpp"

namespace atwood {
namespace {

std::string setting(const MethodInfo& info, const std::string& name) {
  const auto found = info.settings.find(name);
  const auto* text = found == info.settings.end() ? nullptr : std::get_if<std::string>(&found->second);
  return text ? *text : "";
}

bool flag(const MethodId& id, const std::string& name) {
  const auto found = id.overrides.find(name);
  const auto* value = found == id.overrides.end() ? nullptr : std::get_if<bool>(&found->second);
  return value && *value;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

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
  const BodySample& last = truth.values.back().bodies.at(0);
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

struct Solver {
  std::string compile, includes, solve, claimed;
};

// ---- ARKODE --------------------------------------------------------------------------------------------------------
std::string arkode_halves(bool additive) {
  const std::string whole =
      "static int rate(sunrealtype t, N_Vector y, N_Vector dydt, void*) {\n"
      "  f(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dydt));\n  return 0;\n}\n";
  if (!additive) return whole;
  return whole + R"(static int explicit_half(sunrealtype t, N_Vector y, N_Vector dydt, void* d) {  // positions
  rate(t, y, dydt, d);
  for (int i = 0; i < n; ++i) if (n == 6 ? i >= 3 : i % 2) N_VGetArrayPointer(dydt)[i] = 0;
  return 0;
}
static int implicit_half(sunrealtype t, N_Vector y, N_Vector dydt, void* d) {  // velocities
  rate(t, y, dydt, d);
  for (int i = 0; i < n; ++i) if (n == 6 ? i < 3 : i % 2 == 0) N_VGetArrayPointer(dydt)[i] = 0;
  return 0;
}
)";
}

constexpr const char* kArkodeNewton = R"(
  SUNNonlinearSolver newton = SUNNonlinSol_Newton(v, context);
  SUNMatrix matrix = SUNDenseMatrix(n, n, context);
  SUNLinearSolver dense = SUNLinSol_Dense(v, matrix, context);
  ARKStepSetNonlinearSolver(memory, newton);
  ARKStepSetLinearSolver(memory, dense, matrix);
  ARKStepSStolerances(memory, 1e-13, 1e-15);  // Newton stops at a tenth of this: no spoiler of the order
  ARKStepSetMaxNonlinIters(memory, 20);
  ARKStepSetLSetupFrequency(memory, 1);
  ARKStepSetJacEvalFrequency(memory, 1);)";

// Fixed steps become a tolerance: defaults of the library, and for Newton's users a second run with one of them
// changed.
std::string by_tolerance(std::string solve, const std::string& module, bool newton) {
  solve = replaced(solve, "solve(long steps, real* y)", "solve(double rtol, int cure, real* y)");
  solve = replaced(solve, "  " + module + "SetFixedStep(memory, t_end / steps);\n",
                   "  " + module + "SStolerances(memory, rtol, rtol / 100);\n  " + module +
                       "SetMaxNumSteps(memory, 10000000);\n  " + module + "SetStopTime(memory, t_end);\n" +
                       (newton ? "  if (cure) ARKStepSetNonlinCRDown(memory, 1);\n" : "  (void)cure;\n"));
  solve =
      replaced(solve, "for (long k = 0; k < steps; ++k) " + module + "Evolve(memory, 2 * t_end, v, &t, ARK_ONE_STEP);",
               module + "Evolve(memory, t_end, v, &t, ARK_NORMAL);");
  for (const char* line :
       {"  ARKStepSStolerances(memory, 1e-13, 1e-15);  // Newton stops at a tenth of this: no spoiler of the order\n",
        "  ARKStepSetMaxNonlinIters(memory, 20);\n", "  ARKStepSetLSetupFrequency(memory, 1);\n",
        "  ARKStepSetJacEvalFrequency(memory, 1);"})
    solve = replaced(solve, line, "");
  return solve;
}

Solver arkode(const MethodInfo& info, bool tolerance) {
  const std::string module = setting(info, "module"), e = setting(info, "explicit_table"),
                    i = setting(info, "implicit_table");
  const bool additive = !e.empty() && !i.empty();
  Solver made;
  made.compile = "g++ -std=c++17 -O1 program.cpp -o program -lsundials_arkode -lsundials_nvecserial && ./program";
  made.includes = fmt::format("#include <arkode/arkode_{}.h>\n#include <nvector/nvector_serial.h>\n",
                              module == "ERKStep" ? "erkstep" : "arkstep");
  if (!i.empty())
    made.includes +=
        "#include <sunlinsol/sunlinsol_dense.h>\n#include <sunmatrix/sunmatrix_dense.h>\n#include "
        "<sunnonlinsol/sunnonlinsol_newton.h>\n";
  made.claimed =
      fmt::format("ARKodeButcherTable_Load{}ByName(\"{}\")->q", e.empty() ? "DIRK" : "ERK", e.empty() ? i : e);
  std::string create;
  if (module == "ERKStep") {
    create = fmt::format("ERKStepCreate(rate, 0, v, context);\n  ERKStepSetTableName(memory, \"{}\");", e);
  } else {
    create = fmt::format("ARKStepCreate({}, {}, 0, v, context);\n  ARKStepSetTableName(memory, \"{}\", \"{}\");",
                         additive    ? "explicit_half"
                         : e.empty() ? "nullptr"
                                     : "rate",
                         additive    ? "implicit_half"
                         : i.empty() ? "nullptr"
                                     : "rate",
                         i.empty() ? "ARKODE_DIRK_NONE" : i, e.empty() ? "ARKODE_ERK_NONE" : e);
    if (!i.empty()) create += kArkodeNewton;
  }
  made.solve = arkode_halves(additive) + replaced(replaced(R"(static void solve(long steps, real* y) {
  SUNContext context;
  SUNContext_Create(nullptr, &context);
  N_Vector v = N_VNew_Serial(n, context);
  std::copy(y, y + n, N_VGetArrayPointer(v));
  void* memory = @CREATE@
  @M@SetFixedStep(memory, t_end / steps);
  sunrealtype t = 0;
  for (long k = 0; k < steps; ++k) @M@Evolve(memory, 2 * t_end, v, &t, ARK_ONE_STEP);
  std::copy(N_VGetArrayPointer(v), N_VGetArrayPointer(v) + n, y);
  @M@Free(&memory);
  N_VDestroy(v);
  SUNContext_Free(&context);
}
)",
                                                           "@CREATE@", create),
                                                  "@M@", module);
  if (tolerance) made.solve = by_tolerance(made.solve, module, !i.empty());
  if (!i.empty())
    made.compile = replaced(
        made.compile, " -lsundials_nvecserial",
        " -lsundials_nvecserial -lsundials_sunnonlinsolnewton -lsundials_sunlinsoldense -lsundials_sunmatrixdense");
  return made;
}

// ---- odeint -------------------------------------------------------------------------------------------------------
constexpr const char* kOdeintPlain =
    R"(struct System { void operator()(const state& x, state& dxdt, real t) const { f(t, x.data(), dxdt.data()); } };
static void solve(long steps, real* y) {
  @TYPE@ stepper;
  state x(y, y + n)@OUT@;
  const real h = t_end / steps;
  for (long k = 0; k < steps; ++k) @STEP@
  std::copy(x.begin(), x.end(), y);
}
)";
constexpr const char* kOdeintPairs = R"(struct Force {  // q, p -> p'
  void operator()(const state& q, const state& p, state& a, real t) const {
    real y[n], dydt[n];
    std::copy(q.begin(), q.end(), y);
    std::copy(p.begin(), p.end(), y + n / 2);
    f(t, y, dydt);
    std::copy(dydt + n / 2, dydt + n, a.begin());
  }
  void operator()(const state& q, state& a) const { (*this)(q, q, a, 0); }
};
static void solve(long steps, real* y) {
  @TYPE@ stepper;
  std::pair<state, state> x(state(y, y + n / 2), state(y + n / 2, y + n))@OUT@;
  const real h = t_end / steps;
  for (long k = 0; k < steps; ++k) @STEP@
  std::copy(x.first.begin(), x.first.end(), y);
  std::copy(x.second.begin(), x.second.end(), y + n / 2);
}
)";
constexpr const char* kOdeintImplicit = R"(typedef boost::numeric::ublas::vector<real> vector;
typedef boost::numeric::ublas::matrix<real> matrix;
struct System { void operator()(const vector& x, vector& dxdt, real t) const { f(t, &x[0], &dxdt[0]); } };
struct Jacobian {  // central differences
  void operator()(const vector& x, matrix& J, real t, vector& dfdt) const {
    const real d = 1e-5;
    real from[n], up[n], down[n];
    std::copy(x.begin(), x.end(), from);
    for (int j = 0; j < n; ++j) {
      from[j] = x[j] + d; f(t, from, up);
      from[j] = x[j] - d; f(t, from, down);
      from[j] = x[j];
      for (int i = 0; i < n; ++i) J(i, j) = (up[i] - down[i]) / (2 * d);
    }
    f(t + d, from, up); f(t - d, from, down);
    for (int i = 0; i < n; ++i) dfdt[i] = (up[i] - down[i]) / (2 * d);
  }
  void operator()(const vector& x, matrix& J, real t) const { vector dfdt(n); (*this)(x, J, t, dfdt); }
};
static void solve(long steps, real* y) {
  @TYPE@ stepper;
  vector x(n)@OUT@;
  std::copy(y, y + n, x.begin());
  const real h = t_end / steps;
  const auto system = std::make_pair(System(), Jacobian());
  for (long k = 0; k < steps; ++k) @STEP@
  std::copy(x.begin(), x.end(), y);
}
)";

Solver odeint(const MethodId& id, const MethodInfo& info) {
  const std::string type = setting(info, "stepper"), claim = setting(info, "claim"),
                    name = type.substr(0, type.find('<'));
  if (info.adaptive)
    throw InputError(fmt::format("--program: {} chooses its steps; the program shows an order in the step", info.id));
  const bool implicit = name == "rosenbrock4" || name == "implicit_euler";
  const bool verlet = name == "velocity_verlet", pairs = verlet || name.rfind("symplectic", 0) == 0;
  const bool in_place = flag(id, "in_place") || verlet || name == "implicit_euler";
  const std::string system = implicit ? "system" : pairs ? "Force()" : "System()";
  Solver made;
  made.compile =
      std::string("g++ -std=c++17 -O1 ") + (implicit ? "-DNDEBUG " : "") + "program.cpp -o program && ./program";
  made.includes =
      fmt::format("#include <utility>\n#include <vector>\n#include <boost/numeric/odeint/stepper/{}.hpp>\n", name);
  const std::string corrector = "order() of ";
  if (claim == "its order()") made.claimed = fmt::format("{}().order()", type);
  else if (claim.rfind(corrector, 0) == 0)
    made.claimed = replaced(claim.substr(corrector.size()), ">", ", state, real>") + "().order()";
  else made.claimed = fmt::format("{}", info.claimed_order.empty() ? 0.0 : info.claimed_order.begin()->second);
  if (made.claimed.rfind("adams_moulton<", 0) == 0)
    made.includes += "#include <boost/numeric/odeint/stepper/adams_moulton.hpp>\n";
  made.solve = std::string("using namespace boost::numeric::odeint;\n") +
               (implicit ? "" : "typedef std::vector<real> state;\n") +
               replaced(std::string(implicit ? kOdeintImplicit
                                    : pairs  ? kOdeintPairs
                                             : kOdeintPlain),
                        "@TYPE@", type);
  made.solve = replaced(made.solve, "@OUT@", in_place ? "" : implicit ? ", out(n)" : pairs ? ", out = x" : ", out(n)");
  made.solve =
      replaced(made.solve, "@STEP@",
               in_place ? fmt::format("stepper.do_step({}, x, k * h, h);", system)
                        : fmt::format("{{ stepper.do_step({}, x, k * h, out, h); std::swap(x, out); }}", system));
  return made;
}

}  // namespace

std::string evidence_program(const MethodId& id, const MethodInfo& info, const std::string& version,
                             const Scenario& scenario, const Truth& truth) {
  const bool is_odeint = id.engine == "odeint", wide = id.scalar == "long-double";
  if (!is_odeint && id.engine != "arkode")
    throw InputError(fmt::format("--program: {} is no method of ARKODE or odeint", to_string(id)));
  const bool tolerance = id.rtol.has_value();
  if (tolerance && is_odeint)
    throw InputError("--program: of odeint's methods those with equal steps, not those with a tolerance");
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
