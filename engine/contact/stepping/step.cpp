// One step of "+impulse": the increments of the motion without contacts, collision detection, and the substeps
// (world.hpp). Also the bodies' rows, from and to the state as the model lays it out.
#include <algorithm>
#include <atomic>
#include <chrono>

#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood::stepping {
namespace {

// Tolerance of the sweeps. At rest they end where the change of velocity is at most this times what gravity gives in a
// substep; a reported solve counts as converged where it is at most this times that or the largest velocity, whichever
// is larger.
constexpr double kSweepTolerance = 1e-10;

// Minimum number of sweeps of a substep in scenes with joints, where an impulse changes a whole mechanism.
constexpr int kMinSweepsWithJoints = 30;
// Maximum number of alternations of contact and joint solves until both hold at the end of the substep.
constexpr int kMaxJointAlternations = 20;

// Adds the time since the last call to a phase of the profile; without a profile no clock is read.
class PhaseTimer {
 public:
  explicit PhaseTimer(Profile* profile) : profile_(profile) {
    if (profile_ != nullptr) last_ = std::chrono::steady_clock::now();
  }
  void end(const char* phase) {
    if (profile_ == nullptr) return;
    const auto now = std::chrono::steady_clock::now();
    profile_->phase_ns[phase] += std::chrono::duration_cast<std::chrono::nanoseconds>(now - last_).count();
    last_ = now;
  }

 private:
  Profile* profile_;
  std::chrono::steady_clock::time_point last_;
};

// A row of two vectors and two scalars.
template <class S> Row<S> make_row(const Vec3<S>& first, const Vec3<S>& second, S seventh = S(0), S eighth = S(0)) {
  return {{first.x, first.y, first.z, second.x, second.y, second.z, seventh, eighth}};
}

template <class S> bool is_isotropic(const MassProperties<S>& mass) {
  return mass.diagonal && mass.I_row[0].x == mass.I_row[1].y && mass.I_row[1].y == mass.I_row[2].z;
}

// Torque-free rotation over a step of h_s, with the scheme's own gyroscopic term. Sets the angular velocity increment,
// the change of the body rate divided among the substeps, and the pose increment, the rotation that the substeps'
// velocities do not account for.
template <class S> void set_free_rotation(World<S>& world, int i, S h_s) {
  BodyRows<S>& bodies = world.bodies;
  const MassProperties<S>& mass = world.model->mass(i);
  const Quat<S> q = bodies.q_WB[i];
  const Vec3<S> w_W = load3(bodies.velocity[i].at + 3), w_B = rotate_back(q, w_W);
  FreeTurn<S> turn;
  free_turn(FreeTop::splitting, mass, h_s, S(0), w_B, turn);
  const Quat<S> dq = q * turn.minus_one;
  const Quat<S> after = normalised(Quat<S>{q.w + dq.w, q.x + dq.x, q.y + dq.y, q.z + dq.z});
  const Vec3<S> dw_W = rotate(after, w_B + turn.dw_B) - w_W;
  const S n = S(world.substeps);
  // sum over k = 1..n of h/n (w + k/n dw) = h (w + (n + 1) / (2 n) dw)
  const Vec3<S> by_velocities = h_s * (w_W + ((n + S(1)) / (S(2) * n)) * dw_W);
  const Vec3<S> remainder = (S(1) / n) * (so3_log(after * conjugate(q)) - by_velocities);
  for (int c = 0; c < 3; ++c) {
    bodies.velocity_increment[i].at[3 + c] = (c == 0 ? dw_W.x : c == 1 ? dw_W.y : dw_W.z) / n;
    bodies.pose_increment[i].at[3 + c] = c == 0 ? remainder.x : c == 1 ? remainder.y : remainder.z;
  }
}

// Symplectic Euler without contacts: velocities by the accelerations at the step's beginning, then positions by the new
// velocities. Sets the velocity and pose increments of the substeps.
template <class S> void set_increments_of_symplectic_euler(World<S>& world, S t_s, S h_s) {
  BodyRows<S>& bodies = world.bodies;
  RigidModel<S>& model = *world.model;
  const bool forces = model.feels_forces();
  if (forces) {
    store_bodies(world);
    model.accelerations(t_s, world.y.data(), world.y_free.data());
  }
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      store3(Vec3<S>{}, bodies.pose[i].at + 3);
      if (!bodies.moves[i]) continue;
      const bool turns = model.rotates(i) && !bodies.isotropic[i] && !is_tied(world, i);
      if (!turns && !forces) continue;  // its increment is that of load_body()
      if (turns) {
        bodies.inertia[i] = inverse_inertia(model.mass(i), bodies.q_WB[i]);
        set_free_rotation(world, i, h_s);
      }
      if (!forces) continue;
      const S* rate = world.y_free.data() + model.offset(i);
      store3(world.sub_s * load3(rate + kAtVelocity), bodies.velocity_increment[i].at);
      if (!model.rotates(i)) continue;
      const Vec3<S> dw_W = world.sub_s * rotate(bodies.q_WB[i], load3(rate + kAtBodyRate));
      if (turns) store3(load3(bodies.velocity_increment[i].at + 3) + dw_W, bodies.velocity_increment[i].at + 3);
      else store3(dw_W, bodies.velocity_increment[i].at + 3);
    }
  });
}

