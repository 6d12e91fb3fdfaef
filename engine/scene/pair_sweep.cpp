#include "scene/pair_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scene/split_mix.hpp"

namespace atwood {
namespace {

double dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const Real3& a) { return std::sqrt(dot(a, a)); }
Real3 plus(const Real3& a, double s, const Real3& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }

// R(q) v; `back`: its transpose.
Real3 turn(const Real4& q, const Real3& v, bool back) {
  const double w = back ? -q[0] : q[0];
  const Real3 u{q[1], q[2], q[3]};
  const Real3 c{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const Real3 d{u[1] * c[2] - u[2] * c[1], u[2] * c[0] - u[0] * c[2], u[0] * c[1] - u[1] * c[0]};
  return plus(plus(v, 2 * w, c), 2, d);
}

struct Draw {
  SplitMix64 random;
  double between(double low, double high) { return low + (high - low) * random.next_unit(); }
  double decades(double low, double high) { return std::pow(10, between(low, high)); }
  int uniform_below(int n) { return static_cast<int>(random.next() % static_cast<std::uint64_t>(n)); }
  double sign() { return uniform_below(2) == 0 ? 1 : -1; }
  Real3 direction() {  // uniform on the sphere, by rejection
    for (;;) {
      const Real3 v{between(-1, 1), between(-1, 1), between(-1, 1)};
      const double r = norm(v);
      if (r > 0.01 && r <= 1) return {v[0] / r, v[1] / r, v[2] / r};
    }
  }
  Real4 attitude() {
    for (;;) {
      const Real4 v{between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)};
      const double r = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
      if (r > 0.01 && r <= 1) return {v[0] / r, v[1] / r, v[2] / r, v[3] / r};
    }
  }
};

// ---- shapes -------------------------------------------------------------------------------------------------------
// Half extents about `size`: three in five plain, one a slab, one a needle.
Real3 extents(Draw& draw, double size) {
  Real3 h{size * draw.decades(-0.5, 0.5), size * draw.decades(-0.5, 0.5), size * draw.decades(-0.5, 0.5)};
  const int kind = draw.uniform_below(5), axis = draw.uniform_below(3);
  for (int i = 0; i < 3; ++i)
    if ((kind == 0 && i == axis) || (kind == 1 && i != axis)) h[static_cast<std::size_t>(i)] *= 1e-3;
  return h;
}

Shape make_shape(const std::string& name, Draw& draw, double size) {
  if (name == "sphere") return Sphere{size};
  if (name == "plane") return Plane{draw.direction(), 0};
  if (name == "rectangle") return Rectangle{{size * draw.decades(-1, 0.5), size * draw.decades(-0.5, 0.5)}};
  if (name == "box") return Box{extents(draw, size)};
  if (name == "capsule") return Capsule{size * draw.decades(-2, 0), size * draw.decades(-1, 0.5)};
  if (name == "cylinder") return Cylinder{size * draw.decades(-1, 0.5), size * draw.decades(-1, 0.5)};
  if (name == "compound") {
    Compound compound;
    for (int parts = 2 + draw.uniform_below(3); parts > 0; --parts) {
      const Real3 h = extents(draw, size), d = draw.direction();
      compound.boxes.push_back({h, {2 * size * d[0], 2 * size * d[1], 2 * size * d[2]}, draw.attitude()});
    }
    return compound;
  }
  const Real3 h = extents(draw, size);
  const auto point = [&] {
    const Real3 d = draw.direction();
    return Real3{h[0] * d[0], h[1] * d[1], h[2] * d[2]};
  };
  if (name == "convex") {
    Convex convex;
    for (int points = 4 + draw.uniform_below(13); points > 0; --points) convex.points_m.push_back(point());
    return convex;
  }
  if (name == "triangle") return Mesh{"", {point(), point(), point()}, {{0, 1, 2}}};
  // An octahedron with displaced vertices and without one face: it bounds no solid, so that all engines treat it as the
  // same surface.
  Mesh mesh;
  for (std::size_t corner = 0; corner < 6; ++corner) {
    Real3 p{};
    p[corner / 2] = (corner % 2 == 0 ? 1 : -1) * h[corner / 2] * draw.between(0.5, 1.5);
    mesh.points_m.push_back(p);
  }
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}};
  return mesh;
}

// ---- supports -----------------------------------------------------------------------------------------------------
Real3 furthest(const std::vector<Real3>& points, const Real3& n) {
  return *std::max_element(points.begin(), points.end(),
                           [&](const Real3& a, const Real3& b) { return dot(a, n) < dot(b, n); });
}

