// Location of the first switching function that falls through zero within a trial step.
#include "contact/event/event_location.hpp"

#include <algorithm>

#include "contact/event/contact_forces.hpp"
#include "contact/event/edge_candidates.hpp"
#include "contact/event/surface_boundaries.hpp"
#include "math/bracketed_root.hpp"

namespace atwood::event {

namespace {

// ---- impacts --------------------------------------------------------------------------------------------------------
// The theta in (low, high] where a gap falls through zero that is >= 0 at `low` and < 0 at `high`. Newton's method on
// the gap within a bracket, from the root of the parabola through start and end (exact in free flight onto a plane); a
// gap that starts at zero, after an impact, rises first. Ends where corrections no longer shrink: what is left of the
// gap is round-off.
template <class S> S locate_zero_gap(Flow<S>& flow, const Candidate<S>& candidate, S low, S high, S gap_high) {
  const bool leaves = candidate.rate > S(0);
  const S rise = candidate.rate * flow.h_s * high, bend = gap_high - candidate.gap - rise;
  const S root = real::sqrt(real::max(rise * rise - S(4) * bend * candidate.gap, S(0)));
  const S guess = leaves ? (rise + root) / (S(-2) * bend) : S(2) * candidate.gap / (root - rise);
  S theta = guess > S(0) && guess < S(1) && guess * high > low ? guess * high : high, last = high, change = high;
  constexpr int max_iterations = 100;
  int i = 0;
  for (; i < max_iterations; ++i) {
    const GapKinematics<S> kinematics = gap_at(flow.run.bodies, flow.run.proximity, candidate, flow.at(theta).data());
    const S slope = kinematics.rate * flow.h_s;
    if (kinematics.gap > S(0) || (leaves && slope >= S(0))) low = theta;
    else high = theta;
    S next = slope < S(0) ? theta - kinematics.gap / slope : low;
    change = real::abs(next - theta);
    if (change <= real::epsilon<S>() * theta) break;
    if (change >= last / S(2) && real::abs(kinematics.gap) <= flow.run.bodies.gap_round_off()) break;
    if (!(next > low && next < high)) {
      next = low + (high - low) / S(2);
      change = high;
    }
    if (high - low <= real::epsilon<S>() * high) break;
    last = change;
    theta = next;
  }
  flow.report_search(i < max_iterations ? i + 1 : i, real::min(change, high - low), i < max_iterations);
  return flow.theta_of_probe;
}

// The end of the first part of [0, 1] in which the gap falls below zero, and the gap there; theta above 1: none. A dip
// inside the step shows as a gap that falls at the start and rises at the end; its minimum is found by bisection on the
// sign of the rate.
template <class S> struct Penetration { S theta = S(2), gap{}; };
template <class S> Penetration<S> first_penetration(Flow<S>& flow, const Candidate<S>& candidate) {
  const Penetration<S> none;
  if (candidate.gap_end < S(0)) {
    const bool leaves = candidate.gap <= S(0) && candidate.rate_end >= S(0) && candidate.gap_end >= candidate.gap;
    return leaves ? none : Penetration<S>{S(1), candidate.gap_end};
  }
  if (!(candidate.rate < S(0) && candidate.rate_end > S(0))) return none;
  // Bodies that separate from the start of the step, with a rate still negative by round-off, have no dip: the same
  // impact would be found for ever.
  if (candidate.gap <= flow.run.bodies.gap_round_off() && candidate.rate >= -flow.run.bodies.approach_round_off())
    return none;
  // A gap that falls and rises is taken as convex: it lies above its tangents at both ends.
  const S fall = candidate.rate * flow.h_s, rise = candidate.rate_end * flow.h_s;
  if (candidate.gap + fall * ((candidate.gap_end - rise - candidate.gap) / (fall - rise)) > S(0)) return none;
  constexpr int max_halvings = 80;
  S low = S(0), high = S(1);
  int halvings = 0;
  while (halvings < max_halvings && !(high - low < real::epsilon<S>())) {  // on the rate, up to the first penetration
    ++halvings;
    const S middle = low + (high - low) / S(2);
    const GapKinematics<S> kinematics = gap_at(flow.run.bodies, flow.run.proximity, candidate, flow.at(middle).data());
    if (kinematics.gap <= S(0)) return {middle, kinematics.gap};
    if (kinematics.rate < S(0)) low = middle;
    else high = middle;
  }
  flow.report_search(halvings, high - low, high - low < real::epsilon<S>());
  return none;
}

// For a gap that starts at zero with rate zero, up to round-off, because its contact was released: a theta in (0, high]
// where it is open; 0: none, or it starts otherwise.
template <class S> S separated_until(Flow<S>& flow, const Candidate<S>& candidate, S high) {
  const EventRun<S>& run = flow.run;
  if (candidate.gap > run.bodies.gap_round_off() || real::abs(candidate.rate) > run.bodies.approach_round_off())
    return S(0);
  for (S theta = high / S(2); theta > high * S(0x1p-40); theta = theta / S(2))
    if (gap_at(flow.run.bodies, flow.run.proximity, candidate, flow.at(theta).data()).gap > run.bodies.gap_round_off())
      return theta;
  return S(0);
}

template <class S> S impact_theta(Flow<S>& flow, const Candidate<S>& candidate) {
  if (candidate.gap <= S(0) && candidate.rate < -flow.run.bodies.approach_round_off()) return S(0);
  const Penetration<S> overlap = first_penetration(flow, candidate);
  if (overlap.theta > S(1)) return overlap.theta;
  // Closed, neither approaching nor separating, up to round-off: no impact.
  if (real::abs(candidate.gap) <= flow.run.bodies.gap_round_off() &&
      real::abs(candidate.gap_end) <= flow.run.bodies.gap_round_off() &&
      real::abs(candidate.rate_end) <= flow.run.bodies.approach_round_off())
    return S(2);
  return locate_zero_gap(flow, candidate, separated_until(flow, candidate, overlap.theta), overlap.theta, overlap.gap);
}

// Does the candidate, whose gap falls through zero at theta, leave its face there without an impact?
template <class S> bool leaves_face_at(Flow<S>& flow, const Candidate<S>& candidate, S theta) {
  EventRun<S>& run = flow.run;
  if (candidate.feature.edge || run.proximity.surfaces[candidate.surface].kind != SurfaceKind::slab) return false;
  const S* y = theta > S(0) ? flow.at(theta).data() : run.states.y.data();
  const S rate = gap_at(run.bodies, run.proximity, candidate, y).rate;
  return leaves_without_impact(run.bodies, run.proximity, candidate, rate);
}

// Two edges are candidates from where they cross: if they overlap there, another candidate has touched before.
template <class S> S impact_theta_of_edges(Flow<S>& flow, const Candidate<S>& candidate) {
  const S theta = impact_theta(flow, candidate);
  if (!(theta > S(0) && theta <= S(1))) return theta;
  const S gap = gap_at(flow.run.bodies, flow.run.proximity, candidate, flow.at(theta).data()).gap;
  return real::abs(gap) <= S(4) * flow.run.bodies.gap_round_off() ? theta : S(2);
}

// ---- switching functions of lasting contacts -----------------------------------------------------------------------
// From the last evaluation of the contacts.
template <class S>
S value_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
           const StateBuffers<S>& states, SwitchingFunction function, Contact<S>& contact) {
  const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
  switch (function) {
    case SwitchingFunction::normal_force: return contact.normal_N;
    case SwitchingFunction::friction_cone: return pair.friction * contact.normal_N - norm(contact.friction_N);
    case SwitchingFunction::rolling_bound: return pair.rolling_friction_m * contact.normal_N - norm(contact.couple_N_m);
    case SwitchingFunction::slip_reversal: return dot(contact.u, contact.slip_direction);
    case SwitchingFunction::facet:
      return depth_inside_facet(bodies, proximity, active, contact) +
             bodies.gap_round_off();  // 0 above edges inside a mesh
    case SwitchingFunction::reactivation:
      return active.separation_acceleration + normal_acceleration(bodies, proximity, contact, states.dydt.data());
    default: return dot(contact.w, contact.roll_direction);
  }
}

bool depends_on_forces(SwitchingFunction function) {
  return function == SwitchingFunction::normal_force || function == SwitchingFunction::friction_cone ||
         function == SwitchingFunction::rolling_bound || function == SwitchingFunction::reactivation;
}

template <class S> bool applies(const Proximity<S>& proximity, SwitchingFunction function, const Contact<S>& contact) {
  switch (function) {
    case SwitchingFunction::normal_force:
    case SwitchingFunction::reactivation: return true;
    case SwitchingFunction::friction_cone: return contact.mode == FrictionMode::stick;
    case SwitchingFunction::rolling_bound: return contact.rolling == RollingMode::stick;
    case SwitchingFunction::slip_reversal: return contact.mode == FrictionMode::slip && !contact.at_cone_limit;
    case SwitchingFunction::facet: return has_boundary(proximity, contact);
    default: return contact.rolling == RollingMode::roll;
  }
}

// Switching functions of all contacts, evaluated once for each theta.
template <class S> struct SwitchValues {
  Flow<S>& flow;
  S theta = S(-1);
  bool forces = false;

  S value(SwitchingFunction function, int index, S at) {
    EventRun<S>& run = flow.run;
    if (theta != at || (depends_on_forces(function) && !forces)) {
      const State<S>& y = at == S(0) ? run.states.y : at == S(1) ? run.states.y_new : flow.at(at);
      theta = at;
      forces = depends_on_forces(function);
      if (forces) {
        run.bodies.model.system().rate(flow.t_s + at * flow.h_s, y.data(), run.states.dydt.data());
        for (Contact<S>& contact : run.active.contacts)
          if (!contact.active) update_kinematics(run.bodies, run.proximity, contact);
      } else {
        update_active_kinematics(run.bodies, run.proximity, run.active, y.data(), y.version);
      }
    }
    return value_of(run.bodies, run.proximity, run.active, run.states, function, run.active.contacts[index]);
  }
};

// The theta in (0, high] where a function falls through zero, positive at 0 (else 0) and negative at high.
template <class S> S locate(SwitchValues<S>& values, SwitchingFunction function, int index, S f_low, S f_high, S high) {
  if (!(f_low > S(0))) return S(0);
  constexpr int max_iterations = 100;
  const BracketedRoot<S> root = false_position([&](S theta) { return -values.value(function, index, theta); }, S(0),
                                               -f_low, high, -f_high, real::epsilon<S>(), max_iterations);
  values.flow.report_search(root.evaluations, root.high - root.low, root.converged);
  return root.high;
}

template <class S> void search(SwitchValues<S>& values, SwitchingFunction function, Crossing<S>& first) {
  const EventRun<S>& run = values.flow.run;
  for (int i = 0; i < static_cast<int>(run.active.contacts.size()); ++i) {
    const Contact<S>& contact = run.active.contacts[i];
    if (contact.active == (function == SwitchingFunction::reactivation) || !applies(run.proximity, function, contact))
      continue;
    const S until = real::min(first.theta, S(1)), end = values.value(function, i, until);
    const bool bounded = depends_on_forces(function) && function != SwitchingFunction::reactivation;
    const S tiny = bounded ? -S(64) * real::epsilon<S>() * contact.largest_N : S(0);
    if (!(end < tiny)) continue;
    const S theta = locate(values, function, i, values.value(function, i, S(0)), end, until);
    if (theta <= S(1) && theta < first.theta) first = {theta, function, contact.candidate};
  }
}

// ---- the kink of quadratic drag -------------------------------------------------------------------------------------
template <class S> Vec3<S> relative_wind(const Bodies<S>& bodies, const DragBody<S>& wind, const S* y) {
  return load3(y + bodies.model.offset(wind.body) + kAtVelocity) - wind.velocity_W;
}

}  // namespace

