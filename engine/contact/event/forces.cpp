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

#include "contact/event/run.hpp"
#include "math/so3.hpp"

namespace atwood::event {

namespace {

template <class S> Vec3<S> any_tangent(const Vec3<S>& n) {
  const Vec3<S> axis = real::abs(n.x) < S(0.6) ? Vec3<S>{S(1), S(0), S(0)} : Vec3<S>{S(0), S(1), S(0)};
  const Vec3<S> t = axis - dot(axis, n) * n;
  return (S(1) / norm(t)) * t;
}

// Along v's part across n. Its sign follows what was kept from the step's start, so that a trial step past the zero of v stays
// smooth; and next to that zero, where v's direction is round-off, what was kept stands in.
template <class S> Vec3<S> direction_of(const Vec3<S>& v, const Vec3<S>& n, const Vec3<S>& kept, bool keep, S kept_speed, S round_off) {
  const Vec3<S> across = v - dot(v, n) * n;
  const S length = norm(across);
  if (keep || !(length > round_off && length > S(0x1p-13) * kept_speed)) {
    const Vec3<S> along = kept - dot(kept, n) * n;
    const S kept_length = norm(along);
    return kept_length > S(0) ? (S(1) / kept_length) * along : any_tangent(n);
  }
  return (dot(across, kept) < S(0) ? S(-1) / length : S(1) / length) * across;
}

template <class S> const MassProperties<S>& mass_of(const EventRun<S>& run, int body) { return run.model.mass(body); }

template <class S> Vec3<S> angular_acceleration(const EventRun<S>& run, int body, const Vec3<S>& torque_W) {
  if (!run.moves[body] || !run.model.rotates(body)) return {};
  const MassProperties<S>& mass = mass_of(run, body);
  if (run.round[body]) return mass.I_inverse_row[0].x * torque_W;
  const Pose<S>& pose = run.poses[body];
  return turned(pose, mass.times_inverse_inertia(turned_back(pose, torque_W)));
}

template <class S> void finish_row(const EventRun<S>& run, Row<S>& row) {
  row.a_k = row.a_s = {};
  if (run.moves[row.knob_body]) row.a_k = mass_of(run, row.knob_body).inverse_mass_per_kg * row.column.linear;
  if (run.moves[row.surface_body]) row.a_s = -mass_of(run, row.surface_body).inverse_mass_per_kg * row.column.linear;
  row.alpha_k = angular_acceleration(run, row.knob_body, row.column.angular_k);
  row.alpha_s = -angular_acceleration(run, row.surface_body, row.column.angular_s);
}

template <class S> Wrench<S> force_along(const Vec3<S>& d, const Vec3<S>& r_k, const Vec3<S>& r_s) {
  return {d, cross(r_k, d), cross(r_s, d)};
}

// Of one row, what unit loads of another's column do to it.
template <class S> S effect(const Row<S>& on, const Row<S>& of) {
  const auto along = [&](const Vec3<S>& a, const Vec3<S>& alpha, bool on_knob) {
    return on_knob ? dot(on.row.linear, a) + dot(on.row.angular_k, alpha) : -(dot(on.row.linear, a) + dot(on.row.angular_s, alpha));
  };
  S sum{};
  if (of.knob_body == on.knob_body) sum += along(of.a_k, of.alpha_k, true);
  else if (of.knob_body == on.surface_body) sum += along(of.a_k, of.alpha_k, false);
  if (of.surface_body == on.surface_body) sum += along(of.a_s, of.alpha_s, false);
  else if (of.surface_body == on.knob_body) sum += along(of.a_s, of.alpha_s, true);
  return sum;
}

template <class S> void see_contact(EventRun<S>& run, Contact<S>& contact) {
  const Feature<S>& feature = run.features[contact.feature];
  const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
  contact.sight = watch(feature.knob, of, run.surfaces[feature.surface], contact.facet, on);
  const Vec3<S>& x = contact.sight.x;
  contact.u = (of.v + cross(of.w, x - of.p)) - (on.v + cross(on.w, x - on.p));
  contact.w = of.w - on.w;
}

// Rows of a carrying contact, as many as it has unknowns. `plain`: columns are rows (projections), else with slip's friction.
template <class S> void add_rows(EventRun<S>& run, int index, bool plain) {
  Contact<S>& contact = run.contacts[index];
  const Feature<S>& feature = run.features[contact.feature];
  const ShapePair<S>& pair = run.pairs[feature.pair];
  const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
  const Vec3<S>&n = contact.sight.normal, r_k = contact.sight.x - of.p, r_s = contact.sight.x - on.p;
  contact.first_row = static_cast<int>(run.rows.size());
  const auto start = [&](const Wrench<S>& wrench) {
    Row<S> row;
    row.contact = index;
    row.knob_body = feature.knob_body;
    row.surface_body = feature.surface_body;
    row.row = row.column = wrench;
    return row;
  };
  Row<S> row = start(force_along(n, r_k, r_s));
  if (!plain && contact.mode == Mode::slips) {
    const Vec3<S> d = direction_of(contact.u, n, contact.slip_direction, contact.waits || contact.sets_in, contact.slip_speed, run.approach_round_off() / S(64));
    contact.friction_N = -pair.friction * d;  // for 1 N
    row.column = force_along(n - pair.friction * d, r_k, r_s);
  }
  if (!plain && contact.turning == Turning::rolls) {
    const Vec3<S> d = direction_of(contact.w, n, contact.roll_direction, false, contact.roll_speed, run.approach_round_off() / S(64) / pair.reach);
    contact.couple_N_m = -pair.rolling_friction_m * d;
    row.column.angular_k += contact.couple_N_m;
    row.column.angular_s += contact.couple_N_m;
  }
  finish_row(run, row);
  run.rows.push_back(row);
  if (contact.mode != Mode::sticks && contact.turning != Turning::held) return;
  const Vec3<S> t1 = any_tangent(n), tangents[2] = {t1, cross(n, t1)};
  for (int i = 0; contact.mode == Mode::sticks && i < 2; ++i) {
    row = start(force_along(tangents[i], r_k, r_s));
    finish_row(run, row);
    run.rows.push_back(row);
  }
  for (int i = 0; contact.turning == Turning::held && i < 2; ++i) {
    row = start(Wrench<S>{{}, tangents[i], tangents[i]});
    finish_row(run, row);
    run.rows.push_back(row);
  }
}

template <class S> bool share_a_moving_body(const EventRun<S>& run, const Row<S>& a, const Row<S>& b) {
  const auto holds = [&](int body) { return run.moves[body] && (body == b.knob_body || body == b.surface_body); };
  return holds(a.knob_body) || holds(a.surface_body);
}

template <class S> void fill_matrix(EventRun<S>& run) {
  const int n = static_cast<int>(run.rows.size());
  const auto size = static_cast<std::size_t>(n);
  if (run.matrix.size() < size * size) {  // grows with the number of contacts, in the step in which they appear
    run.matrix.resize(size * size);
    run.factors.reserve(size * size);
    for (auto* v : {&run.right, &run.unknown, &run.residual, &run.weight}) v->resize(size);
    run.pivots.resize(size);
  }
  for (int i = 0; i < n; ++i) {
    run.weight[i] = S(1);
    for (int j = 0; j < n; ++j)
      run.matrix[i * n + j] = share_a_moving_body(run, run.rows[i], run.rows[j]) ? effect(run.rows[i], run.rows[j]) : S(0);
  }
}

template <class S> void pose_contact_bodies(EventRun<S>& run, const S* y) {
  for (const int body : run.contact_bodies) run.poses[body] = pose_of(run, body, y);
}

// Bodies' accelerations in `dydt`, world axes.
template <class S> Vec3<S> linear_of(const EventRun<S>& run, int body, const S* dydt) {
  return run.moves[body] ? load3(dydt + run.model.offset(body) + at_velocity) : Vec3<S>{};
}
template <class S> Vec3<S> angular_of(const EventRun<S>& run, int body, const S* dydt) {
  if (!run.moves[body] || !run.model.rotates(body)) return {};
  return turned(run.poses[body], load3(dydt + run.model.offset(body) + at_body_rate));
}

template <class S> void add_load(const EventRun<S>& run, int body, const Vec3<S>& a, const Vec3<S>& alpha, S factor, S* dydt) {
  if (!run.moves[body]) return;
  S* at = dydt + run.model.offset(body);
  store3(load3(at + at_velocity) + factor * a, at + at_velocity);
  if (run.model.rotates(body)) store3(load3(at + at_body_rate) + factor * turned_back(run.poses[body], alpha), at + at_body_rate);
}

// What the unknowns are as forces, and how near their bounds.
template <class S> void read_forces(EventRun<S>& run, Contact<S>& contact) {
  const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
  int row = contact.first_row;
  contact.normal_N = run.unknown[row++];
  contact.largest_N = real::max(contact.largest_N, contact.normal_N);
  S margin = contact.largest_N > S(0) ? contact.normal_N / contact.largest_N : S(0);
  if (contact.mode == Mode::slips) contact.friction_N = contact.normal_N * contact.friction_N;
  if (contact.turning == Turning::rolls) contact.couple_N_m = contact.normal_N * contact.couple_N_m;
  if (contact.mode == Mode::sticks) {
    contact.friction_N = run.unknown[row] * run.rows[row].row.linear + run.unknown[row + 1] * run.rows[row + 1].row.linear;
    row += 2;
    const S bound = pair.friction * contact.normal_N;
    margin = real::min(margin, bound > S(0) ? S(1) - norm(contact.friction_N) / bound : S(0));
  }
  if (contact.turning == Turning::held) {
    contact.couple_N_m = run.unknown[row] * run.rows[row].row.angular_k + run.unknown[row + 1] * run.rows[row + 1].row.angular_k;
    const S bound = pair.rolling_friction_m * contact.normal_N;
    margin = real::min(margin, bound > S(0) ? S(1) - norm(contact.couple_N_m) / bound : S(0));
  }
  run.least_margin = real::min(run.least_margin, margin);
}

// Which of several knobs holds how much of the friction moves nothing as long as they all hold; but it tells when the first lets go.
// Shared in proportion to what presses on them, knobs under a pull through the middle of the pressure reach their cones as one.
template <class S> void share_by_pressure(EventRun<S>& run, int n) {
  S pressed = S(0);
  int sticking = 0;
  bool near_edge = false;
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries || contact.mode != Mode::sticks) continue;
    ++sticking;
    const S *force = &run.unknown[contact.first_row], bound = S(0.5) * run.pairs[run.features[contact.feature].pair].friction * force[0];
    pressed += force[0];
    near_edge = near_edge || !(force[1] * force[1] + force[2] * force[2] < bound * bound);
  }
  if (sticking < 2 || !near_edge || !(pressed > S(0))) return;  // far from their cones, any share will do
  const S mean = pressed / S(sticking);
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries || contact.mode != Mode::sticks) continue;
    const S weight = mean / real::max(run.unknown[contact.first_row], S(0x1p-10) * mean);
    for (int i = 1; i <= 2; ++i) {
      run.weight[contact.first_row + i] = weight;
      run.unknown[contact.first_row + i] = S(0);
    }
  }
  solve_rows(run, n, true);
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
  pose_contact_bodies(run, y);
  run.rows.clear();
  const int count = static_cast<int>(run.contacts.size());
  for (int i = 0; i < count; ++i) {
    if (!run.contacts[i].carries) continue;
    see_contact(run, run.contacts[i]);
    add_rows(run, i, false);
  }
  fill_matrix(run);
  const int n = static_cast<int>(run.rows.size());
  for (int i = 0; i < n; ++i) {
    const Row<S>& row = run.rows[i];
    const Contact<S>& contact = run.contacts[row.contact];
    const bool couple = i > contact.first_row + (contact.mode == Mode::sticks ? 2 : 0);
    S asked = S(0);
    if (couple) {
      asked = dot(contact.w, contact.sight.normal) * dot(row.row.angular_k, contact.sight.normal_dot) -
              dot(row.row.angular_k, angular_of(run, row.knob_body, dydt) - angular_of(run, row.surface_body, dydt));
    } else {
      asked = -dot(row.row.linear, relative_acceleration(run, contact, dydt));
      if (i == contact.first_row) asked -= dot(contact.u, contact.sight.normal_dot);
    }
    run.right[i] = asked;
  }
  std::fill(run.unknown.begin(), run.unknown.begin() + n, S(0));
  for (const Contact<S>& contact : run.contacts)
    if (contact.carries) run.unknown[contact.first_row] = contact.share_N;
  solve_rows(run, n, run.carrying > 1);
  if (run.carrying > 1) share_by_pressure(run, n);
  for (Contact<S>& contact : run.contacts)
    if (contact.carries) read_forces(run, contact);
  for (int i = 0; i < n; ++i) {
    const Row<S>& row = run.rows[i];
    add_load(run, row.knob_body, row.a_k, row.alpha_k, run.unknown[i], dydt);
    add_load(run, row.surface_body, row.a_s, row.alpha_s, run.unknown[i], dydt);
  }
}

