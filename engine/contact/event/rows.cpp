// Contacts as rows: conditions on their bodies' accelerations, each with the load that sees to it.
#include "contact/event/rows.hpp"

namespace atwood::event {

namespace {

// Duff et al., J. Comput. Graph. Tech. 6 (2017) 1: two unit vectors that make a right-handed frame with n, without a
// root.
template <class S> void tangents_of(const Vec3<S>& n, Vec3<S> (&t)[2]) {
  const S sign = n.z < S(0) ? S(-1) : S(1), a = S(-1) / (sign + n.z), b = n.x * n.y * a;
  t[0] = {S(1) + sign * n.x * n.x * a, sign * b, -sign * n.x};
  t[1] = {b, sign + n.y * n.y * a, -n.y};
}

// Along v's part across n. Its sign follows what was kept from the step's start, so that a trial step past the zero of
// v stays smooth; and next to that zero, where v's direction is round-off, what was kept stands in.
template <class S>
Vec3<S> direction_of(const Vec3<S>& v, const Vec3<S>& n, const Vec3<S>& kept, bool keep, S kept_speed, S round_off) {
  const Vec3<S> across = v - dot(v, n) * n;
  const S length = norm(across);
  if (keep || !(length > round_off && length > S(0x1p-13) * kept_speed)) {
    const Vec3<S> along = kept - dot(kept, n) * n;
    const S kept_length = norm(along);
    if (kept_length > S(0)) return (S(1) / kept_length) * along;
    Vec3<S> t[2];
    tangents_of(n, t);
    return t[0];
  }
  return (dot(across, kept) < S(0) ? S(-1) / length : S(1) / length) * across;
}

// R I_B^-1 R^T; where body axes are principal, the sum over them of axis axis^T / I.
template <class S> void turn_inertia(EventRun<S>& run, int body) {
  const MassProperties<S>& mass = run.model.mass(body);
  const Pose<S>& pose = run.poses[body];
  Vec3<S>(&row)[3] = run.inverse[body].I_row;
  if (!mass.diagonal) {  // symmetric, so columns are rows
    const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
    for (int i = 0; i < 3; ++i) row[i] = turned(pose, mass.times_inverse_inertia(turned_back(pose, axes[i])));
    return;
  }
  const Vec3<S>&a = pose.axis[0], &b = pose.axis[1], &c = pose.axis[2];
  const Vec3<S> A = mass.I_inverse_row[0].x * a, B = mass.I_inverse_row[1].y * b, C = mass.I_inverse_row[2].z * c;
  row[0] = A.x * a + B.x * b + C.x * c;
  row[1] = {row[0].y, A.y * a.y + B.y * b.y + C.y * c.y, A.y * a.z + B.y * b.z + C.y * c.z};
  row[2] = {row[0].z, row[1].z, A.z * a.z + B.z * b.z + C.z * c.z};
}

// What comes with 1 N along the normal: friction against the slip, the couple against rolling.
template <class S> void add_resistance(const EventRun<S>& run, Contact<S>& contact) {
  const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
  const Vec3<S>& n = contact.sight.normal;
  const S round_off = run.approach_round_off() / S(64);
  if (contact.mode == Mode::slips) {
    const bool keep = contact.waits || contact.sets_in;
    const Vec3<S> d = direction_of(contact.u, n, contact.slip_direction, keep, contact.slip_speed, round_off);
    contact.along_W = n - pair.friction * d;
  }
  if (contact.turning == Turning::rolls) {
    const Vec3<S> d =
        direction_of(contact.w, n, contact.roll_direction, false, contact.roll_speed, round_off / pair.reach);
    contact.along_couple_W = -pair.rolling_friction_m * d;
  }
}

// Forces and couple on the knob's body of a contact's unknowns.
template <class S> ATWOOD_INLINE void load_by(const Contact<S>& contact, const S* x, Vec3<S>& force, Vec3<S>& couple) {
  force = x[0] * contact.along_W;
  couple = x[0] * contact.along_couple_W;
  if (contact.force_rows == 3) force += x[1] * contact.tangent[0] + x[2] * contact.tangent[1];
  x += contact.force_rows;
  if (contact.couple_rows == 2) couple += x[0] * contact.tangent[0] + x[1] * contact.tangent[1];
}

// Of one row, what a unit of another's load does to it.
template <class S> S effect(const Row<S>& on, const Row<S>& of) {
  S sum{};
  for (int i = 0; i < 2; ++i) {
    if (on.body[i] < 0) continue;
    for (int j = 0; j < 2; ++j)
      if (on.body[i] == of.body[j]) sum += dot(on.row[i], of.answer[j]);
  }
  return sum;
}

// `force` or `couple` alone; the load is the same, or `load_force` and `load_couple`.
template <class S>
void put_row(const EventRun<S>& run, const Place<S>& place, const Vec3<S>& force, const Vec3<S>& couple,
             const Vec3<S>& load_force, const Vec3<S>& load_couple, Row<S>& row) {
  for (int side = 0; side < 2; ++side) {
    const int body = row.body[side] = place.body[side];
    if (body < 0) continue;
    const S sign = side == 0 ? S(1) : S(-1);
    row.row[side] = load_of(force, couple, place.arm[side], sign);
    row.answer[side] = answer_of(run.inverse[body], load_of(load_force, load_couple, place.arm[side], sign));
  }
}

template <class S> void put_rows(EventRun<S>& run, const Contact<S>& contact) {
  const Place<S>& place = contact.place;
  const Vec3<S> none{};
  Row<S>* row = run.rows.data() + contact.first_row;
  put_row(run, place, contact.sight.normal, none, contact.along_W, contact.along_couple_W, *row++);
  for (int i = 0; i + 1 < contact.force_rows; ++i)
    put_row(run, place, contact.tangent[i], none, contact.tangent[i], none, *row++);
  for (int i = 0; i < contact.couple_rows; ++i)
    put_row(run, place, none, contact.tangent[i], none, contact.tangent[i], *row++);
}

template <class S>
void make_room(EventRun<S>& run) {  // in the step in which contacts appear: enough for a few boxes at once
  if (run.unknown.size() >= static_cast<std::size_t>(run.row_count)) return;
  const auto size = static_cast<std::size_t>(std::max(run.row_count, 48));
  run.matrix.resize(size * size);
  for (auto* v : {&run.right, &run.unknown, &run.residual, &run.start, &run.weight, &run.diagonal}) v->resize(size);
  run.rows.resize(size);
  run.pivots.resize(size);
  run.block_ends.reserve(size);
}

}  // namespace

template <class S> void hold_inverses(EventRun<S>& run) {
  run.inverse.resize(static_cast<std::size_t>(run.model.body_count()));
  run.mobility.resize(run.inverse.size());
  for (int i = 0; i < run.model.body_count(); ++i) {
    const MassProperties<S>& mass = run.model.mass(i);
    const Vec3<S>(&I_inverse)[3] = mass.I_inverse_row;
    run.inverse[i].mass_per_kg = mass.inverse_mass_per_kg;
    run.mobility[i] =
        mass.inverse_mass_per_kg + run.reach[i] * run.reach[i] * (I_inverse[0].x + I_inverse[1].y + I_inverse[2].z);
    if (run.round[i]) turn_inertia(run, i);
  }
}

template <class S> void pose_contact_bodies(EventRun<S>& run, const S* y) {
  for (const int body : run.contact_bodies) {
    take_pose(run, body, y, run.poses[body]);
    if (run.moves[body] && run.model.rotates(body) && !run.round[body]) turn_inertia(run, body);
  }
}

template <class S> void see_contact(EventRun<S>& run, Contact<S>& contact) {
  const Feature<S>& feature = run.features[contact.feature];
  const int k = feature.knob_body, s = feature.surface_body;
  const Pose<S>&of = run.poses[k], &on = run.poses[s];
  watch(feature.knob, of, run.surfaces[feature.surface], contact.facet, on, contact.sight);
  Place<S>& place = contact.place;
  place.body[0] = run.moves[k] ? k : -1;
  place.body[1] = run.moves[s] ? s : -1;
  place.arm[0] = contact.sight.x - of.p;
  contact.u = feature.knob.radius == S(0) && !feature.knob.edge
                  ? contact.sight.x_dot
                  : of.v + cross(of.w, place.arm[0]);  // a corner is fixed in its body
  contact.w = of.w;
  if (place.body[1] < 0) return;
  place.arm[1] = contact.sight.x - on.p;
  contact.u -= on.v + cross(on.w, place.arm[1]);
  contact.w -= on.w;
}

template <class S> void see_contacts(EventRun<S>& run, const S* y) {
  pose_contact_bodies(run, y);
  for (Contact<S>& contact : run.contacts)
    if (contact.carries) see_contact(run, contact);
}

template <class S> void take_direction(const EventRun<S>& run, Contact<S>& contact, Rows what) {
  contact.along_W = contact.sight.normal;
  contact.along_couple_W = {};
  if (what == Rows::forces) add_resistance(run, contact);
}

template <class S> void list_unknowns(EventRun<S>& run, Rows what) {
  run.row_count = run.row_contacts = 0;
  for (Contact<S>& contact : run.contacts) {
    contact.first_row = -1;
    if (!contact.carries || (what == Rows::forces && contact.alone)) continue;
    take_direction(run, contact, what);
    contact.first_row = run.row_count;
    contact.force_rows = what != Rows::gaps && contact.mode == Mode::sticks ? 3 : 1;
    contact.couple_rows = what != Rows::gaps && contact.turning == Turning::held ? 2 : 0;
    if (contact.force_rows + contact.couple_rows > 1) tangents_of(contact.sight.normal, contact.tangent);
    run.row_count += contact.force_rows + contact.couple_rows;
    ++run.row_contacts;
  }
  make_room(run);
}

template <class S> void fill_matrix(EventRun<S>& run) {
  const int n = run.row_count;
  for (const Contact<S>& contact : run.contacts)
    if (contact.first_row >= 0) put_rows(run, contact);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) run.matrix[i * n + j] = effect(run.rows[i], run.rows[j]);
  for (int i = 0; i < n; ++i) run.diagonal[i] = real::abs(run.matrix[i * n + i]);
}

