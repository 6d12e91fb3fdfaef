// Forces of lasting contacts, solved for at each evaluation of the rates.
//
// Knob k on surface s, n the normal from s to k, x the point, u = v_k + w_k x (x - p_k) - v_s - w_s x (x - p_s):
//   u'  = a_k + alpha_k x (x - p_k) + w_k x (x' - v_k)  -  the same of s,     x' the way of the geometric point
//   touching     (n . u)' = 0                     force  N n
//   sticking     (t . u)' = 0 for two t           force  T_1 t_1 + T_2 t_2
//   slipping                                      force  -mu N u_t / |u_t|
//   rolling                                       couple -delta N w_t / |w_t|
// Between switches of mode these are smooth in the state, so that a method keeps its order.
// Source: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), ch. 5.
#include <algorithm>

#include "contact/event/rows.hpp"

namespace atwood::event {

namespace {

// Bodies' accelerations in `dydt`, world axes.
template <class S> Vec3<S> linear_of(const EventRun<S>& run, int body, const S* dydt) {
  return run.moves[body] ? load3(dydt + run.model.offset(body) + kAtVelocity) : Vec3<S>{};
}
template <class S> Vec3<S> angular_of(const EventRun<S>& run, int body, const S* dydt) {
  if (!run.moves[body] || !run.model.rotates(body)) return {};
  return turned(run.poses[body], load3(dydt + run.model.offset(body) + kAtBodyRate));
}

// Is some force within a tenth of its bound, or of going?
template <class S> void note_bounds(EventRun<S>& run, Contact<S>& contact) {
  const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
  contact.largest_N = real::max(contact.largest_N, contact.normal_N);
  const auto near = [&](const Vec3<S>& load, S bound) { return !(dot(load, load) <= S(0.81) * bound * bound); };
  run.near_bound =
      run.near_bound || !(contact.normal_N >= S(0.1) * contact.largest_N) ||
      (contact.mode == Mode::sticks && near(contact.friction_N, pair.friction * contact.normal_N)) ||
      (contact.turning == Turning::held && near(contact.couple_N_m, pair.rolling_friction_m * contact.normal_N));
}

// Which of several knobs holds how much of the friction moves nothing as long as they all hold; but it tells when the
// first lets go. Shared in proportion to what presses on them, knobs under a pull through the middle of the pressure
// reach their cones as one.
template <class S> void share_by_pressure(EventRun<S>& run) {
  S pressed = S(0);
  int sticking = 0;
  bool near_edge = false;
  for (const Contact<S>& contact : run.contacts) {
    if (contact.first_row < 0 || contact.mode != Mode::sticks) continue;
    ++sticking;
    const S* force = &run.unknown[contact.first_row];
    const S bound = S(0.5) * run.pairs[run.features[contact.feature].pair].friction * force[0];
    pressed += force[0];
    near_edge = near_edge || !(force[1] * force[1] + force[2] * force[2] < bound * bound);
  }
  if (sticking < 2 || !near_edge || !(pressed > S(0))) return;  // far from their cones, any share will do
  fill_matrix(run);
  S yields = S(0);  // rows of contacts at different places yield differently: their weights make up for it
  for (int i = 0; i < run.row_count; ++i) yields = real::max(yields, run.diagonal[i]);
  const S mean = pressed / S(sticking);
  for (const Contact<S>& contact : run.contacts) {
    if (contact.first_row < 0 || contact.mode != Mode::sticks) continue;
    const S weight = mean / real::max(run.unknown[contact.first_row], S(0x1p-10) * mean);
    for (int i = contact.first_row + 1; i <= contact.first_row + 2; ++i) {
      run.weight[i] = weight * yields / run.diagonal[i];
      run.unknown[i] = S(0);
    }
  }
  solve_rows(run, true);
  run.has_factors = false;  // of these weights alone
}

// What is asked of the contact's rows, less what the bodies' accelerations make of them: (n . u)' = 0, (t . u)' = 0,
// (t . w)' = 0 for t that turn with n.
template <class S> void ask(EventRun<S>& run, const Contact<S>& contact) {
  const Sight<S>& sight = contact.sight;
  Vec3<S> b = -dot(contact.u, sight.normal_dot) * sight.normal, couple{};
  for (int side = 0; side < 2; ++side) {
    if (contact.place.body[side] < 0) continue;
    const Pose<S>& pose = run.poses[contact.place.body[side]];
    const Vec3<S> circling = cross(pose.w, sight.x_dot - pose.v);
    b = side == 0 ? b - circling : b + circling;
  }
  if (contact.couple_rows > 0) couple = dot(contact.w, sight.normal) * sight.normal_dot;
  project_rows(contact, b, couple, run.right.data() + contact.first_row);
}

// Contacts that carry, and how: of the same, rows are near to each other from one evaluation to the next.
template <class S> std::uint64_t modes_of(const EventRun<S>& run) {
  std::uint64_t key = 1;
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const auto feature = static_cast<std::uint64_t>(contact.feature);
    key = key * 0x9e3779b97f4a7c15u + feature * 16 + static_cast<std::uint64_t>(contact.mode) * 4 +
          static_cast<std::uint64_t>(contact.turning) + 0x100000000u * contact.alone;
  }
  return key;
}

template <class S> void find_alone(EventRun<S>& run) {
  const auto knob = [&](const Contact<S>& contact) { return run.features[contact.feature].knob_body; };
  const auto surface = [&](const Contact<S>& contact) { return run.features[contact.feature].surface_body; };
  for (const int body : run.contact_bodies) run.touches[body] = 0;
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    ++run.touches[knob(contact)];
    ++run.touches[surface(contact)];
  }
  const auto shared = [&](int body) { return run.moves[body] && run.touches[body] > 1; };
  for (Contact<S>& contact : run.contacts) {
    const bool forces =
        contact.turning == Turning::free || (contact.turning == Turning::rolls && contact.mode != Mode::sticks);
    contact.alone = forces && !shared(knob(contact)) && !shared(surface(contact));
    const Feature<S>& feature = run.features[contact.feature];
    const SurfaceKind kind = run.surfaces[feature.surface].kind;
    const auto ball = [&](int body) { return !run.model.rotates(body) || run.round[body]; };
    contact.of_balls =
        (!run.moves[knob(contact)] || (feature.knob.centered && !feature.knob.rim && ball(knob(contact)))) &&
        (!run.moves[surface(contact)] || (kind == SurfaceKind::point && ball(surface(contact))));
  }
}

