// A contact that shares no moving body with another, without a couple that holds against rolling: at most three
// unknowns, solved in closed form.

#include "contact/event/single_contact.hpp"

#include "contact/event/painleve.hpp"

namespace atwood::event {

namespace {

// One of the contact's bodies; only `moves` is set where it does not move.
template <class S> struct ContactSide {
  bool moves = false, rotates = false;
  S sign{};
  const Pose<S>* pose = nullptr;
  const InverseInertia<S>* inverse = nullptr;
  Vec3<S> arm;
  S* dydt = nullptr;
};

template <class S> ContactSide<S> side_of(const Bodies<S>& bodies, const Contact<S>& contact, int i, S sign, S* dydt) {
  ContactSide<S> side;
  const int body = contact.levers.body[i];
  side.moves = body >= 0;
  if (!side.moves) return side;
  side.rotates = bodies.model.rotates(body);
  side.sign = sign;
  side.pose = &bodies.poses[body];
  side.inverse = &bodies.inverse_inertia[body];
  side.arm = contact.levers.arm[i];
  side.dydt = dydt + bodies.model.offset(body);
  return side;
}

// Acceleration of the contact point under the forces that are in dydt already.
template <class S> Vec3<S> point_acceleration(const ContactSide<S>& side, const Vec3<S>& x_dot) {
  const Pose<S>& pose = *side.pose;
  Vec3<S> a = load3(side.dydt + kAtVelocity);
  if (side.rotates)
    a += cross(to_world(pose, load3(side.dydt + kAtBodyRate)), side.arm) + cross(pose.w, x_dot - pose.v);
  return a;
}

template <class S> void add_acceleration(const ContactSide<S>& side, const SpatialVector<S>& response) {
  store3(load3(side.dydt + kAtVelocity) + response.linear, side.dydt + kAtVelocity);
  if (side.rotates)
    store3(load3(side.dydt + kAtBodyRate) + to_body(*side.pose, response.angular), side.dydt + kAtBodyRate);
}

// [r]^T I^-1 [r] + 1 / m, row after row: row i of I^-1 [r] is (I^-1)_i x r.
template <class S> void add_inverse_mass_matrix(const ContactSide<S>& side, Vec3<S> (&K)[3]) {
  const Vec3<S>& r = side.arm;
  const Vec3<S>(&row)[3] = side.inverse->I_row;
  const Vec3<S> B[3] = {cross(row[0], r), cross(row[1], r), cross(row[2], r)};
  K[0] += r.z * B[1] - r.y * B[2];
  K[1] += r.x * B[2] - r.z * B[0];
  K[2] += r.y * B[0] - r.x * B[1];
  K[0].x += side.inverse->inverse_mass_per_kg;
  K[1].y += side.inverse->inverse_mass_per_kg;
  K[2].z += side.inverse->inverse_mass_per_kg;
}

// K x = b by L D L^T: K is symmetric and positive.
template <class S> bool solve_ldlt(const Vec3<S> (&K)[3], const Vec3<S>& b, Vec3<S>& x) {
  const S d0 = S(1) / K[0].x, l10 = K[1].x * d0, l20 = K[2].x * d0;
  const S d1 = S(1) / (K[1].y - l10 * K[1].x), e = K[2].y - l20 * K[1].x, l21 = e * d1;
  const S d2 = K[2].z - l20 * K[2].x - l21 * e;
  const S y1 = b.y - l10 * b.x, y2 = b.z - l20 * b.x - l21 * y1;
  x.z = y2 / d2;
  x.y = y1 * d1 - l21 * x.z;
  x.x = b.x * d0 - l10 * x.y - l20 * x.z;
  return d2 > S(0);
}

// Between spheres the arms r are along n: K is 1/m along n, and 1/m + r^2 / I in every direction across.
template <class S>
bool add_sphere_contact_forces(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact,
                               const ContactSide<S> (&sides)[2], const Vec3<S>& b) {
  const Vec3<S>& n = contact.kinematics.normal;
  S along{}, across{};
  for (const ContactSide<S>& side : sides) {
    if (!side.moves) continue;
    along += side.inverse->inverse_mass_per_kg;
    if (side.rotates) across += dot(side.arm, side.arm) * side.inverse->I_row[0].x;
  }
  const S b_n = dot(n, b), N = b_n / along;
  contact.normal_N = N;
  contact.couple_N_m = {};
  if (contact.mode == FrictionMode::stick) {
    contact.friction_N = (S(1) / (along + across)) * (b - b_n * n);
  } else {
    update_unit_load(bodies, proximity, contact, ConstraintLevel::acceleration);
    contact.friction_N = N * (contact.unit_force_W - n);
    contact.couple_N_m = N * contact.unit_couple_W;
  }
  const Vec3<S> force = N * n + contact.friction_N;
  for (const ContactSide<S>& side : sides) {
    if (!side.moves) continue;
    store3(load3(side.dydt + kAtVelocity) + (side.sign * side.inverse->inverse_mass_per_kg) * force,
           side.dydt + kAtVelocity);
    if (!side.rotates || contact.mode == FrictionMode::frictionless) continue;
    const Vec3<S> load = cross(side.arm, contact.friction_N) + contact.couple_N_m;
    const Vec3<S> alpha_B = to_body(*side.pose, (side.sign * side.inverse->I_row[0].x) * load);
    store3(load3(side.dydt + kAtBodyRate) + alpha_B, side.dydt + kAtBodyRate);
  }
  return along > S(0);
}

}  // namespace

// With K f = (1/m) f + (I^-1 (r x f)) x r, summed over both bodies, the relative acceleration that a force f at the
// point gives, and b = -u' - (u . n') n with u' under all other forces:
//   stick   K f = b
//   else    f = N l,  N = n . b / (n . K l),   l = n - mu d,  d the direction of the slip, and the couple
//           that comes with it
template <class S>
bool add_single_contact_forces(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact, S* dydt) {
  const ContactSide<S> sides[2] = {side_of(bodies, contact, 0, S(1), dydt), side_of(bodies, contact, 1, S(-1), dydt)};
  const Vec3<S>& n = contact.kinematics.normal;
  Vec3<S> b = -dot(contact.u, contact.kinematics.normal_dot) * n;
  for (const ContactSide<S>& side : sides)
    if (side.moves) b -= side.sign * point_acceleration(side, contact.kinematics.x_dot);
  if (contact.between_spheres) return add_sphere_contact_forces(bodies, proximity, contact, sides, b);
  if (contact.mode == FrictionMode::stick) {
    Vec3<S> K[3] = {}, force;
    for (const ContactSide<S>& side : sides)
      if (side.moves) add_inverse_mass_matrix(side, K);
    const bool solved = solve_ldlt(K, b, force);
    contact.normal_N = dot(force, n);
    contact.friction_N = force - contact.normal_N * n;
    contact.couple_N_m = {};
    for (const ContactSide<S>& side : sides)
      if (side.moves)
        add_acceleration(side, acceleration_under(*side.inverse, wrench_of(force, {}, side.arm, side.sign)));
    return solved;
  }
  update_unit_load(bodies, proximity, contact, ConstraintLevel::acceleration);
  SpatialVector<S> response[2];
  S delassus{};
  for (int i = 0; i < 2; ++i) {
    if (!sides[i].moves) continue;
    response[i] = acceleration_under(
        *sides[i].inverse, wrench_of(contact.unit_force_W, contact.unit_couple_W, sides[i].arm, sides[i].sign));
    delassus += sides[i].sign * dot(n, response[i].linear + cross(response[i].angular, sides[i].arm));
  }
  const S N = dot(n, b) / delassus;
  if (contact.mode == FrictionMode::slip) record_delassus(contact, delassus, N);
  contact.normal_N = N;
  contact.friction_N = N * (contact.unit_force_W - n);
  contact.couple_N_m = N * contact.unit_couple_W;
  for (int i = 0; i < 2; ++i)
    if (sides[i].moves) add_acceleration(sides[i], SpatialVector<S>{N * response[i].linear, N * response[i].angular});
  return delassus != S(0);
}

#define ATWOOD_SINGLE_CONTACT(S) \
  template bool add_single_contact_forces<S>(const Bodies<S>&, const Proximity<S>&, Contact<S>&, S*);
ATWOOD_SINGLE_CONTACT(float)
ATWOOD_SINGLE_CONTACT(double)
ATWOOD_SINGLE_CONTACT(long double)
#undef ATWOOD_SINGLE_CONTACT

}  // namespace atwood::event
