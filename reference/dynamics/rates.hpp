// The reference's own equations of motion. They share no code with the engine: a differential test compares the two.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/state.hpp"

namespace atwood::dynamics {

// Why these equations don't cover the scene ("unknown potential `x`"); empty when they do. Contacts are not their
// business: see contacts.hpp.
std::string unsupported(const Scene& scene);

// dy/dt = f(t, y) of a scene, S = double, long double or Wide (__float128). Built once, const afterwards, thread-safe.
//
//   p' = v                     m v' = sum of forces
//   q' = 1/2 q (0, w)          I w' = torque - w x (I w)        (body axes)
//
// `interval` says which of the segments between switch_times the evaluation belongs to, so that a step that ends on a
// switch uses the force of its own interval at its last stage too.
template <class S> class Dynamics {
 public:
  Dynamics(const Scene& scene, double t_end_s);  // throws std::invalid_argument with unsupported(scene)
  ~Dynamics();
  Dynamics(Dynamics&&) noexcept;

  int size() const;
  const Layout& layout() const;
  const std::vector<double>& switch_times() const;
  int interval_at(double t_s) const;  // half-open: at a switch, the interval that begins there
  void rate(S t_s, const S* y, S* dydt, int interval) const;

  // A body that came to rest on a plane stays there: the part of its acceleration along `normal` is removed from now
  // on while it points into the plane. Index of the body, unit normal out of the plane.
  void hold_on_plane(int body, const Real3& normal);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

extern template class Dynamics<double>;
extern template class Dynamics<long double>;
extern template class Dynamics<Wide>;

}  // namespace atwood::dynamics