// Any other scheme: the step that it takes without contacts, divided among the substeps.
//   p_free = p + h (v + v_free) / 2 + remainder
// Sets the velocity and pose increments. False: the scheme's implicit equations were not solved.
template <class S> bool set_increments_of_stepper(World<S>& world, S t_s, S h_s) {
  BodyRows<S>& bodies = world.bodies;
  RigidModel<S>& model = *world.model;
  store_bodies(world);
  if (!world.stepper->step(t_s, h_s, world.y.data(), world.y_free.data())) return false;
  const S share = S(1) / S(world.substeps), half_s = h_s / S(2);
  for (int i = 0; i < bodies.count; ++i) {
    store3(Vec3<S>{}, bodies.pose[i].at + 3);
    if (!bodies.moves[i]) continue;
    const BodyState<S> start = model.body(i, world.y.data()), end = model.body(i, world.y_free.data());
    Vec3<S> dw{}, rotation_remainder{};
    if (model.rotates(i)) {
      const Vec3<S> w = load3(bodies.velocity[i].at + 3), w_free = rotate(end.q_WB, end.w_WB_B);
      dw = w_free - w;
      rotation_remainder = so3_log(end.q_WB * conjugate(start.q_WB)) - half_s * (w + w_free);
      if (!bodies.isotropic[i]) bodies.inertia[i] = inverse_inertia(model.mass(i), start.q_WB);
    }
    const Vec3<S> position_remainder = (end.p_WB - start.p_WB) - half_s * (start.v_WB + end.v_WB);
    bodies.velocity_increment[i] = make_row(share * (end.v_WB - start.v_WB), share * dw);
    bodies.pose_increment[i] = make_row(share * position_remainder, share * rotation_remainder);
  }
  return true;
}

// v += dv_free.
template <class S> void apply_free_velocity_increments(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (world.positions_by_mean_velocity) bodies.velocity_before[i] = bodies.velocity[i];
      for (int c = 0; c < kLaneCount; ++c) bodies.velocity[i].at[c] += bodies.velocity_increment[i].at[c];
    }
  });
}

// p += sub_s v, with the velocity or with the mean of those before and after the increment; adds the pose increments
// and the impact shifts.
template <class S> void integrate_positions(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  const S h = world.sub_s, by[kLaneCount] = {h, h, h, h, h, h, S(0), S(0)};
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      S* pose = bodies.pose[i].at;
      const S* v = bodies.velocity[i].at;
      if (world.positions_by_mean_velocity)
        for (int c = 0; c < kLaneCount; ++c)
          pose[c] += by[c] * ((v[c] + bodies.velocity_before[i].at[c]) / S(2)) + bodies.pose_increment[i].at[c];
      else if (world.has_pose_increment)
        for (int c = 0; c < kLaneCount; ++c) pose[c] += by[c] * v[c] + bodies.pose_increment[i].at[c];
      else
        for (int c = 0; c < kLaneCount; ++c) pose[c] += by[c] * v[c];
      if (!world.has_restitution) continue;
      for (int c = 0; c < kLaneCount; ++c) pose[c] += bodies.impact_shift[i].at[c];
      bodies.impact_shift[i] = Row<S>{};
    }
  });
}

