// What partitioned methods are made of: kicks change velocities by forces, drifts move bodies freely.
#pragma once

#include <vector>

#include "integrators/implicit_solver.hpp"
#include "rigid/model.hpp"

namespace atwood {

enum class FreeTop { lie, strang };  // the drift of a rotating body: order 1, or symmetric and of order 2

// p += h v; attitude and body rate by the splitting of the free top (rigid/free_top.hpp).
template <class S> void drift(const RigidModel<S>& model, S h_s, FreeTop top, S* y);

template <class S> class Kicker {
 public:
  explicit Kicker(RigidModel<S>& model);

  // v += h a(t, y), body rates likewise by I^-1 torque: forces at the state as it stands.
  void explicit_kick(S t_s, S h_s, S* y);
  // The same by the implicit midpoint rule in the velocities, at fixed positions: symmetric, so Verlet and leapfrog
  // keep order 2 under drag, damping, Coriolis and Lorentz forces (for the Lorentz force it is Boris's rotation).
  // Explicit where no force depends on velocities. False: not solved.
  bool symmetric_kick(S t_s, S h_s, S* y);

 private:
  RigidModel<S>& model_;
  std::vector<S> acceleration_, middle_;
  ImplicitSolver<S> solver_;
};

}  // namespace atwood
