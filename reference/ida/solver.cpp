#include "ida/solver.hpp"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>

#include "sundials/sundials.hpp"

namespace atwood::ida {

namespace {

using stepping::Equations;
using stepping::Failure;

class Solver : public stepping::Stepper<double> {
 public:
  Solver(const Options& options, const Equations<double>& equations, const std::vector<double>& y)
      : equations_(equations), f_(y.size()) {
    y_ = N_VNew_Serial(equations.size, context_);
    dydt_ = N_VNew_Serial(equations.size, context_);
    std::copy(y.begin(), y.end(), N_VGetArrayPointer(y_));
    equations.rate(0, y.data(), N_VGetArrayPointer(dydt_));  // consistent with y by definition
    memory_ = IDACreate(context_);
#if SUNDIALS_VERSION_MAJOR < 7
    IDASetErrHandlerFn(memory_, sundials::ignore_messages, nullptr);
#endif
    check(IDASetUserData(memory_, this), 0);
    check(IDAInit(memory_, residual, 0, y_, dydt_), 0);
    check(IDASStolerances(memory_, options.rtol, options.atol), 0);
    check(IDASetMaxOrd(memory_, options.max_order), 0);
    check(IDASetMaxNumSteps(memory_, static_cast<long int>(options.max_steps)), 0);
    matrix_ = SUNDenseMatrix(equations.size, equations.size, context_);
    linear_ = SUNLinSol_Dense(y_, matrix_, context_);
    check(IDASetLinearSolver(memory_, linear_, matrix_), 0);
  }
  ~Solver() override {
    if (memory_ != nullptr) IDAFree(&memory_);
    if (linear_ != nullptr) SUNLinSolFree(linear_);
    if (matrix_ != nullptr) SUNMatDestroy(matrix_);
    for (N_Vector v : {y_, dydt_})
      if (v != nullptr) N_VDestroy(v);
  }

  void step(double, double, std::vector<double>&) override {
    throw Failure(Status::unsupported, "IDA has error control: expected a tolerance, as in ida/bdf:1e-10");
  }
  std::int64_t advance(double, double to_s, std::vector<double>& y) override {
    long int before = 0, after = 0;
    IDAGetNumSteps(memory_, &before);
    check(IDASetStopTime(memory_, to_s), to_s);
    double reached = 0;
    check(IDASolve(memory_, to_s, &reached, y_, dydt_, IDA_NORMAL), reached);
    IDAGetNumSteps(memory_, &after);
    const double* from = N_VGetArrayPointer(y_);
    y.assign(from, from + equations_.size);
    return after - before;
  }

 private:
  static int residual(sunrealtype t, N_Vector y, N_Vector dydt, N_Vector r, void* self) {
    auto* solver = static_cast<Solver*>(self);
    solver->equations_.rate(t, N_VGetArrayPointer(y), solver->f_.data());
    for (int i = 0; i < solver->equations_.size; ++i) {
      if (!std::isfinite(solver->f_[i])) return 1;  // recoverable: IDA tries a shorter step
      N_VGetArrayPointer(r)[i] = N_VGetArrayPointer(dydt)[i] - solver->f_[i];
    }
    return 0;
  }
  void check(int flag, double t_s) const {
    if (flag >= 0) return;
    char* name = IDAGetReturnFlagName(flag);
    const std::string words = std::string("failed at t = ") + std::to_string(t_s) + " s with " + name;
    std::free(name);
    const bool of_rates = flag == IDA_RES_FAIL || flag == IDA_FIRST_RES_FAIL || flag == IDA_REP_RES_ERR;
    throw Failure(of_rates ? Status::not_finite : Status::diverged, words);
  }

  const Equations<double>& equations_;
  std::vector<double> f_;
  sundials::Context owner_;
  SUNContext context_ = static_cast<SUNContext>(owner_.handle);
  N_Vector y_ = nullptr, dydt_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<stepping::Stepper<double>> make_solver(const Options& options, const Equations<double>& equations,
                                                       const std::vector<double>& y) {
  return std::make_unique<Solver>(options, equations, y);
}

}  // namespace atwood::ida
