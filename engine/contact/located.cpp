// `+event`: impacts located to round-off on the method's own flow.
//
// A step that ends (or dips) into overlap is cut at the touch: theta in (0, 1] with gap(step(y, theta h)) = 0. Probing
// is done by shorter steps from the same state, not by interpolation, so a touch is as accurate as the method.
#include <cmath>

#include "contact/response.hpp"

namespace atwood {

namespace {

constexpr int most_impacts_a_step = 10000;

template <class S> struct Touch { S theta; int pair = -1; };

// A run's probe: the state after theta h.
template <class S> struct Flow {
  ContactRun<S>& run;
  S t_s, h_s;
  bool ok = true;

  const S* at(S theta) {
    ok = run.stepper.step(t_s, theta * h_s, run.y.data(), run.y_probe.data()) && ok;
    return run.y_probe.data();
  }
};

// Newton on the gap, kept inside a bracket: gap(low) > 0 >= gap(high).
template <class S> S refine(Flow<S>& flow, const ContactPair<S>& pair, S low, S high) {
  S theta = high, best = high;
  for (int i = 0; i < 100; ++i) {
    const S* y = flow.at(theta);
    const S gap = gap_of(flow.run, pair, y).distance;
    const S slope = gap_rate(flow.run, pair, y) * flow.h_s;
    best = theta;
    if (gap > S(0)) low = theta; else high = theta;
    S next = slope < S(0) ? theta - gap / slope : low;
    if (!(next > low && next < high)) next = low + (high - low) / S(2);
    if (real::abs(next - theta) <= real::epsilon<S>() * theta || high - low <= real::epsilon<S>() * high) break;
    theta = next;
  }
  return best;
}

// Where in (0, high) the approach begins: the largest known theta with a positive gap and a falling one after it.
// After an impact the gap starts at zero and rises; half the flight that its first curvature predicts is inside the
// flight, or is halved until it is.
template <class S> S bracket_start(Flow<S>& flow, const ContactPair<S>& pair, S gap_start, S rate_start, S high) {
  if (gap_start > S(0) && rate_start <= S(0)) return S(0);
  const S rate_end = gap_rate(flow.run, pair, flow.at(high)) * flow.h_s;
  const S fall = rate_start * flow.h_s - rate_end;
  S theta = fall > S(0) ? rate_start * flow.h_s / fall * high : high / S(2);
  theta = real::min(theta, high);
  for (int i = 0; i < 200; ++i) {
    if (gap_of(flow.run, pair, flow.at(theta)).distance > S(0)) return theta;
    theta = theta / S(2);
  }
  return S(0);
}

// The earliest touch of one pair within the step whose end is y_new; theta > 1 if there is none. A dip inside the step
// shows as a gap that falls at the start and rises at the end: its lowest point is sought by the sign of the rate.
template <class S> S touch_of(Flow<S>& flow, const ContactPair<S>& pair) {
  ContactRun<S>& run = flow.run;
  const S none = S(2);
  const S gap_start = gap_of(run, pair, run.y.data()).distance;
  const S rate_start = gap_rate(run, pair, run.y.data());
  const S gap_end = gap_of(run, pair, run.y_new.data()).distance;
  const S rate_end = gap_rate(run, pair, run.y_new.data());
  if (gap_start <= S(0) && rate_start < S(0)) return S(0);
  S high = S(1);
  if (gap_end > S(0)) {
    if (!(rate_start < S(0) && rate_end > S(0))) return none;
    S low = S(0);
    for (int i = 0; i < 60; ++i) {  // bisection on the rate; stops at the first overlap
      const S middle = low + (high - low) / S(2);
      const S* y = flow.at(middle);
      if (gap_of(run, pair, y).distance <= S(0)) {
        high = middle;
        break;
      }
      if (gap_rate(run, pair, y) < S(0)) low = middle; else high = middle;
      if (high - low < real::epsilon<S>()) return none;
    }
    if (gap_of(run, pair, flow.at(high)).distance > S(0)) return none;
  } else if (gap_start <= S(0) && rate_end >= S(0) && gap_end > gap_start) {
    return none;  // still inside by round-off, and leaving
  }
  const S low = bracket_start(flow, pair, gap_start, rate_start, high);
  return refine(flow, pair, low, high);
}

template <class S> Touch<S> earliest_touch(Flow<S>& flow) {
  Touch<S> first{S(2), -1};
  for (std::size_t i = 0; i < flow.run.pairs.size(); ++i) {
    if (is_resting(flow.run, static_cast<int>(i))) continue;
    const S theta = touch_of(flow, flow.run.pairs[i]);
    if (theta <= S(1) && theta < first.theta) first = {theta, static_cast<int>(i)};
  }
  return first;
}

template <class S> Vec3<S> through_air(const ContactRun<S>& run, const Wind<S>& wind, const S* y) {
  return run.model.body(wind.body, y).v_WB - wind.velocity_W;
}

// Where in the step a body's velocity through the air has turned square to what it was at the start; theta > 1 if
// nowhere. Steps are cut there: across the kink of |u| u no method keeps more than third order. False position
// (Illinois), which probes from the smooth side.
template <class S> S calm_of(Flow<S>& flow) {
  ContactRun<S>& run = flow.run;
  S first = S(2);
  for (const Wind<S>& wind : run.winds) {
    const Vec3<S> u0 = through_air(run, wind, run.y.data()), u1 = through_air(run, wind, run.y_new.data());
    const S tiny = S(1024) * real::epsilon<S>();
    S low = S(0), high = S(1), f_low = dot(u0, u0), f_high = dot(u0, u1);
    if (!(f_high < S(0)) || f_low < tiny * tiny * dot(u1, u1)) continue;
    const S enough = real::epsilon<S>() * f_low;
    S theta = high;
    for (int i = 0, side = 0; i < 60 && high - low > real::epsilon<S>() * high; ++i) {
      theta = (low * f_high - high * f_low) / (f_high - f_low);
      if (!(theta > low && theta < high)) theta = low + (high - low) / S(2);
      const S f = dot(u0, through_air(run, wind, flow.at(theta)));
      if (f > S(0)) {
        low = theta;
        f_low = f;
        if (side == 1) f_high = f_high / S(2);
        side = 1;
      } else {
        high = theta;
        f_high = f;
        if (side == -1) f_low = f_low / S(2);
        side = -1;
      }
      if (real::abs(f) <= enough) break;
    }
    first = real::min(first, theta);
  }
  return first;
}

// Puts a resting ball exactly on its plane and takes its normal velocity away. Frictionless along the plane.
template <class S> void settle(ContactRun<S>& run, const Resting& resting, S* y) {
  const ContactPair<S>& pair = run.pairs[resting.pair];
  BodyState<S> state = run.model.body(resting.ball, y);
  const Gap<S> gap = gap_of(run, pair, y);
  const Vec3<S> out = resting.ball == pair.b ? gap.normal_W : -gap.normal_W;  // from the plane to the ball
  state.p_WB -= gap.distance * out;
  state.v_WB -= dot(state.v_WB, out) * out;
  run.model.set_body(resting.ball, state, y);
}

template <class S> void settle_all(ContactRun<S>& run, S* y) {
  for (const Resting& resting : run.resting) settle(run, resting, y);
}

// Does this impact end a Zeno series? Each touch is located to about eps r / v, so late bounces cost more than they tell:
// the series is summed once a bounce rises by less than eps^(2/3) r.
//   flight T_k = 2 v / a,  rise a T^2 / 8,  rest of the series T_k / (1 - e)
template <class S> bool ends_bouncing(ContactRun<S>& run, const ContactPair<S>& pair, S t_s, S vn_after, S& tail_s) {
  const bool ball_on_plane = pair.plane_a || pair.plane_b;
  const S pressing = -normal_acceleration(run, pair, t_s, run.y.data());
  tail_s = S(0);
  if (!ball_on_plane || !(pressing > S(0))) return false;
  const S radius = pair.plane_a ? pair.radius_b : pair.radius_a;
  const S flight = S(2) * vn_after / pressing;
  const S root = std::cbrt(real::epsilon<S>());
  if (pressing * flight * flight / S(8) > root * root * radius) return false;
  if (pair.restitution >= S(1)) return false;  // never comes to rest
  tail_s = flight / (S(1) - pair.restitution);
  return true;
}

// The impulse at a touch; the state is run.y at t_s. False: something this engine has no law for.
template <class S> bool respond(ContactRun<S>& run, int index, S t_s) {
  const ContactPair<S>& pair = run.pairs[index];
  const Gap<S> gap = gap_of(run, pair, run.y.data());
  ImpactBody<S> a, b;
  load_impact(run, pair, gap, run.y.data(), a, b);
  const Impulse<S> impulse = collide({pair.restitution, pair.friction}, gap.normal_W, a, b);
  store_impact(run, pair, a, b, run.y.data());
  report_event(run, EventKind::impact, pair, gap, impulse, t_s);
  S tail_s{};
  if (!ends_bouncing(run, pair, t_s, impulse.vn_after_m_per_s, tail_s)) return true;
  const Vec3<S> between = velocity_between(a, b);
  const S slip = norm(between - dot(between, gap.normal_W) * gap.normal_W);
  if (pair.friction > S(0) && slip > S(1024) * real::epsilon<S>() * real::max(S(1), norm(between))) {
    run.outcome = {Status::unsupported, "atwood's +event has no sliding or rolling under friction yet", 0, 0, {}};
    return false;
  }
  run.resting.push_back({index, pair.plane_a ? pair.b : pair.a});
  settle(run, run.resting.back(), run.y.data());
  report_event(run, EventKind::rest, pair, gap, {S(0), S(0), impulse.vn_after_m_per_s, S(0)}, t_s + tail_s);
  return true;
}

// Lets go of balls that something pulls off their plane.
template <class S> void release(ContactRun<S>& run, S t_s) {
  for (std::size_t i = 0; i < run.resting.size();) {
    const ContactPair<S>& pair = run.pairs[run.resting[i].pair];
    if (normal_acceleration(run, pair, t_s, run.y.data()) > S(0)) {
      report_event(run, EventKind::separate, pair, gap_of(run, pair, run.y.data()), Impulse<S>{}, t_s);
      run.resting.erase(run.resting.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

// One free step from run.y into run.y_new, as long as error control allows: at most `h_s`, which it may shorten.
template <class S> bool free_step(ContactRun<S>& run, S t_s, S& h_s) {
  if (run.rtol <= S(0)) return run.stepper.step(t_s, h_s, run.y.data(), run.y_new.data());
  if (run.h_next_s > S(0) && run.h_next_s < h_s) h_s = run.h_next_s;
  for (int i = 0; i < 60; ++i) {
    if (!run.stepper.step(t_s, h_s, run.y.data(), run.y_new.data())) return false;
    const S error = run.stepper.error_norm(run.rtol, run.atol);
    const S factor = error > S(0) ? S(0.9) / real::sqrt(real::sqrt(error)) : S(5);  // order 4 estimate, damped
    if (error <= S(1)) {
      run.h_next_s = h_s * real::min(S(5), real::max(S(0.2), factor));
      return true;
    }
    h_s = h_s * real::max(S(0.2), real::min(factor, S(0.9)));
  }
  return false;
}

}  // namespace

template <class S> bool step_with_events(ContactRun<S>& run, S t_s, S h_s) {
  const S t_end_s = t_s + h_s;
  S left_s = h_s;
  release(run, t_s);
  for (int impacts = 0; impacts < most_impacts_a_step; ++impacts) {
    S step_s = left_s;
    if (!free_step(run, t_s, step_s)) return false;
    Flow<S> flow{run, t_s, step_s};
    const Touch<S> touch = earliest_touch(flow);
    const S calm = run.winds.empty() ? S(2) : calm_of(flow);
    if (!flow.ok) return false;
    if (calm < S(1) && calm < touch.theta) {
      if (!run.stepper.step(t_s, calm * step_s, run.y.data(), run.y_try.data())) return false;
      run.y.swap(run.y_try);
      settle_all(run, run.y.data());
      t_s += calm * step_s;
      left_s -= calm * step_s;
      continue;
    }
    if (touch.pair < 0) {
      settle_all(run, run.y_new.data());
      run.y.swap(run.y_new);
      left_s -= step_s;
      t_s += step_s;
      if (!(left_s > real::epsilon<S>() * real::abs(t_end_s))) return true;
      --impacts;
      continue;
    }
    if (touch.theta > S(0)) {
      if (!run.stepper.step(t_s, touch.theta * step_s, run.y.data(), run.y_try.data())) return false;
      run.y.swap(run.y_try);
      settle_all(run, run.y.data());
    }
    t_s += touch.theta * step_s;
    left_s -= touch.theta * step_s;
    if (!respond(run, touch.pair, t_s)) return false;
    if (!(left_s > S(0))) return true;
  }
  run.outcome = {Status::diverged, "atwood's +event met more than 10000 impacts in one step", 0, 0, {}};
  return false;
}

template bool step_with_events<float>(ContactRun<float>&, float, float);
template bool step_with_events<double>(ContactRun<double>&, double, double);
template bool step_with_events<long double>(ContactRun<long double>&, long double, long double);

}  // namespace atwood