template <class S> void locate_impact(Flow<S>& flow, Crossing<S>& first) {
  EventRun<S>& run = flow.run;
  for (const int p : run.proximity.near) {
    const ShapePair<S>& pair = run.proximity.pairs[p];
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      const Candidate<S>& candidate = run.proximity.candidates[f];
      if (candidate.in_contact || (candidate.gap > S(0) && candidate.gap_end > S(0) && candidate.rate_end <= S(0)))
        continue;
      const S theta = candidate.feature.edge ? impact_theta_of_edges(flow, candidate) : impact_theta(flow, candidate);
      if (theta <= S(1) && theta < first.theta && !leaves_face_at(flow, candidate, theta))
        first = {theta, SwitchingFunction::gap, f};
    }
  }
}

template <class S> void locate_mode_change(Flow<S>& flow, Crossing<S>& first) {
  const EventRun<S>& run = flow.run;
  SwitchValues<S> values{flow};
  if (run.active.force_near_bound)
    for (const SwitchingFunction function :
         {SwitchingFunction::normal_force, SwitchingFunction::friction_cone, SwitchingFunction::rolling_bound})
      search(values, function, first);
  if (run.active.count < static_cast<int>(run.active.contacts.size()))
    search(values, SwitchingFunction::reactivation, first);
  for (const SwitchingFunction function :
       {SwitchingFunction::slip_reversal, SwitchingFunction::rolling_reversal, SwitchingFunction::facet})
    search(values, function, first);
}

