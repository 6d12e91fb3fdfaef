// What joints do in a substep of "+impulse" (mechanisms.hpp).
#include <algorithm>
#include <cmath>

#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood::stepping {
namespace {

constexpr int kMaxJointIterations = 50;

// A body at the end of the substep, as satisfy_joints_at_end() left it.
template <class S> TiedBody<S> body_at_end(const World<S>& world, int body) {
  TiedBody<S> out = tied_body(world, body, S(0));
  if (body < 0 || !is_tied(world, body)) return out;
  out.p_WB = world.tied->p_end[static_cast<std::size_t>(body)];
  out.q_WB = world.tied->q_end[static_cast<std::size_t>(body)];
  return out;
}

// The values of all conditions at t_s, of the poses that `pose_of` gives; the largest in units of its round-off.
template <class S, class PoseOf>
S set_values(const World<S>& world, Mechanism<S>& mechanism, S t_s, const PoseOf& pose_of) {
  S worst{};
  std::size_t at = 0;
  for (const int j : mechanism.joints) {
    const JointConstraint<S>& constraint = world.tied->joints[static_cast<std::size_t>(j)].constraint;
    const TiedBody<S> parent = pose_of(constraint.parent), child = pose_of(constraint.child);
    JointRow<S> c;
    for (int i = 0; i < static_cast<int>(constraint.conditions.size()); ++i, ++at) {
      constraint_row(constraint, i, parent, child, t_s, c);
      mechanism.rows[at].value = c.value;
      const S now = real::abs(c.value) / mechanism.rows[at].tolerance;
      if (!(now <= worst)) worst = now;
    }
    while (at < mechanism.rows.size() && mechanism.rows[at].compliant_unknown >= 0 && mechanism.rows[at].joint == j)
      ++at;
  }
  return worst;
}

// Sets p_end and q_end: the free motion from the beginning of the substep, with the shifts of its impacts.
template <class S> void move_freely(World<S>& world, const Mechanism<S>& mechanism) {
  TiedBodies<S>& tied = *world.tied;
  for (const int body : mechanism.bodies) {
    const auto i = static_cast<std::size_t>(body);
    const S *v = world.bodies.velocity[i].at, *shift = world.bodies.impact_shift[i].at;
    tied.p_end[i] = load3(world.bodies.pose[i].at);
    tied.q_end[i] = tied.q_begin[i];
    if (!world.bodies.moves[i]) continue;
    tied.p_end[i] += world.sub_s * load3(v) + load3(shift);
    if (!world.model->rotates(body)) continue;
    const Quat<S>& q = tied.q_begin[i];
    FreeTurn<S> turn;
    free_turn(FreeTop::splitting, world.model->mass(body), world.sub_s / S(2), world.sub_s / S(2),
              rotate_back(q, load3(v + 3)), turn);
    const Quat<S> by = q * turn.minus_one;
    tied.q_end[i] = normalised(Quat<S>{q.w + by.w, q.x + by.x, q.y + by.y, q.z + by.z});
    const Vec3<S> turned = load3(shift + 3);
    if (dot(turned, turned) > S(0)) tied.q_end[i] = normalised(so3_exp(turned) * tied.q_end[i]);
  }
}

template <class S> void report_joint_solve(World<S>& world, int iterations, S worst, SolveEnd ended) {
  const double residual = static_cast<double>(S(32) * real::epsilon<S>() * worst);
  world.model->system().solvers.add(IterativeSolver::invariant_projection, {iterations, residual, ended});
  const double met =
      std::sqrt(static_cast<double>(real::epsilon<S>()));  // far above round-off, far below a visible gap
  if (ended == SolveEnd::capped && !(residual < met)) world.tied->failed = true;
}

// Brings poses that position corrections moved back onto the joints, nearest in the metric of the masses. The rows and
// factors are those before it.
template <class S> void project_poses(World<S>& world, Mechanism<S>& mechanism, S worst) {
  constexpr int max_iterations = 20;
  TiedBodies<S>& tied = *world.tied;
  int iterations = 0;
  for (; iterations < max_iterations && worst > S(1); ++iterations) {
    for (std::size_t j = 0; j < mechanism.rows.size(); ++j)
      mechanism.b[j] =
          mechanism.rows[j].compliant_unknown >= 0 ? S(0) : -mechanism.rows[j].scale * mechanism.rows[j].value;
    mechanism.qr.solve(mechanism.b.data(), mechanism.z.data());
    mechanism.qr.multipliers(mechanism.x.data());
    for (std::size_t j = 0; j < mechanism.rows.size(); ++j) {
      const TiedRow<S>& row = mechanism.rows[j];
      const S by = row.scale * mechanism.x[j];
      for (int k = 0; k < 2; ++k) {
        if (by == S(0) || row.body[k] < 0 || !is_tied(world, row.body[k])) continue;
        const auto i = static_cast<std::size_t>(row.body[k]);
        const Row<S>& inertia = world.bodies.inertia[i];
        S* pose = world.bodies.pose[i].at;
        store3(load3(pose) + (by * inertia.at[6]) * row.on[k].force, pose);
        tied.q_begin[i] = normalised(so3_exp(apply_inverse_inertia(inertia, by * row.on[k].torque)) * tied.q_begin[i]);
      }
    }
    const S before = worst;
    worst = set_values(world, mechanism, world.t_s, [&](int body) { return tied_body(world, body, S(0)); });
    if (iterations > 2 && !(worst < before / S(2)) && worst <= S(256)) break;
  }
  for (const int body : mechanism.bodies) {
    const auto i = static_cast<std::size_t>(body);
    if (!world.bodies.moves[i] || !world.model->rotates(body)) continue;
    store3(so3_log(tied.q_begin[i] * conjugate(world.bodies.q_WB[i])), world.bodies.pose[i].at + 3);
    world.bodies.inertia[i] = inverse_inertia(world.model->mass(body), tied.q_begin[i]);
  }
  report_joint_solve(world, iterations, worst,
                     worst <= S(1)     ? SolveEnd::converged
                     : worst <= S(256) ? SolveEnd::stagnated
                                       : SolveEnd::capped);
}

template <class S> S coordinate_at_end(const World<S>& world, int joint) {
  const Joint& of = world.scene->joints[static_cast<std::size_t>(joint)];
  S q[4], u[3];
  std::copy(std::begin(world.tied->joints[static_cast<std::size_t>(joint)].q),
            std::end(world.tied->joints[static_cast<std::size_t>(joint)].q), q);
  coordinates_of(of, body_at_end(world, of.parent), body_at_end(world, of.child), q, u);
  return q[0];
}

// Bias, mobility and warm start of the mechanism's stops.
template <class S> void prepare_stops(World<S>& world, Mechanism<S>& mechanism) {
  for (const int s : mechanism.stops) {
    StopConstraint<S>& stop = world.tied->stops[static_cast<std::size_t>(s)];
    set_stop_row(world, stop, S(0));
    const S left = stop.impulse > S(0) && stop.gap <= stop.round_off ? S(0) : stop.gap;
    stop.bias = real::max(left, S(0)) / world.sub_s;
    TiedResponse<S> response = stop_response(world, stop);
    stop.mobility = squared(response);
    if (!world.options.warm_start) stop.impulse = S(0);
    if (stop.impulse > S(0)) apply_row(world, stop.row, stop.impulse);
  }
}

}  // namespace

