// What errors of the state become along a motion with impacts: to first order, as a bound.
//
// Between impacts an error grows by the flow's derivative T, at an impact by the saltation matrix
//   S = DR + (f+ - DR f-) g^T / (g^T f-)        R: the law of impact, g: the gap's gradient, f-+: the rates around it
// (M. A. Aizerman and F. R. Gantmakher 1958; R. I. Leine and H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth
// Mechanical Systems, 2004, section 7.4). The errors that are possible at one instant are held as a rotated box
//   { Q r : |r_i| <= rho_i },  Q orthogonal
// so that a sheared box is not wrapped in a larger one step after step (R. J. Lohner, Enclosing the solutions of
// ordinary initial and boundary value problems, 1987): Q' from the QR decomposition of T Q, its longest columns first,
// and rho' = |Q'^T T Q| rho + |Q'^T| delta for new errors of at most delta.
#pragma once

#include <vector>

#include "dynamics/rates.hpp"
#include "dynamics/simultaneous.hpp"

namespace atwood::dynamics {

class ErrorGrowth {
 public:
  // More unknowns than this are not followed.
  static constexpr int most_unknowns = 200;

  // `round_off`: the relative error of one operation of the run that is followed. No error at the start.
  ErrorGrowth(const Scene& scene, double t_end_s, double round_off);

  // From t to t_next in `interval`, y at t; `steps` of the run went there, each with round-off of its own.
  void flow(Wide t_s, Wide t_next_s, const std::vector<Wide>& y, int interval, double steps);
  // Through one blow at t_s, after which the state was y. `off_m`: how far from zero the gaps were.
  void strike(Wide t_s, const Blow<Wide>& blow, const std::vector<Wide>& after, int interval, double off_m);
  // A further error of at most this much in each component.
  void add(const std::vector<double>& delta);
  // A ball stays within `off_m` of a plane; its motion along the plane's normal is not followed further.
  void keep_to_plane(int body, const Real3& normal, double off_m);
  void hold_on_plane(int body, const Real3& normal);

  // Per component of y.
  std::vector<double> bounds() const;
  // Of a pair's gap [m], and of the gap's rate [m/s].
  double gap_bound(const ContactPair& pair, const std::vector<Wide>& y) const;
  double rate_bound(const ContactPair& pair, const std::vector<Wide>& y) const;
  // d^2 gap / dt^2 along the motion [m/s^2].
  double gap_acceleration(const ContactPair& pair, Wide t_s, const std::vector<Wide>& y, int interval) const;
  bool finite() const { return finite_; }

 private:
  using Columns = std::vector<std::vector<double>>;  // one vector a column
  Columns derivative(double t_s, double span_s, const std::vector<double>& y, int interval, int steps);
  // moved: T Q, scaled; known to a factor of `inflation`.
  void apply(const Columns& moved, const std::vector<double>& delta, double inflation);
  double along(const std::vector<double>& row) const;
  std::vector<Wide> gap_gradient(const ContactPair& pair, const std::vector<Wide>& y) const;
  double reach(int body, const Wide* y, double span_s) const;
  double speed(int body, const Wide* y) const;
  std::vector<double> noise(const std::vector<Wide>& y, double span_s, double ulps) const;

  const Scene& scene_;
  Dynamics<Wide> dynamics_;
  Dynamics<double> narrow_;
  const Layout& layout_;
  double round_off_;
  bool coupled_ = false;  // a force depends on two bodies at once
  bool finite_ = true;
  std::vector<int> body_;      // of each component
  std::vector<double> scale_;  // of each component: what Q and rho are relative to
  Columns Q_;
  std::vector<double> rho_;
};

}  // namespace atwood::dynamics
