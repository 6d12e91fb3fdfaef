#include "cvode/solver.hpp"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <cmath>

#include "sundials/sundials.hpp"

namespace atwood::cvode {

struct Solver::Parts {
  Options options;
  std::vector<double> atol;
  int size = 0;
  Rate rate;
  Roots g;
  int roots = 0;
  std::int64_t evaluations = 0, steps_before = 0;
  bool not_finite = false, created = false;
  std::string failure;
  sundials::Context owner;
  SUNContext context = static_cast<SUNContext>(owner.handle);
  N_Vector y = nullptr, derivative = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  SUNNonlinearSolver nonlinear = nullptr;
  void* memory = nullptr;

  static int evaluate(sunrealtype t, N_Vector y, N_Vector dydt, void* self) {
    auto* parts = static_cast<Parts*>(self);
    ++parts->evaluations;
    const double* from = N_VGetArrayPointer(y);
    double* to = N_VGetArrayPointer(dydt);
    parts->rate(t, from, to);
    for (int i = 0; i < parts->size; ++i)
      if (!std::isfinite(to[i])) return 1;  // recoverable: CVODE tries a shorter step
    return 0;
  }
  static int evaluate_roots(sunrealtype t, N_Vector y, sunrealtype* g, void* self) {
    static_cast<Parts*>(self)->g(t, N_VGetArrayPointer(y), g);
    return 0;
  }

  std::int64_t steps_now() const {
    long int now = 0;
    if (created) CVodeGetNumSteps(memory, &now);
    return now;
  }

  std::int64_t steps_left() const {
    return options.max_steps - steps_now() - (options.limit_per_segment ? 0 : steps_before);
  }

  // What CVode() has answered.
  Stop ended(int flag, double reached, double& t_s, std::vector<double>& state) {
    const double* from = N_VGetArrayPointer(y);
    if (flag < 0) {
      char* name = CVodeGetReturnFlagName(flag);
      failure = std::string("CVODE failed at t = ") + std::to_string(reached) + " s with " + name;
      std::free(name);
      if (flag == CV_TOO_MUCH_WORK) failure += ": " + std::to_string(options.max_steps) + " steps";
      // The rate was not finite even with the shortest step.
      not_finite = flag == CV_RHSFUNC_FAIL || flag == CV_FIRST_RHSFUNC_ERR || flag == CV_REPTD_RHSFUNC_ERR ||
                   flag == CV_UNREC_RHSFUNC_ERR;
      return Stop::failed;
    }
    t_s = reached;
    state.assign(from, from + size);
    if (!std::all_of(state.begin(), state.end(), [](double v) { return std::isfinite(v); })) {
      not_finite = true;
      failure = "the state is not finite at t = " + std::to_string(reached) + " s";
      return Stop::failed;
    }
    return flag == CV_ROOT_RETURN ? Stop::root : Stop::reached;
  }

  // The k-th derivative at the step's end is k! / h^k times a coefficient of CVODE's polynomial.
  void read(Trajectory& path) {
    int order = 0;
    CVodeGetCurrentOrder(memory, &order);
    CVodeGetCurrentTime(memory, &path.t_s);
    CVodeGetLastStep(memory, &path.span_s);
    path.c.resize(static_cast<std::size_t>(order) + 1);
    if (derivative == nullptr) derivative = N_VNew_Serial(size, context);
    double factor = 1;
    for (int k = 0; k <= order; ++k) {
      if (k > 0) factor *= path.span_s / k;
      CVodeGetDky(memory, path.t_s, k, derivative);
      const double* from = N_VGetArrayPointer(derivative);
      path.c[k].resize(size);
      for (int i = 0; i < size; ++i) path.c[k][i] = factor * from[i];
    }
  }

