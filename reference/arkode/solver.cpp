#include "arkode/solver.hpp"

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <cmath>

#include "sundials/sundials.hpp"

namespace atwood::arkode {

namespace {

using stepping::Equations;
using stepping::Failure;

class Solver : public stepping::Stepper<double> {
 public:
  Solver(const Options& options, const Equations<double>& equations, const std::vector<double>& y, double h_s)
      : options_(options), equations_(equations) {
    y_ = N_VNew_Serial(equations.size, context_);
    std::copy(y.begin(), y.end(), N_VGetArrayPointer(y_));
    if (options.scheme.module == Module::erkstep) create_erkstep(h_s);
    else create_arkstep(h_s);
  }
  ~Solver() override {
    if (memory_ != nullptr) is_erkstep() ? ERKStepFree(&memory_) : ARKStepFree(&memory_);
    if (nonlinear_ != nullptr) SUNNonlinSolFree(nonlinear_);
    if (linear_ != nullptr) SUNLinSolFree(linear_);
    if (matrix_ != nullptr) SUNMatDestroy(matrix_);
    if (y_ != nullptr) N_VDestroy(y_);
  }

  void step(double t_s, double h_s, std::vector<double>& y) override {
    double reached = t_s;
    check(evolve(t_s + h_s, reached, ARK_ONE_STEP), reached);
    read(y);
  }

  std::int64_t advance(double, double to_s, std::vector<double>& y) override {
    const long int before = steps();
    double reached = 0;
    check(is_erkstep() ? ERKStepSetStopTime(memory_, to_s) : ARKStepSetStopTime(memory_, to_s), to_s);
    check(evolve(to_s, reached, ARK_NORMAL), reached);
    read(y);
    return steps() - before;
  }

 private:
  bool is_erkstep() const { return options_.scheme.module == Module::erkstep; }

  static int all(sunrealtype t, N_Vector y, N_Vector dydt, void* self) {
    const Equations<double>& equations = static_cast<Solver*>(self)->equations_;
    double* to = N_VGetArrayPointer(dydt);
    equations.rate(t, N_VGetArrayPointer(y), to);
    for (int i = 0; i < equations.size; ++i)
      if (!std::isfinite(to[i])) return 1;  // recoverable: ARKODE tries a shorter step
    return 0;
  }
  // The additive split: rates of positions and attitudes explicitly, of velocities and body rates implicitly; of a bare
  // problem the even components explicitly.
  bool is_explicit(int component) const {
    return equations_.positions > 0 ? component < equations_.positions : component % 2 == 0;
  }
  static int part(sunrealtype t, N_Vector y, N_Vector dydt, void* self, bool explicit_half) {
    const int flag = all(t, y, dydt, self);
    double* to = N_VGetArrayPointer(dydt);
    const auto* solver = static_cast<Solver*>(self);
    for (int i = 0; i < solver->equations_.size; ++i)
      if (solver->is_explicit(i) != explicit_half) to[i] = 0;
    return flag;
  }
  static int explicit_part(sunrealtype t, N_Vector y, N_Vector dydt, void* self) {
    return part(t, y, dydt, self, true);
  }
  static int implicit_part(sunrealtype t, N_Vector y, N_Vector dydt, void* self) {
    return part(t, y, dydt, self, false);
  }

  void create_erkstep(double h_s) {
    memory_ = ERKStepCreate(all, 0, y_, context_);
#if SUNDIALS_VERSION_MAJOR < 7
    ERKStepSetErrHandlerFn(memory_, sundials::ignore_messages, nullptr);
#endif
    check(ERKStepSetUserData(memory_, this), 0);
    check(ERKStepSetTableName(memory_, options_.scheme.explicit_table.c_str()), 0);
    check(ERKStepSStolerances(memory_, options_.rtol, options_.atol), 0);
    check(ERKStepSetMaxNumSteps(memory_, static_cast<long int>(options_.max_steps)), 0);
    if (!options_.by_tolerance) check(ERKStepSetFixedStep(memory_, h_s), 0);
  }