// At the end of the step: q_WB <- exp(s) q_WB of the rotation vector s since its beginning.
template <class S> void update_orientations(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (!bodies.moves[i] || !world.model->rotates(i)) continue;
      const Vec3<S> s = load3(bodies.pose[i].at + 3);
      if (s.x == S(0) && s.y == S(0) && s.z == S(0)) continue;
      bodies.q_WB[i] = normalised(so3_exp(s) * bodies.q_WB[i]);
    }
  });
}

// True: no body is faster than the velocity that gravity adds in a substep, and there are at most 1000 pairs. Then the
// sweeps go on until the velocities converge, so that a stack does not creep while its contact forces build up. Once
// they have converged, the first sweep changes nothing.
template <class S> bool is_at_rest(const World<S>& world) {
  constexpr std::size_t max_pairs = 1000;
  if (world.candidates.sphere_pairs.size() + world.candidates.plane_pairs.size() + world.manifolds.size() > max_pairs)
    return false;
  const S max_speed = norm(world.gravity_W) * world.sub_s;
  const BodyRows<S>& bodies = world.bodies;
  for (int i = 0; i < bodies.count; ++i) {
    const S* v = bodies.velocity[i].at;
    if (bodies.moves[i] && !(norm(load3(v)) + world.geometry[i].bounding_radius * norm(load3(v + 3)) <= max_speed))
      return false;
  }
  return true;
}

// The largest of `largest_of(first, last)` over shares of the bodies, at least 0: the same for any number of threads,
// since real::max takes no NaN.
template <class S, class F> S largest_over_bodies(World<S>& world, const F& largest_of) {
  std::atomic<S> most{};
  for_bodies(world, [&](int first, int last) {
    const S own = largest_of(first, last);
    S seen = most.load(std::memory_order_relaxed);
    while (seen < own && !most.compare_exchange_weak(seen, own, std::memory_order_relaxed)) continue;
  });
  return most;
}

// Largest component of the change of a surface velocity by the last sweep, m/s.
template <class S> S largest_change(World<S>& world) {
  const BodyRows<S>& bodies = world.bodies;
  return largest_over_bodies(world, [&](int first, int last) {
    S most{};
    for (int i = first; i < last; ++i)
      for (int c = 0; c < 3; ++c) {
        const S rotation = world.geometry[i].bounding_radius *
                           (bodies.velocity[i].at[3 + c] - bodies.velocity_before_sweep[i].at[3 + c]);
        if (bodies.moves[i])
          most = real::max(most, real::max(real::abs(bodies.velocity[i].at[c] - bodies.velocity_before_sweep[i].at[c]),
                                           real::abs(rotation)));
      }
    return most;
  });
}

// Adds the sweeps of a substep to the run's tallies. `change`: largest change of a surface velocity in the last sweep
// [m/s]; the residual is its ratio to what gravity gives in a substep or to the largest velocity, whichever is larger.
template <class S> void report_sweeps(World<S>& world, int sweeps, S change) {
  const BodyRows<S>& bodies = world.bodies;
  const S fastest = largest_over_bodies(world, [&](int first, int last) {
    S most{};
    for (int i = first; i < last; ++i)
      for (int c = 0; c < 6 && bodies.moves[i]; ++c) {
        const S speed = real::abs(bodies.velocity[i].at[c]);
        most = real::max(most, c < 3 ? speed : world.geometry[i].bounding_radius * speed);
      }
    return most;
  });
  const S scale = real::max(norm(world.gravity_W) * world.sub_s, fastest);
  const S residual = change == S(0) ? change : change / scale;
  world.model->system().solvers.add(
      IterativeSolver::contact_sweeps,
      {sweeps, static_cast<double>(residual), residual <= S(kSweepTolerance) ? SolveEnd::converged : SolveEnd::capped});
}

