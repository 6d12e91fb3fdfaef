#include <algorithm>
#include <chrono>

#include "contact/stepping/points.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood::stepping {
namespace {

// Share of what gravity gives in a substep, or of the largest velocity: sweeps that change less are at their end.
constexpr double kStill = 1e-10;

// Adds the time since the last call to a phase; without a profile no clock is read.
class Phases {
 public:
  explicit Phases(Profile* profile) : profile_(profile) {
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

template <class S> Row<S> row(const Vec3<S>& first, const Vec3<S>& second, S seventh = S(0), S eighth = S(0)) {
  return {{first.x, first.y, first.z, second.x, second.y, second.z, seventh, eighth}};
}

template <class S> bool is_isotropic(const MassProperties<S>& mass) {
  return mass.diagonal && mass.I_row[0].x == mass.I_row[1].y && mass.I_row[1].y == mass.I_row[2].z;
}

// Turning free of torque over the step, with the scheme's own gyroscopic term: the body rate's change is spread over
// the substeps, and what they miss of the attitude is `rest`.
template <class S> void turn_freely(World<S>& world, int i, S h_s) {
  Bodies<S>& bodies = world.bodies;
  const MassProperties<S>& mass = world.model->mass(i);
  const Quat<S> q = bodies.q_WB[i];
  const Vec3<S> w_W = load3(bodies.velocity[i].at + 3), w_B = rotate_back(q, w_W);
  FreeTurn<S> turn;
  free_turn(FreeTop::splitting, mass, h_s, S(0), w_B, turn);
  const Quat<S> moved = q * turn.less_one;
  const Quat<S> after = normalised(Quat<S>{q.w + moved.w, q.x + moved.x, q.y + moved.y, q.z + moved.z});
  const Vec3<S> dw_W = rotate(after, w_B + turn.dw_B) - w_W;
  const S n = S(world.substeps);
  // sum over k = 1..n of h/n (w + k/n dw) = h (w + (n + 1) / (2 n) dw)
  const Vec3<S> by_velocities = h_s * (w_W + ((n + S(1)) / (S(2) * n)) * dw_W);
  const Vec3<S> rest = (S(1) / n) * (so3_log(after * conjugate(q)) - by_velocities);
  for (int c = 0; c < 3; ++c) {
    bodies.kick[i].at[3 + c] = (c == 0 ? dw_W.x : c == 1 ? dw_W.y : dw_W.z) / n;
    bodies.rest[i].at[3 + c] = c == 0 ? rest.x : c == 1 ? rest.y : rest.z;
  }
}

// Symplectic Euler: velocities by the accelerations at the step's start, then places by the velocities.
template <class S> void prepare_fused_flight(World<S>& world, S t_s, S h_s) {
  Bodies<S>& bodies = world.bodies;
  RigidModel<S>& model = *world.model;
  const bool forces = model.feels_forces();
  if (forces) {
    store_bodies(world);
    model.accelerations(t_s, world.y.data(), world.y_free.data());
  }
  const S sub_s = h_s / S(world.substeps);
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      store3(Vec3<S>{}, bodies.place[i].at + 3);
      if (!bodies.moves[i]) continue;
      const bool turns = model.rotates(i) && !bodies.isotropic[i];
      if (!turns && !forces) continue;  // its kick stands since load_bodies
      if (turns) {
        bodies.inertia[i] = inverse_inertia(model.mass(i), bodies.q_WB[i]);
        turn_freely(world, i, h_s);
      }
      if (!forces) continue;
      const S* rate = world.y_free.data() + model.offset(i);
      store3(sub_s * load3(rate + kAtVelocity), bodies.kick[i].at);
      if (!model.rotates(i)) continue;
      const Vec3<S> dw_W = sub_s * rotate(bodies.q_WB[i], load3(rate + kAtBodyRate));
      if (turns) store3(load3(bodies.kick[i].at + 3) + dw_W, bodies.kick[i].at + 3);
      else store3(dw_W, bodies.kick[i].at + 3);
    }
  });
}

