// A contact that shares no moving body with another, and has no couple besides friction that holds: at most three unknowns.
#include "contact/event/rows.hpp"

namespace atwood::event {

// Its own equations, in world axes. With K f the acceleration that a force f at the point gives, (1/m) f + (I^-1 (r x f)) x r of both
// bodies, and b = -u' - (u . n') n what is asked for:
//   sticks   K f = b          else   f = N l,  N = n . b / (n . K l),   l = n - mu d, with the couple that comes with it
// K r . : rows of [r]^T I^-1 [r], where (I^-1 [r])_i = (I^-1)_i x r.  K f = b by L D L^T: K is symmetric and positive.
template <class S> bool solve_alone(const EventRun<S>& run, Contact<S>& contact, const Vec3<S>& b, Twist<S> (&answer)[2]) {
  const Place<S> place = place_of(run, contact);
  const Vec3<S>& n = contact.sight.normal;
  Vec3<S> force{};
  if (contact.mode != Mode::sticks) {
    take_direction(run, contact, Rows::forces);
    S gives{};
    for (int side = 0; side < 2; ++side) {
      if (place.body[side] < 0) continue;
      answer[side] = answer_of(run.inverse[place.body[side]], load_of(contact.along_W, contact.along_couple_W, place.arm[side], S(1)));
      gives += dot(n, answer[side].linear + cross(answer[side].angular, place.arm[side]));
    }
    const S N = dot(n, b) / gives;
    contact.normal_N = N;
    contact.friction_N = N * (contact.along_W - n);
    contact.couple_N_m = N * contact.along_couple_W;
    for (int side = 0; side < 2; ++side)
      answer[side] = {(side == 0 ? N : -N) * answer[side].linear, (side == 0 ? N : -N) * answer[side].angular};
    return gives != S(0);
  }
  Vec3<S> K[3] = {};
  for (int side = 0; side < 2; ++side) {
    if (place.body[side] < 0) continue;
    const Inverse<S>& inverse = run.inverse[place.body[side]];
    const Vec3<S>& r = place.arm[side];
    const Vec3<S> B[3] = {cross(inverse.I_row[0], r), cross(inverse.I_row[1], r), cross(inverse.I_row[2], r)};
    K[0] += r.z * B[1] - r.y * B[2];
    K[1] += r.x * B[2] - r.z * B[0];
    K[2] += r.y * B[0] - r.x * B[1];
    K[0].x += inverse.mass_per_kg;
    K[1].y += inverse.mass_per_kg;
    K[2].z += inverse.mass_per_kg;
  }
  const S d0 = S(1) / K[0].x, l10 = K[1].x * d0, l20 = K[2].x * d0;
  const S d1 = S(1) / (K[1].y - l10 * K[1].x), e = K[2].y - l20 * K[1].x, l21 = e * d1;
  const S last = K[2].z - l20 * K[2].x - l21 * e;
  const S y1 = b.y - l10 * b.x, y2 = b.z - l20 * b.x - l21 * y1;
  force.z = y2 / last;
  force.y = y1 * d1 - l21 * force.z;
  force.x = b.x * d0 - l10 * force.y - l20 * force.z;
  contact.normal_N = dot(force, n);
  contact.friction_N = force - contact.normal_N * n;
  contact.couple_N_m = {};
  for (int side = 0; side < 2; ++side)
    if (place.body[side] >= 0)
      answer[side] = answer_of(run.inverse[place.body[side]], load_of(force, {}, place.arm[side], side == 0 ? S(1) : S(-1)));
  return last > S(0);
}

#define ATWOOD_ALONE(S) template bool solve_alone<S>(const EventRun<S>&, Contact<S>&, const Vec3<S>&, Twist<S> (&)[2]);
ATWOOD_ALONE(float)
ATWOOD_ALONE(double)
ATWOOD_ALONE(long double)
#undef ATWOOD_ALONE

}  // namespace atwood::event
