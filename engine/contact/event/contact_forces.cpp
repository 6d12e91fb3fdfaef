// Forces of lasting contacts, solved for in each evaluation of the rates.
//
// Feature body k on surface body s, n the normal from s to k, x the contact point,
//   u   = v_k + w_k x (x - p_k) - v_s - w_s x (x - p_s)
//   u'  = a_k + alpha_k x (x - p_k) + w_k x (x' - v_k)  -  the same of s,     x' the velocity of the geometric point
//   closed       (n . u)' = 0                     force  N n
//   sticking     (t . u)' = 0 for two t           force  T_1 t_1 + T_2 t_2
//   slipping                                      force  -mu N u_t / |u_t|
//   rolling                                       couple -delta N w_t / |w_t|
// Between mode changes these are smooth functions of the state, so a method keeps its order.
// Source: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), ch. 5.
#include "contact/event/contact_forces.hpp"

#include <algorithm>

#include "contact/event/linear_solve.hpp"
#include "contact/event/painleve.hpp"
#include "contact/event/run.hpp"
#include "contact/event/single_contact.hpp"

namespace atwood::event {

namespace {

// Bodies' accelerations in `dydt`, world axes.
template <class S> Vec3<S> linear_of(const Bodies<S>& bodies, int body, const S* dydt) {
  return bodies.moves[body] ? load3(dydt + bodies.model.offset(body) + kAtVelocity) : Vec3<S>{};
}
template <class S> Vec3<S> angular_of(const Bodies<S>& bodies, int body, const S* dydt) {
  if (!bodies.moves[body] || !bodies.model.rotates(body)) return {};
  return to_world(bodies.poses[body], load3(dydt + bodies.model.offset(body) + kAtBodyRate));
}

// Raises contact.largest_N, and sets active.force_near_bound if the normal force, friction or couple is within a tenth
// of its bound.
template <class S> void monitor_bounds(const Proximity<S>& proximity, ActiveSet<S>& active, Contact<S>& contact) {
  const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
  contact.largest_N = real::max(contact.largest_N, contact.normal_N);
  const auto near = [&](const Vec3<S>& load, S bound) { return !(dot(load, load) <= S(0.81) * bound * bound); };
  active.force_near_bound =
      active.force_near_bound || !(contact.normal_N >= S(0.1) * contact.largest_N) ||
      (contact.mode == FrictionMode::stick && near(contact.friction_N, pair.friction * contact.normal_N)) ||
      (contact.rolling == RollingMode::stick && near(contact.couple_N_m, pair.rolling_friction_m * contact.normal_N));
}

// How several sticking contacts share friction does not affect the motion as long as all stick, but decides which one
// slips first. In proportion to their normal forces, contacts reach their cones together when the tangential load acts
// at the centre of pressure.
template <class S>
void distribute_friction_by_normal_force(const Bodies<S>& bodies, const Proximity<S>& proximity,
                                         const ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  S sum_N = S(0);
  int sticking = 0;
  bool near_edge = false;
  for (const Contact<S>& contact : active.contacts) {
    if (contact.first_row < 0 || contact.mode != FrictionMode::stick) continue;
    ++sticking;
    const S* force = &constraints.unknown[contact.first_row];
    const S bound = S(0.5) * proximity.pairs[proximity.candidates[contact.candidate].pair].friction * force[0];
    sum_N += force[0];
    near_edge = near_edge || !(force[1] * force[1] + force[2] * force[2] < bound * bound);
  }
  if (sticking < 2 || !near_edge || !(sum_N > S(0))) return;  // far from their cones the distribution does not matter
  assemble_delassus(bodies, active, constraints);
  S largest = S(0);  // weights make up for the different diagonals of contacts at different points
  for (int i = 0; i < constraints.row_count; ++i) largest = real::max(largest, constraints.diagonal[i]);
  const S mean = sum_N / S(sticking);
  for (const Contact<S>& contact : active.contacts) {
    if (contact.first_row < 0 || contact.mode != FrictionMode::stick) continue;
    const S weight = mean / real::max(constraints.unknown[contact.first_row], S(0x1p-10) * mean);
    for (int i = contact.first_row + 1; i <= contact.first_row + 2; ++i) {
      constraints.weight[i] = weight * largest / constraints.diagonal[i];
      constraints.unknown[i] = S(0);
    }
  }
  solve_rows(bodies, active, constraints, true, std::uint64_t{0});  // factors of these weights only
}

// right = -(velocity terms of g'' = (n . u)', (t . u)' and (t . w)'), for tangents t that turn with n.
template <class S>
void assemble_right_hand_side(const Bodies<S>& bodies, ConstraintSystem<S>& constraints, const Contact<S>& contact) {
  const GapKinematics<S>& kinematics = contact.kinematics;
  Vec3<S> b = -dot(contact.u, kinematics.normal_dot) * kinematics.normal, couple{};
  for (int side = 0; side < 2; ++side) {
    if (contact.levers.body[side] < 0) continue;
    const Pose<S>& pose = bodies.poses[contact.levers.body[side]];
    const Vec3<S> circling = cross(pose.w, kinematics.x_dot - pose.v);
    b = side == 0 ? b - circling : b + circling;
  }
  if (contact.couple_rows > 0) couple = dot(contact.w, kinematics.normal) * kinematics.normal_dot;
  project_rows(contact, b, couple, constraints.right.data() + contact.first_row);
}

// Equal keys: the same contacts are active, in the same modes, so that matrices differ little from one evaluation to
// the next.
template <class S> std::uint64_t mode_key_of(const Bodies<S>& bodies, const ActiveSet<S>& active) {
  std::uint64_t key = bodies.moves_version + 1;
  for (const Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    const auto candidate = static_cast<std::uint64_t>(contact.candidate);
    key = key * 0x9e3779b97f4a7c15u + candidate * 16 + static_cast<std::uint64_t>(contact.mode) * 4 +
          static_cast<std::uint64_t>(contact.rolling) + 0x100000000u * contact.decoupled;
  }
  return key;
}

template <class S>
void find_decoupled_contacts(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active) {
  const auto feature = [&](const Contact<S>& contact) { return proximity.candidates[contact.candidate].feature_body; };
  const auto surface = [&](const Contact<S>& contact) { return proximity.candidates[contact.candidate].surface_body; };
  for (const int body : active.bodies) active.contacts_on_body[body] = 0;
  for (const Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    ++active.contacts_on_body[feature(contact)];
    ++active.contacts_on_body[surface(contact)];
  }
  const auto shared = [&](int body) { return bodies.moves[body] && active.contacts_on_body[body] > 1; };
  for (Contact<S>& contact : active.contacts) {
    const bool forces = contact.rolling == RollingMode::free ||
                        (contact.rolling == RollingMode::roll && contact.mode != FrictionMode::stick);
    contact.decoupled = forces && !shared(feature(contact)) && !shared(surface(contact));
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const SurfaceKind kind = proximity.surfaces[candidate.surface].kind;
    const auto turns_freely = [&](int body) { return !bodies.model.rotates(body) || bodies.isotropic[body]; };
    contact.between_spheres =
        (!bodies.moves[feature(contact)] ||
         (candidate.feature.centered && !candidate.feature.circle && turns_freely(feature(contact)))) &&
        (!bodies.moves[surface(contact)] || (kind == SurfaceKind::point && turns_freely(surface(contact))));
  }
}

// The start decides among solutions of redundant constraints.
template <class S> void load_warm_start(const ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  std::fill_n(constraints.weight.begin(), constraints.row_count, S(1));
  for (const Contact<S>& contact : active.contacts) {
    if (contact.first_row < 0) continue;
    S* x = constraints.unknown.data() + contact.first_row;
    project_rows(contact, contact.warm_start_friction_N, contact.warm_start_couple_N_m, x);
    x[0] = contact.warm_start_N;
  }
}

template <class S>
void solve_coupled_contacts(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                            ConstraintSystem<S>& constraints) {
  assign_rows(bodies, proximity, active, constraints, ConstraintLevel::acceleration);
  load_warm_start(active, constraints);
  std::fill_n(constraints.right_round_off.begin(), constraints.row_count, S(0));
  for (const Contact<S>& contact : active.contacts)
    if (contact.first_row >= 0) assemble_right_hand_side(bodies, constraints, contact);
  if (constraints.row_contacts == 1) {
    solve_rows(bodies, active, constraints, false, std::uint64_t{0});
    return;
  }
  solve_rows(bodies, active, constraints, true, active.mode_key);
  distribute_friction_by_normal_force(bodies, proximity, active, constraints);
}

// Records, at the first contact that slips, the Delassus form x . A x of the coupled contacts' forces x, divided by the
// square of the sum of their normal forces, where
//   A x = right - (the rows' values without these forces)
template <class S> void record_coupled_delassus(ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  Contact<S>* slips = nullptr;
  S along = S(0), size = S(0), normal = S(0), free_rows[5];
  constraints.acceleration.swap(constraints.free_acceleration);
  for (Contact<S>& contact : active.contacts) {
    if (contact.first_row < 0) continue;
    if (slips == nullptr && contact.mode == FrictionMode::slip && !contact.at_cone_limit) slips = &contact;
    const S* x = constraints.unknown.data() + contact.first_row;
    row_values(constraints, contact, free_rows);
    for (int i = 0; i < contact.force_rows + contact.couple_rows; ++i) {
      const S right = constraints.right[contact.first_row + i];
      along += x[i] * (right - free_rows[i]);
      size += real::abs(x[i]) * (real::abs(right) + real::abs(free_rows[i]));
    }
    normal += x[0];
  }
  constraints.acceleration.swap(constraints.free_acceleration);
  // Forces that pull (the contact separates, or a stage lies past a zero of the form) count where the form is more than
  // round-off.
  const bool known = normal < S(0) && real::abs(along) > S(256) * real::epsilon<S>() * size;
  if (slips != nullptr && (normal > S(0) || known)) record_delassus(*slips, along / (normal * normal), normal);
}

template <class S>
void add_coupled_forces(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                        ConstraintSystem<S>& constraints, S* dydt) {
  for (const int body : active.bodies)
    constraints.free_acceleration[body] = {linear_of(bodies, body, dydt), angular_of(bodies, body, dydt)};
  solve_coupled_contacts(bodies, proximity, active, constraints);
  for (Contact<S>& contact : active.contacts)
    if (contact.first_row >= 0) store_forces(constraints, contact);
  if (std::any_of(active.contacts.begin(), active.contacts.end(),
                  [](const Contact<S>& c) { return c.mode == FrictionMode::slip; }))
    record_coupled_delassus(active, constraints);
  for (const int body : active.bodies) {
    if (!bodies.moves[body] || !constraints.loaded[body]) continue;
    S* at = dydt + bodies.model.offset(body);
    store3(constraints.acceleration[body].linear, at + kAtVelocity);
    if (bodies.model.rotates(body))
      store3(to_body(bodies.poses[body], constraints.acceleration[body].angular), at + kAtBodyRate);
  }
}

// Callbacks of System; `context` is the EventRun.
template <class S> void rate_with_contacts(void* context, S t_s, const S* y, S* dydt) {
  EventRun<S>& run = *static_cast<EventRun<S>*>(context);
  ++run.integration.wrapped_calls;
  run.integration.free.rate(t_s, y, dydt);
  if (run.active.count > 0)
    add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, y, run.states.version_of(y), dydt);
}
template <class S> void project_with_contacts(void* context, S* y) {
  const EventRun<S>& run = *static_cast<EventRun<S>*>(context);
  run.integration.free.project_of(run.integration.free.context, y);
}
template <class S> void projection_with_contacts(void* context, const S* y, S* change) {
  const EventRun<S>& run = *static_cast<EventRun<S>*>(context);
  run.integration.free.projection_of(run.integration.free.context, y, change);
}

}  // namespace

