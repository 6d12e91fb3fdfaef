// Rows of the contact constraints, and the bodies' response to their unknowns.

#include "contact/event/constraints.hpp"

namespace atwood::event {

namespace {

// Two unit vectors that make a right-handed frame with n, without a square root; Duff et al., J. Comput. Graph. Tech. 6
// (2017) 1.
template <class S> void tangents_of(const Vec3<S>& n, Vec3<S> (&t)[2]) {
  const S sign = n.z < S(0) ? S(-1) : S(1), a = S(-1) / (sign + n.z), b = n.x * n.y * a;
  t[0] = {S(1) + sign * n.x * n.x * a, sign * b, -sign * n.x};
  t[1] = {b, sign + n.y * n.y * a, -n.y};
}

// The unit vector along v's part across n. Its sign follows `kept`, the direction at the step's start, so that a trial
// step beyond the zero of v stays smooth; near that zero, where v's direction is round-off, `kept` takes its place.
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

// I^-1 = R I_B^-1 R^T; where body axes are principal, the sum of axis axis^T / I over them.
template <class S> void rotate_inverse_inertia(Bodies<S>& bodies, int body) {
  const MassProperties<S>& mass = bodies.model.mass(body);
  const Pose<S>& pose = bodies.poses[body];
  Vec3<S>(&row)[3] = bodies.inverse_inertia[body].I_row;
  if (!mass.diagonal) {  // symmetric, so columns are rows
    const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
    for (int i = 0; i < 3; ++i) row[i] = to_world(pose, mass.times_inverse_inertia(to_body(pose, axes[i])));
    return;
  }
  const Vec3<S>&a = pose.axis[0], &b = pose.axis[1], &c = pose.axis[2];
  const Vec3<S> A = mass.I_inverse_row[0].x * a, B = mass.I_inverse_row[1].y * b, C = mass.I_inverse_row[2].z * c;
  row[0] = A.x * a + B.x * b + C.x * c;
  row[1] = {row[0].y, A.y * a.y + B.y * b.y + C.y * c.y, A.y * a.z + B.y * b.z + C.y * c.z};
  row[2] = {row[0].z, row[1].z, A.z * a.z + B.z * b.z + C.z * c.z};
}

// Adds to the unit load: friction against the slip, the couple against rolling.
template <class S>
void add_friction_of_motion(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact) {
  const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
  const Vec3<S>& n = contact.kinematics.normal;
  const S round_off = bodies.approach_round_off() / S(64);
  if (contact.mode == FrictionMode::slip) {
    const bool keep = contact.at_cone_limit || contact.slip_onset;
    const Vec3<S> d = direction_of(contact.u, n, contact.slip_direction, keep, contact.slip_speed, round_off);
    contact.unit_force_W = n - pair.friction * d;
  }
  if (contact.rolling == RollingMode::roll) {
    const Vec3<S> d =
        direction_of(contact.w, n, contact.roll_direction, false, contact.roll_speed, round_off / pair.bounding_radii);
    contact.unit_couple_W = -pair.rolling_friction_m * d;
  }
}

// Force and couple on the feature's body of a contact's unknowns.
template <class S>
ATWOOD_INLINE void load_of_unknowns(const Contact<S>& contact, const S* x, Vec3<S>& force, Vec3<S>& couple) {
  force = x[0] * contact.unit_force_W;
  couple = x[0] * contact.unit_couple_W;
  if (contact.force_rows == 3) force += x[1] * contact.tangent[0] + x[2] * contact.tangent[1];
  x += contact.force_rows;
  if (contact.couple_rows == 2) couple += x[0] * contact.tangent[0] + x[1] * contact.tangent[1];
}

// J_on M^-1 J_of^T.
template <class S> S delassus_entry(const ConstraintRow<S>& on, const ConstraintRow<S>& of) {
  S sum{};
  for (int i = 0; i < 2; ++i) {
    if (on.body[i] < 0) continue;
    for (int j = 0; j < 2; ++j)
      if (on.body[i] == of.body[j]) sum += dot(on.jacobian[i], of.response[j]);
  }
  return sum;
}

// A row along `force` or `couple`, whose unknown is a load along load_force and load_couple.
template <class S>
void assemble_row(const Bodies<S>& bodies, const LeverArms<S>& levers, const Vec3<S>& force, const Vec3<S>& couple,
                  const Vec3<S>& load_force, const Vec3<S>& load_couple, ConstraintRow<S>& row) {
  for (int side = 0; side < 2; ++side) {
    const int body = row.body[side] = levers.body[side];
    if (body < 0) continue;
    const S sign = side == 0 ? S(1) : S(-1);
    row.jacobian[side] = wrench_of(force, couple, levers.arm[side], sign);
    row.response[side] =
        acceleration_under(bodies.inverse_inertia[body], wrench_of(load_force, load_couple, levers.arm[side], sign));
  }
}

template <class S>
void assemble_rows(const Bodies<S>& bodies, ConstraintSystem<S>& constraints, const Contact<S>& contact) {
  const LeverArms<S>& levers = contact.levers;
  const Vec3<S> none{};
  ConstraintRow<S>* row = constraints.rows.data() + contact.first_row;
  assemble_row(bodies, levers, contact.kinematics.normal, none, contact.unit_force_W, contact.unit_couple_W, *row++);
  for (int i = 0; i + 1 < contact.force_rows; ++i)
    assemble_row(bodies, levers, contact.tangent[i], none, contact.tangent[i], none, *row++);
  for (int i = 0; i < contact.couple_rows; ++i)
    assemble_row(bodies, levers, none, contact.tangent[i], none, contact.tangent[i], *row++);
}

// The first time: enough for a few boxes, so that later steps rarely allocate.
template <class S> void reserve_rows(ConstraintSystem<S>& constraints) {
  if (constraints.unknown.size() >= static_cast<std::size_t>(constraints.row_count)) return;
  const auto size = static_cast<std::size_t>(std::max(constraints.row_count, 48));
  constraints.matrix.resize(size * size);
  for (auto* v : {&constraints.right, &constraints.unknown, &constraints.residual, &constraints.start,
                  &constraints.right_round_off, &constraints.weight, &constraints.diagonal})
    v->resize(size);
  constraints.rows.resize(size);
  constraints.pivots.resize(size);
  constraints.block_ends.reserve(size);
}

}  // namespace

template <class S>
LeverArms<S> levers_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  const int feature = candidate.feature_body, surface = candidate.surface_body;
  return {{bodies.moves[feature] ? feature : -1, bodies.moves[surface] ? surface : -1},
          {contact.kinematics.x - bodies.poses[feature].p, contact.kinematics.x - bodies.poses[surface].p}};
}

