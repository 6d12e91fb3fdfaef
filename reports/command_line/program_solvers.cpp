#include "reports/command_line/program_solvers.hpp"

#include <fmt/format.h>

#include "scene/files.hpp"

namespace atwood {
namespace {

bool flag(const MethodId& id, const std::string& name) {
  const auto found = id.overrides.find(name);
  const auto* value = found == id.overrides.end() ? nullptr : std::get_if<bool>(&found->second);
  return value && *value;
}

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

}  // namespace

std::string setting(const MethodInfo& info, const std::string& name) {
  const auto found = info.settings.find(name);
  const auto* text = found == info.settings.end() ? nullptr : std::get_if<std::string>(&found->second);
  return text ? *text : "";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
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

}  // namespace atwood
