// The Taylor method of any order: the state's power series in time, by recurrences (Jorba, Zou, Exp. Math. 14 (2005)
// 99; Hairer, Norsett, Wanner, Solving ODEs I, I.8).
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/families.hpp"
#include "math/lanes.hpp"
#include "rigid/model.hpp"

namespace atwood {

MethodInfo taylor_method();
template <class S> StepperResult<S> make_taylor(const StepperRequest<S>& request);  // refuses forces without a series

struct TaylorOptions {
  int order = 0;  // 0: by the tolerance; 12 without one
  bool compensated = false;
};
inline constexpr int kTaylorEqualStepsOrder = 12, kTaylorMaxOrder = 100;

// Series of r = p_b - p_a of every pair, |r|^2 and |r|^-3, stored by coefficient, one pair per lane.
template <class S> struct PairSeries {
  int lanes = 0;                                       // pairs, filled up to whole blocks
  bool blocks = false;                                 // lanes are processed in eights
  std::vector<S> rows;                                 // coefficient k: x y z u w, `lanes` each
  std::vector<S> softening2, inverse_u, acceleration;  // the last: x y z of r / |r|^3 at the newest coefficient

  S* row(int k, int which) { return rows.data() + (static_cast<std::ptrdiff_t>(k) * 5 + which) * lanes; }
};

template <class S> class Taylor final : public Stepper<S> {
 public:
  // Requires forces with recurrences (SeriesForces::refusal is "").
  Taylor(RigidModel<S>& model, const TaylorOptions& options);

  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  bool chooses_steps() const override { return true; }
  typename Stepper<S>::Advice advise(S rtol, S atol) override;
  void set_tolerance(S rtol, S atol) override;
  void dense(S theta, S* y_at) override;
  bool dense_is_accurate() const override { return true; }
  int order() const { return order_; }

 private:
  // at: of its attitude in the state
  struct Top {
    int body, at;
    S angular_drag;
  };

  void set_order(int order);
  void lay_out_pairs();
  bool known(S t_s, const S* y) const;
  void find_series(S t_s, S h_s, const S* y);
  void next_bodies(int k);
  void next_lorenz(int k);
  void find_turning(std::size_t top);
  Vec3<S> gyroscopic_torque(int k, std::size_t top);
  void attract(int k);
  void add_linear(int k);
  void add_oscillating(int k);
  void add_quadratic(int k);
  S longest_step() const;
  void sum(S theta);

  S* row(int k) { return series_.data() + static_cast<std::ptrdiff_t>(k) * size_; }
  const S* row(int k) const { return series_.data() + static_cast<std::ptrdiff_t>(k) * size_; }

  RigidModel<S>& model_;
  const SeriesForces<S>& forces_;
  const int wanted_order_;
  const VectorWidth width_ = widest_vectors();
  int size_, order_ = 0;
  S rtol_{}, atol_{}, bound_s_{};  // rtol 0: equal steps
  // The state, force law and time that the series belongs to; coefficients are in units of `unit_s`: c_k unit^k.
  bool valid_ = false;
  S start_s_{}, unit_s_{};
  std::int64_t epoch_ = -1;
  std::vector<S> series_;    // coefficient k of component i: series_[k size + i]
  std::vector<S> momentum_;  // I w of each top, x y z, likewise
  std::vector<S> turning_;   // attitude and body rate of a top, in the layout of series::rotation_products
  std::vector<S> increment_, half_, reciprocal_;  // n / 2, 1 / n
  PairSeries<S> pairs_;
  std::vector<Vec3<S>> acceleration_;  // one per body, at the newest coefficient
  std::vector<S> sine_, cosine_;       // of each oscillating force, likewise
  std::vector<Top> tops_;
  std::vector<int> kind_;  // of each component: position, velocity, attitude, body rate
  Compensation<S> compensation_;
};

}  // namespace atwood