template <class S> S squared(const TiedResponse<S>& response) {
  S sum{};
  for (const S z : response.z) sum += z * z;
  return sum;
}

template <class S> void set_stop_row(const World<S>& world, StopConstraint<S>& stop, S after_s) {
  coordinate_row(world, stop.joint, 0, after_s, stop.row);
  for (Wrench<S>& on : stop.row.on) on = {stop.side * on.force, stop.side * on.torque};
}

template <class S> TiedResponse<S> stop_response(World<S>& world, const StopConstraint<S>& stop) {
  TiedResponse<S> out;
  const Joint& joint = world.scene->joints[static_cast<std::size_t>(stop.joint)];
  out.mechanism = world.tied->mechanism_of[static_cast<std::size_t>(joint.child)];
  out.z.assign(world.tied->mechanisms[static_cast<std::size_t>(out.mechanism)].z.size(), S(0));
  for (int k = 0; k < 2; ++k)
    if (stop.row.body[k] >= 0 && is_tied(world, stop.row.body[k]))
      add_to_response(world, stop.row.body[k], stop.row.on[k].force, stop.row.on[k].torque, out);
  project_response(world, out);
  return out;
}

template <class S> void begin_tied_substep(World<S>& world) {
  TiedBodies<S>& tied = *world.tied;
  for (const Mechanism<S>& mechanism : tied.mechanisms)
    for (const int body : mechanism.bodies) {
      const auto i = static_cast<std::size_t>(body);
      tied.q_begin[i] = so3_exp(load3(world.bodies.pose[i].at + 3)) * world.bodies.q_WB[i];
    }
  for (StopConstraint<S>& stop : tied.stops)
    stop.begin_gap = stop.gap = stop.side * (tied.joints[static_cast<std::size_t>(stop.joint)].q[0] - stop.limit);
}