// Any other scheme: the step that it would take without contacts, spread over the substeps.
//   p_free = p + h (v + v_free) / 2 + rest
template <class S> bool prepare_flight(World<S>& world, S t_s, S h_s) {
  Bodies<S>& bodies = world.bodies;
  RigidModel<S>& model = *world.model;
  store_bodies(world);
  if (!world.stepper->step(t_s, h_s, world.y.data(), world.y_free.data())) return false;
  const S share = S(1) / S(world.substeps), half_s = h_s / S(2);
  for (int i = 0; i < bodies.count; ++i) {
    store3(Vec3<S>{}, bodies.place[i].at + 3);
    if (!bodies.moves[i]) continue;
    const BodyState<S> start = model.body(i, world.y.data()), end = model.body(i, world.y_free.data());
    Vec3<S> dw{}, turn_rest{};
    if (model.rotates(i)) {
      const Vec3<S> w = load3(bodies.velocity[i].at + 3), w_free = rotate(end.q_WB, end.w_WB_B);
      dw = w_free - w;
      turn_rest = so3_log(end.q_WB * conjugate(start.q_WB)) - half_s * (w + w_free);
      if (!bodies.isotropic[i]) bodies.inertia[i] = inverse_inertia(model.mass(i), start.q_WB);
    }
    const Vec3<S> shift_rest = (end.p_WB - start.p_WB) - half_s * (start.v_WB + end.v_WB);
    bodies.kick[i] = row(share * (end.v_WB - start.v_WB), share * dw);
    bodies.rest[i] = row(share * shift_rest, share * turn_rest);
  }
  return true;
}

template <class S> void kick(World<S>& world) {
  Bodies<S>& bodies = world.bodies;
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (world.by_mean) bodies.before[i] = bodies.velocity[i];
      for (int c = 0; c < kLaneCount; ++c) bodies.velocity[i].at[c] += bodies.kick[i].at[c];
    }
  });
}

template <class S> void drift(World<S>& world, S sub_s) {
  Bodies<S>& bodies = world.bodies;
  const S by[kLaneCount] = {sub_s, sub_s, sub_s, sub_s, sub_s, sub_s, S(0), S(0)};
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      S* place = bodies.place[i].at;
      const S* v = bodies.velocity[i].at;
      if (world.by_mean)
        for (int c = 0; c < kLaneCount; ++c)
          place[c] += by[c] * ((v[c] + bodies.before[i].at[c]) / S(2)) + bodies.rest[i].at[c];
      else if (world.has_rest)
        for (int c = 0; c < kLaneCount; ++c) place[c] += by[c] * v[c] + bodies.rest[i].at[c];
      else
        for (int c = 0; c < kLaneCount; ++c) place[c] += by[c] * v[c];
      if (!world.bounces) continue;
      for (int c = 0; c < kLaneCount; ++c) place[c] += bodies.shift[i].at[c];
      bodies.shift[i] = Row<S>{};
    }
  });
}

template <class S> void turn_bodies(World<S>& world) {
  Bodies<S>& bodies = world.bodies;
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (!bodies.moves[i] || !world.model->rotates(i)) continue;
      const Vec3<S> s = load3(bodies.place[i].at + 3);
      if (s.x == S(0) && s.y == S(0) && s.z == S(0)) continue;
      bodies.q_WB[i] = normalised(so3_exp(s) * bodies.q_WB[i]);
    }
  });
}

// Few enough contacts, and no body faster than what gravity brings within a substep: then the sweeps go on until the
// velocities stay, so that what stands does not creep while its forces build up. Once they have, the first sweep
// changes nothing.
template <class S> bool at_rest(const World<S>& world) {
  constexpr std::size_t most_pairs = 1000;
  if (world.ball_pairs.size() + world.plane_pairs.size() + world.manifolds.size() > most_pairs) return false;
  const S most = norm(world.gravity_W) * world.sub_s;
  const Bodies<S>& bodies = world.bodies;
  for (int i = 0; i < bodies.count; ++i) {
    const S* v = bodies.velocity[i].at;
    if (bodies.moves[i] && !(norm(load3(v)) + world.geometry[i].bounding_radius * norm(load3(v + 3)) <= most))
      return false;
  }
  return true;
}