// Where a body's relative wind has turned by a right angle since the start of the step. Steps end there: across the
// kink of |u| u no method is of more than third order.
template <class S> void locate_zero_wind(Flow<S>& flow, Crossing<S>& first) {
  constexpr int max_iterations = 60;
  EventRun<S>& run = flow.run;
  for (std::size_t i = 0; i < run.drag_bodies.size(); ++i) {
    const DragBody<S>& wind = run.drag_bodies[i];
    const Vec3<S> u0 = relative_wind(run.bodies, wind, run.states.y.data()),
                  u1 = relative_wind(run.bodies, wind, run.states.y_new.data());
    const S tiny = S(1024) * real::epsilon<S>(), f_low = dot(u0, u0), f_high = dot(u0, u1);
    if (!(f_high < S(0)) || f_low < tiny * tiny * dot(u1, u1)) continue;
    const S round_off = real::epsilon<S>() * f_low;
    const auto against_first = [&](S theta) {
      const S f = dot(u0, relative_wind(run.bodies, wind, flow.at(theta).data()));
      return real::abs(f) <= round_off ? S(0) : -f;
    };
    const BracketedRoot<S> root =
        false_position(against_first, S(0), -f_low, S(1), -f_high, real::epsilon<S>(), max_iterations);
    flow.report_search(root.evaluations, root.high - root.low, root.converged);
    if (root.high < S(1) && root.high < first.theta)
      first = {root.high, SwitchingFunction::zero_wind, static_cast<int>(i)};
  }
}

