#include "scene/inertia.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

namespace atwood {
namespace {

constexpr double kPi = std::numbers::pi;

std::string number_text(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

Real33 diagonal(double x, double y, double z) { return {x, 0, 0, 0, y, 0, 0, 0, z}; }

// Per unit of mass.
Real33 box_inertia(const Real3& h) {
  const double x = h[0] * h[0], y = h[1] * h[1], z = h[2] * h[2];
  return diagonal((y + z) / 3, (x + z) / 3, (x + y) / 3);
}

// A cylinder of half length h and two half balls of radius r, whose centroids lie h + 3/8 r from the middle:
// per half ball about the middle, across the axis: 83/320 r^2 + (h + 3/8 r)^2 = 2/5 r^2 + h^2 + 3/4 h r.
MassProperties capsule(double r, double h) {
  const double tube = kPi * r * r * 2 * h, balls = 4 * kPi / 3 * r * r * r, volume = tube + balls;
  const double a = tube / volume, b = balls / volume;
  const double across = a * (r * r / 4 + h * h / 3) + b * (0.4 * r * r + h * h + 0.75 * h * r);
  return {volume, diagonal(across, across, a * r * r / 2 + b * 0.4 * r * r)};
}

Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double extent(const std::vector<Real3>& points) {
  double most = 0;
  for (const Real3& p : points)
    for (const double x : p) most = std::max(most, std::abs(x));
  return most;
}

std::string off_centre(const Real3& centroid) {
  return "has its centroid at [" + number_text(centroid[0]) + ", " + number_text(centroid[1]) + ", " +
         number_text(centroid[2]) + "] m in body axes; expected it at the origin, the centre of mass";
}

bool is_off_centre(const Real3& centroid, double size) { return !(std::sqrt(dot(centroid, centroid)) <= 1e-9 * size); }

// Second moments C = int x x^T dV give I = tr(C) 1 - C.
Real33 inertia_of_moments(const Real33& c) {
  const double trace = c[0] + c[4] + c[8];
  Real33 inertia{};
  for (std::size_t i = 0; i < 9; ++i) inertia[i] = (i % 4 == 0 ? trace : 0) - c[i];
  return inertia;
}

// Sum over the tetrahedra from the origin to each triangle (a, b, c), of volume v = a . (b x c) / 6: first moments
// v (a + b + c) / 4; second moments v / 20 (a a^T + b b^T + c c^T + s s^T), s = a + b + c.
// Blow and Binstock, How to find the inertia tensor of a 3D solid body (2004).
std::string polyhedron(const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& triangles,
                       MassProperties& out) {
  double volume = 0;
  Real3 first{};
  Real33 second{};
  for (const auto& t : triangles) {
    const Real3 &a = points[static_cast<std::size_t>(t[0])], &b = points[static_cast<std::size_t>(t[1])],
                &c = points[static_cast<std::size_t>(t[2])];
    const double v = dot(a, cross(b, c)) / 6;
    volume += v;
    for (std::size_t i = 0; i < 3; ++i) {
      const double s_i = a[i] + b[i] + c[i];
      first[i] += v * s_i / 4;
      for (std::size_t j = 0; j < 3; ++j)
        second[3 * i + j] += v / 20 * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s_i * (a[j] + b[j] + c[j]));
    }
  }
  if (!(volume > 0)) return "has its triangles inside out; expected them anticlockwise seen from outside";
  for (double& x : first) x /= volume;
  if (is_off_centre(first, extent(points))) return off_centre(first);
  for (double& x : second) x /= volume;
  out = {volume, inertia_of_moments(second)};
  return "";
}

// Every edge occurs once in each direction.
bool closed(const std::vector<std::array<int, 3>>& triangles) {
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  return !edges.empty() && std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto back = edges.find({edge.first.second, edge.first.first});
    return edge.second == 1 && back != edges.end() && back->second == 1;
  });
}