template <class S> S largest_change(const World<S>& world) {
  const Bodies<S>& bodies = world.bodies;
  S most{};
  for (int i = 0; i < bodies.count; ++i)
    for (int c = 0; c < 3; ++c) {
      const S turned = world.geometry[i].bounding_radius * (bodies.velocity[i].at[3 + c] - bodies.swept[i].at[3 + c]);
      if (bodies.moves[i])
        most =
            real::max(most, real::max(real::abs(bodies.velocity[i].at[c] - bodies.swept[i].at[c]), real::abs(turned)));
    }
  return most;
}

// Of the last sweep, `change` by it: relative to what gravity gives in a substep or to the largest velocity, whichever
// is larger.
template <class S> void report_sweeps(World<S>& world, int sweeps, S change) {
  const Bodies<S>& bodies = world.bodies;
  S scale = norm(world.gravity_W) * world.sub_s;
  for (int i = 0; i < bodies.count; ++i)
    for (int c = 0; c < 6 && bodies.moves[i]; ++c) {
      const S speed = real::abs(bodies.velocity[i].at[c]);
      scale = real::max(scale, c < 3 ? speed : world.geometry[i].bounding_radius * speed);
    }
  const S residual = change == S(0) ? change : change / scale;
  world.model->system().solvers.add(
      IterativeSolver::contact_sweeps,
      {sweeps, static_cast<double>(residual), residual <= S(kStill) ? SolveEnd::converged : SolveEnd::capped});
}

// The last sweep of a substep is measured where `reports`, and where the scene is at rest.
template <class S> void sweep(World<S>& world, bool rests, bool reports) {
  constexpr int look_every = 8;
  if (world.balls.batches.empty() && world.manifold_batches.batches.empty()) return;
  const int sweeps = rests ? std::max(world.options.iterations, world.options.rest_sweeps) : world.options.iterations;
  const S still = S(kStill) * norm(world.gravity_W) * world.sub_s;
  for (int k = 0; k < sweeps; ++k) {
    const bool looks = rests && k % look_every == 0 && k + 1 >= world.options.iterations;
    const bool measures = looks || ((rests || reports) && k + 1 == sweeps);
    if (measures) world.bodies.swept = world.bodies.velocity;
    solve_balls(world);
    solve_manifolds(world);
    if (!measures) continue;
    const S change = largest_change(world);
    const bool stays = looks && change <= still;
    if (stays || k + 1 == sweeps) report_sweeps(world, k + 1, change);
    if (stays) return;
  }
}

template <class S> void substep(World<S>& world, S sub_s, bool last, Phases& phases) {
  const Options& options = world.options;
  meet_impacts(world, sub_s);
  const bool rests = options.rest_sweeps > options.iterations && at_rest(world);
  phases.end("solve");
  kick_rolling(world, sub_s);
  kick(world);
  phases.end("integrate");
  prepare_balls(world, sub_s, options.push_apart, options.warm_start);
  prepare_manifolds(world, sub_s, options.push_apart, options.warm_start);
  look_ahead(world, sub_s);
  const bool solved = options.solver != Solver::sequential && solve_directly(world, rests);
  if (!solved) sweep(world, rests, last);
  if (world.sums_impulses) add_sums(world);
  phases.end("solve");
  drift(world, sub_s);
  turn_rolling(world, sub_s);
  phases.end("integrate");
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
  Bodies<S>& bodies = world.bodies;
  const RigidModel<S>& model = *world.model;
  std::fill(bodies.moves.begin(), bodies.moves.end(), 0);
  for (const int i : model.moving()) bodies.moves[i] = 1;
  world.has_rest = false;
  for (int i = 0; i < bodies.count; ++i) {
    load_body(world, i);
    if (!world.sleep.island.empty() && world.sleep.island[i] >= 0) lay_down(world, i);
  }
}

