// Incremental convex hull. Orientation tests are exact, so the faces visible from a point are connected and their
// horizon is a single loop, also for needle-shaped and flat hulls.
#include "collision/hull_triangles.hpp"

#include <cmath>
#include <set>
#include <utility>

#include "collision/predicates.hpp"

namespace atwood {
namespace {

using Point = Vec3<double>;

template <class Measure> int farthest(const std::vector<Point>& points, const Measure& measure) {
  int best = 0;
  double most = measure(points[0]);
  for (int i = 1; i < static_cast<int>(points.size()); ++i)
    if (const double here = measure(points[i]); here > most) most = here, best = i;
  return best;
}

// False where all points lie in a plane, to 64 roundings. The first three run anticlockwise seen from the side away
// from the fourth.
bool first_tetrahedron(const std::vector<Point>& p, std::array<int, 4>& t) {
  const int a = farthest(p, [](const Point& x) { return x.x; });
  const int b = farthest(p, [&](const Point& x) { return norm(x - p[a]); });
  const double size = norm(p[b] - p[a]), flat = 64 * 0x1p-52 * size;
  if (!(size > 0) || !std::isfinite(size)) return false;
  const Point along = (1 / size) * (p[b] - p[a]);
  const auto off_line = [&](const Point& x) { return norm(cross(along, x - p[a])); };
  const int c = farthest(p, off_line);
  if (!(off_line(p[c]) > flat)) return false;
  const Point across = cross(along, p[c] - p[a]), normal = (1 / norm(across)) * across;
  const auto off_plane = [&](const Point& x) { return std::abs(dot(normal, x - p[a])); };
  const int d = farthest(p, off_plane);
  const int side = orient3d(p[a], p[b], p[c], p[d]);
  if (!(off_plane(p[d]) > flat) || side == 0) return false;
  t = side > 0 ? std::array<int, 4>{a, b, c, d} : std::array<int, 4>{a, c, b, d};
  return true;
}

}  // namespace

std::vector<std::array<int, 3>> hull_triangles(const std::vector<Real3>& given) {
  std::vector<Point> p;
  for (const Real3& x : given) p.push_back(narrow3<double>(x));
  std::array<int, 4> t{};
  if (p.size() < 4 || !first_tetrahedron(p, t)) return {};
  std::vector<std::array<int, 3>> faces = {
      {t[0], t[1], t[2]}, {t[0], t[3], t[1]}, {t[1], t[3], t[2]}, {t[2], t[3], t[0]}};
  for (int i = 0; i < static_cast<int>(p.size()); ++i) {
    const auto is_visible_from_i = [&](const std::array<int, 3>& f) {
      return orient3d(p[f[0]], p[f[1]], p[f[2]], p[i]) < 0;
    };
    std::set<std::pair<int, int>> horizon;
    std::size_t kept = 0;
    for (const std::array<int, 3>& f : faces) {
      if (!is_visible_from_i(f)) {
        faces[kept++] = f;
        continue;
      }
      for (int k = 0; k < 3; ++k)
        if (horizon.erase({f[(k + 1) % 3], f[k]}) == 0) horizon.insert({f[k], f[(k + 1) % 3]});
    }
    faces.resize(kept);
    for (const auto& [from, to] : horizon) faces.push_back({from, to, i});
  }
  return faces;
}

}  // namespace atwood
