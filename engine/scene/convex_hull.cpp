// Incremental convex hull: for a new point outside, the faces visible from it are removed, and it is connected with
// their horizon. Points within a small distance of a face count as on it.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "scene/inertia.hpp"

namespace atwood {
namespace {

Real3 minus(const Real3& a, const Real3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Real3& a) { return std::sqrt(dot(a, a)); }

struct Face {
  std::array<int, 3> corner;
  Real3 normal;
  double offset;
};

Face face_of(const std::vector<Real3>& p, int a, int b, int c) {
  const Real3& at = p[static_cast<std::size_t>(a)];
  Real3 n = cross(minus(p[static_cast<std::size_t>(b)], at), minus(p[static_cast<std::size_t>(c)], at));
  if (const double size = length(n); size > 0)
    for (double& x : n) x /= size;
  return {{a, b, c}, n, dot(n, at)};
}

// The index of the largest `measure`.
template <class Measure> std::size_t farthest(const std::vector<Real3>& points, Measure measure) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (measure(points[i]) > measure(points[best])) best = i;
  return best;
}

// Four points far apart from each other, positively oriented; false when all points are flat within `tolerance`.
bool first_tetrahedron(const std::vector<Real3>& p, double tolerance, std::array<int, 4>& out) {
  const std::size_t a = farthest(p, [](const Real3& x) { return x[0]; });
  const std::size_t b = farthest(p, [&](const Real3& x) { return length(minus(x, p[a])); });
  const Real3 ab = minus(p[b], p[a]);
  if (!(length(ab) > tolerance)) return false;
  const auto off_line = [&](const Real3& x) { return length(cross(ab, minus(x, p[a]))) / length(ab); };
  const std::size_t c = farthest(p, off_line);
  if (!(off_line(p[c]) > tolerance)) return false;
  const Face base = face_of(p, static_cast<int>(a), static_cast<int>(b), static_cast<int>(c));
  const auto off_plane = [&](const Real3& x) { return std::abs(dot(base.normal, x) - base.offset); };
  const std::size_t d = farthest(p, off_plane);
  if (!(off_plane(p[d]) > tolerance)) return false;
  out = {static_cast<int>(a), static_cast<int>(b), static_cast<int>(c), static_cast<int>(d)};
  if (dot(base.normal, p[d]) > base.offset) std::swap(out[1], out[2]);  // the normal of the base points away from d
  return true;
}

}  // namespace

std::vector<std::array<int, 3>> convex_hull(const std::vector<Real3>& points) {
  if (points.size() < 4) return {};
  double size = 0;
  for (const Real3& p : points) size = std::max(size, length(minus(p, points[0])));
  const double tolerance = 1e-12 * size;
  std::array<int, 4> t{};
  if (!std::isfinite(size) || !first_tetrahedron(points, tolerance, t)) return {};
  std::vector<Face> faces = {face_of(points, t[0], t[1], t[2]), face_of(points, t[0], t[3], t[1]),
                             face_of(points, t[1], t[3], t[2]), face_of(points, t[2], t[3], t[0])};
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::set<std::pair<int, int>> horizon;
    const auto sees = [&](const Face& f) { return dot(f.normal, points[i]) - f.offset > tolerance; };
    for (const Face& f : faces) {
      if (!sees(f)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::pair<int, int> edge{f.corner[k], f.corner[(k + 1) % 3]};
        if (horizon.erase({edge.second, edge.first}) == 0) horizon.insert(edge);
      }
    }
    if (horizon.empty()) continue;
    std::erase_if(faces, sees);
    for (const auto& [from, to] : horizon) faces.push_back(face_of(points, from, to, static_cast<int>(i)));
  }
  std::vector<std::array<int, 3>> triangles;
  for (const Face& f : faces) triangles.push_back(f.corner);
  return triangles;
}

}  // namespace atwood