template <class S> void set_kicks(World<S>& world) {
  Bodies<S>& bodies = world.bodies;
  const Row<S> kick = row(world.sub_s * world.gravity_W, Vec3<S>{});
  for_bodies(world, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      if (bodies.moves[i]) bodies.kick[i] = kick;
  });
}

template <class S> void load_body(World<S>& world, int i) {
  Bodies<S>& bodies = world.bodies;
  const RigidModel<S>& model = *world.model;
  const BodyState<S> state = model.body(i, world.y.data());
  const MassProperties<S>& mass = model.mass(i);
  const bool turns = bodies.moves[i] && model.rotates(i);
  bodies.isotropic[i] = is_isotropic(mass);
  bodies.q_WB[i] = state.q_WB;
  bodies.kick[i] = bodies.rest[i] = bodies.inertia[i] = bodies.velocity[i] = Row<S>{};
  bodies.place[i] = row(state.p_WB, Vec3<S>{});
  if (!bodies.moves[i]) return;
  bodies.velocity[i] = row(state.v_WB, turns ? rotate(state.q_WB, state.w_WB_B) : Vec3<S>{}, mass.inverse_mass_per_kg,
                           turns && bodies.isotropic[i] ? mass.I_inverse_row[0].x : S(0));
  bodies.inertia[i] = turns ? inverse_inertia(mass, state.q_WB) : row(Vec3<S>{}, Vec3<S>{}, mass.inverse_mass_per_kg);
  bodies.kick[i] = row(world.sub_s * world.gravity_W, Vec3<S>{});
  world.has_rest = world.has_rest || (turns && !bodies.isotropic[i]);
}

template <class S> void store_bodies(World<S>& world) {
  const Bodies<S>& bodies = world.bodies;
  for (int i = 0; i < bodies.count; ++i) {
    if (!bodies.moves[i]) continue;
    const S* v = bodies.velocity[i].at;
    BodyState<S> state{load3(bodies.place[i].at), load3(v), bodies.q_WB[i], {}};
    if (world.model->rotates(i)) state.w_WB_B = rotate_back(bodies.q_WB[i], load3(v + 3));
    world.model->set_body(i, state, world.y.data());
  }
}

template <class S> bool step(World<S>& world, S t_s, S h_s) {
  Phases phases(world.profile);
  world.sub_s = h_s / S(world.substeps);
  if (world.stepper == nullptr) prepare_fused_flight(world, t_s, h_s);
  else if (!prepare_flight(world, t_s, h_s)) return false;
  phases.end("integrate");
  find_candidates(world, h_s);
  phases.end("broad");
  find_manifolds(world);
  if (world.options.sleeping && wake_whom_others_meet(world)) {
    find_candidates(world, h_s);
    find_manifolds(world);
  }
  list_bouncing(world);
  list_rolling(world, h_s);
  const bool events = world.observer != nullptr && world.observer->event;
  world.sums_impulses = world.sums_impulses || events;
  if (world.sums_impulses) clear_sums(world);
  if (events) note_approaches(world);
  phases.end("narrow");
  for (int k = 0; k < world.substeps; ++k) {
    world.t_s = t_s + S(k) * world.sub_s;
    if (k > 0) turn_rolling_inertias(world);
    if (k > 0) renew_manifolds(world);
    phases.end("narrow");
    substep(world, world.sub_s, k + 1 == world.substeps, phases);
  }
  if (events) tell_onsets(world);
  turn_bodies(world);
  if (world.options.sleeping) fall_asleep(world, h_s);
  phases.end("integrate");
  return true;
}

#define ATWOOD_STEP(S)                                                          \
  template void load_bodies<S>(World<S>&);                                      \
  template void set_kicks<S>(World<S>&);                                        \
  template Row<S> inverse_inertia<S>(const MassProperties<S>&, const Quat<S>&); \
  template void load_body<S>(World<S>&, int);                                   \
  template void store_bodies<S>(World<S>&);                                     \
  template bool step<S>(World<S>&, S, S);
ATWOOD_STEP(float)
ATWOOD_STEP(double)
#undef ATWOOD_STEP

}  // namespace atwood::stepping