template <class S> void answer_unknowns(EventRun<S>& run) {
  for (const int body : run.contact_bodies) {
    run.acceleration[body] = {};
    run.loaded[body] = 0;
  }
  for (const Contact<S>& contact : run.contacts) {
    if (contact.first_row < 0) continue;
    const Place<S>& place = contact.place;
    Vec3<S> force, couple;
    load_by(contact, run.unknown.data() + contact.first_row, force, couple);
    for (int side = 0; side < 2; ++side) {
      if (place.body[side] < 0) continue;
      Twist<S>& load = run.acceleration[place.body[side]];
      const Twist<S> more = load_of(force, couple, place.arm[side], side == 0 ? S(1) : S(-1));
      load.linear += more.linear;
      load.angular += more.angular;
      run.loaded[place.body[side]] = 1;
    }
  }
  for (const int body : run.contact_bodies) {
    if (!run.loaded[body]) continue;
    const Twist<S> answer = answer_of(run.inverse[body], run.acceleration[body]), &free = run.free_acceleration[body];
    run.acceleration[body] = {free.linear + answer.linear, free.angular + answer.angular};
  }
  run.answered = true;
}

template <class S> void read_rows(const EventRun<S>& run, const Contact<S>& contact, S* values) {
  const Place<S>& place = contact.place;
  Vec3<S> a{}, alpha{};
  for (int side = 0; side < 2; ++side) {
    if (place.body[side] < 0) continue;
    const Twist<S>& of = run.acceleration[place.body[side]];
    const Vec3<S> at = of.linear + cross(of.angular, place.arm[side]);
    a = side == 0 ? at : a - at;
    alpha = side == 0 ? of.angular : alpha - of.angular;
  }
  project_rows(contact, a, alpha, values);
}

