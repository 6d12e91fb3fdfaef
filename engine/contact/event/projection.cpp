// Removal of drift off the constraints of lasting contacts.
#include "contact/event/projection.hpp"

#include <algorithm>

#include "math/so3.hpp"

#include "contact/event/linear_solve.hpp"

namespace atwood::event {

namespace {

// The loads of least size that give constraints.right, and the bodies' response in constraints.acceleration.
template <class S>
void solve_least_change(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  for (const int body : active.bodies) constraints.free_acceleration[body] = {};
  std::fill_n(constraints.unknown.begin(), constraints.row_count, S(0));
  std::fill_n(constraints.weight.begin(), constraints.row_count, S(1));
  solve_rows(bodies, active, constraints, constraints.row_contacts > 1, std::uint64_t{0});
}

template <class S> void displace_body(const Bodies<S>& bodies, const ConstraintSystem<S>& constraints, int body, S* y) {
  if (!bodies.moves[body]) return;
  S* at = y + bodies.model.offset(body);
  const SpatialVector<S>& by = constraints.acceleration[body];
  store3(load3(at + kAtPosition) + by.linear, at + kAtPosition);
  if (!bodies.model.rotates(body) || dot(by.angular, by.angular) == S(0)) return;
  store4(normalised(so3_exp(by.angular) * load4(at + kAtAttitude)), at + kAtAttitude);
}

template <class S>
void change_velocity(const Bodies<S>& bodies, const ConstraintSystem<S>& constraints, int body, S* y) {
  if (!bodies.moves[body]) return;
  S* at = y + bodies.model.offset(body);
  const SpatialVector<S>& by = constraints.acceleration[body];
  store3(load3(at + kAtVelocity) + by.linear, at + kAtVelocity);
  if (bodies.model.rotates(body))
    store3(load3(at + kAtBodyRate) + to_body(bodies.poses[body], by.angular), at + kAtBodyRate);
}

template <class S> S largest_drift(const ActiveSet<S>& active) {
  S worst = S(0);
  for (const Contact<S>& contact : active.contacts)
    if (contact.active) worst = real::max(worst, real::abs(contact.kinematics.gap - contact.target_gap));
  return worst;
}

// Restores the gaps at which contacts are held, by the least displacement; two Newton iterations at most.
template <class S>
void project_positions(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                       ConstraintSystem<S>& constraints, StateBuffers<S>& states) {
  constexpr int max_iterations = 2;
  const S tolerance = bodies.gap_round_off() / S(16);
  if (largest_drift(active) <= tolerance) return;
  int iteration = 0;
  S worst{};
  do {
    assign_rows(bodies, proximity, active, constraints, ConstraintLevel::position);
    for (const Contact<S>& contact : active.contacts)
      if (contact.active) constraints.right[contact.first_row] = contact.target_gap - contact.kinematics.gap;
    std::fill_n(constraints.right_round_off.begin(), constraints.row_count, tolerance);
    solve_least_change(bodies, active, constraints);
    S* y = states.overwrite(states.y);
    for (const int body : active.bodies) displace_body(bodies, constraints, body, y);
    update_active_kinematics(bodies, proximity, active, y, states.y.version);
    worst = largest_drift(active);
  } while (++iteration < max_iterations && !(worst <= tolerance));
  S size = bodies.length_scale;  // bodies may have slid far from where the scale was taken
  for (const int body : active.bodies) size = real::max(size, norm(bodies.poses[body].p));
  bodies.model.system().solvers.add(
      IterativeSolver::contact_projection,
      {iteration, static_cast<double>(worst / size),
       worst <= S(64) * real::epsilon<S>() * size ? SolveEnd::converged : SolveEnd::capped});
}

// Do the velocities obey the constraints up to round-off? Angular velocities count as those of points at the bodies'
// bounding radii.
template <class S>
bool velocities_consistent(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active) {
  S worst = S(0), size = S(0);  // squares
  const auto speed_square = [&](int body) {
    const Pose<S>& pose = bodies.poses[body];
    const S radius = bodies.bounding_radius[body];
    return dot(pose.v, pose.v) + radius * radius * dot(pose.w, pose.w);
  };
  for (const Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const Vec3<S>& n = contact.kinematics.normal;
    const S normal = dot(contact.u, n);
    worst = real::max(worst, contact.mode == FrictionMode::stick ? dot(contact.u, contact.u) : normal * normal);
    if (contact.rolling == RollingMode::stick) {
      const Vec3<S> roll = proximity.pairs[candidate.pair].bounding_radii * (contact.w - dot(contact.w, n) * n);
      worst = real::max(worst, dot(roll, roll));
    }
    size = real::max(size, speed_square(candidate.feature_body) + speed_square(candidate.surface_body));
  }
  const S round_off = S(4) * real::epsilon<S>();
  return worst <= round_off * round_off * real::max(size, bodies.speed_scale * bodies.speed_scale);
}

// Relative velocities at the contacts are known to this.
template <class S>
void set_velocity_round_off(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                            ConstraintSystem<S>& constraints) {
  const S of_speed = S(4) * real::epsilon<S>() * bodies.speed_scale;
  for (const Contact<S>& contact : active.contacts) {
    if (contact.first_row < 0) continue;
    S* row = constraints.right_round_off.data() + contact.first_row;
    std::fill_n(row, contact.force_rows, of_speed);
    std::fill_n(row + contact.force_rows, contact.couple_rows,
                of_speed / proximity.pairs[proximity.candidates[contact.candidate].pair].bounding_radii);
  }
}

}  // namespace

template <class S>
void project_contacts(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                      ConstraintSystem<S>& constraints, StateBuffers<S>& states) {
  if (active.count == 0) return;
  update_active_kinematics(bodies, proximity, active, states.y.data(), states.y.version);
  project_positions(bodies, proximity, active, constraints, states);
  if (velocities_consistent(bodies, proximity, active)) return;
  assign_rows(bodies, proximity, active, constraints, ConstraintLevel::velocity);
  for (const Contact<S>& contact : active.contacts)
    if (contact.active) project_rows(contact, -contact.u, -contact.w, constraints.right.data() + contact.first_row);
  set_velocity_round_off(bodies, proximity, active, constraints);
  solve_least_change(bodies, active, constraints);
  S* y = states.overwrite(states.y);
  for (const int body : active.bodies) change_velocity(bodies, constraints, body, y);
}

#define ATWOOD_PROJECTION(S)                                                                              \
  template void project_contacts<S>(Bodies<S>&, const Proximity<S>&, ActiveSet<S>&, ConstraintSystem<S>&, \
                                    StateBuffers<S>&);
ATWOOD_PROJECTION(float)
ATWOOD_PROJECTION(double)
ATWOOD_PROJECTION(long double)
#undef ATWOOD_PROJECTION

}  // namespace atwood::event