// Support point of the shape along n (body axes, unit). For a face orthogonal to n any of its points.
struct Support {
  Real3 n;
  Draw& draw;
  double side(double component, double h) const { return component > 0 ? h : component < 0 ? -h : draw.between(-h, h); }
  Real3 operator()(const std::monostate&) const { return {}; }
  Real3 operator()(const Plane&) const { return {}; }
  Real3 operator()(const Sphere& s) const { return plus({}, s.radius_m, n); }
  Real3 operator()(const Rectangle& s) const {
    return {side(n[0], s.half_extents_m[0]), side(n[1], s.half_extents_m[1]), 0};
  }
  Real3 operator()(const Box& s) const {
    const Real3& h = s.half_extents_m;
    return {side(n[0], h[0]), side(n[1], h[1]), side(n[2], h[2])};
  }
  Real3 operator()(const Capsule& s) const { return plus({0, 0, side(n[2], s.half_length_m)}, s.radius_m, n); }
  Real3 operator()(const Cylinder& s) const {
    const double across = std::hypot(n[0], n[1]);
    const double r = across > 0 ? s.radius_m / across : 0;
    return {r * n[0], r * n[1], side(n[2], s.half_length_m)};
  }
  Real3 operator()(const Convex& s) const { return furthest(s.points_m, n); }
  Real3 operator()(const Mesh& s) const { return furthest(s.points_m, n); }
  Real3 operator()(const Compound& s) const {
    std::vector<Real3> points;
    for (const Compound::Part& part : s.boxes) {
      const Support in_part{turn(part.orientation_wxyz, n, true), draw};
      points.push_back(
          plus(part.position_body_m, 1, turn(part.orientation_wxyz, in_part(Box{part.half_extents_m}), false)));
    }
    return furthest(points, n);
  }
};

Real3 support(const Body& body, const Real3& n, Draw& draw) {
  const Support in_body{turn(body.orientation_wxyz, n, true), draw};
  return turn(body.orientation_wxyz, std::visit(in_body, body.shape), false);
}

// A normal of one of the body's faces, exactly one of its axes; spheres have none.
bool has_faces(const Body& body) {
  return std::holds_alternative<Box>(body.shape) || std::holds_alternative<Rectangle>(body.shape) ||
         std::holds_alternative<Cylinder>(body.shape) || std::holds_alternative<Capsule>(body.shape);
}

double radius(const Body& body) {
  struct Radius {
    static double furthest(const std::vector<Real3>& points) {
      double r = 0;
      for (const Real3& p : points) r = std::max(r, norm(p));
      return r;
    }
    double operator()(const std::monostate&) const { return 0; }
    double operator()(const Plane&) const { return HUGE_VAL; }
    double operator()(const Sphere& s) const { return s.radius_m; }
    double operator()(const Rectangle& s) const { return std::hypot(s.half_extents_m[0], s.half_extents_m[1]); }
    double operator()(const Box& s) const { return norm(s.half_extents_m); }
    double operator()(const Capsule& s) const { return s.radius_m + s.half_length_m; }
    double operator()(const Cylinder& s) const { return std::hypot(s.radius_m, s.half_length_m); }
    double operator()(const Convex& s) const { return furthest(s.points_m); }
    double operator()(const Mesh& s) const { return furthest(s.points_m); }
    double operator()(const Compound& s) const {
      double r = 0;
      for (const auto& part : s.boxes) r = std::max(r, norm(part.position_body_m) + norm(part.half_extents_m));
      return r;
    }
  };
  return std::visit(Radius{}, body.shape);
}

// ---- poses --------------------------------------------------------------------------------------------------------
Body make_body(const std::string& name, const std::string& shape, Draw& draw, double size) {
  Body body;
  body.name = name;
  body.shape = make_shape(shape, draw, size);
  body.fixed = shape == "plane";
  if (body.fixed) return body;
  body.mass_kg = 1;
  body.inertia_kg_m2 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  body.orientation_wxyz = draw.attitude();
  return body;
}

double gap(Draw& draw, double size) {
  const int kind = draw.uniform_below(20);
  if (kind < 2) return -size * draw.between(0.5, 1.5);  // deep inside
  return (kind < 11 ? 1 : -1) * size * draw.decades(-8, 0);
}

