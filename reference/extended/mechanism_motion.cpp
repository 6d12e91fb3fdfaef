#include "extended/mechanism_motion.hpp"

#include <algorithm>
#include <optional>

#include "extended/collocation.hpp"
#include "extended/extrapolation.hpp"
#include "mechanism/reduced.hpp"

namespace atwood::extended {

namespace {

constexpr double kStagesToTolerance = 1e-4;  // of the stage equations: their residual to the error of a step

using mechanism::Maximal;
using mechanism::Reduced;

// Steps are controlled relative to the largest of all components, in SI units: a kind of its own would have the scale
// of round-off where a mechanism starts in an equilibrium.
//
// What both formulations answer in the same way.
template <class Formulation> class Common : public MechanismMotion {
 public:
  Common(const Scene& scene, double t_end_s, const Sample& start) : wide_(scene, t_end_s, start) {}
  int size() const override { return wide_.size(); }
  std::vector<Wide> initial(const Sample& start) const override { return wide_.initial(start); }
  const std::vector<double>& switch_times() const override { return wide_.equations().switch_times(); }
  mechanism::StepChoice& choice() override { return wide_.choice; }
  mechanism::Independence choose(Wide t_s, const Wide* y) override { return wide_.choose(t_s, y); }
  Wide project(Wide t_s, Wide* y) override { return wide_.project(t_s, y); }
  Sample sample(Wide t_s, const Wide* y) const override { return wide_.sample(t_s, y); }
  Wide stop_force(Wide t_s, const Wide* y, int joint) const override { return wide_.stop_force(t_s, y, joint); }
  Wide acceleration(Wide t_s, const Wide* y, int joint) const override { return wide_.acceleration(t_s, y, joint); }
  Wide impact(Wide t_s, Wide* y, int joint, Wide e) const override { return wide_.impact(t_s, y, joint, e); }
  Wide response(Wide t_s, const Wide* y, int joint, int other) const override {
    return wide_.response(t_s, y, joint, other);
  }
  Wide off_plane(const Wide* y) const override { return mechanism::off_pulley_planes(wide_.model(), wide_.motions(y)); }
  mechanism::RopeMargins<Wide> rope_margins(const Wide* y, int rope) const override {
    return mechanism::rope_margins(wide_.model(), rope, wide_.motions(y), wide_.choice.memory);
  }

 protected:
  Wide longest_step_of(const Wide* y, bool closing_alone) const {
    const auto& model = wide_.model();
    const auto now = wide_.motions(y);
    Wide fastest = 0;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      if (closing_alone && !model.scene->joints[j].closes_loop) continue;
      if (model.joints[j].kind == JointKind::slider) continue;
      for (const Wide& u : mechanism::rates(model, static_cast<int>(j), now))
        fastest = std::max(fastest, u < 0 ? -u : u);
    }
    return fastest > 0 ? 2 / fastest : Wide(0);
  }
  Formulation wide_;
};

// Extrapolation in long double from states in quad: each step starts from the nearest state and ends in long double.
class NarrowSteps : public Stepper<Wide> {
 public:
  NarrowSteps(int size, Rate<long double> rate, double tolerance)
      : steps_(size, std::vector<int>{}, std::move(rate), tolerance), y_(size) {}
  Wide step(Wide t, Wide* y, Wide limit) override {
    for (std::size_t k = 0; k < y_.size(); ++k) y_[k] = static_cast<long double>(y[k]);
    const auto narrow_limit = static_cast<long double>(limit);
    const long double taken = steps_.step(static_cast<long double>(t), y_.data(), narrow_limit);
    evaluations = steps_.evaluations;
    steps = steps_.steps;
    if (!(taken > 0)) return 0;
    std::copy(y_.begin(), y_.end(), y);
    return taken == narrow_limit ? limit : Wide(taken);
  }
  DenseStep<Wide> dense() override {
    const DenseStep<long double> narrow = steps_.dense();
    const auto widened = [](const std::vector<long double>& x) { return std::vector<Wide>(x.begin(), x.end()); };
    return {narrow.t,           narrow.span,        widened(narrow.y0), widened(narrow.f0),
            widened(narrow.ym), widened(narrow.fm), widened(narrow.y1), widened(narrow.f1)};
  }
  void raise_scale(const Wide* sizes) override {
    const std::vector<long double> narrow(sizes, sizes + y_.size());
    steps_.raise_scale(narrow.data());
  }

