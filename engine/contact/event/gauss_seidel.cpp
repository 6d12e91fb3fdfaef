// Contact forces at one instant by projected Gauss-Seidel iteration on round friction cones. It finds which of several
// redundant contacts separate, and the directions at the onset of slip, but converges slowly: used only where the
// active set changes.
//
//   0 <= N  complementary to  g'' >= 0
//   stick   |T| <= mu N;  |T| = mu N only with T opposed to u'
//   slip    T = -mu N u_t / |u_t|
//
// Each sweep solves one contact after the other exactly for the present forces of the others; Jourdan, Alart, Jean,
// Comp. Meth. Appl. Mech. Engng 155 (1998) 31.
#include "contact/event/gauss_seidel.hpp"

#include <algorithm>

namespace atwood::event {

namespace {

template <class S> struct GaussSeidel {
  const Bodies<S>& bodies;
  const Proximity<S>& proximity;
  ConstraintSystem<S>& constraints;

  Vec3<S> relative_acceleration(const Contact<S>& contact) const {
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const Vec3<S>&x = contact.kinematics.x, &x_dot = contact.kinematics.x_dot;
    const auto point_acceleration = [&](int body) {
      const Pose<S>& pose = bodies.poses[body];
      const SpatialVector<S>& a = constraints.acceleration[body];
      return a.linear + cross(a.angular, x - pose.p) + cross(pose.w, x_dot - pose.v);
    };
    return point_acceleration(candidate.feature_body) - point_acceleration(candidate.surface_body);
  }
  Vec3<S> relative_angular_acceleration(const Contact<S>& contact) const {
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    return constraints.acceleration[candidate.feature_body].angular -
           constraints.acceleration[candidate.surface_body].angular;
  }
  void apply(const Contact<S>& contact, const Vec3<S>& force, const Vec3<S>& couple) {
    const ConstraintRow<S> row = row_of_load(bodies, proximity, contact, force, couple);
    for (int side = 0; side < 2; ++side) {
      if (row.body[side] < 0) continue;
      constraints.acceleration[row.body[side]].linear += row.response[side].linear;
      constraints.acceleration[row.body[side]].angular += row.response[side].angular;
    }
  }
  // Sets the contact's start values, unit loads and inverse effective masses; a warm start's load is added to the
  // accelerations of its bodies.
  void prepare(Contact<S>& contact) {
    const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
    const Vec3<S>& n = contact.kinematics.normal;
    const bool warm = contact.slip_onset && contact.mode == FrictionMode::slip &&
                      !contact.at_cone_limit;  // starts from the present forces
    if (!warm) {
      contact.normal_N = S(0);
      contact.friction_N = {};
    }
    contact.couple_N_m = {};
    contact.unit_force_W = n;
    contact.unit_couple_W = {};
    if (contact.mode == FrictionMode::slip && !contact.at_cone_limit && !contact.slip_onset)
      contact.unit_force_W = n - pair.friction * contact.slip_direction;
    if (contact.rolling == RollingMode::roll) contact.unit_couple_W = -pair.rolling_friction_m * contact.roll_direction;
    if (warm)
      apply(contact, contact.normal_N * contact.unit_force_W + contact.friction_N,
            contact.normal_N * contact.unit_couple_W);
    contact.inverse_mass_n =
        delassus_entry(bodies, proximity, contact, n, {}, contact.unit_force_W, contact.unit_couple_W);
    const Vec3<S> t = any_tangent(n), t2 = cross(n, t);
    contact.inverse_mass_t = real::max(delassus_entry(bodies, proximity, contact, t, {}, t, {}),
                                       delassus_entry(bodies, proximity, contact, t2, {}, t2, {})) +
                             real::abs(delassus_entry(bodies, proximity, contact, t, {}, t2, {}));
    contact.inverse_inertia_r = real::max(delassus_entry(bodies, proximity, contact, {}, t, {}, t),
                                          delassus_entry(bodies, proximity, contact, {}, t2, {}, t2)) +
                                real::abs(delassus_entry(bodies, proximity, contact, {}, t, {}, t2));
  }
  // Solves one contact for the present forces of the others. Raises `change` to the largest change of a force, or of a
  // couple over the bounding radii, and `size` to the normal force.
  void solve(Contact<S>& contact, S inverse_step_per_s, S& change, S& size) {
    const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
    const Vec3<S>& n = contact.kinematics.normal;
    const S gap_acceleration = dot(n, relative_acceleration(contact)) + dot(contact.u, contact.kinematics.normal_dot);
    const S normal = real::max(S(0), contact.normal_N - gap_acceleration / contact.inverse_mass_n);
    apply(contact, (normal - contact.normal_N) * contact.unit_force_W,
          (normal - contact.normal_N) * contact.unit_couple_W);
    change = real::max(change, real::abs(normal - contact.normal_N));
    contact.normal_N = normal;
    size = real::max(size, normal);
    if (contact.mode != FrictionMode::frictionless &&
        (contact.mode == FrictionMode::stick || contact.at_cone_limit || contact.slip_onset)) {
      const Vec3<S> u_dot =
                        relative_acceleration(contact) + (contact.slip_onset ? inverse_step_per_s : S(0)) * contact.u,
                    across = u_dot - dot(u_dot, n) * n;
      const Vec3<S> friction =
          shortened(contact.friction_N - (S(1) / contact.inverse_mass_t) * across, pair.friction * normal);
      apply(contact, friction - contact.friction_N, {});
      change = real::max(change, norm(friction - contact.friction_N));
      contact.friction_N = friction;
    }
    if (contact.rolling == RollingMode::stick) {
      const Vec3<S> alpha = relative_angular_acceleration(contact), across = alpha - dot(alpha, n) * n;
      const Vec3<S> couple =
          shortened(contact.couple_N_m - (S(1) / contact.inverse_inertia_r) * across, pair.rolling_friction_m * normal);
      apply(contact, {}, couple - contact.couple_N_m);
      change = real::max(change, norm(couple - contact.couple_N_m) / pair.bounding_radii);
      contact.couple_N_m = couple;
    }
  }
};

}  // namespace

template <class S>
SolveReport solve_forces_gauss_seidel(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                                      ConstraintSystem<S>& constraints, const S* free_dydt, S inverse_step_per_s) {
  std::fill(constraints.acceleration.begin(), constraints.acceleration.end(), SpatialVector<S>{});
  for (const int body : active.bodies) {
    if (!bodies.moves[body]) continue;
    const S* at = free_dydt + bodies.model.offset(body);
    constraints.acceleration[body].linear = load3(at + kAtVelocity);
    if (bodies.model.rotates(body))
      constraints.acceleration[body].angular = to_world(bodies.poses[body], load3(at + kAtBodyRate));
  }
  GaussSeidel<S> solver{bodies, proximity, constraints};
  for (Contact<S>& contact : active.contacts) solver.prepare(contact);
  constexpr int max_sweeps = 5000;
  SolveReport report{max_sweeps, 0, SolveEnd::capped};
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    S change = S(0), size = S(0);
    for (Contact<S>& contact : active.contacts) solver.solve(contact, inverse_step_per_s, change, size);
    report = {sweep + 1, size > S(0) ? static_cast<double>(change / size) : 0.0, SolveEnd::capped};
    if (change > S(2) * real::epsilon<S>() * size) continue;
    if (change == change) report.ended = SolveEnd::converged;  // not NaN
    break;
  }
  bodies.model.system().solvers.add(IterativeSolver::contact_forces, report);
  for (Contact<S>& contact : active.contacts) {
    contact.u_dot = solver.relative_acceleration(contact);
    contact.alpha = solver.relative_angular_acceleration(contact);
    if (!contact.slip_onset || contact.mode != FrictionMode::slip || contact.at_cone_limit) continue;
    const Vec3<S> u_end = contact.u_dot + inverse_step_per_s * contact.u,
                  across = u_end - dot(u_end, contact.kinematics.normal) * contact.kinematics.normal;
    const S braking = proximity.pairs[proximity.candidates[contact.candidate].pair].friction * contact.normal_N *
                      contact.inverse_mass_t;
    // The slip direction at the end of the step, unless friction nearly stops the slip: then it is round-off.
    if (norm(across) > S(0x1p-16) * braking) contact.slip_direction = (S(1) / norm(across)) * across;
  }
  return report;
}

#define ATWOOD_GAUSS_SEIDEL(S)                                                                            \
  template SolveReport solve_forces_gauss_seidel<S>(const Bodies<S>&, const Proximity<S>&, ActiveSet<S>&, \
                                                    ConstraintSystem<S>&, const S*, S);
ATWOOD_GAUSS_SEIDEL(float)
ATWOOD_GAUSS_SEIDEL(double)
ATWOOD_GAUSS_SEIDEL(long double)
#undef ATWOOD_GAUSS_SEIDEL

}  // namespace atwood::event
