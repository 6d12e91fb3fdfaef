// Which pairs of bodies to look at in a step, and how far apart their features are at both of its ends.
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

constexpr int kFewPairs = 3;  // up to here all pairs are looked at in every step

// No farther than the hull of the cubic through both ends.
template <class S> S excursion(const EventRun<S>& run, int body, S h_s) {
  const int offset = run.model.offset(body);
  if (offset < 0 || !run.moves[body]) return S(0);
  const S *from = run.y.data() + offset, *to = run.y_new.data() + offset;
  const S end = norm(load3(to + kAtPosition) - load3(from + kAtPosition)) + h_s / S(3) * norm(load3(to + kAtVelocity));
  return real::max(end, h_s / S(3) * norm(load3(from + kAtVelocity)));
}

template <class S> Vec3<S> center(const EventRun<S>& run, int body, const S* y) {
  const int offset = run.model.offset(body);
  return offset < 0 ? run.poses[body].p : load3(y + offset);
}

// Between the bounding spheres (or from one to the plane).
template <class S> S clearance(const EventRun<S>& run, const ShapePair<S>& pair, const S* y) {
  if (pair.plane >= 0) {
    const Surface<S>& plane = run.surfaces[pair.plane];
    return dot(plane.normal_W, center(run, pair.plane_is_a ? pair.b : pair.a, y)) - plane.offset - pair.reach;
  }
  return norm(center(run, pair.b, y) - center(run, pair.a, y)) - pair.reach;
}

template <class S> bool refuse_if_near(EventRun<S>& run, const ShapePair<S>& pair, S clear) {
  if (pair.refused.empty() || clear > S(0)) return true;
  run.outcome = {Status::unsupported, pair.refused, 0, 0, {}};
  return false;
}

// Gaps and rates at `y` of those of a pair's features [feature, end) that do not last.
template <class S>
void measure(EventRun<S>& run, Feature<S>* feature, const Feature<S>* end, const S* y, S Feature<S>::*gap,
             S Feature<S>::*rate) {
  bool posed = false;
  for (; feature != end; ++feature) {
    if (feature->lasting) continue;
    const bool axes = needs_axes(run, *feature);
    if (axes && !posed) pose_bodies(run, *feature, y);
    posed = posed || axes;
    const Surface<S>& surface = run.surfaces[feature->surface];
    if (axes && surface.kind == SurfaceKind::plane && !feature->knob.rim) {  // of many corners: no more than is asked
      const Pose<S>& pose = run.poses[feature->knob_body];
      const Vec3<S> arm = turned(pose, feature->knob.center_B);
      feature->*gap = dot(surface.normal_W, pose.p + arm) - surface.offset - feature->knob.radius;
      feature->*rate = dot(surface.normal_W, pose.v + cross(pose.w, arm));
      continue;
    }
    const Sight<S> sight = axes ? posed_sight(run, *feature) : sight_of_ball(run, *feature, y);
    feature->*gap = sight.gap;
    feature->*rate = sight.rate;
  }
}

}  // namespace

template <class S> bool find_near(EventRun<S>& run, S h_s) {
  run.near.clear();
  const int count = static_cast<int>(run.pairs.size());
  const bool few = count <= kFewPairs;
  if (!few)
    for (std::size_t i = 0; i < run.reach.size(); ++i) run.excursions[i] = excursion(run, static_cast<int>(i), h_s);
  for (int p = 0; p < count; ++p) {
    ShapePair<S>& pair = run.pairs[p];
    if (few && pair.refused.empty()) {
      run.near.push_back(p);
      continue;
    }
    const S so_far = run.travel[pair.a] + run.travel[pair.b];
    const S in_step = few ? excursion(run, pair.a, h_s) + excursion(run, pair.b, h_s)
                          : run.excursions[pair.a] + run.excursions[pair.b];
    if (!few && so_far + in_step < pair.look_again_at) continue;
    const S clear = clearance(run, pair, run.y.data());
    pair.look_again_at = so_far + clear - run.gap_round_off();
    if (in_step < clear - run.gap_round_off()) continue;
    if (!refuse_if_near(run, pair, real::min(clear, clearance(run, pair, run.y_new.data())))) return false;
    if (pair.refused.empty()) run.near.push_back(p);
  }
  return true;
}

template <class S> void advance_travel(EventRun<S>& run) {
  if (static_cast<int>(run.pairs.size()) <= kFewPairs) return;
  for (std::size_t i = 0; i < run.travel.size(); ++i)
    run.travel[i] += run.excursions[i];  // of the whole step: bounds a part's
}

// Lasting contacts are not looked at: their gaps are held.
template <class S> void measure_gaps(EventRun<S>& run) {
  for (const int p : run.near) {
    ShapePair<S>& pair = run.pairs[p];
    Feature<S>* feature = run.features.data() + pair.first;
    Feature<S>* const end = feature + pair.count;
    while (feature != end && feature->lasting) ++feature;
    if (feature != end) {
      if (pair.known_at != run.step_count)
        measure(run, feature, end, run.y.data(), &Feature<S>::gap, &Feature<S>::rate);
      measure(run, feature, end, run.y_new.data(), &Feature<S>::gap_end, &Feature<S>::rate_end);
    }
    pair.known_at = run.step_count;
  }
}

// The step's end is the next one's start.
template <class S> void pass_gaps_on(EventRun<S>& run) {
  ++run.step_count;
  for (const int p : run.near) {
    ShapePair<S>& pair = run.pairs[p];
    pair.known_at = run.step_count;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      run.features[f].gap = run.features[f].gap_end;
      run.features[f].rate = run.features[f].rate_end;
    }
  }
}

#define ATWOOD_NEAR(S)                           \
  template bool find_near<S>(EventRun<S>&, S);   \
  template void advance_travel<S>(EventRun<S>&); \
  template void measure_gaps<S>(EventRun<S>&);   \
  template void pass_gaps_on<S>(EventRun<S>&);
ATWOOD_NEAR(float)
ATWOOD_NEAR(double)
ATWOOD_NEAR(long double)
#undef ATWOOD_NEAR

}  // namespace atwood::event
