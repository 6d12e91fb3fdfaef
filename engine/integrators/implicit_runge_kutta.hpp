// Implicit Runge-Kutta methods: collocation and diagonally implicit tables.
#pragma once

#include "integrators/collocation_nodes.hpp"
#include "integrators/compensation.hpp"
#include "integrators/implicit_stages.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

struct ImplicitOptions {
  bool compensated = false;
  bool projects = true;    // unit quaternions after each step; Gauss methods conserve the norm
  bool estimates = false;  // Radau IIA of three stages: error_norm() works
};

// Any implicit Runge-Kutta method, in increments z_i = Y_i - y:
//
//   z_i = h sum_j a_ij k_j,   k_j = f(t + c_j h, y + z_j),   y_new = y + h sum_j b_j k_j
//
// Stages that depend on each other are solved together, those that depend on earlier ones only after them: a full
// matrix is one system, a lower triangular one (DIRK) a sequence of small systems; a stage with a_ii = 0 is explicit.
// All stages of a system are evaluated in one batch. The first guess extrapolates the last step's collocation
// polynomial if that step ended where this one starts.
template <class S> class ImplicitRungeKutta final : public Stepper<S> {
 public:
  ImplicitRungeKutta(System<S>& system, const CollocationTableau& tableau, const ImplicitOptions& options);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  S error_norm(S rtol, S atol) const override;
  int estimate_order() const override { return 3; }

 private:
  struct Group {  // stages first ... first + solver.stages() - 1
    int first;
    bool is_explicit;
    StageSolver<S> solver;
  };
  void find_groups(const CollocationTableau& tableau);
  void find_extrapolation(const CollocationTableau& tableau);
  void guess(const Group& group, S t_s, const S* y, bool continued);
  bool solve_group(Group& group, const S* y);
  void take_first_slope(S t_s, const S* y, bool continued);
  void estimate(S h_s);
  void project(S* y_new);
  static void rates_at(void* stepper, const S* z, S* k);

  int size_, stages_;
  ImplicitOptions options_;
  bool stiffly_accurate_ = false;  // y_new is the last stage
  std::vector<S> a_, b_, c_;
  std::vector<S> extrapolated_;  // z_i = h sum_j extrapolated_ij k_j of the step before; empty: not a collocation
  std::vector<Group> groups_;
  std::vector<S> k_, z_;  // of all stages, component after component
  std::vector<S> group_k_, group_z_, known_, stage_y_, stage_t_s_, scratch_, slope_;
  std::vector<S> first_slope_, error_;  // of methods that estimate
  S gamma0_{};
  Compensation<S> compensation_;
  DenseLu<S> filter_;
  // the end of the last step
  std::vector<S> last_end_;
  S last_end_s_{}, last_h_s_{};
  std::int64_t last_epoch_ = -1;
  // of the present step
  const Group* group_ = nullptr;
  const S* start_ = nullptr;
  S start_s_{}, step_s_{};
};

}  // namespace atwood