template <class S> Row<S> load_row(const EventRun<S>& run, const Contact<S>& contact, const Vec3<S>& force, const Vec3<S>& couple) {
  const Feature<S>& feature = run.features[contact.feature];
  Row<S> row;
  row.knob_body = feature.knob_body;
  row.surface_body = feature.surface_body;
  row.column = force_along(force, contact.sight.x - run.poses[row.knob_body].p, contact.sight.x - run.poses[row.surface_body].p);
  row.column.angular_k += couple;
  row.column.angular_s += couple;
  finish_row(run, row);
  return row;
}

template <class S>
S effect_of_load(const EventRun<S>& run, const Contact<S>& contact, const Vec3<S>& on, const Vec3<S>& on_couple, const Vec3<S>& force,
                 const Vec3<S>& couple) {
  const Row<S> load = load_row(run, contact, force, couple);
  Row<S> seen = load_row(run, contact, on, on_couple);
  seen.row = seen.column;
  return effect(seen, load);
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
  return dot(contact.sight.normal, relative_acceleration(run, contact, dydt)) + dot(contact.u, contact.sight.normal_dot);
}

namespace {

// Moves and turns a body by its part of a row times `factor`.
template <class S> void displace(const EventRun<S>& run, int body, const Vec3<S>& by, const Vec3<S>& turn_W, S factor, S* y) {
  if (!run.moves[body]) return;
  S* at = y + run.model.offset(body);
  store3(load3(at + at_position) + factor * by, at + at_position);
  if (!run.model.rotates(body)) return;
  const Quat<S> q = normalised(so3_exp(factor * turn_W) * load4(at + at_attitude));
  if (turn_W.x != S(0) || turn_W.y != S(0) || turn_W.z != S(0)) store4(q, at + at_attitude);
}

// Solves rows . (change) = right, and applies it to positions or velocities.
template <class S> void spread(EventRun<S>& run, bool positions, S* y) {
  const int n = static_cast<int>(run.rows.size());
  std::fill(run.unknown.begin(), run.unknown.begin() + n, S(0));
  solve_rows(run, n, run.carrying > 1);
  for (int i = 0; i < n; ++i) {
    const Row<S>& row = run.rows[i];
    if (positions) {
      displace(run, row.knob_body, row.a_k, row.alpha_k, run.unknown[i], y);
      displace(run, row.surface_body, row.a_s, row.alpha_s, run.unknown[i], y);
    } else {
      add_load(run, row.knob_body, row.a_k, row.alpha_k, run.unknown[i], y);  // velocities stand where their rates do
      add_load(run, row.surface_body, row.a_s, row.alpha_s, run.unknown[i], y);
    }
  }
}

}  // namespace