template <class S> void apply_joint_forces(World<S>& world) {
  TiedBodies<S>& tied = *world.tied;
  TiedRow<S> row;
  const auto apply = [&](int joint, int k, S force) {
    coordinate_row(world, joint, k, S(0), row);
    apply_row(world, row, world.sub_s * force);
    tied.joints[static_cast<std::size_t>(joint)].applied[k] += world.sub_s * force;
  };
  const double middle_s = static_cast<double>(world.t_s + world.sub_s / S(2));
  for (const JointForce& force : world.scene->joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) {
      const S q = tied.joints[static_cast<std::size_t>(spring->joint)].q[spring->coordinate];
      if (spring->stiffness > 0)
        apply(spring->joint, spring->coordinate, -S(spring->stiffness) * (q - S(spring->rest)));
      continue;
    }
    const auto& motor = std::get<JointTorque>(force);
    const bool on = motor.on_s.empty() || std::any_of(motor.on_s.begin(), motor.on_s.end(), [&](const Interval& i) {
                      return i.from_s <= middle_s && middle_s < i.to_s;
                    });
    const double angle = motor.angular_frequency_rad_per_s * middle_s + motor.phase_rad;
    if (on) apply(motor.joint, motor.coordinate, S(motor.torque * real::cos(angle)));
  }
}

template <class S> void prepare_joints(World<S>& world) {
  constexpr int moved = 4;  // round-offs
  for (Mechanism<S>& mechanism : world.tied->mechanisms) {
    factor_rows(world, mechanism, S(0), true);
    const S worst = set_values(world, mechanism, world.t_s, [&](int body) { return tied_body(world, body, S(0)); });
    if (worst > S(moved)) {
      project_poses(world, mechanism, worst);
      factor_rows(world, mechanism, S(0), true);
    }
    prepare_stops(world, mechanism);
  }
}

template <class S> int satisfy_joints_at_end(World<S>& world) {
  int changes = 0;
  const S end_s = world.t_s + world.sub_s;
  for (Mechanism<S>& mechanism : world.tied->mechanisms) {
    S before{};
    for (int n = 0;; ++n) {
      satisfy_joints(world, mechanism);
      move_freely(world, mechanism);
      const S worst = set_values(world, mechanism, end_s, [&](int body) { return body_at_end(world, body); });
      const bool stagnates = n > 2 && worst > before / S(2) && worst <= S(256);
      const bool ends = worst <= S(1) || stagnates || n == kMaxJointIterations || !(worst < S(1e30f));
      if (ends) {
        report_joint_solve(world, n, worst,
                           worst <= S(1) ? SolveEnd::converged
                           : stagnates   ? SolveEnd::stagnated
                                         : SolveEnd::capped);
        if (!stagnates) changes += n;
        break;
      }
      before = worst;
      for (TiedRow<S>& row : mechanism.rows)
        if (row.compliant_unknown < 0) row.target_rate -= row.value / world.sub_s;
    }
  }
  return changes;
}

