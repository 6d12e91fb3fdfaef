#include "closed_form/floor.hpp"

#include <algorithm>
#include <map>

namespace atwood::closed_form {

namespace {

// What the round-off of a scene's doubles may do to a sum of a few of them.
constexpr double kUlps = 16 * 0x1p-53;
// A gap is closed only if it is nothing beside the body, however far from the origin that lies.
constexpr double kClosed = 1e-9;

template <class S> void plane_floor(const Plane& plane, Floor<S>& floor) {
  const Vec<S> normal = vec<S>(plane.normal);
  const S length = norm(normal);
  floor.n = (1 / length) * normal;
  floor.offset = S(plane.offset_m) / length;
}

template <class S> void mesh_floor(const Body& body, const Mesh& mesh, Floor<S>& floor) {
  const Pose<S> pose = initial_pose<S>(body);
  std::vector<Vec<S>> points;
  for (const Real3& p : mesh.points_m) points.push_back(pose.p_WB + rotate(pose.q_WB, vec<S>(p)));
  Vec<S> area{};
  std::map<std::pair<int, int>, int> triangles_of_edge;
  for (const auto& corner : mesh.triangles) {
    area = area + cross(points[corner[1]] - points[corner[0]], points[corner[2]] - points[corner[0]]);
    for (int k = 0; k < 3; ++k) {
      const int i = corner[k], j = corner[(k + 1) % 3];
      ++triangles_of_edge[{std::min(i, j), std::max(i, j)}];
    }
  }
  if (is_zero(area)) {
    floor.misfit = "the triangles of `" + body.name + "` face no way";
    return;
  }
  floor.n = (1 / norm(area)) * area;
  floor.offset = dot(floor.n, points.front());
  S size = 0;
  for (const Vec<S>& p : points) {
    floor.flat = larger(floor.flat, magnitude(dot(floor.n, p) - floor.offset));
    size = larger(size, norm(p));
  }
  if (floor.flat > S(kUlps) * size) floor.misfit = "the mesh of `" + body.name + "` is not flat";
  for (const auto& [edge, count] : triangles_of_edge)
    if (count == 1) floor.rim.push_back({rounded(points[edge.first]), rounded(points[edge.second])});
}

template <class S> void box_on_face(const Box& box, const Pose<S>& pose, const Floor<S>& floor, Stance<S>& stance) {
  const Vec<S> up = rotate(conjugate(pose.q_WB), floor.n);
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (magnitude(up[i]) > magnitude(up[k])) k = i;
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  stance.tilt = sqrt(up[i] * up[i] + up[j] * up[j]);
  stance.height = box.half_extents_m[k];
  for (const auto& [at, axis] : {std::pair{0, i}, std::pair{1, j}}) {
    Vec<S> unit{};
    unit[axis] = 1;
    stance.side[at] = rotate(pose.q_WB, unit);
    stance.half[at] = box.half_extents_m[axis];
  }
  stance.reach_m = std::hypot(box.half_extents_m[0], box.half_extents_m[1], box.half_extents_m[2]);
}

}  // namespace

template <class S> Floor<S> find_floor(const Scene& scene) {
  Floor<S> floor;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (!body.fixed || body.shape.index() == 0) continue;
    if (floor.body >= 0) floor.misfit = "`" + body.name + "` is there beside one floor";
    floor.body = static_cast<int>(i);
    if (const auto* plane = std::get_if<Plane>(&body.shape)) plane_floor(*plane, floor);
    else if (const auto* mesh = std::get_if<Mesh>(&body.shape)) mesh_floor(body, *mesh, floor);
    else floor.misfit = "`" + body.name + "` is neither a plane nor a flat mesh";
    if (!floor.misfit.empty()) return floor;
  }
  if (floor.body < 0) {
    floor.misfit = "a fixed floor is needed";
    return floor;
  }
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2);
  floor.g_n = -dot(floor.n, g);
  floor.g_t = g + floor.g_n * floor.n;
  // Along a level floor gravity has no part; what a tilted normal's round-off leaves is not a slope; the
  // bars hold it.
  if (norm(floor.g_t) <= S(kUlps) * norm(g)) {
    floor.dropped = norm(floor.g_t);
    floor.g_t = {};
  }
  if (!(floor.g_n > 0)) floor.misfit = "gravity does not press onto `" + scene.bodies[floor.body].name + "`";
  return floor;
}

