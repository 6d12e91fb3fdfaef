// Adaptive steps that do not pass over a compliant contact.
#include <algorithm>
#include <limits>

#include "contact/penalty_force.hpp"
#include "scene/joined.hpp"

namespace atwood {

// The gap of two bodies at `places`; infinite where it is above `margin`.
template <class S> S PenaltyForce<S>::least_gap(int a, int b, const std::vector<Transform<S>>& places, S margin) {
  manifolds_.clear();
  find_contacts(shapes_[a], places[a], shapes_[b], places[b], margin, manifolds_);
  S least = std::numeric_limits<S>::infinity();
  for (const Manifold<S>& manifold : manifolds_)
    for (int i = 0; i < manifold.count; ++i) least = real::min(least, manifold.points[i].gap);
  return least;
}

// With the relative speed V and acceleration A of two bodies a gap g lasts at least until V t + A t^2 / 2 = g. Steps up
// to there pass over nothing. Once that is within 1 / (16 w) of the stiffest contact, such steps are allowed, in which
// missed_contact() looks for contacts.
template <class S>
S PenaltyForce<S>::longest_step(const Motion<S>& motion, const std::vector<Vec3<S>>& acceleration_W, S step_s) {
  if (near_s_ == S(0)) near_s_ = S(0.0625) / S(stiffest().angular_frequency_rad_per_s);
  places_.resize(shapes_.size());
  start_.resize(shapes_.size());
  items_.clear();
  may_touch_.clear();
  const auto turning = [&](int body) {
    const S rate = norm(start_[body].w_B);
    return rate > S(0) ? rate * shapes_[body].bounding_radius : S(0);
  };
  for (const auto* list : {&bounded_, &planes_})
    for (const int body : *list) {
      start_[body] = {motion.p_WB(body), motion.v_WB(body), motion.w_WB_B(body), motion.q_WB(body),
                      moving(motion, body)};
      if (!start_[body].moves) start_[body].v_W = start_[body].w_B = {};
      places_[body] = transform(start_[body].p_W, start_[body].q_WB);
    }
  for (const int body : bounded_) {
    const S reach = (norm(start_[body].v_W) + turning(body)) * step_s +
                    (start_[body].moves ? norm(acceleration_W[body]) * step_s * step_s / S(2) : S(0));
    const double way = 1.000001 * static_cast<double>(reach);
    Aabb<double> box;
    const Aabb<S> own = bounds(shapes_[body], places_[body]);
    box.low = {static_cast<double>(own.low.x) - way, static_cast<double>(own.low.y) - way,
               static_cast<double>(own.low.z) - way};
    box.high = {static_cast<double>(own.high.x) + way, static_cast<double>(own.high.y) + way,
                static_cast<double>(own.high.z) + way};
    const Vec3<S>& p = places_[body].p_W;
    items_.push_back({box,
                      {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)},
                      1.000001 * static_cast<double>(shapes_[body].bounding_radius) + way,
                      start_[body].moves});
  }
  broad_->find(items_, near_);
  S longest = step_s;
  const auto limit = [&](int a, int b) {
    if (!start_[a].moves && !start_[b].moves) return;
    if (!scene_.joints.empty() && joined(scene_, a, b)) return;
    const auto pull = [&](int body) { return start_[body].moves ? acceleration_W[body] : Vec3<S>{}; };
    const S speed = norm(start_[a].v_W - start_[b].v_W) + turning(a) + turning(b), grows = norm(pull(a) - pull(b));
    const S gap = least_gap(a, b, places_, longest * (speed + grows * longest / S(2)));
    if (!(gap > S(0))) {  // the steps' errors show the force, but of a contact that begins or ends it is small
      if (!(-gap < speed * near_s_)) return;
      may_touch_.push_back({a, b});
      longest = real::min(longest, near_s_);
      return;
    }
    if (gap == std::numeric_limits<S>::infinity()) return;
    const S apart_s = S(2) * gap / (speed + real::sqrt(speed * speed + S(2) * grows * gap));
    if (!(apart_s < longest)) return;
    if (apart_s <= near_s_) may_touch_.push_back({a, b});
    longest = real::min(longest, real::max(apart_s, near_s_));
  };
  for (const auto& [i, j] : std::vector<BodyPair>(near_)) limit(bounded_[i], bounded_[j]);
  for (const int plane : planes_)
    for (const int body : bounded_) limit(std::min(body, plane), std::max(body, plane));
  return longest;
}

