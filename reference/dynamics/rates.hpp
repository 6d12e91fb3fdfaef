// The reference's own equations of motion. They share no code with the engine: a differential test compares the two.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/state.hpp"

namespace atwood::dynamics {

// Why these equations do not cover the scene ("no equations for the potential `x`"); empty when they do. Contacts are
// not considered here: see contacts.hpp.
std::string unsupported(const Scene& scene);

// dy/dt = f(t, y) of a scene for S = double, long double or Wide (__float128), without contacts. rate() is thread-safe
// as long as hold_on_plane() is not called at the same time.
//
//   p' = v                     m v' = sum of forces
//   q' = 1/2 q (0, w)          I w' = torque - w x (I w)        (body axes)
//
// `interval` is the index of the segment between switch_times that the evaluation belongs to, so that a step that ends
// on a switch uses the forces of its own interval at its last stage too.
template <class S> class Dynamics {
 public:
  Dynamics(const Scene& scene, double t_end_s);  // throws std::invalid_argument with unsupported(scene)
  ~Dynamics();
  Dynamics(Dynamics&&) noexcept;

  int size() const;
  const Layout& layout() const;
  const std::vector<double>& switch_times() const;
  int interval_at(double t_s) const;  // half-open: at a switch, the interval that begins there
  // dydt: size() numbers in the layout of y.
  void rate(S t_s, const S* y, S* dydt, int interval) const;

  // A body at rest on a plane: from now on its acceleration along `normal` (out of the plane, any length) is removed
  // while it points into the plane.
  void hold_on_plane(int body, const Real3& normal);
  void release_from_plane(int body);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

extern template class Dynamics<double>;
extern template class Dynamics<long double>;
extern template class Dynamics<Wide>;

}  // namespace atwood::dynamics
