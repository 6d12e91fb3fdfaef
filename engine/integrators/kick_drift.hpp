// The parts of partitioned methods: kicks change velocities by forces, drifts move bodies freely.
#pragma once

#include <vector>

#include "integrators/compensation.hpp"
#include "integrators/implicit_solver.hpp"
#include "rigid/free_top.hpp"
#include "rigid/model.hpp"

namespace atwood {

// p += h v; attitude and body rate by the free top; h = direct_s + adjoint_s (rigid/free_top.hpp). False: not solved.
template <class S>
bool drift(RigidModel<S>& model, FreeTop top, S direct_s, S adjoint_s, S* y, Compensation<S>& compensation);

// Normalises the quaternions of the moving bodies.
template <class S> void renormalise(const RigidModel<S>& model, S* y, Compensation<S>& compensation);

template <class S> class Kicker {
 public:
  explicit Kicker(RigidModel<S>& model);

  // v += h a(t, y), body rates likewise by I^-1 torque, h = direct_s + adjoint_s. Where forces depend on velocities:
  // over adjoint_s a() takes the velocities at its end (implicit Euler), over direct_s, which follows, those at its
  // start: both are v_m = v + adjoint_s a(t, v_m). Equal parts: the implicit midpoint rule in
  // the velocities, symmetric. In a magnetic field v_m is formed in closed form, and equal parts are Boris's rotation
  // (with the half angle in place of its tangent: Cayley's map). False: not solved.
  bool kick(S t_s, S direct_s, S adjoint_s, S* y, Compensation<S>& compensation);
  // The same with the accelerations of the last kick, which must be those at y; forces without velocities only.
  void kick_again(S h_s, S* y, Compensation<S>& compensation);

 private:
  void add(S h_s, S* y, Compensation<S>& compensation) const;
  void kick_in_magnetic_field(S t_s, S direct_s, S adjoint_s, S* y, Compensation<S>& compensation);

  RigidModel<S>& model_;
  std::vector<S> acceleration_, middle_;
  std::vector<Vec3<S>> omega_W_;
  std::int64_t omega_epoch_ = -1;
  ImplicitSolver<S> solver_;
};

}  // namespace atwood
