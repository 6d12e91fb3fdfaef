#include "ida/mechanism.hpp"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>

#include "dynamics/rates.hpp"
#include "mechanism/reduced.hpp"
#include "mechanism/start.hpp"
#include "protocol/refusal.hpp"
#include "scene/mechanism.hpp"
#include "sundials/sundials.hpp"

namespace atwood::ida {

namespace {

constexpr double kMultiplierTolerance = 1e8;

std::string uncovered(const Scene& scene) {
  for (const std::string& why : {mechanism::unsupported(scene), dynamics::unsupported(scene)})
    if (!why.empty()) return why;
  for (const Joint& joint : scene.joints)
    if (joint.limits) return "joint `" + joint.name + "` has stops, whose impacts IDA's adapter does not locate";
  for (const Body& body : scene.bodies)
    if (!body.fixed && body.release_s > 0) return "`" + body.name + "` is held until its release: not covered";
  return "";
}

// Owns one integration and the memory of IDA for it.
class Integration {
 public:
  Integration(const Scene& scene, double t_end_s, const Options& options, const Sample& start)
      : options_(options), motion_(scene, t_end_s, start), wide_(scene, t_end_s, start), y(motion_.initial(start)) {}
  ~Integration() { release(); }
  Integration(const Integration&) = delete;

  const std::vector<double>& switch_times() const { return motion_.equations().switch_times(); }
  Sample sample(double t_s) { return motion_.sample(t_s, y.data()); }

  // (Re)starts with consistent rates and multipliers. The rows are chosen in quad.
  void start(double t_s, int interval, double stop_s) {
    release();
    if (motion_.size() == 0) return;  // nothing moves but by drives
    const std::vector<Wide> wide(y.begin(), y.end());
    wide_.choose(t_s, wide.data());
    motion_.choice.chosen = wide_.choice.chosen;
    motion_.choice.interval = interval;
    motion_.choice.interval_s = t_s + (stop_s - t_s) / 2;
    motion_.remember_branches(y.data());
    constraints_ = static_cast<int>(motion_.choice.chosen.size());
    const int n = motion_.size() + 2 * constraints_;
    Y_ = N_VNew_Serial(n, context_);
    rate_ = N_VNew_Serial(n, context_);
    N_Vector atol = N_VNew_Serial(n, context_);
    N_VConst(0, Y_);
    N_VConst(0, rate_);
    N_VConst(kMultiplierTolerance, atol);
    std::fill_n(N_VGetArrayPointer(atol), motion_.size(), options_.atol);
    std::copy(y.begin(), y.end(), N_VGetArrayPointer(Y_));
    motion_.rate(t_s, y.data(), N_VGetArrayPointer(rate_));
    const std::vector<double> multipliers = motion_.multipliers(t_s, y.data());
    std::copy(multipliers.begin(), multipliers.end(), N_VGetArrayPointer(Y_) + motion_.size());
    memory_ = IDACreate(context_);
#if SUNDIALS_VERSION_MAJOR < 7
    IDASetErrHandlerFn(memory_, sundials::ignore_messages, nullptr);
#endif
    IDASetUserData(memory_, this);
    IDAInit(memory_, residual, t_s, Y_, rate_);
    IDASVtolerances(memory_, options_.rtol, atol);
    N_VDestroy(atol);
    IDASetMaxOrd(memory_, options_.max_order);
    IDASetMaxNumSteps(memory_, static_cast<long int>(options_.max_steps));
    matrix_ = SUNDenseMatrix(n, n, context_);
    linear_ = SUNLinSol_Dense(Y_, matrix_, context_);
    IDASetLinearSolver(memory_, linear_, matrix_);
  }

  // False: failure says why.
  bool advance(double to_s) {
    if (motion_.size() == 0) return true;
    IDASetStopTime(memory_, to_s);
    for (double reached = 0; reached < to_s;) {
      const int flag = IDASolve(memory_, to_s, &reached, Y_, rate_, IDA_ONE_STEP);
      if (flag < 0) {
        char* name = IDAGetReturnFlagName(flag);
        failure = std::string("IDA failed at t = ") + format_double(reached) + " s with " + name;
        std::free(name);
        return false;
      }
      const double* from = N_VGetArrayPointer(Y_);
      y.assign(from, from + motion_.size());
      if (!std::all_of(y.begin(), y.end(), [](double v) { return std::isfinite(v); })) {
        failure = "the state is not finite at t = " + format_double(reached) + " s";
        return false;
      }
      motion_.remember_branches(y.data());  // angles go on to the nearest turn from step to step
      if (slackens(reached)) return false;
    }
    return true;
  }
  std::int64_t steps() const {
    long int now = 0;
    if (memory_ != nullptr) IDAGetNumSteps(memory_, &now);
    return steps_before_ + now;
  }

