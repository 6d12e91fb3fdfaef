#include "fluid/body_overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "collision/contacts.hpp"
#include "fluid/particle_set.hpp"
#include "protocol/sample.hpp"

namespace atwood::fluid {
namespace {

template <class S> Vec3<double> in_double(const Vec3<S>& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
template <class S> Quat<double> in_double(const Quat<S>& q) {
  return {static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z)};
}

std::string three_digits(double x) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g", x);
  return digits;
}

bool is_plane(const Geometry<double>& shape) { return shape.kind == ShapeKind::plane; }

}  // namespace

template <class S>
BodyOverlaps<S>::BodyOverlaps(const Scene& scene, const RigidModel<S>& bodies) : scene_(scene), bodies_(bodies) {
  shapes_.resize(scene.bodies.size());
  poses_.resize(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (std::holds_alternative<std::monostate>(body.shape)) continue;
    shapes_[i] = make_geometry<double>(body.shape);
    const Real4& q = body.orientation_wxyz;
    poses_[i] = transform(narrow3<double>(body.position_m), Quat<double>{q[0], q[1], q[2], q[3]});
    all_.push_back(static_cast<int>(i));
    if (!body.fixed) moving_.push_back(static_cast<int>(i));
  }
  for (const Joint& joint : scene.joints)
    if (joint.parent >= 0) joined_.push_back(std::minmax(joint.parent, joint.child));
  std::sort(joined_.begin(), joined_.end());
  std::set<std::pair<ShapeKind, ShapeKind>> tested;
  for (const int a : moving_)
    for (const int b : all_) {
      if (a == b || !tested.emplace(shapes_[a].kind, shapes_[b].kind).second) continue;
      if (const char* missing = missing_contact_test(shapes_[a].kind, shapes_[b].kind)) {
        unsupported_ = "contact between bodies is not part of +sph, and whether " + name(a) + " and " + name(b) +
                       " overlap has no test (" + missing + ")";
        return;
      }
    }
  if (const Overlap overlap = first_overlap(); overlap.a >= 0)
    unsupported_ = "contact between bodies is not part of +sph, and " + name(overlap.a) + " and " + name(overlap.b) +
                   " overlap at the start, by " + three_digits(overlap.depth_m) + " m at " + place_words(overlap);
}

template <class S> std::string BodyOverlaps<S>::found(S t_s, const S* y) {
  if (moving_.empty()) return "";
  place(t_s, y);
  const Overlap overlap = first_overlap();
  if (overlap.a < 0) return "";
  return name(overlap.a) + " ran into " + name(overlap.b) + " (contact between bodies is not part of +sph) at " +
         place_words(overlap);
}

template <class S> void BodyOverlaps<S>::place(S t_s, const S* y) {
  const Motion<S> motion = bodies_.motion(t_s, y);
  for (const int b : moving_) poses_[b] = transform(in_double(motion.p_WB(b)), in_double(motion.q_WB(b)));
}

template <class S> auto BodyOverlaps<S>::first_overlap() const -> Overlap {
  for (const int a : moving_)
    for (const int b : all_) {
      if (a == b || (b < a && !scene_.bodies[b].fixed)) continue;  // two that move: once
      if (const Overlap overlap = overlap_of(a, b); overlap.a >= 0) return overlap;
    }
  return {};
}

// The images of b along the periodic axes whose bounding spheres can touch that of a.
template <class S> auto BodyOverlaps<S>::overlap_of(int a, int b) const -> Overlap {
  constexpr double most_images = 3;  // to either side
  Overlap found;
  if (std::binary_search(joined_.begin(), joined_.end(), std::pair<int, int>(std::minmax(a, b)))) return found;
  const Geometry<double>&of_a = shapes_[a], &of_b = shapes_[b];
  if (is_plane(of_a) || is_plane(of_b)) {
    overlap_at(a, b, {}, found);
    return found;
  }
  const double reach = (of_a.bounding_radius + of_b.bounding_radius) * (1 + 1e-9);
  const Vec3<double> apart = poses_[b].p_W - poses_[a].p_W;
  const double along[3] = {apart.x, apart.y, apart.z};
  const Real3& period = scene_.domain.periodic_m;
  double nearest2 = 0, to_nearest[3]{};
  int first[3]{}, last[3]{};
  for (int c = 0; c < 3; ++c) {
    const double nearest = period[c] > 0 ? std::remainder(along[c], period[c]) : along[c];
    nearest2 += nearest * nearest;
    if (!(period[c] > 0)) continue;
    to_nearest[c] = nearest - along[c];
    first[c] = static_cast<int>(std::max(-most_images, std::ceil((-reach - nearest) / period[c])));
    last[c] = static_cast<int>(std::min(most_images, std::floor((reach - nearest) / period[c])));
  }
  if (nearest2 > reach * reach) return found;
  for (int i = first[0]; i <= last[0]; ++i)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int k = first[2]; k <= last[2]; ++k)
        if (overlap_at(a, b,
                       {to_nearest[0] + i * period[0], to_nearest[1] + j * period[1], to_nearest[2] + k * period[2]},
                       found))
          return found;
  return found;
}

template <class S> bool BodyOverlaps<S>::overlap_at(int a, int b, const Vec3<double>& shift, Overlap& found) const {
  Transform<double> pose = poses_[b];
  pose.p_W = pose.p_W + shift;
  const Separation<double> apart = separation(shapes_[a], poses_[a], shapes_[b], pose);
  // Rounding of the state in the scalar of the run, of which a shape of double precision knows nothing.
  const double units = std::max(1.0, static_cast<double>(real::epsilon<S>()) / real::epsilon<double>());
  const double round_off = units * touch_round_off(shapes_[a], poses_[a].p_W, shapes_[b], pose.p_W);
  if (!(apart.gap < -round_off)) return false;
  found = {a, b, -apart.gap, 0.5 * (apart.on_a_W + apart.on_b_W)};
  return true;
}

template <class S> std::string BodyOverlaps<S>::name(int body) const {
  const auto& boundaries = scene_.fluid_boundaries;
  const bool wall = scene_.bodies[body].fixed && std::any_of(boundaries.begin(), boundaries.end(),
                                                             [&](const auto& one) { return one.body == body; });
  return (wall ? "the boundary `" : "the body `") + scene_.bodies[body].name + "`";
}

template <class S> std::string BodyOverlaps<S>::place_words(const Overlap& overlap) const {
  const double x[3] = {overlap.at_W.x, overlap.at_W.y, overlap.at_W.z};
  return position_text(x, scene_.domain.dimensions);
}

template class BodyOverlaps<float>;
template class BodyOverlaps<double>;
template class BodyOverlaps<long double>;
template class BodyOverlaps<Quad>;

}  // namespace atwood::fluid
