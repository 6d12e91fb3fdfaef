// `+impulse`: plain time stepping.
//
//   y*  = step(y, h)                                  free motion
//   for pairs that y* would leave overlapping:
//     fast approach (v_n < -2 |a_n| h):  restitution and friction now, at the start of the step
//     slow approach:                     v_n += -(gap* - min(gap, 0)) / h, so that the step ends where the gap allows
//   y_new = step(y, h) again
//
// Sequential over pairs, repeated until none overlaps (a cradle needs as many sweeps as it has balls).
#include "contact/response.hpp"

namespace atwood {

namespace {

constexpr int most_sweeps = 16;

template <class S> bool respond(ContactRun<S>& run, const ContactPair<S>& pair, S t_s, S h_s) {
  const Gap<S> start = gap_of(run, pair, run.y.data());
  const Gap<S> end = gap_of(run, pair, run.y_new.data());
  const S allowed = real::min(start.distance, S(0));
  if (!(end.distance < allowed)) return false;
  ImpactBody<S> a, b;
  load_impact(run, pair, start, run.y.data(), a, b);
  const S vn = dot(velocity_between(a, b), start.normal_W);
  const S pressing = real::abs(normal_acceleration(run, pair, t_s, run.y.data()));
  if (vn < -S(2) * pressing * h_s) {
    const Impulse<S> impulse = collide({pair.restitution, pair.friction}, start.normal_W, a, b);
    report_event(run, EventKind::impact, pair, start, impulse, t_s);
  } else {
    const S j_n = (allowed - end.distance) / h_s / mobility(a, b, start.normal_W);
    push(a, b, start.normal_W, j_n);
    const Vec3<S> between = velocity_between(a, b);
    const Vec3<S> slip = between - dot(between, start.normal_W) * start.normal_W;
    const S speed = norm(slip);
    if (pair.friction > S(0) && speed > S(0)) {
      const Vec3<S> along = (S(1) / speed) * slip;
      push(a, b, along, -real::min(pair.friction * j_n, speed / mobility(a, b, along)));
    }
  }
  store_impact(run, pair, a, b, run.y.data());
  return true;
}

}  // namespace

template <class S> bool step_with_impulse(ContactRun<S>& run, S t_s, S h_s) {
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    if (!run.stepper.step(t_s, h_s, run.y.data(), run.y_new.data())) return false;
    bool touched = false;
    for (const auto& pair : run.pairs) touched = respond(run, pair, t_s, h_s) || touched;
    if (!touched) break;
  }
  run.y.swap(run.y_new);
  return true;
}

template bool step_with_impulse<float>(ContactRun<float>&, float, float);
template bool step_with_impulse<double>(ContactRun<double>&, double, double);
template bool step_with_impulse<long double>(ContactRun<long double>&, long double, long double);

}  // namespace atwood
