// Propagation of errors of the state along a motion with impacts: a bound, to first order.
//
// Between impacts an error is multiplied by the flow's derivative T, at an impact by the saltation matrix
//   S = DR + (f+ - DR f-) g^T / (g^T f-)        R: impact law, g: gradient of the gap, f-, f+: rates before and after
// (M. A. Aizerman and F. R. Gantmakher 1958; R. I. Leine and H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth
// Mechanical Systems, 2004, section 7.4). The set of possible errors at one instant is a rotated box
//   { Q r : |r_i| <= rho_i },  Q orthogonal
// which avoids the wrapping effect of boxes along the axes (R. J. Lohner, Enclosing the solutions of
// ordinary initial and boundary value problems, 1987): Q' from the QR decomposition of T Q, its longest columns first,
// and rho' = |Q'^T T Q| rho + |Q'^T| delta for new errors of at most delta.
#pragma once

#include <vector>

#include "dynamics/rates.hpp"
#include "dynamics/simultaneous.hpp"

namespace atwood::dynamics {

class ErrorGrowth {
 public:
  // Motions with more unknowns are not covered.
  static constexpr int kMaxUnknowns = 200;

  // `round_off`: relative error of one operation of the run. The errors are zero at the start.
  ErrorGrowth(const Scene& scene, double t_end_s, double round_off);

  // From t to t_next in `interval`, y at t. The run took `steps` steps there, each of which adds round-off. When the
  // flow's derivative does not converge, finite() becomes false.
  void flow(Wide t_s, Wide t_next_s, const std::vector<Wide>& y, int interval, double steps);
  // Through one impact at t_s with the state `after` it. `gap_error_m`: largest |gap| at the located impact.
  void impact(Wide t_s, const Impact<Wide>& impact, const std::vector<Wide>& after, int interval, double gap_error_m);
  // Adds an error of at most delta[i] in component i of y.
  void add(const std::vector<double>& delta);
  // The ball stays within `gap_error_m` of a plane: its errors along the normal become this and zero velocity.
  void keep_to_plane(int body, const Real3& normal, double gap_error_m);
  // From now on the plane cancels the ball's acceleration into it.
  void hold_on_plane(int body, const Real3& normal);
  // It leaves the plane where the normal force is zero: the rates are continuous there, and no error is added.
  void release_from_plane(int body);

  // Half-width per component of y; infinite when finite() is false.
  std::vector<double> bounds() const;
  // Half-width of a pair's gap [m], and of the gap's rate [m/s].
  double gap_bound(const ContactPair& pair, const std::vector<Wide>& y) const;
  double rate_bound(const ContactPair& pair, const std::vector<Wide>& y) const;
  // d^2 gap / dt^2 along the motion [m/s^2].
  double gap_acceleration(const ContactPair& pair, Wide t_s, const std::vector<Wide>& y, int interval) const;
  // False: the errors have overflowed or their growth could not be computed; every bound is then infinite.
  bool finite() const { return finite_; }

 private:
  using Columns = std::vector<std::vector<double>>;  // [column][row]
  Columns derivative(double t_s, double span_s, const std::vector<double>& y, int interval, int steps);
  // The new box from moved = T Q (scaled, known to a factor of `inflation`) and new errors of at most delta.
  void apply(const Columns& moved, const std::vector<double>& delta, double inflation);
  double project_bound(const std::vector<double>& row) const;
  std::vector<Wide> gap_gradient(const ContactPair& pair, const std::vector<Wide>& y) const;
  double position_magnitude(int body, const Wide* y, double span_s) const;
  double speed(int body, const Wide* y) const;
  std::vector<double> round_off_bound(const std::vector<Wide>& y, double span_s, double ulps) const;

  const Scene& scene_;
  Dynamics<Wide> dynamics_;
  Dynamics<double> double_dynamics_;
  const Layout& layout_;
  double round_off_;
  bool coupled_ = false;  // a force depends on two bodies at once
  bool finite_ = true;
  std::vector<int> body_;      // of each component
  std::vector<double> scale_;  // of each component: the unit of Q and rho
  Columns Q_;
  std::vector<double> rho_;
};

}  // namespace atwood::dynamics