template <class S> void read_unknowns(const EventRun<S>& run, Contact<S>& contact) {
  const S* x = run.unknown.data() + contact.first_row;
  Vec3<S> force;
  load_by(contact, x, force, contact.couple_N_m);
  contact.normal_N = x[0];
  contact.friction_N = force - x[0] * contact.sight.normal;
}

template <class S>
Row<S> load_row(const EventRun<S>& run, const Contact<S>& contact, const Vec3<S>& force, const Vec3<S>& couple) {
  const Place<S> place = place_of(run, contact);
  Row<S> row;
  for (int side = 0; side < 2; ++side) {
    const int body = row.body[side] = place.body[side];
    if (body < 0) continue;
    const S sign = side == 0 ? S(1) : S(-1);
    row.row[side] = load_of(force, couple, place.arm[side], sign);
    row.answer[side].linear = run.inverse[body].mass_per_kg * row.row[side].linear;
    if (!run.model.rotates(body)) continue;
    const Pose<S>& pose = run.poses[body];
    row.answer[side].angular =
        turned(pose, run.model.mass(body).times_inverse_inertia(turned_back(pose, row.row[side].angular)));
  }
  return row;
}

template <class S>
S effect_of_load(const EventRun<S>& run, const Contact<S>& contact, const Vec3<S>& on, const Vec3<S>& on_couple,
                 const Vec3<S>& force, const Vec3<S>& couple) {
  return effect(load_row(run, contact, on, on_couple), load_row(run, contact, force, couple));
}

#define ATWOOD_ROWS(S)                                                                                                \
  template void hold_inverses<S>(EventRun<S>&);                                                                       \
  template void pose_contact_bodies<S>(EventRun<S>&, const S*);                                                       \
  template void see_contact<S>(EventRun<S>&, Contact<S>&);                                                            \
  template void see_contacts<S>(EventRun<S>&, const S*);                                                              \
  template void take_direction<S>(const EventRun<S>&, Contact<S>&, Rows);                                             \
  template void list_unknowns<S>(EventRun<S>&, Rows);                                                                 \
  template void fill_matrix<S>(EventRun<S>&);                                                                         \
  template void answer_unknowns<S>(EventRun<S>&);                                                                     \
  template void read_rows<S>(const EventRun<S>&, const Contact<S>&, S*);                                              \
  template void read_unknowns<S>(const EventRun<S>&, Contact<S>&);                                                    \
  template Row<S> load_row<S>(const EventRun<S>&, const Contact<S>&, const Vec3<S>&, const Vec3<S>&);                 \
  template S effect_of_load<S>(const EventRun<S>&, const Contact<S>&, const Vec3<S>&, const Vec3<S>&, const Vec3<S>&, \
                               const Vec3<S>&);
ATWOOD_ROWS(float)
ATWOOD_ROWS(double)
ATWOOD_ROWS(long double)
#undef ATWOOD_ROWS

}  // namespace atwood::event