// Sweeps over all contacts: `iterations` of them, with joints at least kMinSweepsWithJoints; at rest until the
// velocities converge, at most `rest_sweeps`. `reports`: the change by the last sweep is reported also where not at
// rest.
template <class S> void sweep_velocities(World<S>& world, bool at_rest, bool reports) {
  constexpr int check_every = 8;
  const bool has_stops = world.tied != nullptr && !world.tied->stops.empty();
  if (world.sphere_contacts.batches.empty() && world.manifold_contacts.batches.empty() && !has_stops) return;
  const int min_sweeps =
      world.tied == nullptr ? world.options.iterations : std::max(world.options.iterations, kMinSweepsWithJoints);
  const int sweeps = at_rest ? std::max(min_sweeps, world.options.rest_sweeps) : min_sweeps;
  const S tolerance_m_per_s = S(kSweepTolerance) * norm(world.gravity_W) * world.sub_s;
  for (int k = 0; k < sweeps; ++k) {
    const bool checks = at_rest && k % check_every == 0 && k + 1 >= world.options.iterations;
    const bool measures = checks || ((at_rest || reports) && k + 1 == sweeps);
    if (measures) world.bodies.velocity_before_sweep = world.bodies.velocity;
    solve_sphere_contacts(world);
    solve_manifold_contacts(world);
    if (world.tied != nullptr) sweep_joints(world);
    if (!measures) continue;
    const S change = largest_change(world);
    const bool converged = checks && change <= tolerance_m_per_s;
    if (converged || k + 1 == sweeps) report_sweeps(world, k + 1, change);
    if (converged) return;
  }
}

template <class S> Preparation<S> preparation_of(const World<S>& world) {
  Preparation<S> out;
  out.position_correction.share = S(world.options.correction);
  out.velocity_bias.sub_s = world.sub_s;
  out.velocity_bias.impact_shift = world.has_restitution ? world.bodies.impact_shift.data() : nullptr;
  out.warm_start = world.options.warm_start ? WarmStart::on : WarmStart::off;
  return out;
}

// Contacts and joints, alternately: the joints must hold after the motion that the contact impulses change.
template <class S> void solve_velocities(World<S>& world, bool at_rest, bool last) {
  const auto solve_contacts = [&] {
    const bool solved = world.options.solver != Solver::sequential && solve_directly(world, at_rest);
    if (!solved) sweep_velocities(world, at_rest, last);
    return solved;
  };
  if (world.tied == nullptr) {
    solve_contacts();
    return;
  }
  satisfy_joints_at_end(world);
  for (int n = 0; n < kMaxJointAlternations; ++n) {
    if (n + 1 == kMaxJointAlternations) world.bodies.velocity_before_sweep = world.bodies.velocity;
    const bool solved = solve_contacts();
    const bool moved = satisfy_joints_at_end(world) > 0, corrected = correct_stop_biases(world);
    if (!(moved || corrected) || (!solved && n > 0)) return;
  }
  report_sweeps(world, kMaxJointAlternations, largest_change(world));
}

template <class S> void substep(World<S>& world, bool last, PhaseTimer& timer) {
  const Options& options = world.options;
  if (world.tied != nullptr) begin_tied_substep(world);
  resolve_impacts(world);
  const bool at_rest = options.rest_sweeps > options.iterations && is_at_rest(world);
  timer.end("solve");
  set_rolling_velocity_increments(world);
  apply_free_velocity_increments(world);
  if (world.tied != nullptr) apply_joint_forces(world);
  timer.end("integrate");
  const Preparation<S> preparation = preparation_of(world);
  prepare_sphere_contacts(world, preparation);
  prepare_manifold_contacts(world, preparation);
  predict_rolling_contact_points(world);
  if (world.tied != nullptr) prepare_joints(world);
  solve_velocities(world, at_rest, last);
  if (world.records_impulses) add_impulses_to_sums(world);
  timer.end("solve");
  integrate_positions(world);
  compose_rolling_rotations(world);
  if (world.tied != nullptr) end_tied_substep(world);
  timer.end("integrate");
}

}  // namespace

template <class S> Row<S> inverse_inertia(const MassProperties<S>& mass, const Quat<S>& q_WB) {
  const auto image = [&](const Vec3<S>& axis) {
    return rotate(q_WB, mass.times_inverse_inertia(rotate_back(q_WB, axis)));
  };
  const Vec3<S> x = image({S(1), S(0), S(0)}), y = image({S(0), S(1), S(0)}), z = image({S(0), S(0), S(1)});
  return {{x.x, x.y, x.z, y.y, y.z, z.z, mass.inverse_mass_per_kg, S(0)}};
}

template <class S> void load_bodies(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  const RigidModel<S>& model = *world.model;
  std::fill(bodies.moves.begin(), bodies.moves.end(), 0);
  for (const int i : model.moving()) bodies.moves[i] = 1;
  world.has_pose_increment = false;
  for (int i = 0; i < bodies.count; ++i) {
    load_body(world, i);
    if (!world.sleep.sleeping_island.empty() && world.sleep.sleeping_island[i] >= 0) freeze_body(world, i);
  }
}