 private:
  // A rope cannot push: a tension below 0 ends the run.
  bool slackens(double t_s) {
    const std::vector<Rope>& ropes = motion_.model().scene->ropes;
    if (ropes.empty()) return false;
    const Sample now = motion_.sample(t_s, y.data());
    for (std::size_t k = 0; k < ropes.size(); ++k) {
      if (!(now.ropes[k].tension_N < 0)) continue;
      failure = "rope `" + ropes[k].name + "` is slack at t = " + format_double(t_s) + " s";
      return true;
    }
    return false;
  }
  static int residual(sunrealtype t, N_Vector Y, N_Vector rate, N_Vector r, void* self) {
    return static_cast<Integration*>(self)->evaluate(t, N_VGetArrayPointer(Y), N_VGetArrayPointer(rate),
                                                     N_VGetArrayPointer(r));
  }
  int evaluate(double t, const double* Y, const double* rate, double* r) {
    ++evaluations;
    const int nq = motion_.coordinate_count(), nv = motion_.rate_count(), n = nq + nv;
    const double *lambda = Y + n, *mu = lambda + constraints_;
    motion_.constrained(t, Y, g_, g_rate_, G_);
    std::vector<double> u(Y + nq, Y + n), q_rate(static_cast<std::size_t>(nq));
    for (int i = 0; i < constraints_; ++i)
      for (int k = 0; k < nv; ++k) u[k] += mu[i] * G_[i][k];
    motion_.coordinate_rates(Y, u.data(), q_rate.data());
    for (int k = 0; k < nq; ++k) r[k] = rate[k] - q_rate[k];
    const std::vector<double> imbalance = motion_.imbalance(t, Y, rate + nq, lambda);
    std::copy(imbalance.begin(), imbalance.end(), r + nq);
    std::copy(g_.begin(), g_.end(), r + n);
    std::copy(g_rate_.begin(), g_rate_.end(), r + n + constraints_);
    return std::all_of(r, r + n + 2 * constraints_, [](double x) { return std::isfinite(x); }) ? 0 : 1;
  }
  void release() {
    steps_before_ = steps();
    if (memory_ != nullptr) IDAFree(&memory_);
    if (linear_ != nullptr) SUNLinSolFree(linear_);
    if (matrix_ != nullptr) SUNMatDestroy(matrix_);
    for (N_Vector v : {Y_, rate_})
      if (v != nullptr) N_VDestroy(v);
    memory_ = nullptr, linear_ = nullptr, matrix_ = nullptr, Y_ = rate_ = nullptr;
  }

  Options options_;
  mechanism::Reduced<double> motion_;
  mechanism::Reduced<Wide> wide_;
  int constraints_ = 0;
  std::int64_t steps_before_ = 0;
  std::vector<double> g_, g_rate_;
  std::vector<std::vector<double>> G_;
  sundials::Context owner_;
  SUNContext context_ = static_cast<SUNContext>(owner_.handle);
  N_Vector Y_ = nullptr, rate_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
  void* memory_ = nullptr;

 public:
  std::vector<double> y;
  std::string failure;
  std::int64_t evaluations = 0;
};

}  // namespace

Outcome run_mechanism(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options,
                      const Observer& observer, std::chrono::nanoseconds* busy) {
  if (const std::string why = uncovered(scene); !why.empty()) return refused("IDA: " + why);
  if (!(t_end_s > 0) || samples < 1) return refused("IDA: nothing to run");
  Sample start;
  try {
    start = mechanism::start_sample(scene);
  } catch (const MechanismError& error) {
    return refused("IDA: " + std::string(error.what()));
  }
  Integration run(scene, t_end_s, options, start);
  const std::vector<double>& switches = run.switch_times();
  const auto sample_s = [&](std::int64_t k) {
    return k == samples ? t_end_s : static_cast<double>(Wide(t_end_s) * k / samples);
  };
  const auto from = std::chrono::steady_clock::now();
  double t = 0;
  std::size_t interval = 0;
  const auto next_stop = [&] { return interval < switches.size() ? switches[interval] : t_end_s; };
  const auto take = [&](std::int64_t k) {
    if (!observer.sample) return;
    Sample made = run.sample(sample_s(k));
    made.t_s = Wide(t_end_s) * k / samples;
    observer.sample(made);
  };
  run.start(t, 0, next_stop());
  take(0);
  for (std::int64_t k = 1; k <= samples && run.failure.empty(); ++k) {
    while (t < sample_s(k)) {
      const double target = std::min(next_stop(), sample_s(k));
      if (!run.advance(target)) break;
      t = target;
      if (t >= next_stop() && t < t_end_s) run.start(t, static_cast<int>(++interval), next_stop());
    }
    if (run.failure.empty()) take(k);
  }
  if (busy != nullptr)
    *busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - from);
  Outcome outcome;
  outcome.steps_taken = run.steps();
  outcome.rate_evaluations = run.evaluations;
  if (!run.failure.empty()) {
    outcome.status = run.failure.find("not finite") != std::string::npos ? Status::not_finite : Status::diverged;
    outcome.reason = run.failure;
  }
  return outcome;
}

}  // namespace atwood::ida