template <class S> void install_contact_forces(EventRun<S>& run) {
  System<S>& system = run.bodies.model.system();
  run.integration.free.context = system.context;
  run.integration.free.rate_of = system.rate_of;
  run.integration.free.project_of = system.project_of;
  run.integration.free.projection_of = system.projection_of;
  system.context = &run;
  system.rate_of = &rate_with_contacts<S>;
  system.rates_of = nullptr;
  if (system.project_of != nullptr) system.project_of = &project_with_contacts<S>;
  if (system.projection_of != nullptr) system.projection_of = &projection_with_contacts<S>;
}

template <class S>
void add_contact_forces(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                        ConstraintSystem<S>& constraints, const S* y, std::uint64_t version, S* dydt) {
  update_active_kinematics(bodies, proximity, active, y, version);
  if (mode_key_of(bodies, active) != active.mode_key) {
    find_decoupled_contacts(bodies, proximity, active);
    active.mode_key = mode_key_of(bodies, active);
  }
  bool together = false;
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    if (contact.decoupled && !add_single_contact_forces(bodies, proximity, contact, dydt)) constraints.solvable = false;
    together = together || !contact.decoupled;
  }
  if (together) add_coupled_forces(bodies, proximity, active, constraints, dydt);
  for (Contact<S>& contact : active.contacts)
    if (contact.active) monitor_bounds(proximity, active, contact);
}