template <class S> bool correct_stop_biases(World<S>& world) {
  bool changed = false;
  for (StopConstraint<S>& stop : world.tied->stops) {
    const S end = stop.side * (coordinate_at_end(world, stop.joint) - stop.limit) - real::min(stop.begin_gap, S(0));
    if (!(end < -stop.round_off || (stop.impulse > S(0) && end > stop.round_off))) continue;
    stop.bias += end / world.sub_s;
    changed = true;
  }
  return changed;
}

template <class S> void sweep_joints(World<S>& world) {
  for (Mechanism<S>& mechanism : world.tied->mechanisms) {
    satisfy_joints(world, mechanism);
    for (const int s : mechanism.stops) {
      StopConstraint<S>& stop = world.tied->stops[static_cast<std::size_t>(s)];
      if (!(stop.mobility > S(0))) continue;
      const S to = real::max(S(0), stop.impulse - (rate_of(world, stop.row) + stop.bias) / stop.mobility);
      if (to == stop.impulse) continue;
      apply_row(world, stop.row, to - stop.impulse);
      stop.impulse = to;
      satisfy_joints(world, mechanism);
    }
  }
}

template <class S> void end_tied_substep(World<S>& world) {
  TiedBodies<S>& tied = *world.tied;
  for (Mechanism<S>& mechanism : tied.mechanisms) {
    add_reactions(world, mechanism, S(0));
    for (const int s : mechanism.stops) {
      const StopConstraint<S>& stop = tied.stops[static_cast<std::size_t>(s)];
      tied.joints[static_cast<std::size_t>(stop.joint)].stop += stop.side * stop.impulse;
    }
    for (const int body : mechanism.bodies) {
      const auto i = static_cast<std::size_t>(body);
      if (!world.bodies.moves[i]) continue;
      S *pose = world.bodies.pose[i].at, *v = world.bodies.velocity[i].at;
      store3(tied.p_end[i], pose);
      world.bodies.impact_shift[i] = Row<S>{};
      if (!world.model->rotates(body)) continue;
      const Quat<S>&q = tied.q_begin[i], &q_end = tied.q_end[i];
      const MassProperties<S>& mass = world.model->mass(body);
      const Vec3<S> momentum_W = rotate(q, mass.times_inertia(rotate_back(q, load3(v + 3))));
      store3(rotate(q_end, mass.times_inverse_inertia(rotate_back(q_end, momentum_W))), v + 3);
      store3(so3_log(q_end * conjugate(world.bodies.q_WB[i])), pose + 3);
      world.bodies.inertia[i] = inverse_inertia(mass, q_end);
      tied.q_begin[i] = q_end;
    }
  }
  for (std::size_t j = 0; j < tied.joints.size(); ++j) {
    const Joint& joint = world.scene->joints[j];
    coordinates_of(joint, tied_body(world, joint.parent, S(0)), tied_body(world, joint.child, S(0)), tied.joints[j].q,
                   tied.joints[j].u);
  }
}

#define ATWOOD_MECHANISM_SUBSTEP(S)                                               \
  template S squared<S>(const TiedResponse<S>&);                                  \
  template void set_stop_row<S>(const World<S>&, StopConstraint<S>&, S);          \
  template TiedResponse<S> stop_response<S>(World<S>&, const StopConstraint<S>&); \
  template void begin_tied_substep<S>(World<S>&);                                 \
  template void apply_joint_forces<S>(World<S>&);                                 \
  template void prepare_joints<S>(World<S>&);                                     \
  template int satisfy_joints_at_end<S>(World<S>&);                               \
  template bool correct_stop_biases<S>(World<S>&);                                \
  template void sweep_joints<S>(World<S>&);                                       \
  template void end_tied_substep<S>(World<S>&);
ATWOOD_MECHANISM_SUBSTEP(float)
ATWOOD_MECHANISM_SUBSTEP(double)
#undef ATWOOD_MECHANISM_SUBSTEP

}  // namespace atwood::stepping