void set_apart(Body& a, Body& b, double g, Draw& draw) {
  if (auto* plane = std::get_if<Plane>(&b.shape)) {
    const Real3 down{-plane->normal[0], -plane->normal[1], -plane->normal[2]};
    plane->offset_m = dot(plane->normal, plus(a.position_m, 1, support(a, down, draw))) - g;
    return;
  }
  Real3 n = draw.direction();
  const int choice = draw.uniform_below(10);
  if (const Body& owner = choice < 2 ? a : b; choice < 4 && has_faces(owner)) {
    Real3 axis{};
    axis[static_cast<std::size_t>(draw.uniform_below(3))] = draw.sign();
    n = turn(owner.orientation_wxyz, axis, false);
  }
  const Real3 on_a = plus(a.position_m, 1, support(a, n, draw));
  const Real3 on_b = support(b, {-n[0], -n[1], -n[2]}, draw);
  b.position_m = plus(plus(on_a, g, n), -1, on_b);
}

// Moves the bodies backwards on straight lines, so that they reach the pose at some time within the sweep.
void start_earlier(Body& body, double t_s, double speed, Draw& draw) {
  if (body.fixed) return;
  const Real3 d = draw.direction();
  body.velocity_m_per_s = {speed * d[0], speed * d[1], speed * d[2]};
  body.position_m = plus(body.position_m, -t_s, body.velocity_m_per_s);
  const Real3 axis = draw.direction();
  const double rate = draw.uniform_below(3) == 0 ? 0 : draw.decades(-1, 1);
  body.angular_velocity_body_rad_per_s = {rate * axis[0], rate * axis[1], rate * axis[2]};
}

}  // namespace

const std::vector<std::string>& sweep_pairs() {
  static const std::vector<std::string> pairs = {
      "sphere-sphere",   "sphere-plane",   "sphere-rectangle", "sphere-box",        "sphere-capsule",
      "sphere-cylinder", "sphere-convex",  "sphere-mesh",      "box-plane",         "box-rectangle",
      "box-box",         "capsule-plane",  "capsule-box",      "capsule-capsule",   "cylinder-plane",
      "convex-plane",    "convex-box",     "convex-convex",    "triangle-triangle", "mesh-plane",
      "mesh-mesh",       "compound-plane", "compound-box",     "compound-compound"};
  return pairs;
}

const std::vector<std::string>& touch_pairs() {
  static const std::vector<std::string> pairs = {"sphere-sphere", "sphere-plane", "sphere-box", "box-plane", "box-box"};
  return pairs;
}

Scene sweep_scene(const std::string& pair, std::uint64_t seed, std::int64_t index, bool swept) {
  const auto& known = swept ? touch_pairs() : sweep_pairs();
  if (std::find(known.begin(), known.end(), pair) == known.end()) {
    std::string names;
    for (const auto& name : known) names += (names.empty() ? "" : ", ") + name;
    throw std::invalid_argument("no pair `" + pair + "` to sweep" + (swept ? " in time" : "") + "; expected one of " +
                                names);
  }
  SplitMix64 mixed{seed};
  for (const char c : pair) mixed.state = mixed.next() ^ static_cast<unsigned char>(c);
  mixed.state = mixed.next() ^ static_cast<std::uint64_t>(index);
  Draw draw{{mixed.next()}};

  const std::size_t dash = pair.find('-');
  const double size = draw.decades(-3, 3);
  Scene scene;
  scene.materials.push_back({"default", 0, 0, 0});
  scene.pairs.push_back({});
  scene.bodies = {make_body("a", pair.substr(0, dash), draw, size * draw.decades(-1, 1)),
                  make_body("b", pair.substr(dash + 1), draw, size)};
  Body &a = scene.bodies[0], &b = scene.bodies[1];
  a.position_m = {size * draw.between(-1, 1), size * draw.between(-1, 1), size * draw.between(-1, 1)};
  set_apart(a, b, gap(draw, pair_size_m(scene)), draw);
  if (swept) {
    const double t_s = draw.between(0.01, 1) * kSweepEndS, speed = pair_size_m(scene) * draw.decades(0, 3);
    start_earlier(a, t_s, speed, draw);
    start_earlier(b, t_s, speed * draw.decades(-1, 0), draw);
  }
  return scene;
}

double pair_size_m(const Scene& scene) {
  double size = HUGE_VAL;
  for (const Body& body : scene.bodies) size = std::min(size, radius(body));
  return size;
}

double largest_radius_m(const Scene& scene) {
  double size = 0;
  for (const Body& body : scene.bodies)
    if (!std::holds_alternative<Plane>(body.shape)) size = std::max(size, radius(body));
  return size;
}

}  // namespace atwood