Real33 rotation(const Real4& q) {
  const auto [w, x, y, z] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

// For each box: R I R^T about its centre, plus d . d 1 - d d^T for the offset to the body's centre (parallel axes).
std::string compound(const Compound& shape, MassProperties& out) {
  double volume = 0, size = 0;
  Real3 first{};
  Real33 sum{};
  for (const auto& box : shape.boxes) {
    const Real3 &h = box.half_extents_m, &d = box.position_body_m;
    const double v = 8 * h[0] * h[1] * h[2];
    const Real33 own = box_inertia(h), r = rotation(box.orientation_wxyz);
    volume += v;
    for (std::size_t i = 0; i < 3; ++i) {
      first[i] += v * d[i];
      size = std::max(size, std::abs(d[i]) + h[i]);
      for (std::size_t j = 0; j < 3; ++j) {
        double turned = 0;
        for (std::size_t k = 0; k < 3; ++k) turned += r[3 * i + k] * own[4 * k] * r[3 * j + k];
        sum[3 * i + j] += v * (turned + (i == j ? dot(d, d) : 0) - d[i] * d[j]);
      }
    }
  }
  for (double& x : first) x /= volume;
  if (is_off_centre(first, size)) return off_centre(first);
  for (double& x : sum) x /= volume;
  out = {volume, sum};
  return "";
}

struct Properties {
  MassProperties& out;
  std::string operator()(const std::monostate&) const { return ""; }
  std::string operator()(const Plane&) const { return "is a plane, which has no mass; expected `fixed = true`"; }
  std::string operator()(const Sphere& s) const {
    const double r2 = s.radius_m * s.radius_m;
    out = {4 * kPi / 3 * r2 * s.radius_m, diagonal(0.4 * r2, 0.4 * r2, 0.4 * r2)};
    return "";
  }
  std::string operator()(const Rectangle& s) const {
    const double x = s.half_extents_m[0] * s.half_extents_m[0] / 3, y = s.half_extents_m[1] * s.half_extents_m[1] / 3;
    out = {0, diagonal(y, x, x + y)};
    return "";
  }
  std::string operator()(const Box& s) const {
    out = {8 * s.half_extents_m[0] * s.half_extents_m[1] * s.half_extents_m[2], box_inertia(s.half_extents_m)};
    return "";
  }
  std::string operator()(const Capsule& s) const {
    out = capsule(s.radius_m, s.half_length_m);
    return "";
  }
  std::string operator()(const Cylinder& s) const {
    const double r2 = s.radius_m * s.radius_m, h2 = s.half_length_m * s.half_length_m;
    out = {2 * kPi * r2 * s.half_length_m, diagonal(r2 / 4 + h2 / 3, r2 / 4 + h2 / 3, r2 / 2)};
    return "";
  }
  std::string operator()(const Convex& s) const {
    const auto faces = convex_hull(s.points_m);
    if (faces.empty()) return "has points that enclose no volume; expected at least 4 that do not lie in one plane";
    return polyhedron(s.points_m, faces, out);
  }
  std::string operator()(const Mesh& s) const {
    if (!closed(s.triangles))
      return "is a mesh that is not closed; expected each edge in two triangles, or `fixed = true`";
    return polyhedron(s.points_m, s.triangles, out);
  }
  std::string operator()(const Compound& s) const { return compound(s, out); }
};

}  // namespace

std::string mass_properties(const Shape& shape, MassProperties& out) { return std::visit(Properties{out}, shape); }

std::string inertia_problem(const Real33& m) {
  double largest = 0;
  for (const double x : m) {
    if (!std::isfinite(x)) return "overflows, or is not a number; expected a smaller body";
    largest = std::max(largest, std::abs(x));
  }
  for (const auto& [i, j] : {std::pair<std::size_t, std::size_t>{1, 3}, {2, 6}, {5, 7}})
    if (std::abs(m[i] - m[j]) > 1e-12 * largest)
      return "is not symmetric (" + number_text(m[i]) + " against " + number_text(m[j]) +
             "); expected a symmetric matrix";
  Real33 scaled = m;
  for (double& x : scaled) x /= largest;
  Real3 moment = diagonalise(scaled).moments;
  std::sort(moment.begin(), moment.end());
  const auto listed = [&] {
    return "principal moments " + number_text(moment[0] * largest) + ", " + number_text(moment[1] * largest) + ", " +
           number_text(moment[2] * largest);
  };
  if (!(moment[0] > 0)) return "has " + listed() + "; expected all above 0";
  if (moment[2] > (moment[0] + moment[1]) * (1 + 1e-9))
    return "has " + listed() + "; expected none above the sum of the other two (triangle inequality)";
  return "";
}

}  // namespace atwood
