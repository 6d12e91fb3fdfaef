// Pairs that may touch within a step, by bounding spheres and path lengths, and the gaps of their candidates.
#include "contact/event/proximity.hpp"

#include "contact/event/report.hpp"
#include "protocol/refusal.hpp"

namespace atwood::event {

namespace {

constexpr int kMaxPairsWithoutBroadPhase = 3;  // with at most this many pairs all of them are examined in every step

// A bound of a body's path in the trial step: of the cubic Hermite interpolant by its control polygon.
template <class S> S path_bound(const Bodies<S>& bodies, const StateBuffers<S>& states, int body, S h_s) {
  const int offset = bodies.model.offset(body);
  if (offset < 0 || !bodies.moves[body]) return S(0);
  const S *from = states.y.data() + offset, *to = states.y_new.data() + offset;
  const S end = norm(load3(to + kAtPosition) - load3(from + kAtPosition)) + h_s / S(3) * norm(load3(to + kAtVelocity));
  return real::max(end, h_s / S(3) * norm(load3(from + kAtVelocity)));
}

template <class S> Vec3<S> center(const Bodies<S>& bodies, int body, const S* y) {
  const int offset = bodies.model.offset(body);
  return offset < 0 ? bodies.poses[body].p : load3(y + offset);
}

// The distance between the bounding spheres, or from one to the plane.
template <class S>
S clearance(const Bodies<S>& bodies, const Proximity<S>& proximity, const ShapePair<S>& pair, const S* y) {
  if (pair.plane >= 0) {
    const Surface<S>& plane = proximity.surfaces[pair.plane];
    return dot(plane.normal_W, center(bodies, pair.plane_is_a ? pair.b : pair.a, y)) - plane.offset -
           pair.bounding_radii;
  }
  return norm(center(bodies, pair.b, y) - center(bodies, pair.a, y)) - pair.bounding_radii;
}

template <class S> bool refuse_if_near(Report& report, const ShapePair<S>& pair, S clear) {
  if (pair.refusal.empty() || clear > S(0)) return true;
  report.outcome = refused(pair.refusal);
  return false;
}

// Gaps and rates at `y` of the candidates [candidate, end) that are not in contact.
template <class S>
void measure(Bodies<S>& bodies, const Proximity<S>& proximity, Candidate<S>* candidate, const Candidate<S>* end,
             const S* y, S Candidate<S>::*gap, S Candidate<S>::*rate) {
  bool posed = false;
  for (; candidate != end; ++candidate) {
    if (candidate->in_contact) continue;
    const bool axes = needs_orientation(proximity, *candidate);
    if (axes && !posed) update_poses(bodies, *candidate, y);
    posed = posed || axes;
    const Surface<S>& surface = proximity.surfaces[candidate->surface];
    if (axes && surface.kind == SurfaceKind::plane &&
        !candidate->feature.circle) {  // a vertex over a plane, by far the most frequent case
      const Pose<S>& pose = bodies.poses[candidate->feature_body];
      const Vec3<S> arm = to_world(pose, candidate->feature.center_B);
      candidate->*gap = dot(surface.normal_W, pose.p + arm) - surface.offset - candidate->feature.radius;
      candidate->*rate = dot(surface.normal_W, pose.v + cross(pose.w, arm));
      continue;
    }
    const GapKinematics<S> kinematics =
        axes ? gap_from_poses(bodies, proximity, *candidate) : sphere_gap(bodies, proximity, *candidate, y);
    candidate->*gap = kinematics.gap;
    candidate->*rate = kinematics.rate;
  }
}

}  // namespace

template <class S>
bool find_near(const Bodies<S>& bodies, Proximity<S>& proximity, const StateBuffers<S>& states, Report& report, S h_s) {
  proximity.near.clear();
  const int count = static_cast<int>(proximity.pairs.size());
  const bool examines_all = count <= kMaxPairsWithoutBroadPhase;
  if (!examines_all)
    for (std::size_t i = 0; i < bodies.bounding_radius.size(); ++i)
      proximity.path_bounds[i] = path_bound(bodies, states, static_cast<int>(i), h_s);
  for (int p = 0; p < count; ++p) {
    ShapePair<S>& pair = proximity.pairs[p];
    if (examines_all && pair.refusal.empty()) {
      proximity.near.push_back(p);
      continue;
    }
    const S so_far = proximity.path_length[pair.a] + proximity.path_length[pair.b];
    const S in_step = examines_all ? path_bound(bodies, states, pair.a, h_s) + path_bound(bodies, states, pair.b, h_s)
                                   : proximity.path_bounds[pair.a] + proximity.path_bounds[pair.b];
    if (!examines_all && so_far + in_step < pair.travel_until_recheck) continue;
    const S clear = clearance(bodies, proximity, pair, states.y.data());
    pair.travel_until_recheck = so_far + clear - bodies.gap_round_off();
    if (in_step < clear - bodies.gap_round_off()) continue;
    if (!refuse_if_near(report, pair, real::min(clear, clearance(bodies, proximity, pair, states.y_new.data()))))
      return false;
    if (pair.refusal.empty()) proximity.near.push_back(p);
  }
  return true;
}

template <class S> void advance_path_lengths(Proximity<S>& proximity) {
  if (static_cast<int>(proximity.pairs.size()) <= kMaxPairsWithoutBroadPhase) return;
  for (std::size_t i = 0; i < proximity.path_length.size(); ++i)
    proximity.path_length[i] += proximity.path_bounds[i];  // of the whole trial step, which bounds that of a part
}

template <class S> void measure_gaps(Bodies<S>& bodies, Proximity<S>& proximity, const StateBuffers<S>& states) {
  for (const int p : proximity.near) {
    ShapePair<S>& pair = proximity.pairs[p];
    Candidate<S>* candidate = proximity.candidates.data() + pair.first;
    Candidate<S>* const end = candidate + pair.count;
    while (candidate != end && candidate->in_contact) ++candidate;
    if (candidate != end) {
      if (pair.gaps_segment != proximity.segment)
        measure(bodies, proximity, candidate, end, states.y.data(), &Candidate<S>::gap, &Candidate<S>::rate);
      measure(bodies, proximity, candidate, end, states.y_new.data(), &Candidate<S>::gap_end, &Candidate<S>::rate_end);
    }
    pair.gaps_segment = proximity.segment;
  }
}

template <class S> void shift_gaps(Proximity<S>& proximity) {
  ++proximity.segment;
  for (const int p : proximity.near) {
    ShapePair<S>& pair = proximity.pairs[p];
    pair.gaps_segment = proximity.segment;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      proximity.candidates[f].gap = proximity.candidates[f].gap_end;
      proximity.candidates[f].rate = proximity.candidates[f].rate_end;
    }
  }
}

#define ATWOOD_BROAD_PHASE(S)                                                                      \
  template bool find_near<S>(const Bodies<S>&, Proximity<S>&, const StateBuffers<S>&, Report&, S); \
  template void advance_path_lengths<S>(Proximity<S>&);                                            \
  template void measure_gaps<S>(Bodies<S>&, Proximity<S>&, const StateBuffers<S>&);                \
  template void shift_gaps<S>(Proximity<S>&);
ATWOOD_BROAD_PHASE(float)
ATWOOD_BROAD_PHASE(double)
ATWOOD_BROAD_PHASE(long double)
#undef ATWOOD_BROAD_PHASE

}  // namespace atwood::event