template <class S> bool check_boundaries(Flow<S>& flow, Crossing<S>& first) {
  EventRun<S>& run = flow.run;
  if (run.proximity.boundaries.empty()) return true;
  const S until = real::min(first.theta, S(1));
  const bool whole = until >= S(1);
  const int samples =
      may_cross_boundary(run.bodies, run.proximity, run.states.y.data(), run.states.y_new.data()) ? 32 : 1;
  for (int k = 1; k <= samples; ++k) {
    const State<S>& y = k == samples ? (whole ? run.states.y_new : flow.at(until)) : flow.at(until * S(k) / S(samples));
    if (!clear_of_boundaries(run.bodies, run.proximity, run.active, run.report, y.data()))
      return locate_penetration(flow, until * S(k - 1) / S(samples), until * S(k) / S(samples), first);
  }
  return true;
}

template <class S> bool check_other_facets(Flow<S>& flow, const Crossing<S>& first) {
  EventRun<S>& run = flow.run;
  const S until = real::min(first.theta, S(1));
  for (const Contact<S>& contact : run.active.contacts) {
    const Candidate<S>& candidate = run.proximity.candidates[contact.candidate];
    if (!has_concave_edges(run.proximity.surfaces[candidate.surface])) continue;
    // Often enough that the sphere cannot pass a facet unseen.
    const auto apart = [&](const State<S>& y) {
      return pose_of(run.bodies, candidate.feature_body, y.data()).p -
             pose_of(run.bodies, candidate.surface_body, y.data()).p;
    };
    const S parts = S(4) * norm(apart(run.states.y_new) - apart(run.states.y)) / candidate.feature.radius;
    const int samples = 1 + static_cast<int>(real::min(parts, S(255)));
    for (int k = 1; k <= samples; ++k) {
      const S theta = until * S(k) / S(samples);
      const State<S>& y = theta < S(1) ? flow.at(theta) : run.states.y_new;
      if (!overlaps_other_facet(run.bodies, run.proximity, contact, y.data())) continue;
      return refuse_at(run.report, static_cast<double>(flow.t_s + theta * flow.h_s),
                       run.proximity.pairs[candidate.pair].boundary_refusal);
    }
  }
  return true;
}

#define ATWOOD_EVENT_LOCATION(S)                                     \
  template void locate_impact<S>(Flow<S>&, Crossing<S>&);            \
  template void locate_mode_change<S>(Flow<S>&, Crossing<S>&);       \
  template bool check_other_facets<S>(Flow<S>&, const Crossing<S>&); \
  template void locate_zero_wind<S>(Flow<S>&, Crossing<S>&);         \
  template bool check_boundaries<S>(Flow<S>&, Crossing<S>&);
ATWOOD_EVENT_LOCATION(float)
ATWOOD_EVENT_LOCATION(double)
ATWOOD_EVENT_LOCATION(long double)
#undef ATWOOD_EVENT_LOCATION

}  // namespace atwood::event