template <class S> void set_gravity_increments(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  const Row<S> increment = make_row(world.sub_s * world.gravity_W, Vec3<S>{});
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      if (bodies.moves[i]) bodies.velocity_increment[i] = increment;
  });
}

template <class S> void load_body(World<S>& world, int i) {
  BodyRows<S>& bodies = world.bodies;
  const RigidModel<S>& model = *world.model;
  const BodyState<S> state = model.body(i, world.y.data());
  const MassProperties<S>& mass = model.mass(i);
  const bool turns = bodies.moves[i] && model.rotates(i);
  bodies.isotropic[i] = is_isotropic(mass);
  bodies.q_WB[i] = state.q_WB;
  bodies.velocity_increment[i] = bodies.pose_increment[i] = bodies.inertia[i] = bodies.velocity[i] = Row<S>{};
  bodies.pose[i] = make_row(state.p_WB, Vec3<S>{});
  if (!bodies.moves[i]) return;
  bodies.velocity[i] =
      make_row(state.v_WB, turns ? rotate(state.q_WB, state.w_WB_B) : Vec3<S>{}, mass.inverse_mass_per_kg,
               turns && bodies.isotropic[i] ? mass.I_inverse_row[0].x : S(0));
  bodies.inertia[i] =
      turns ? inverse_inertia(mass, state.q_WB) : make_row(Vec3<S>{}, Vec3<S>{}, mass.inverse_mass_per_kg);
  bodies.velocity_increment[i] = make_row(world.sub_s * world.gravity_W, Vec3<S>{});
  world.has_pose_increment = world.has_pose_increment || (turns && !bodies.isotropic[i]);
}

template <class S> void store_bodies(World<S>& world) {
  const BodyRows<S>& bodies = world.bodies;
  for (int i = 0; i < bodies.count; ++i) {
    if (!bodies.moves[i]) continue;
    const S* v = bodies.velocity[i].at;
    BodyState<S> state{load3(bodies.pose[i].at), load3(v), bodies.q_WB[i], {}};
    if (world.model->rotates(i)) state.w_WB_B = rotate_back(bodies.q_WB[i], load3(v + 3));
    world.model->set_body(i, state, world.y.data());
  }
}

template <class S> bool step(World<S>& world, S t_s, S h_s) {
  PhaseTimer timer(world.profile);
  world.sub_s = h_s / S(world.substeps);
  world.step_end_s = t_s + h_s;
  if (world.stepper == nullptr) set_increments_of_symplectic_euler(world, t_s, h_s);
  else if (!set_increments_of_stepper(world, t_s, h_s)) return false;
  timer.end("integrate");
  update_candidate_pairs(world, h_s);
  timer.end("broad");
  find_manifolds(world);
  if (world.options.sleeping && wake_touched_islands(world)) {
    update_candidate_pairs(world, h_s);
    find_manifolds(world);
  }
  list_contacts_with_restitution(world);
  list_rolling(world, h_s);
  const bool events = world.observer != nullptr && world.observer->event;
  world.records_impulses = world.records_impulses || events;
  if (world.records_impulses) clear_impulse_sums(world);
  if (world.tied != nullptr) clear_joint_sums(world);
  if (events) record_approach_speeds(world);
  timer.end("narrow");
  for (int k = 0; k < world.substeps; ++k) {
    world.t_s = t_s + S(k) * world.sub_s;
    if (k > 0) update_rolling_inertias(world);
    if (k > 0) update_stale_manifolds(world);
    timer.end("narrow");
    substep(world, k + 1 == world.substeps, timer);
  }
  if (events) report_impacts(world);
  update_orientations(world);
  if (world.options.sleeping) put_islands_to_sleep(world, h_s);
  timer.end("integrate");
  return true;
}

#define ATWOOD_STEP(S)                                                          \
  template void load_bodies<S>(World<S>&);                                      \
  template void set_gravity_increments<S>(World<S>&);                           \
  template Row<S> inverse_inertia<S>(const MassProperties<S>&, const Quat<S>&); \
  template void load_body<S>(World<S>&, int);                                   \
  template void store_bodies<S>(World<S>&);                                     \
  template bool step<S>(World<S>&, S, S);
ATWOOD_STEP(float)
ATWOOD_STEP(double)
#undef ATWOOD_STEP

}  // namespace atwood::stepping