template <class S> void project_contacts(EventRun<S>& run, S* y) {
  if (run.carrying == 0) return;
  const S near_enough = run.gap_round_off() / S(32);
  for (int turn = 0; turn < 2; ++turn) {
    pose_contact_bodies(run, y);
    S worst = S(0);
    for (Contact<S>& contact : run.contacts) {
      if (!contact.carries) continue;
      see_contact(run, contact);
      worst = real::max(worst, real::abs(contact.sight.gap - contact.rest_gap));
    }
    if (worst <= near_enough) break;
    run.rows.clear();
    for (int i = 0; i < static_cast<int>(run.contacts.size()); ++i) {
      Contact<S>& contact = run.contacts[i];
      if (!contact.carries) continue;
      const Mode mode = contact.mode;
      const Turning turning = contact.turning;
      contact.mode = Mode::smooth;
      contact.turning = Turning::free;
      add_rows(run, i, true);
      contact.mode = mode;
      contact.turning = turning;
    }
    fill_matrix(run);
    for (std::size_t i = 0; i < run.rows.size(); ++i) {
      const Contact<S>& contact = run.contacts[run.rows[i].contact];
      run.right[i] = contact.rest_gap - contact.sight.gap;
    }
    spread(run, true, y);
  }
  S worst = S(0), size = S(0);
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const Feature<S>& feature = run.features[contact.feature];
    const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
    const S normal = dot(contact.u, contact.sight.normal);
    worst = real::max(worst, contact.mode == Mode::sticks ? norm(contact.u) : real::abs(normal));
    if (contact.turning == Turning::held) worst = real::max(worst, norm(contact.w - dot(contact.w, contact.sight.normal) * contact.sight.normal));
    size = real::max(size, norm(of.v) + norm(on.v) + norm(of.w) + norm(on.w));
  }
  if (worst <= S(2) * real::epsilon<S>() * size) return;
  run.rows.clear();
  for (int i = 0; i < static_cast<int>(run.contacts.size()); ++i)
    if (run.contacts[i].carries) add_rows(run, i, true);
  fill_matrix(run);
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const Row<S>& row = run.rows[i];
    const Contact<S>& contact = run.contacts[row.contact];
    const bool couple = static_cast<int>(i) > contact.first_row + (contact.mode == Mode::sticks ? 2 : 0);
    run.right[i] = couple ? -dot(row.row.angular_k, contact.w) : -dot(row.row.linear, contact.u);
  }
  spread(run, false, y);
}

#define ATWOOD_FORCES(S)                                                                               \
  template void wrap_rates<S>(EventRun<S>&);                                                           \
  template void contact_rates<S>(EventRun<S>&, S, const S*, S*);                                       \
  template Vec3<S> relative_acceleration<S>(const EventRun<S>&, const Contact<S>&, const S*);          \
  template Row<S> load_row<S>(const EventRun<S>&, const Contact<S>&, const Vec3<S>&, const Vec3<S>&);  \
  template S effect_of_load<S>(const EventRun<S>&, const Contact<S>&, const Vec3<S>&, const Vec3<S>&, const Vec3<S>&, const Vec3<S>&); \
  template S normal_acceleration<S>(const EventRun<S>&, const Contact<S>&, const S*);                  \
  template void project_contacts<S>(EventRun<S>&, S*);
ATWOOD_FORCES(float)
ATWOOD_FORCES(double)
ATWOOD_FORCES(long double)
#undef ATWOOD_FORCES

}  // namespace atwood::event