  void create_arkstep(double h_s) {
    const Module module = options_.scheme.module;
    const bool additive = module == Module::arkstep_imex;
    memory_ = ARKStepCreate(module == Module::arkstep_implicit ? nullptr
                            : additive                         ? explicit_part
                                                               : all,
                            module == Module::arkstep_explicit ? nullptr
                            : additive                         ? implicit_part
                                                               : all,
                            0, y_, context_);
#if SUNDIALS_VERSION_MAJOR < 7
    ARKStepSetErrHandlerFn(memory_, sundials::ignore_messages, nullptr);
#endif
    check(ARKStepSetUserData(memory_, this), 0);
    const auto name = [](const std::string& text, const char* none) { return text.empty() ? none : text.c_str(); };
    check(ARKStepSetTableName(memory_, name(options_.scheme.implicit_table, "ARKODE_DIRK_NONE"),
                              name(options_.scheme.explicit_table, "ARKODE_ERK_NONE")),
          0);
    check(ARKStepSStolerances(memory_, options_.rtol, options_.atol), 0);
    check(ARKStepSetMaxNumSteps(memory_, static_cast<long int>(options_.max_steps)), 0);
    if (!options_.by_tolerance) check(ARKStepSetFixedStep(memory_, h_s), 0);
    if (module != Module::arkstep_explicit) attach_newton();
  }

  void attach_newton() {
    nonlinear_ = SUNNonlinSol_Newton(y_, context_);
    check(ARKStepSetNonlinearSolver(memory_, nonlinear_), 0);
    matrix_ = SUNDenseMatrix(equations_.size, equations_.size, context_);
    linear_ = SUNLinSol_Dense(y_, matrix_, context_);
    check(ARKStepSetLinearSolver(memory_, linear_, matrix_), 0);
    check(ARKStepSetNonlinConvCoef(memory_, options_.nonlinear_coefficient), 0);
    if (options_.nonlinear_crdown > 0) check(ARKStepSetNonlinCRDown(memory_, options_.nonlinear_crdown), 0);
    if (options_.nonlinear_iterations > 0) check(ARKStepSetMaxNonlinIters(memory_, options_.nonlinear_iterations), 0);
    if (options_.by_tolerance) return;
    if (options_.nonlinear_iterations == 0) check(ARKStepSetMaxNonlinIters(memory_, 20), 0);
    check(ARKStepSetLSetupFrequency(memory_, 1), 0);  // a new Newton matrix at each step, for fast convergence
    check(ARKStepSetJacEvalFrequency(memory_, 1), 0);
  }

  int evolve(double to_s, double& reached, int task) {
    return is_erkstep() ? ERKStepEvolve(memory_, to_s, y_, &reached, task)
                        : ARKStepEvolve(memory_, to_s, y_, &reached, task);
  }
  long int steps() const {
    long int now = 0;
    is_erkstep() ? ERKStepGetNumSteps(memory_, &now) : ARKStepGetNumSteps(memory_, &now);
    return now;
  }
  void read(std::vector<double>& y) const {
    const double* from = N_VGetArrayPointer(y_);
    y.assign(from, from + equations_.size);
  }

  void check(int flag, double t_s) const {
    if (flag >= 0) return;
    char* name = ARKStepGetReturnFlagName(flag);
    std::string words = std::string("failed at t = ") + std::to_string(t_s) + " s with " + name;
    std::free(name);
    const bool of_rates = flag == ARK_RHSFUNC_FAIL || flag == ARK_FIRST_RHSFUNC_ERR || flag == ARK_REPTD_RHSFUNC_ERR ||
                          flag == ARK_UNREC_RHSFUNC_ERR;
    throw Failure(of_rates ? Status::not_finite : Status::diverged, words);
  }

  Options options_;
  const Equations<double>& equations_;
  sundials::Context owner_;
  SUNContext context_ = static_cast<SUNContext>(owner_.handle);
  N_Vector y_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
  SUNNonlinearSolver nonlinear_ = nullptr;
  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<stepping::Stepper<double>> make_solver(const Options& options, const Equations<double>& equations,
                                                       const std::vector<double>& y, double h_s) {
  return std::make_unique<Solver>(options, equations, y, h_s);
}

}  // namespace atwood::arkode
