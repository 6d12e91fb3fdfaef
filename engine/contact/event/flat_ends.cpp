#include "contact/event/flat_ends.hpp"

#include <algorithm>

namespace atwood::event {

namespace {

// The part of the face's normal across the circle's axis: its length is the sine of their angle.
template <class S>
Vec3<S> tilt_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                const Vec3<S>& facet_direction_B, const S* y) {
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  const Vec3<S> axis = to_world(pose_of(bodies, candidate.feature_body, y), candidate.feature.axis_B);
  const Vec3<S> n = surface.kind == SurfaceKind::plane
                        ? surface.normal_W
                        : to_world(pose_of(bodies, candidate.surface_body, y), facet_direction_B);
  return n - dot(n, axis) * axis;
}

// Does the centre stand for the circle? See flat_ends.hpp.
template <class S>
bool acts_at_centre(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                    const Vec3<S>& tilt, const S* y) {
  if (norm(tilt) > tilt_round_off<S>()) return false;
  const Pose<S> of = pose_of(bodies, candidate.feature_body, y), on = pose_of(bodies, candidate.surface_body, y);
  const Vec3<S> axis = to_world(of, candidate.feature.axis_B), center = of.p + to_world(of, candidate.feature.center_B);
  const Vec3<S> w = of.w - on.w, over = w - dot(w, axis) * axis;
  const S tiny = bodies.slip_round_off(), radius = candidate.feature.radius;
  if (radius * norm(over) > tiny) return false;
  if (!(proximity.pairs[candidate.pair].friction > S(0))) return true;
  const Vec3<S> u = of.v + cross(of.w, center - of.p) - on.v - cross(on.w, center - on.p);
  return radius * norm(w) <= tiny && norm(u - dot(u, axis) * axis) <= tiny;
}

// Below this sine round-off decides which point of the circle is lowest.
template <class S> bool is_flat(const Vec3<S>& tilt) { return norm(tilt) <= least_crossing_sine<S>(); }

template <class S>
bool refuse_candidate(EventRun<S>& run, const Candidate<S>& candidate, const Vec3<S>& facet_direction_B, S t_s) {
  if (!candidate.feature.circle) return true;
  const S* y = run.states.y.data();
  const Vec3<S> tilt = tilt_of(run.bodies, run.proximity, candidate, facet_direction_B, y);
  if (!is_flat(tilt) || acts_at_centre(run.bodies, run.proximity, candidate, tilt, y)) return true;
  return refuse_at(run.report, static_cast<double>(t_s), run.proximity.pairs[candidate.pair].flat_end_refusal);
}

// Of an active contact: does it pass through flat between two states, or has it come to lie flat?
template <class S> bool passes_through_flat(const Vec3<S>& tilt, const Vec3<S>& next) {
  return is_flat(next) || dot(tilt, next) < S(0);
}

}  // namespace

template <class S> bool refuse_flat_ends(EventRun<S>& run, S t_s) {
  if (!run.proximity.has_circles) return true;
  for (const ImpactPoint<S>& point : run.impacts.points) {
    if (!(point.kinematics.rate < -run.bodies.approach_round_off())) continue;
    const Candidate<S>& candidate = run.proximity.candidates[point.candidate];
    const Vec3<S> n_B =
        to_body(pose_of(run.bodies, candidate.surface_body, run.states.y.data()), point.kinematics.normal);
    if (!refuse_candidate(run, candidate, n_B, t_s)) return false;
  }
  for (const Contact<S>& contact : run.active.contacts)
    if (contact.active &&
        !refuse_candidate(run, run.proximity.candidates[contact.candidate], contact.facet.direction_B, t_s))
      return false;
  return true;
}

template <class S> bool check_flat_ends(Flow<S>& flow, const Crossing<S>& first) {
  EventRun<S>& run = flow.run;
  if (!run.proximity.has_circles) return true;
  constexpr int max_samples = 32;  // of a step in which the tilt turns by more than a right angle
  const S until = real::min(first.theta, S(1));
  const auto state_at = [&](S theta) -> const State<S>& { return theta < S(1) ? flow.at(theta) : run.states.y_new; };
  for (const Contact<S>& contact : run.active.contacts) {
    const Candidate<S>& candidate = run.proximity.candidates[contact.candidate];
    if (!contact.active || !candidate.feature.circle) continue;
    const auto lean_at = [&](const S* y) {
      return tilt_of(run.bodies, run.proximity, candidate, contact.facet.direction_B, y);
    };
    const Vec3<S> start = lean_at(run.states.y.data()), end = lean_at(state_at(until).data());
    S ended = S(2);
    if (is_flat(start)) {  // the centre stood for the circle so far
      if (!acts_at_centre(run.bodies, run.proximity, candidate, end, state_at(until).data())) ended = until;
    } else if (passes_through_flat(start, end)) {
      Vec3<S> last = start;
      for (int k = 1; k <= max_samples && ended > S(1); ++k) {
        const S theta = until * S(k) / S(max_samples);
        const Vec3<S> next = lean_at(state_at(theta).data());
        if (passes_through_flat(last, next)) ended = theta;
        last = next;
      }
    }
    if (ended <= S(1))
      return refuse_at(run.report, static_cast<double>(flow.t_s + ended * flow.h_s),
                       run.proximity.pairs[candidate.pair].flat_end_refusal);
  }
  return true;
}

#define ATWOOD_FLAT_ENDS(S)                           \
  template bool refuse_flat_ends<S>(EventRun<S>&, S); \
  template bool check_flat_ends<S>(Flow<S>&, const Crossing<S>&);
ATWOOD_FLAT_ENDS(float)
ATWOOD_FLAT_ENDS(double)
ATWOOD_FLAT_ENDS(long double)
#undef ATWOOD_FLAT_ENDS

}  // namespace atwood::event
