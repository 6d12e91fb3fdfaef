#include "closed_form/obstacles.hpp"

#include <algorithm>

namespace atwood::closed_form {

namespace {

// The two faces orthogonal to axis k of the obstacle.
template <class S> void add_faces(Obstacle<S>& made, int k) {
  for (const int side : {1, -1}) {
    Face<S> face;
    face.n = S(side) * made.axis[k];
    face.center = made.center + (S(side) * made.half[k]) * made.axis[k];
    face.offset = dot(face.n, face.center);
    for (int i = 0; i < 2; ++i) {
      face.side[i] = made.axis[(k + 1 + i) % 3];
      face.half[i] = made.half[(k + 1 + i) % 3];
    }
    made.faces.push_back(face);
  }
}

template <class S> Vec<S> place(const Arc<S>& arc, S t) {
  const S since = t - arc.from;
  return arc.p + since * (arc.v + (since / 2) * arc.g);
}

}  // namespace

template <class S> bool add_obstacle(const Body& body, int at, std::vector<Obstacle<S>>& obstacles) {
  Obstacle<S> made;
  made.body = at;
  if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    Face<S> face;
    const Vec<S> normal = vec<S>(plane->normal);
    const S length = norm(normal);
    face.n = (1 / length) * normal;
    face.offset = S(plane->offset_m) / length;
    face.infinite = true;
    made.faces.push_back(face);
    obstacles.push_back(made);
    return true;
  }
  const auto* box = std::get_if<Box>(&body.shape);
  const auto* rectangle = std::get_if<Rectangle>(&body.shape);
  if (box == nullptr && rectangle == nullptr) return false;
  const Pose<S> pose = initial_pose<S>(body);
  made.center = pose.p_WB;
  for (int k = 0; k < 3; ++k) {
    Vec<S> unit{};
    unit[k] = 1;
    made.axis[k] = rotate(pose.q_WB, unit);
    made.half[k] = box != nullptr ? S(box->half_extents_m[k]) : k < 2 ? S(rectangle->half_extents_m[k]) : S(0);
  }
  for (int k = 2; k >= (box != nullptr ? 0 : 2); --k) add_faces(made, k);
  obstacles.push_back(made);
  return true;
}

template <class S> S distance(const Obstacle<S>& obstacle, const Vec<S>& p) {
  if (obstacle.faces.front().infinite) return dot(obstacle.faces.front().n, p) - obstacle.faces.front().offset;
  Vec<S> beyond{};
  for (int k = 0; k < 3; ++k)
    beyond[k] = larger(S(0), magnitude(dot(obstacle.axis[k], p - obstacle.center)) - obstacle.half[k]);
  return norm(beyond);
}

template <class S> bool within_sides(const Face<S>& face, const Vec<S>& p) {
  for (int k = 0; k < 2 && !face.infinite; ++k)
    if (magnitude(dot(face.side[k], p - face.center)) > face.half[k]) return false;
  return true;
}

// The speed there is V with V^2 = u^2 + 2 a h; the root is computed without cancellation.
template <class S> S descent_time(S h, S u, S a, S contact_tolerance, S& speed) {
  if (magnitude(h) <= contact_tolerance) h = 0;
  const S square = u * u + 2 * a * h;
  if (!(square >= 0) || (!(a > 0) && !(u < 0)) || (h < 0 && !(u > 0))) return -1;
  speed = sqrt(square);
  if (u > 0) return larger(S(0), (u + speed) / a);
  return speed - u > 0 ? larger(S(0), 2 * h / (speed - u)) : S(0);
}

template <class S>
bool stays_positive(S start, S end, const std::function<S(S)>& gap, const std::function<S(S, S)>& way, S near) {
  std::vector<std::array<S, 2>> open{{start, end}};
  while (!open.empty()) {
    const auto [from, until] = open.back();
    open.pop_back();
    const S middle = from + (until - from) / 2, changes = way(from, until) / 2;
    if (gap(middle) > changes) continue;
    if (changes < near) return false;
    open.push_back({from, middle});
    open.push_back({middle, until});
  }
  return true;
}

template <class S> bool stays_clear(const Arc<S>& arc, S clearance, const std::function<S(const Vec<S>&)>& distance) {
  const auto way = [&](S from, S until) {
    const S v0 = norm(arc.v + (from - arc.from) * arc.g),
            v1 = norm(arc.v + (until - arc.from) * arc.g);  // |v| is convex
    return larger(v0, v1) * (until - from);
  };
  return stays_positive<S>(
      arc.from, arc.until, [&](S t) { return distance(place(arc, t)) - clearance; }, way, S(1e-9) * clearance);
}

template <class S> bool may_meet_edge(const Obstacle<S>& obstacle, S radius, const Arc<S>& arc) {
  for (const Face<S>& face : obstacle.faces) {
    if (face.infinite) continue;
    const S height = dot(face.n, arc.p) - face.offset;
    S wait = 0, speed{};
    if (height >= radius || height < 0)
      wait = descent_time<S>(height - radius, dot(face.n, arc.v), -dot(face.n, arc.g), S(0), speed);
    if (wait < 0 || !(arc.from + wait < arc.until) || within_sides(face, place(arc, arc.from + wait))) continue;
    Arc<S> low{arc.from + wait, arc.until, place(arc, arc.from + wait), arc.v + wait * arc.g, arc.g};
    if (!stays_clear<S>(low, radius, [&](const Vec<S>& p) { return distance(obstacle, p); })) return true;
  }
  return false;
}

template bool add_obstacle(const Body&, int, std::vector<Obstacle<Narrow>>&);
template bool add_obstacle(const Body&, int, std::vector<Obstacle<Wide>>&);
template Narrow distance(const Obstacle<Narrow>&, const Vec<Narrow>&);
template Wide distance(const Obstacle<Wide>&, const Vec<Wide>&);
template bool within_sides(const Face<Narrow>&, const Vec<Narrow>&);
template bool within_sides(const Face<Wide>&, const Vec<Wide>&);
template Narrow descent_time(Narrow, Narrow, Narrow, Narrow, Narrow&);
template Wide descent_time(Wide, Wide, Wide, Wide, Wide&);
template bool stays_positive(Narrow, Narrow, const std::function<Narrow(Narrow)>&,
                             const std::function<Narrow(Narrow, Narrow)>&, Narrow);
template bool stays_positive(Wide, Wide, const std::function<Wide(Wide)>&, const std::function<Wide(Wide, Wide)>&,
                             Wide);
template bool stays_clear(const Arc<Narrow>&, Narrow, const std::function<Narrow(const Vec<Narrow>&)>&);
template bool stays_clear(const Arc<Wide>&, Wide, const std::function<Wide(const Vec<Wide>&)>&);
template bool may_meet_edge(const Obstacle<Narrow>&, Narrow, const Arc<Narrow>&);
template bool may_meet_edge(const Obstacle<Wide>&, Wide, const Arc<Wide>&);

}  // namespace atwood::closed_form
