#include "closed_form/floor.hpp"

#include <algorithm>
#include <map>

namespace atwood::closed_form {

namespace {

// Relative round-off of a sum of a few of a scene's doubles.
constexpr double kUlps = 16 * 0x1p-53;
// Relative to the body: a larger gap is not a contact, however far from the origin the body is.
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
    floor.refusal =
        "the triangles of `" + body.name + "` have a total area vector of zero, so that the floor has no normal";
    return;
  }
  floor.n = (1 / norm(area)) * area;
  floor.offset = dot(floor.n, points.front());
  S size = 0;
  for (const Vec<S>& p : points) {
    floor.unevenness = larger(floor.unevenness, magnitude(dot(floor.n, p) - floor.offset));
    size = larger(size, norm(p));
  }
  if (floor.unevenness > S(kUlps) * size) floor.refusal = "the mesh of `" + body.name + "` is not flat";
  for (const auto& [edge, count] : triangles_of_edge)
    if (count == 1) floor.boundary.push_back({rounded(points[edge.first]), rounded(points[edge.second])});
}

template <class S>
void box_on_face(const Box& box, const Pose<S>& pose, const Floor<S>& floor, FloorContact<S>& contact) {
  const Vec<S> up = rotate(conjugate(pose.q_WB), floor.n);
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (magnitude(up[i]) > magnitude(up[k])) k = i;
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  contact.tilt = sqrt(up[i] * up[i] + up[j] * up[j]);
  contact.height = box.half_extents_m[k];
  for (const auto& [at, axis] : {std::pair{0, i}, std::pair{1, j}}) {
    Vec<S> unit{};
    unit[axis] = 1;
    contact.side[at] = rotate(pose.q_WB, unit);
    contact.half[at] = box.half_extents_m[axis];
  }
  contact.extent_m = std::hypot(box.half_extents_m[0], box.half_extents_m[1], box.half_extents_m[2]);
}

}  // namespace

template <class S> Floor<S> find_floor(const Scene& scene) {
  Floor<S> floor;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (!body.fixed || body.shape.index() == 0) continue;
    if (floor.body >= 0) floor.refusal = "`" + body.name + "` is a second fixed body with a shape: expected one floor";
    floor.body = static_cast<int>(i);
    if (const auto* plane = std::get_if<Plane>(&body.shape)) plane_floor(*plane, floor);
    else if (const auto* mesh = std::get_if<Mesh>(&body.shape)) mesh_floor(body, *mesh, floor);
    else floor.refusal = "`" + body.name + "` is fixed and has another shape: expected a plane or a flat mesh";
    if (!floor.refusal.empty()) return floor;
  }
  if (floor.body < 0) {
    floor.refusal = "expected a fixed floor (a plane or a flat mesh); found none";
    return floor;
  }
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2);
  floor.g_n = -dot(floor.n, g);
  floor.g_t = g + floor.g_n * floor.n;
  // A component within the round-off of the normal is treated as zero, and included in the bars.
  if (norm(floor.g_t) <= S(kUlps) * norm(g)) {
    floor.neglected = norm(floor.g_t);
    floor.g_t = {};
  }
  if (!(floor.g_n > 0)) floor.refusal = "gravity does not press onto `" + scene.bodies[floor.body].name + "`";
  return floor;
}

template <class S> FloorContact<S> floor_contact(const Floor<S>& floor, const Scene& scene, int at) {
  const Body& body = scene.bodies[at];
  const std::string name = "`" + body.name + "`";
  const Pose<S> pose = initial_pose<S>(body);
  FloorContact<S> contact;
  if (const auto* box = std::get_if<Box>(&body.shape)) {
    box_on_face(*box, pose, floor, contact);
    if (contact.tilt > S(kUlps))
      contact.refusal =
          name + " does not lie flat on a face (tilt " + format_double(static_cast<double>(contact.tilt)) + ")";
  } else if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    contact.height = contact.extent_m = sphere->radius_m;
  } else if (const auto* cylinder = std::get_if<Cylinder>(&body.shape)) {
    contact.axis = rotate(pose.q_WB, Vec<S>{0, 0, 1});
    contact.tilt = magnitude(dot(contact.axis, floor.n));
    contact.height = cylinder->radius_m;
    contact.extent_m = std::hypot(cylinder->radius_m, cylinder->half_length_m);
    if (contact.tilt > S(kUlps))
      contact.refusal =
          name + " does not lie on its side (tilt " + format_double(static_cast<double>(contact.tilt)) + ")";
  } else {
    contact.refusal = name + " has another shape: expected a box, a sphere or a cylinder";
  }
  if (body.release_s > 0) contact.refusal = name + " has a release time: expected a release at t = 0";
  if (!contact.refusal.empty()) return contact;
  const S gap = dot(floor.n, pose.p_WB) - floor.offset - contact.height;
  contact.normal_speed = magnitude(dot(floor.n, pose.v_WB));
  if (magnitude(gap) > S(kUlps) * (norm(pose.p_WB) + contact.height) ||
      magnitude(gap) > S(kClosed) * S(contact.extent_m))
    contact.refusal = name + " does not touch the floor: its gap is " + format_double(static_cast<double>(gap)) + " m";
  if (contact.normal_speed > S(kUlps) * norm(pose.v_WB))
    contact.refusal = name + " has a velocity component along the normal of the floor";
  contact.gap_error_m = 4 * (magnitude(gap) + floor.unevenness) + contact.tilt * S(contact.extent_m);
  return contact;
}

template <class S>
std::string leaves_floor(const Floor<S>& floor, const Scene& scene, const Vec<double>& from, const Vec<double>& to,
                         double extent_m) {
  if (floor.boundary.empty()) return "";
  // The start is over the floor when a ray from it crosses an odd number of boundary edges, seen along n.
  const Vec<double> n = rounded(floor.n);
  Vec<double> e = std::fabs(n[0]) < 0.6 ? Vec<double>{1, 0, 0} : Vec<double>{0, 1, 0};
  e = e - dot(e, n) * n;
  const Vec<double> f = cross(n, e);
  bool over = false;
  const Vec<double> foot = from - (dot(n, from) - static_cast<double>(floor.offset)) * n;
  const Vec<double> end = to - (dot(n, to) - static_cast<double>(floor.offset)) * n;
  double nearest = HUGE_VAL;
  for (const auto& [a, b] : floor.boundary) {
    nearest = std::min(nearest, segment_distance(foot, end, a, b));
    const double ya = dot(f, a - foot), yb = dot(f, b - foot);
    if ((ya > 0) == (yb > 0)) continue;
    if (dot(e, a - foot) + (dot(e, b - a)) * ya / (ya - yb) > 0) over = !over;
  }
  if (over && nearest > extent_m) return "";
  return "the path of a body reaches the boundary of `" + scene.bodies[floor.body].name + "`";
}

template Floor<Narrow> find_floor(const Scene&);
template Floor<Wide> find_floor(const Scene&);
template FloorContact<Narrow> floor_contact(const Floor<Narrow>&, const Scene&, int);
template FloorContact<Wide> floor_contact(const Floor<Wide>&, const Scene&, int);
template std::string leaves_floor(const Floor<Narrow>&, const Scene&, const Vec<double>&, const Vec<double>&, double);
template std::string leaves_floor(const Floor<Wide>&, const Scene&, const Vec<double>&, const Vec<double>&, double);

}  // namespace atwood::closed_form
