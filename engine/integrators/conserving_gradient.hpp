// The energy-conserving midpoint method by discrete gradients.
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/implicit_stages.hpp"
#include "integrators/stepper.hpp"
#include "rigid/model.hpp"

namespace atwood {

// Order 2, symmetric, implicit, energy kept by construction: with z = y_new - y,
//
//   z_p = h (v + v_new) / 2,      z_v = h / m F(p, p_new),
//   z_q = h/2 q_m (0, w_m),     I z_w = -h w_m x I w_m,      _m: the midpoint
//
// F: the mean of the forces over the segment from p to p_new (average vector field: Quispel, McLaren, J. Phys. A 41
// (2008) 045206), by Gauss's formula of nine nodes; or a discrete gradient of the potential (forces/conservative.hpp).
// The free top's midpoint keeps its energy and the size of its momentum, both quadratic, and the quaternion's length.
template <class S> class DiscreteGradient final : public Stepper<S> {
 public:
  enum class Force { mean_over_segment, discrete_gradient };
  DiscreteGradient(RigidModel<S>& model, Force force, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  static void rates_at(void* stepper, const S* z, S* k);
  void average_over_segment(const S* z, S* k);
  void difference_potential(const S* z, S* k);

  RigidModel<S>& model_;
  int size_;
  Force force_;
  StageSolver<S> solver_;
  std::vector<S> node_, weight_;
  std::vector<S> node_t_s_, node_y_, node_rate_, scratch_;
  std::vector<S> z_, k_, known_, end_y_;
  std::vector<Vec3<S>> force_W_;
  Compensation<S> compensation_;
  // of the step under way
  const S* y_ = nullptr;
  S t_s_now_{}, h_now_s_{};
};

}  // namespace atwood