template <class S> Stance<S> stand_on(const Floor<S>& floor, const Scene& scene, int at) {
  const Body& body = scene.bodies[at];
  const std::string name = "`" + body.name + "`";
  const Pose<S> pose = initial_pose<S>(body);
  Stance<S> stance;
  if (const auto* box = std::get_if<Box>(&body.shape)) {
    box_on_face(*box, pose, floor, stance);
    if (stance.tilt > S(kUlps)) stance.misfit = name + " does not lie flat on a face";
  } else if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    stance.height = stance.reach_m = sphere->radius_m;
  } else if (const auto* cylinder = std::get_if<Cylinder>(&body.shape)) {
    stance.axis = rotate(pose.q_WB, Vec<S>{0, 0, 1});
    stance.tilt = magnitude(dot(stance.axis, floor.n));
    stance.height = cylinder->radius_m;
    stance.reach_m = std::hypot(cylinder->radius_m, cylinder->half_length_m);
    if (stance.tilt > S(kUlps)) stance.misfit = name + " does not lie on its side";
  } else {
    stance.misfit = name + " is neither a box nor a sphere nor a cylinder";
  }
  if (body.release_s > 0) stance.misfit = name + " is released late";
  if (!stance.misfit.empty()) return stance;
  const S gap = dot(floor.n, pose.p_WB) - floor.offset - stance.height;
  stance.rise = magnitude(dot(floor.n, pose.v_WB));
  if (magnitude(gap) > S(kUlps) * (norm(pose.p_WB) + stance.height) || magnitude(gap) > S(kClosed) * S(stance.reach_m))
    stance.misfit = name + " does not touch the floor";
  if (stance.rise > S(kUlps) * norm(pose.v_WB)) stance.misfit = name + " does not move along the floor";
  stance.slack_m = 4 * (magnitude(gap) + floor.flat) + stance.tilt * S(stance.reach_m);
  return stance;
}

template <class S>
std::string leaves(const Floor<S>& floor, const Scene& scene, const Vec<double>& from, const Vec<double>& to,
                   double reach_m) {
  if (floor.rim.empty()) return "";
  // Over the floor at the start: an odd number of rim edges are crossed on the way out, seen along n.
  const Vec<double> n = rounded(floor.n);
  Vec<double> e = std::fabs(n[0]) < 0.6 ? Vec<double>{1, 0, 0} : Vec<double>{0, 1, 0};
  e = e - dot(e, n) * n;
  const Vec<double> f = cross(n, e);
  bool over = false;
  const Vec<double> foot = from - (dot(n, from) - static_cast<double>(floor.offset)) * n;
  const Vec<double> end = to - (dot(n, to) - static_cast<double>(floor.offset)) * n;
  double nearest = HUGE_VAL;
  for (const auto& [a, b] : floor.rim) {
    nearest = std::min(nearest, segment_distance(foot, end, a, b));
    const double ya = dot(f, a - foot), yb = dot(f, b - foot);
    if ((ya > 0) == (yb > 0)) continue;
    if (dot(e, a - foot) + (dot(e, b - a)) * ya / (ya - yb) > 0) over = !over;
  }
  if (over && nearest > reach_m) return "";
  return "the way of a body leads over the rim of `" + scene.bodies[floor.body].name + "`";
}

template Floor<Narrow> find_floor(const Scene&);
template Floor<Wide> find_floor(const Scene&);
template Stance<Narrow> stand_on(const Floor<Narrow>&, const Scene&, int);
template Stance<Wide> stand_on(const Floor<Wide>&, const Scene&, int);
template std::string leaves(const Floor<Narrow>&, const Scene&, const Vec<double>&, const Vec<double>&, double);
template std::string leaves(const Floor<Wide>&, const Scene&, const Vec<double>&, const Vec<double>&, double);

}  // namespace atwood::closed_form