template <class S> void evaluate_rates(EventRun<S>& run, S t_s) {
  StateBuffers<S>& states = run.states;
  run.integration.free.rate(t_s, states.y.data(), states.dydt.data());
  if (run.active.count > 0)
    add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, states.y.data(), states.y.version,
                       states.dydt.data());
}

template <class S> void store_warm_start(ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts) {
    contact.warm_start_N = contact.normal_N;
    contact.warm_start_friction_N = contact.friction_N;
    contact.warm_start_couple_N_m = contact.couple_N_m;
  }
}

template <class S>
Vec3<S> relative_acceleration(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                              const S* dydt) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  const int feature = candidate.feature_body, surface = candidate.surface_body;
  const Pose<S>&of = bodies.poses[feature], &on = bodies.poses[surface];
  const Vec3<S>&x = contact.kinematics.x, &x_dot = contact.kinematics.x_dot;
  return linear_of(bodies, feature, dydt) + cross(angular_of(bodies, feature, dydt), x - of.p) +
         cross(of.w, x_dot - of.v) -
         (linear_of(bodies, surface, dydt) + cross(angular_of(bodies, surface, dydt), x - on.p) +
          cross(on.w, x_dot - on.v));
}

template <class S>
S normal_acceleration(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                      const S* dydt) {
  return dot(contact.kinematics.normal, relative_acceleration(bodies, proximity, contact, dydt)) +
         dot(contact.u, contact.kinematics.normal_dot);
}

template <class S>
Vec3<S> relative_angular_acceleration(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                                      const S* dydt) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  return angular_of(bodies, candidate.feature_body, dydt) - angular_of(bodies, candidate.surface_body, dydt);
}

#define ATWOOD_CONTACT_FORCES(S)                                                                                      \
  template void install_contact_forces<S>(EventRun<S>&);                                                              \
  template void add_contact_forces<S>(Bodies<S>&, const Proximity<S>&, ActiveSet<S>&, ConstraintSystem<S>&, const S*, \
                                      std::uint64_t, S*);                                                             \
  template void evaluate_rates<S>(EventRun<S>&, S);                                                                   \
  template void store_warm_start<S>(ActiveSet<S>&);                                                                   \
  template Vec3<S> relative_acceleration<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&, const S*);      \
  template S normal_acceleration<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&, const S*);              \
  template Vec3<S> relative_angular_acceleration<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&, const S*);
ATWOOD_CONTACT_FORCES(float)
ATWOOD_CONTACT_FORCES(double)
ATWOOD_CONTACT_FORCES(long double)
#undef ATWOOD_CONTACT_FORCES

}  // namespace atwood::event
