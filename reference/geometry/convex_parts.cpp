#include "geometry/convex_parts.hpp"

#include <algorithm>

namespace atwood::geometry {
namespace {

ConvexPart box(const Real3& half, const Pose& pose) {
  ConvexPart part;
  const Vector h = widened(half);
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [&](int i) -> Real { return (corner >> i & 1) != 0 ? 1 : -1; };
    part.vertices.push_back(pose.p_W + to_world(pose, {side(0) * h[0], side(1) * h[1], side(2) * h[2]}));
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3, bi = 1 << i, bj = 1 << j, bk = 1 << k;
    const Vector& axis = pose.axis_W[static_cast<std::size_t>(i)];
    part.faces.push_back({axis, {bi, bi + bj, bi + bj + bk, bi + bk}});
    part.faces.push_back({-1 * axis, {0, bk, bj + bk, bj}});
    for (const int start : {0, bj, bk, bj + bk}) part.edges.push_back({start, start + bi});
  }
  return part;
}

ConvexPart polygon(std::vector<Vector> vertices, const Vector& normal) {
  ConvexPart part;
  part.dimension = 2;
  part.vertices = std::move(vertices);
  const int n = static_cast<int>(part.vertices.size());
  ConvexPart::Face& face = part.faces.emplace_back();
  face.normal = normal;
  for (int i = 0; i < n; ++i) face.corners.push_back(i), part.edges.push_back({i, (i + 1) % n});
  return part;
}

// A triangle of zero area is replaced by its longest side.
ConvexPart triangle(const Vector& a, const Vector& b, const Vector& c) {
  const Vector n = cross(b - a, c - a);
  const Real area = norm(n), longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
  ConvexPart part;
  if (area > 8 * kUnit * longest * longest) {
    part = polygon({a, b, c}, (1 / area) * n);
    part.faces.front().sharpness = area / (longest * longest);
    return part;
  }
  part.dimension = longest > 0 ? 1 : 0;
  if (longest == 0) part.vertices = {a};
  else if (longest == norm(b - a)) part.vertices = {a, b};
  else if (longest == norm(c - b)) part.vertices = {b, c};
  else part.vertices = {c, a};
  if (longest > 0) part.edges = {{0, 1}};
  return part;
}

// (b - a) x (c - a) . (d - a), in S.
template <class S> std::array<S, 3> normal_of(const Real3& a, const Real3& b, const Real3& c) {
  std::array<S, 3> u, v;
  for (std::size_t i = 0; i < 3; ++i) u[i] = static_cast<S>(b[i]) - a[i], v[i] = static_cast<S>(c[i]) - a[i];
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
template <class S> S side_of(const Real3& a, const std::array<S, 3>& normal, const Real3& d) {
  S sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += normal[i] * (static_cast<S>(d[i]) - a[i]);
  return sum;
}

// Squared.
Real longest_side(const Real3& a, const Real3& b, const Real3& c) {
  const Vector u = widened(b) - widened(a), v = widened(c) - widened(b), w = widened(a) - widened(c);
  return std::max({dot(u, u), dot(v, v), dot(w, w)});
}

// The sides of the plane through three of the points on which the others are. In long double, or in quad where that
// does not decide.
struct Sides {
  bool below = false, beyond = false;
};
Sides sides(const std::vector<Real3>& points, std::size_t i, std::size_t j, std::size_t k, Real extent) {
  const Vector rough = normal_of<Real>(points[i], points[j], points[k]);
  const Real doubt = 256 * kUnit * extent * extent * extent;
  Sides found;
  for (std::size_t l = 0; l < points.size() && !(found.below && found.beyond); ++l) {
    if (l == i || l == j || l == k) continue;
    Real side = side_of<Real>(points[i], rough, points[l]);
    if (std::fabs(side) <= doubt)
      side = static_cast<Real>(side_of<Wide>(points[i], normal_of<Wide>(points[i], points[j], points[k]), points[l]));
    found.below = found.below || side < 0;
    found.beyond = found.beyond || side > 0;
  }
  return found;
}

// Every three points with all others on one side form a face. When more points are in its plane, triangles overlap in
// it, which does not change a separation.
ConvexPart hull(const std::vector<Real3>& points, const Pose& pose) {
  ConvexPart part;
  Real extent = 0;
  for (const Real3& p : points) {
    part.vertices.push_back(pose.p_W + to_world(pose, widened(p)));
    extent = std::max(extent, 2 * norm(widened(p)));
  }
  std::vector<std::array<int, 2>> edges;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      for (std::size_t k = j + 1; k < points.size(); ++k) {
        const Vector m_B = normal_of<Real>(points[i], points[j], points[k]);
        if (!(norm(m_B) > 0)) continue;
        const auto [below, beyond] = sides(points, i, j, k, extent);
        if (below && beyond) continue;
        const Real sign = beyond ? -1 : 1;
        const Vector normal = (sign / norm(m_B)) * to_world(pose, m_B);
        const int a = static_cast<int>(i), b = static_cast<int>(j), c = static_cast<int>(k);
        const Real sharpness = std::min<Real>(1, norm(m_B) / longest_side(points[i], points[j], points[k]));
        part.faces.push_back({normal, beyond ? std::vector<int>{a, c, b} : std::vector<int>{a, b, c}, sharpness});
        if (!below && !beyond) part.faces.push_back({-1 * normal, {a, c, b}, sharpness});  // flat: both sides
        for (const auto& edge : {std::array{a, b}, std::array{b, c}, std::array{a, c}}) edges.push_back(edge);
      }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  part.edges = edges;
  const bool flat = std::any_of(part.faces.begin(), part.faces.end(), [&](const ConvexPart::Face& face) {
    return std::all_of(part.vertices.begin(), part.vertices.end(), [&](const Vector& v) {
      return dot(face.normal, v - part.vertices[static_cast<std::size_t>(face.corners[0])]) == 0;
    });
  });
  if (flat) part.dimension = 2;
  return part;
}

struct ConvexParts {
  const Pose& pose;

  std::vector<ConvexPart> operator()(const std::monostate&) const { return {}; }
  std::vector<ConvexPart> operator()(const Plane&) const { return {}; }
  std::vector<ConvexPart> operator()(const Cylinder&) const { return {}; }
  std::vector<ConvexPart> operator()(const Sphere& s) const { return {{0, {pose.p_W}, {}, {}, s.radius_m}}; }
  std::vector<ConvexPart> operator()(const Capsule& s) const {
    const Vector along = static_cast<Real>(s.half_length_m) * pose.axis_W[2];
    if (s.half_length_m == 0) return (*this)(Sphere{s.radius_m});
    return {{1, {pose.p_W - along, pose.p_W + along}, {}, {{0, 1}}, s.radius_m}};
  }
  std::vector<ConvexPart> operator()(const Rectangle& s) const {
    const Vector x = static_cast<Real>(s.half_extents_m[0]) * pose.axis_W[0];
    const Vector y = static_cast<Real>(s.half_extents_m[1]) * pose.axis_W[1];
    const Vector& p = pose.p_W;
    return {polygon({p - x - y, p + x - y, p + x + y, p - x + y}, pose.axis_W[2])};
  }
  std::vector<ConvexPart> operator()(const Box& s) const { return {box(s.half_extents_m, pose)}; }
  std::vector<ConvexPart> operator()(const Convex& s) const { return {hull(s.points_m, pose)}; }
  std::vector<ConvexPart> operator()(const Mesh& s) const {
    std::vector<ConvexPart> triangles;
    const auto at = [&](int i) { return pose.p_W + to_world(pose, widened(s.points_m[static_cast<std::size_t>(i)])); };
    for (const auto& t : s.triangles) triangles.push_back(triangle(at(t[0]), at(t[1]), at(t[2])));
    return triangles;
  }
  std::vector<ConvexPart> operator()(const Compound& s) const {
    std::vector<ConvexPart> boxes;
    for (const Compound::Part& part : s.boxes) {
      Pose inside = pose_of(widened(part.position_body_m), widened(part.orientation_wxyz));
      inside.p_W = pose.p_W + to_world(pose, inside.p_W);
      for (Vector& axis : inside.axis_W) axis = to_world(pose, axis);
      boxes.push_back(box(part.half_extents_m, inside));
    }
    return boxes;
  }
};

}  // namespace

// R = 1 + 2 (w [u] + [u]^2) / (w^2 + u^2), independent of the length of the quaternion.
Pose pose_of(const Vector& p_WB, const std::array<Real, 4>& q) {
  const auto [w, x, y, z] = q;
  const Real s = 2 / (w * w + x * x + y * y + z * z);
  Pose pose;
  pose.p_W = p_WB;
  pose.axis_W[0] = {1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)};
  pose.axis_W[1] = {s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)};
  pose.axis_W[2] = {s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)};
  return pose;
}

std::vector<ConvexPart> convex_parts_of(const Shape& shape, const Pose& pose) {
  return std::visit(ConvexParts{pose}, shape);
}

}  // namespace atwood::geometry