template <class S> S PenaltyForce<S>::missed_contact(const Motion<S>& motion, S step_s) {
  constexpr int parts = 16, refinements = 40;
  S until_s = step_s;
  if (may_touch_.empty()) return until_s;
  std::vector<BodyMotion> end(start_.size());
  for (const auto* list : {&bounded_, &planes_})
    for (const int body : *list) {
      end[body] = {motion.p_WB(body), motion.v_WB(body), motion.w_WB_B(body), motion.q_WB(body), start_[body].moves};
      if (!end[body].moves) end[body].v_W = {};
    }
  between_ = places_;
  between_.resize(start_.size());
  for (const auto& [first, second] : may_touch_) {
    const int a = first, b = second;
    S way{};
    // Cubic Hermite paths of the bodies' origins; attitudes change evenly.
    const auto gap = [&](S part) {
      for (const int body : {a, b}) {
        const BodyMotion &x = start_[body], &y = end[body];
        const S back = part - S(1);
        const Vec3<S> rise = y.p_W - x.p_W;
        const Vec3<S> bend = (S(1) - S(2) * part) * rise + step_s * (back * x.v_W + part * y.v_W);
        const Quat<S>&p = x.q_WB, &q = y.q_WB;
        const S sign = p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z < S(0) ? S(-1) : S(1);
        Quat<S> turned = p;
        turned.w += part * (sign * q.w - p.w);
        turned.x += part * (sign * q.x - p.x);
        turned.y += part * (sign * q.y - p.y);
        turned.z += part * (sign * q.z - p.z);
        const S size =
            real::sqrt(turned.w * turned.w + turned.x * turned.x + turned.y * turned.y + turned.z * turned.z);
        turned.w /= size, turned.x /= size, turned.y /= size, turned.z /= size;
        between_[body] = transform(x.p_W + part * rise + (part * back) * bend, turned);
      }
      return least_gap(a, b, between_, way);
    };
    way = S(2) * step_s * real::max(norm(start_[a].v_W - start_[b].v_W), norm(end[a].v_W - end[b].v_W));
    if (!(gap(S(1)) > S(0))) continue;  // the end of the step shows the force
    int lowest = 0;
    S least = std::numeric_limits<S>::infinity();
    for (int k = 1; k < parts; ++k)
      if (const S now = gap(S(k) / S(parts)); now < least) least = now, lowest = k;
    if (lowest == 0) continue;
    S low = S(lowest - 1) / S(parts), high = S(lowest + 1) / S(parts);
    for (int k = 0; k < refinements; ++k) {
      const S third = (high - low) / S(3);
      if (gap(low + third) < gap(high - third)) high -= third;
      else low += third;
    }
    const S deepest = low + (high - low) / S(2);
    // A contact that is there at the start and ends is none that was passed over, unless it grows first.
    const S at_start = real::min(gap(S(0)), S(0));
    if (gap(deepest) < S(1.1) * at_start) until_s = real::min(until_s, deepest * step_s);
  }
  return until_s;
}

#define ATWOOD_PENALTY_STEPS(S)                                                               \
  template S PenaltyForce<S>::least_gap(int, int, const std::vector<Transform<S>>&, S);       \
  template S PenaltyForce<S>::longest_step(const Motion<S>&, const std::vector<Vec3<S>>&, S); \
  template S PenaltyForce<S>::missed_contact(const Motion<S>&, S);
ATWOOD_PENALTY_STEPS(float)
ATWOOD_PENALTY_STEPS(double)
ATWOOD_PENALTY_STEPS(long double)
#undef ATWOOD_PENALTY_STEPS

}  // namespace atwood