// Where redundant unknowns start: what the solution does not decide stays as it is.
template <class S> void start_from_shares(EventRun<S>& run) {
  std::fill_n(run.weight.begin(), run.row_count, S(1));
  for (const Contact<S>& contact : run.contacts) {
    if (contact.first_row < 0) continue;
    S* x = run.unknown.data() + contact.first_row;
    project_rows(contact, contact.share_friction_N, contact.share_couple_N_m, x);
    x[0] = contact.share_N;
  }
  run.answered = false;
}

template <class S> void solve_contacts(EventRun<S>& run) {
  list_unknowns(run, Rows::forces);
  start_from_shares(run);
  for (const Contact<S>& contact : run.contacts)
    if (contact.first_row >= 0) ask(run, contact);
  if (run.row_contacts == 1) return solve_rows(run, false);
  solve_rows(run, true, run.modes == run.factors_of);
  run.factors_of = run.modes;
  share_by_pressure(run);
}

// Of several contacts: what their forces x make of the rows, A x = right - rows without them, along x, per 1 N of all
// normal forces. The first that slips keeps it.
template <class S> void note_yield_together(EventRun<S>& run) {
  Contact<S>* slips = nullptr;
  S along = S(0), normal = S(0), free_rows[5];
  run.acceleration.swap(run.free_acceleration);
  for (Contact<S>& contact : run.contacts) {
    if (contact.first_row < 0) continue;
    if (slips == nullptr && contact.mode == Mode::slips && !contact.waits) slips = &contact;
    const S* x = run.unknown.data() + contact.first_row;
    read_rows(run, contact, free_rows);
    for (int i = 0; i < contact.force_rows + contact.couple_rows; ++i)
      along += x[i] * (run.right[contact.first_row + i] - free_rows[i]);
    normal += x[0];
  }
  run.acceleration.swap(run.free_acceleration);
  if (slips != nullptr && normal > S(0)) note_yield(*slips, along / (normal * normal));
}

template <class S> void add_together(EventRun<S>& run, S* dydt) {
  for (const int body : run.contact_bodies)
    run.free_acceleration[body] = {linear_of(run, body, dydt), angular_of(run, body, dydt)};
  solve_contacts(run);
  if (!run.answered) answer_unknowns(run);
  for (Contact<S>& contact : run.contacts)
    if (contact.first_row >= 0) read_unknowns(run, contact);
  if (std::any_of(run.contacts.begin(), run.contacts.end(), [](const Contact<S>& c) { return c.mode == Mode::slips; }))
    note_yield_together(run);
  for (const int body : run.contact_bodies) {
    if (!run.moves[body] || !run.loaded[body]) continue;
    S* at = dydt + run.model.offset(body);
    store3(run.acceleration[body].linear, at + kAtVelocity);
    if (run.model.rotates(body)) store3(turned_back(run.poses[body], run.acceleration[body].angular), at + kAtBodyRate);
  }
}