template <class S> void initialize_inverse_inertia(Bodies<S>& bodies) {
  bodies.inverse_inertia.resize(static_cast<std::size_t>(bodies.model.body_count()));
  bodies.largest_inverse_mass.resize(bodies.inverse_inertia.size());
  for (int i = 0; i < bodies.model.body_count(); ++i) {
    const MassProperties<S>& mass = bodies.model.mass(i);
    const Vec3<S>(&I_inverse)[3] = mass.I_inverse_row;
    bodies.inverse_inertia[i].inverse_mass_per_kg = mass.inverse_mass_per_kg;
    bodies.largest_inverse_mass[i] = mass.inverse_mass_per_kg + bodies.bounding_radius[i] * bodies.bounding_radius[i] *
                                                                    (I_inverse[0].x + I_inverse[1].y + I_inverse[2].z);
    if (bodies.isotropic[i]) rotate_inverse_inertia(bodies, i);
  }
}

template <class S> void update_contact_body_poses(Bodies<S>& bodies, const ActiveSet<S>& active, const S* y) {
  for (const int body : active.bodies) {
    update_pose(bodies, body, y, bodies.poses[body]);
    if (bodies.moves[body] && bodies.model.rotates(body) && !bodies.isotropic[body])
      rotate_inverse_inertia(bodies, body);
  }
}

