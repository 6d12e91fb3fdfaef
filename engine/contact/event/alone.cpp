// A contact that shares no moving body with another, and has no couple besides friction that holds: at most three
// unknowns.
#include "contact/event/rows.hpp"

namespace atwood::event {

namespace {

// One of the contact's bodies: nothing of it is read where it does not move.
template <class S> struct Side {
  bool moves = false, rotates = false;
  S sign{};
  const Pose<S>* pose = nullptr;
  const Inverse<S>* inverse = nullptr;
  Vec3<S> arm;
  S* dydt = nullptr;
};

template <class S> Side<S> side_of(const EventRun<S>& run, const Contact<S>& contact, int i, S sign, S* dydt) {
  Side<S> side;
  const int body = contact.place.body[i];
  side.moves = body >= 0;
  if (!side.moves) return side;
  side.rotates = run.model.rotates(body);
  side.sign = sign;
  side.pose = &run.poses[body];
  side.inverse = &run.inverse[body];
  side.arm = contact.place.arm[i];
  side.dydt = dydt + run.model.offset(body);
  return side;
}

// Of the body's point, under the forces that are in dydt already.
template <class S> Vec3<S> point_acceleration(const Side<S>& side, const Vec3<S>& x_dot) {
  const Pose<S>& pose = *side.pose;
  Vec3<S> a = load3(side.dydt + kAtVelocity);
  if (side.rotates) a += cross(turned(pose, load3(side.dydt + kAtBodyRate)), side.arm) + cross(pose.w, x_dot - pose.v);
  return a;
}

template <class S> void add_answer(const Side<S>& side, const Twist<S>& answer) {
  store3(load3(side.dydt + kAtVelocity) + answer.linear, side.dydt + kAtVelocity);
  if (side.rotates)
    store3(load3(side.dydt + kAtBodyRate) + turned_back(*side.pose, answer.angular), side.dydt + kAtBodyRate);
}

// [r]^T I^-1 [r] + 1 / m, row after row: row i of I^-1 [r] is (I^-1)_i x r.
template <class S> void add_mobility(const Side<S>& side, Vec3<S> (&K)[3]) {
  const Vec3<S>& r = side.arm;
  const Vec3<S>(&row)[3] = side.inverse->I_row;
  const Vec3<S> B[3] = {cross(row[0], r), cross(row[1], r), cross(row[2], r)};
  K[0] += r.z * B[1] - r.y * B[2];
  K[1] += r.x * B[2] - r.z * B[0];
  K[2] += r.y * B[0] - r.x * B[1];
  K[0].x += side.inverse->mass_per_kg;
  K[1].y += side.inverse->mass_per_kg;
  K[2].z += side.inverse->mass_per_kg;
}

// K x = b by L D L^T: K is symmetric and positive.
template <class S> bool solve(const Vec3<S> (&K)[3], const Vec3<S>& b, Vec3<S>& x) {
  const S d0 = S(1) / K[0].x, l10 = K[1].x * d0, l20 = K[2].x * d0;
  const S d1 = S(1) / (K[1].y - l10 * K[1].x), e = K[2].y - l20 * K[1].x, l21 = e * d1;
  const S d2 = K[2].z - l20 * K[2].x - l21 * e;
  const S y1 = b.y - l10 * b.x, y2 = b.z - l20 * b.x - l21 * y1;
  x.z = y2 / d2;
  x.y = y1 * d1 - l21 * x.z;
  x.x = b.x * d0 - l10 * x.y - l20 * x.z;
  return d2 > S(0);
}

// Of balls the arms r are along n, so that K is 1/m along n and 1/m + r^2 / I in every direction across.
template <class S>
bool add_to_balls(const EventRun<S>& run, Contact<S>& contact, const Side<S> (&sides)[2], const Vec3<S>& b) {
  const Vec3<S>& n = contact.sight.normal;
  S along{}, across{};
  for (const Side<S>& side : sides) {
    if (!side.moves) continue;
    along += side.inverse->mass_per_kg;
    if (side.rotates) across += dot(side.arm, side.arm) * side.inverse->I_row[0].x;
  }
  const S asked = dot(n, b), N = asked / along;
  contact.normal_N = N;
  contact.couple_N_m = {};
  if (contact.mode == Mode::sticks) {
    contact.friction_N = (S(1) / (along + across)) * (b - asked * n);
  } else {
    take_direction(run, contact, Rows::forces);
    contact.friction_N = N * (contact.along_W - n);
    contact.couple_N_m = N * contact.along_couple_W;
  }
  const Vec3<S> force = N * n + contact.friction_N;
  for (const Side<S>& side : sides) {
    if (!side.moves) continue;
    store3(load3(side.dydt + kAtVelocity) + (side.sign * side.inverse->mass_per_kg) * force, side.dydt + kAtVelocity);
    if (!side.rotates || contact.mode == Mode::smooth) continue;
    const Vec3<S> load = cross(side.arm, contact.friction_N) + contact.couple_N_m;
    const Vec3<S> turns = turned_back(*side.pose, (side.sign * side.inverse->I_row[0].x) * load);
    store3(load3(side.dydt + kAtBodyRate) + turns, side.dydt + kAtBodyRate);
  }
  return along > S(0);
}

}  // namespace

// In world axes. With K f the acceleration between the bodies that a force f at the point gives, (1/m) f + (I^-1 (r x
// f)) x r of both, and b = -u' - (u . n') n what is asked for, u' under all other forces:
//   sticks   K f = b          else   f = N l,  N = n . b / (n . K l),   l = n - mu d, with the couple that comes with
//   it
template <class S> bool add_alone(const EventRun<S>& run, Contact<S>& contact, S* dydt) {
  const Side<S> sides[2] = {side_of(run, contact, 0, S(1), dydt), side_of(run, contact, 1, S(-1), dydt)};
  const Vec3<S>& n = contact.sight.normal;
  Vec3<S> b = -dot(contact.u, contact.sight.normal_dot) * n;
  for (const Side<S>& side : sides)
    if (side.moves) b -= side.sign * point_acceleration(side, contact.sight.x_dot);
  if (contact.of_balls) return add_to_balls(run, contact, sides, b);
  if (contact.mode == Mode::sticks) {
    Vec3<S> K[3] = {}, force;
    for (const Side<S>& side : sides)
      if (side.moves) add_mobility(side, K);
    const bool solved = solve(K, b, force);
    contact.normal_N = dot(force, n);
    contact.friction_N = force - contact.normal_N * n;
    contact.couple_N_m = {};
    for (const Side<S>& side : sides)
      if (side.moves) add_answer(side, answer_of(*side.inverse, load_of(force, {}, side.arm, side.sign)));
    return solved;
  }
  take_direction(run, contact, Rows::forces);
  Twist<S> answer[2];
  S gives{};
  for (int i = 0; i < 2; ++i) {
    if (!sides[i].moves) continue;
    answer[i] =
        answer_of(*sides[i].inverse, load_of(contact.along_W, contact.along_couple_W, sides[i].arm, sides[i].sign));
    gives += sides[i].sign * dot(n, answer[i].linear + cross(answer[i].angular, sides[i].arm));
  }
  const S N = dot(n, b) / gives;
  if (contact.mode == Mode::slips) note_yield(contact, gives);
  contact.normal_N = N;
  contact.friction_N = N * (contact.along_W - n);
  contact.couple_N_m = N * contact.along_couple_W;
  for (int i = 0; i < 2; ++i)
    if (sides[i].moves) add_answer(sides[i], Twist<S>{N * answer[i].linear, N * answer[i].angular});
  return gives != S(0);
}

template bool add_alone<float>(const EventRun<float>&, Contact<float>&, float*);
template bool add_alone<double>(const EventRun<double>&, Contact<double>&, double*);
template bool add_alone<long double>(const EventRun<long double>&, Contact<long double>&, long double*);

}  // namespace atwood::event