template <class S> void rate_with_contacts(void* context, S t_s, const S* y, S* dydt) {
  EventRun<S>& run = *static_cast<EventRun<S>*>(context);
  ++run.wrapped_calls;
  run.free_rate_of(run.free_context, t_s, y, dydt);
  if (run.carrying > 0) contact_rates(run, t_s, y, dydt);
}
template <class S> void project_with_contacts(void* context, S* y) {
  const EventRun<S>& run = *static_cast<EventRun<S>*>(context);
  run.free_project_of(run.free_context, y);
}
template <class S> void projection_with_contacts(void* context, const S* y, S* change) {
  const EventRun<S>& run = *static_cast<EventRun<S>*>(context);
  run.free_projection_of(run.free_context, y, change);
}

}  // namespace

template <class S> void wrap_rates(EventRun<S>& run) {
  System<S>& system = run.model.system();
  run.free_context = system.context;
  run.free_rate_of = system.rate_of;
  run.free_project_of = system.project_of;
  run.free_projection_of = system.projection_of;
  system.context = &run;
  system.rate_of = &rate_with_contacts<S>;
  system.rates_of = nullptr;
  if (system.project_of != nullptr) system.project_of = &project_with_contacts<S>;
  if (system.projection_of != nullptr) system.projection_of = &projection_with_contacts<S>;
}

template <class S> void contact_rates(EventRun<S>& run, S, const S* y, S* dydt) {
  const bool seen = run.sights_at_start && y == run.y.data();
  run.sights_at_start = false;
  if (!seen) pose_contact_bodies(run, y);
  if (modes_of(run) != run.modes) {
    find_alone(run);
    run.modes = modes_of(run);
  }
  bool together = false;
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    if (!seen) see_contact(run, contact);
    if (contact.alone && !add_alone(run, contact, dydt)) run.solvable = false;
    together = together || !contact.alone;
  }
  if (together) add_together(run, dydt);
  for (Contact<S>& contact : run.contacts)
    if (contact.carries) note_bounds(run, contact);
}

template <class S> void keep_shares(EventRun<S>& run) {
  for (Contact<S>& contact : run.contacts) {
    contact.share_N = contact.normal_N;
    contact.share_friction_N = contact.friction_N;
    contact.share_couple_N_m = contact.couple_N_m;
  }
}

template <class S> Vec3<S> relative_acceleration(const EventRun<S>& run, const Contact<S>& contact, const S* dydt) {
  const Feature<S>& feature = run.features[contact.feature];
  const int k = feature.knob_body, s = feature.surface_body;
  const Pose<S>&of = run.poses[k], &on = run.poses[s];
  const Vec3<S>&x = contact.sight.x, &x_dot = contact.sight.x_dot;
  return linear_of(run, k, dydt) + cross(angular_of(run, k, dydt), x - of.p) + cross(of.w, x_dot - of.v) -
         (linear_of(run, s, dydt) + cross(angular_of(run, s, dydt), x - on.p) + cross(on.w, x_dot - on.v));
}

template <class S> S normal_acceleration(const EventRun<S>& run, const Contact<S>& contact, const S* dydt) {
  return dot(contact.sight.normal, relative_acceleration(run, contact, dydt)) +
         dot(contact.u, contact.sight.normal_dot);
}

template <class S> Vec3<S> relative_turning(const EventRun<S>& run, const Contact<S>& contact, const S* dydt) {
  const Feature<S>& feature = run.features[contact.feature];
  return angular_of(run, feature.knob_body, dydt) - angular_of(run, feature.surface_body, dydt);
}

#define ATWOOD_FORCES(S)                                                                      \
  template void wrap_rates<S>(EventRun<S>&);                                                  \
  template void contact_rates<S>(EventRun<S>&, S, const S*, S*);                              \
  template void keep_shares<S>(EventRun<S>&);                                                 \
  template Vec3<S> relative_acceleration<S>(const EventRun<S>&, const Contact<S>&, const S*); \
  template S normal_acceleration<S>(const EventRun<S>&, const Contact<S>&, const S*);         \
  template Vec3<S> relative_turning<S>(const EventRun<S>&, const Contact<S>&, const S*);
ATWOOD_FORCES(float)
ATWOOD_FORCES(double)
ATWOOD_FORCES(long double)
#undef ATWOOD_FORCES

}  // namespace atwood::event