template <class S> void update_kinematics(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  const int feature = candidate.feature_body, surface = candidate.surface_body;
  const Pose<S>&of = bodies.poses[feature], &on = bodies.poses[surface];
  gap_kinematics_with_rates(candidate.feature, of, proximity.surfaces[candidate.surface], contact.facet, on,
                            contact.kinematics);
  LeverArms<S>& levers = contact.levers;
  levers.body[0] = bodies.moves[feature] ? feature : -1;
  levers.body[1] = bodies.moves[surface] ? surface : -1;
  levers.arm[0] = contact.kinematics.x - of.p;
  contact.u = candidate.feature.radius == S(0) && !candidate.feature.edge
                  ? contact.kinematics.x_dot
                  : of.v + cross(of.w, levers.arm[0]);  // a vertex is fixed in its body
  contact.w = of.w;
  if (levers.body[1] < 0) return;
  levers.arm[1] = contact.kinematics.x - on.p;
  contact.u -= on.v + cross(on.w, levers.arm[1]);
  contact.w -= on.w;
}

template <class S>
void update_active_kinematics(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active, const S* y,
                              std::uint64_t version) {
  if (version == 0 || bodies.poses_version != version) {
    update_contact_body_poses(bodies, active, y);
    bodies.poses_version = version;
  }
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active || (version != 0 && contact.kinematics_version == version)) continue;
    update_kinematics(bodies, proximity, contact);
    contact.kinematics_version = version;
  }
}

template <class S>
void update_unit_load(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact,
                      ConstraintLevel level) {
  contact.unit_force_W = contact.kinematics.normal;
  contact.unit_couple_W = {};
  if (level == ConstraintLevel::acceleration) add_friction_of_motion(bodies, proximity, contact);
}

template <class S>
void assign_rows(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                 ConstraintSystem<S>& constraints, ConstraintLevel level) {
  constraints.row_count = constraints.row_contacts = 0;
  for (Contact<S>& contact : active.contacts) {
    contact.first_row = -1;
    if (!contact.active || (level == ConstraintLevel::acceleration && contact.decoupled)) continue;
    update_unit_load(bodies, proximity, contact, level);
    contact.first_row = constraints.row_count;
    contact.force_rows = level != ConstraintLevel::position && contact.mode == FrictionMode::stick ? 3 : 1;
    contact.couple_rows = level != ConstraintLevel::position && contact.rolling == RollingMode::stick ? 2 : 0;
    if (contact.force_rows + contact.couple_rows > 1) tangents_of(contact.kinematics.normal, contact.tangent);
    constraints.row_count += contact.force_rows + contact.couple_rows;
    ++constraints.row_contacts;
  }
  reserve_rows(constraints);
}

template <class S>
void assemble_delassus(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  const int n = constraints.row_count;
  for (const Contact<S>& contact : active.contacts)
    if (contact.first_row >= 0) assemble_rows(bodies, constraints, contact);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      constraints.matrix[i * n + j] = delassus_entry(constraints.rows[i], constraints.rows[j]);
  for (int i = 0; i < n; ++i) constraints.diagonal[i] = real::abs(constraints.matrix[i * n + i]);
}

template <class S>
void apply_unknowns(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  for (const int body : active.bodies) {
    constraints.acceleration[body] = {};
    constraints.loaded[body] = 0;
  }
  for (const Contact<S>& contact : active.contacts) {
    if (contact.first_row < 0) continue;
    const LeverArms<S>& levers = contact.levers;
    Vec3<S> force, couple;
    load_of_unknowns(contact, constraints.unknown.data() + contact.first_row, force, couple);
    for (int side = 0; side < 2; ++side) {
      if (levers.body[side] < 0) continue;
      SpatialVector<S>& load = constraints.acceleration[levers.body[side]];
      const SpatialVector<S> more = wrench_of(force, couple, levers.arm[side], side == 0 ? S(1) : S(-1));
      load.linear += more.linear;
      load.angular += more.angular;
      constraints.loaded[levers.body[side]] = 1;
    }
  }
  for (const int body : active.bodies) {
    if (!constraints.loaded[body]) continue;
    const SpatialVector<S> answer = acceleration_under(bodies.inverse_inertia[body], constraints.acceleration[body]),
                           &free = constraints.free_acceleration[body];
    constraints.acceleration[body] = {free.linear + answer.linear, free.angular + answer.angular};
  }
}