 private:
  Extrapolation<long double> steps_;
  std::vector<long double> y_;
};

class ReducedMotion : public Common<Reduced<Wide>> {
 public:
  ReducedMotion(const Scene& scene, double t_end_s, const Sample& start, Arithmetic arithmetic)
      : Common(scene, t_end_s, start) {
    if (arithmetic == Arithmetic::long_double) narrow_.emplace(scene, t_end_s, start);
  }
  std::unique_ptr<Stepper<Wide>> make_stepper(double tolerance) override {
    if (narrow_)
      return std::make_unique<NarrowSteps>(
          size(),
          [this](long double t, const long double* y, long double* dydt) {
            narrow_->choice.interval = wide_.choice.interval;
            narrow_->choice.interval_s = wide_.choice.interval_s;
            narrow_->rate(t, y, dydt);
          },
          tolerance);
    return std::make_unique<Extrapolation<Wide>>(
        size(), std::vector<int>{}, [this](Wide t, const Wide* y, Wide* dydt) { wide_.rate(t, y, dydt); }, tolerance);
  }
  mechanism::Independence choose(Wide t_s, const Wide* y) override {
    const mechanism::Independence made = wide_.choose(t_s, y);
    if (narrow_) narrow_->choice = wide_.choice;
    columns_ = wide_.pivot_columns(t_s, y);
    orientation_ = wide_.orientation(t_s, y, columns_);
    return made;
  }
  Wide longest_step(const Wide* y) const override { return longest_step_of(y, true); }
  bool turned_over(Wide t_s, const Wide* y) const override {
    return !columns_.empty() && wide_.orientation(t_s, y, columns_) != orientation_;
  }
  std::array<Wide, 2> coordinate(const Wide* y, int joint) const override {
    return {y[wide_.coordinate_slot(joint)], y[wide_.rate_slot(joint)]};
  }

 private:
  std::optional<Reduced<long double>> narrow_;
  std::vector<int> columns_;
  int orientation_ = 1;
};

class MaximalMotion : public Common<Maximal<Wide>> {
 public:
  MaximalMotion(const Scene& scene, double t_end_s, const Sample& start)
      : Common(scene, t_end_s, start), narrow_(scene, t_end_s, start) {}
  std::unique_ptr<Stepper<Wide>> make_stepper(double tolerance) override {
    Problem problem{size(),
                    {},
                    [this](Wide t, const Wide* y, Wide* dydt) { wide_.rate(t, y, dydt); },
                    [this](double t, const double* y, double* dydt) {
                      narrow_.choice.interval = wide_.choice.interval;
                      narrow_.rate(t, y, dydt);
                    }};
    return std::make_unique<Collocation>(problem, tolerance, std::max(1e-31, kStagesToTolerance * tolerance));
  }
  mechanism::Independence choose(Wide t_s, const Wide* y) override {
    const mechanism::Independence made = wide_.choose(t_s, y);
    narrow_.choice = wide_.choice;
    return made;
  }
  Wide longest_step(const Wide* y) const override { return longest_step_of(y, false); }
  std::array<Wide, 2> coordinate(const Wide* y, int joint) const override {
    const auto now = wide_.motions(y);
    return {mechanism::coordinates(wide_.model(), joint, now, wide_.choice.memory)[0],
            mechanism::rates(wide_.model(), joint, now)[0]};
  }

 private:
  Maximal<double> narrow_;
};

}  // namespace

std::unique_ptr<MechanismMotion> reduced_motion(const Scene& scene, double t_end_s, const Sample& start,
                                                Arithmetic arithmetic) {
  return std::make_unique<ReducedMotion>(scene, t_end_s, start, arithmetic);
}
std::unique_ptr<MechanismMotion> maximal_motion(const Scene& scene, double t_end_s, const Sample& start) {
  return std::make_unique<MaximalMotion>(scene, t_end_s, start);
}

}  // namespace atwood::extended