  void create(double t_s) {
    memory = CVodeCreate(options.family == Family::adams ? CV_ADAMS : CV_BDF, context);
#if SUNDIALS_VERSION_MAJOR < 7
    CVodeSetErrHandlerFn(memory, sundials::ignore_messages, nullptr);
#endif
    CVodeInit(memory, evaluate, t_s, y);
    CVodeSetUserData(memory, this);
    N_Vector each = N_VNew_Serial(size, context);
    std::copy(atol.begin(), atol.end(), N_VGetArrayPointer(each));
    CVodeSVtolerances(memory, options.rtol, each);  // keeps a copy
    N_VDestroy(each);
    CVodeSetMaxOrd(memory, options.max_order);
    if (options.family == Family::adams || !options.newton) {
      nonlinear = SUNNonlinSol_FixedPoint(y, 0, context);
      CVodeSetNonlinearSolver(memory, nonlinear);
    } else {
      nonlinear = SUNNonlinSol_Newton(y, context);
      CVodeSetNonlinearSolver(memory, nonlinear);
      matrix = SUNDenseMatrix(size, size, context);
      linear = SUNLinSol_Dense(y, matrix, context);
      CVodeSetLinearSolver(memory, linear, matrix);
    }
    created = true;
  }

  ~Parts() {
    if (memory != nullptr) CVodeFree(&memory);
    if (nonlinear != nullptr) SUNNonlinSolFree(nonlinear);
    if (linear != nullptr) SUNLinSolFree(linear);
    if (matrix != nullptr) SUNMatDestroy(matrix);
    for (N_Vector each : {y, derivative})
      if (each != nullptr) N_VDestroy(each);
  }
};

Solver::Solver(const Options& options, const std::vector<double>& atol, Rate rate) : parts_(std::make_unique<Parts>()) {
  const int size = static_cast<int>(atol.size());
  parts_->options = options;
  parts_->atol = atol;
  parts_->size = size;
  parts_->rate = std::move(rate);
  parts_->y = N_VNew_Serial(size, parts_->context);
}
Solver::~Solver() = default;

void Solver::start(double t_s, const std::vector<double>& y, double stop_s, int roots, Roots g) {
  Parts& p = *parts_;
  std::copy(y.begin(), y.end(), N_VGetArrayPointer(p.y));
  p.steps_before += p.steps_now();
  if (p.created) CVodeReInit(p.memory, t_s, p.y);
  else p.create(t_s);
  p.roots = roots;
  p.g = std::move(g);
  CVodeRootInit(p.memory, roots, roots > 0 ? Parts::evaluate_roots : nullptr);
  if (roots > 0) {
    std::vector<int> falling(roots, -1);
    CVodeSetRootDirection(p.memory, falling.data());
    CVodeSetNoInactiveRootWarn(p.memory);
  }
  CVodeSetStopTime(p.memory, stop_s);
}

Stop Solver::advance(double target_s, double& t_s, std::vector<double>& y) {
  Parts& p = *parts_;
  // CVODE refuses a target this close to the time (CV_TOO_CLOSE).
  if (target_s - t_s <= 4e-16 * std::fmax(std::fabs(t_s), std::fabs(target_s))) return Stop::reached;
  CVodeSetMaxNumSteps(p.memory, static_cast<long int>(std::max<std::int64_t>(p.steps_left(), 1)));
  sunrealtype reached = t_s;
  const int flag = CVode(p.memory, target_s, p.y, &reached, CV_NORMAL);
  return p.ended(flag, reached, t_s, y);
}

Stop Solver::step(double stop_s, double& t_s, std::vector<double>& y, Trajectory& path) {
  Parts& p = *parts_;
  if (stop_s - t_s <= 4e-16 * std::fmax(std::fabs(t_s), std::fabs(stop_s))) {
    path = {stop_s, 1, {y}};
    t_s = stop_s;
    return Stop::reached;
  }
  sunrealtype reached = t_s;
  const int flag =
      p.steps_left() > 0 ? CVode(p.memory, stop_s, p.y, &reached, CV_ONE_STEP) : static_cast<int>(CV_TOO_MUCH_WORK);
  const Stop made = p.ended(flag, reached, t_s, y);
  if (made != Stop::failed) p.read(path);
  return made;
}

const std::string& Solver::failure() const { return parts_->failure; }
bool Solver::not_finite() const { return parts_->not_finite; }
std::int64_t Solver::steps() const { return parts_->steps_before + parts_->steps_now(); }
std::int64_t Solver::rate_evaluations() const { return parts_->evaluations; }

std::string version() { return sundials::version(); }

}  // namespace atwood::cvode