template <class S> void row_values(const ConstraintSystem<S>& constraints, const Contact<S>& contact, S* values) {
  const LeverArms<S>& levers = contact.levers;
  Vec3<S> a{}, alpha{};
  for (int side = 0; side < 2; ++side) {
    if (levers.body[side] < 0) continue;
    const SpatialVector<S>& of = constraints.acceleration[levers.body[side]];
    const Vec3<S> at = of.linear + cross(of.angular, levers.arm[side]);
    a = side == 0 ? at : a - at;
    alpha = side == 0 ? of.angular : alpha - of.angular;
  }
  project_rows(contact, a, alpha, values);
}

template <class S> void store_forces(const ConstraintSystem<S>& constraints, Contact<S>& contact) {
  const S* x = constraints.unknown.data() + contact.first_row;
  Vec3<S> force;
  load_of_unknowns(contact, x, force, contact.couple_N_m);
  contact.normal_N = x[0];
  contact.friction_N = force - x[0] * contact.kinematics.normal;
}

template <class S>
ConstraintRow<S> row_of_load(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                             const Vec3<S>& force, const Vec3<S>& couple) {
  const LeverArms<S> levers = levers_of(bodies, proximity, contact);
  ConstraintRow<S> row;
  for (int side = 0; side < 2; ++side) {
    const int body = row.body[side] = levers.body[side];
    if (body < 0) continue;
    const S sign = side == 0 ? S(1) : S(-1);
    row.jacobian[side] = wrench_of(force, couple, levers.arm[side], sign);
    row.response[side].linear = bodies.inverse_inertia[body].inverse_mass_per_kg * row.jacobian[side].linear;
    if (!bodies.model.rotates(body)) continue;
    const Pose<S>& pose = bodies.poses[body];
    row.response[side].angular =
        to_world(pose, bodies.model.mass(body).times_inverse_inertia(to_body(pose, row.jacobian[side].angular)));
  }
  return row;
}

template <class S>
S delassus_entry(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact, const Vec3<S>& on,
                 const Vec3<S>& on_couple, const Vec3<S>& force, const Vec3<S>& couple) {
  return delassus_entry(row_of_load(bodies, proximity, contact, on, on_couple),
                        row_of_load(bodies, proximity, contact, force, couple));
}

#define ATWOOD_CONSTRAINTS(S)                                                                                         \
  template void initialize_inverse_inertia<S>(Bodies<S>&);                                                            \
  template void update_contact_body_poses<S>(Bodies<S>&, const ActiveSet<S>&, const S*);                              \
  template void update_kinematics<S>(const Bodies<S>&, const Proximity<S>&, Contact<S>&);                             \
  template void update_active_kinematics<S>(Bodies<S>&, const Proximity<S>&, ActiveSet<S>&, const S*, std::uint64_t); \
  template void update_unit_load<S>(const Bodies<S>&, const Proximity<S>&, Contact<S>&, ConstraintLevel);             \
  template LeverArms<S> levers_of<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&);                       \
  template void assign_rows<S>(const Bodies<S>&, const Proximity<S>&, ActiveSet<S>&, ConstraintSystem<S>&,            \
                               ConstraintLevel);                                                                      \
  template void assemble_delassus<S>(const Bodies<S>&, const ActiveSet<S>&, ConstraintSystem<S>&);                    \
  template void apply_unknowns<S>(const Bodies<S>&, const ActiveSet<S>&, ConstraintSystem<S>&);                       \
  template void row_values<S>(const ConstraintSystem<S>&, const Contact<S>&, S*);                                     \
  template void store_forces<S>(const ConstraintSystem<S>&, Contact<S>&);                                             \
  template ConstraintRow<S> row_of_load<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&, const Vec3<S>&,  \
                                           const Vec3<S>&);                                                           \
  template S delassus_entry<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&, const Vec3<S>&,              \
                               const Vec3<S>&, const Vec3<S>&, const Vec3<S>&);
ATWOOD_CONSTRAINTS(float)
ATWOOD_CONSTRAINTS(double)
ATWOOD_CONSTRAINTS(long double)
#undef ATWOOD_CONSTRAINTS

}  // namespace atwood::event
