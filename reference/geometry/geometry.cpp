#include "geometry/geometry.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "geometry/convex_parts.hpp"

namespace atwood::geometry {
namespace {

const char* name_of(const Shape& shape) {
  static constexpr const char* names[] = {"no shape", "sphere",   "plane",  "rectangle", "box",
                                          "capsule",  "cylinder", "convex", "mesh",      "compound"};
  return names[shape.index()];
}

Separation swapped(Separation found) {
  std::swap(found.on_a, found.on_b);
  found.normal = -1 * found.normal;
  return found;
}

RoundBar round_bar(const Cylinder& shape, const Pose& pose) {
  return {pose.p_W, pose.axis_W[2], shape.radius_m, shape.half_length_m};
}

HalfSpace half_space(const Plane& plane) {
  const Vector n{plane.normal[0], plane.normal[1], plane.normal[2]};
  const Real length = norm(n);
  return {(1 / length) * n, static_cast<Real>(plane.offset_m) / length};
}

// The pair of parts with the smallest gap. With another pair of the same depth in another direction none is unique.
template <class Each> Separation smallest(const std::vector<ConvexPart>& parts, Each each) {
  std::vector<Separation> all;
  for (const ConvexPart& part : parts) all.push_back(each(part));
  const auto nearer = [](const Separation& x, const Separation& y) { return x.gap_m < y.gap_m; };
  const auto best = std::min_element(all.begin(), all.end(), nearer);
  Separation found = *best;
  for (const Separation& other : all)
    if (norm(other.normal - found.normal) > 1e-7L) found.margin_m = std::min(found.margin_m, other.gap_m - found.gap_m);
  // Another pair of parts may have the smaller gap, within its bar.
  for (const Separation& other : all) found.bar_m = std::max(found.bar_m, found.gap_m - (other.gap_m - other.bar_m));
  return found;
}

Pose initial(const Body& body) {
  const auto& q = body.orientation_wxyz;
  return pose_of({body.position_m[0], body.position_m[1], body.position_m[2]}, {q[0], q[1], q[2], q[3]});
}

Pose sampled(const BodySample& body) {
  const auto r = [](Wide x) { return static_cast<Real>(x); };
  return pose_of({r(body.p_m[0]), r(body.p_m[1]), r(body.p_m[2])},
                 {r(body.q_wxyz[0]), r(body.q_wxyz[1]), r(body.q_wxyz[2]), r(body.q_wxyz[3])});
}

void require(const Shape& a, const Shape& b) {
  if (const std::string why = no_separation(a, b); !why.empty())
    throw std::invalid_argument("truth: no separation of " + why);
}

// ---- inside of closed meshes --------------------------------------------------------------------------------------
// Every edge belongs to two triangles, in opposite directions.
bool closed(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> ways;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++ways[{t[k], t[(k + 1) % 3]}];
  return !ways.empty() && std::all_of(ways.begin(), ways.end(), [&](const auto& way) {
    const auto back = ways.find({way.first.second, way.first.first});
    return way.second == 1 && back != ways.end() && back->second == 1;
  });
}

// Winding number: solid angles of the triangles over 4 pi (van Oosterom and Strackee 1983); 1 inside, 0 outside.
Real winding(const std::vector<std::array<Vector, 3>>& triangles, const Vector& x) {
  Real sum = 0;
  for (const auto& t : triangles) {
    const Vector a = t[0] - x, b = t[1] - x, c = t[2] - x;
    const Real la = norm(a), lb = norm(b), lc = norm(c);
    sum += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * std::acos(Real(-1)));
}

// A closed convex mesh as a solid. (Hulls are computed from all triples of points, therefore for small meshes only.)
Shape filled(const Shape& shape) {
  const auto* mesh = std::get_if<Mesh>(&shape);
  constexpr std::size_t max_points = 64;
  if (mesh == nullptr || mesh->points_m.size() > max_points || !closed(*mesh)) return shape;
  const auto at = [&](int i) {
    const Real3& p = mesh->points_m[static_cast<std::size_t>(i)];
    return Vector{p[0], p[1], p[2]};
  };
  for (const auto& t : mesh->triangles) {
    const Vector n = cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
    for (const auto& other : mesh->triangles)
      for (const int corner : other) {
        const Vector way = at(corner) - at(t[0]);
        if (dot(n, way) > 64 * kUnit * norm(n) * norm(way)) return shape;
      }
  }
  return Convex{mesh->points_m};
}

// The separation of a shape inside of a closed mesh; empty when that of the mesh's triangles is sufficient.
std::optional<Separation> inside_mesh(const Shape& shape, const Pose& pose, const Mesh& mesh, const Pose& pose_mesh) {
  if (!closed(mesh)) return {};
  std::vector<std::array<Vector, 3>> triangles;
  const auto at = [&](int i) {
    const Real3& p = mesh.points_m[static_cast<std::size_t>(i)];
    return pose_mesh.p_W + to_world(pose_mesh, {p[0], p[1], p[2]});
  };
  for (const auto& t : mesh.triangles) triangles.push_back({at(t[0]), at(t[1]), at(t[2])});
  const std::vector<ConvexPart> of_shape = convex_parts_of(shape, pose), of_mesh = convex_parts_of(mesh, pose_mesh);
  const auto* ball = std::get_if<Sphere>(&shape);
  if (!(winding(triangles, ball != nullptr ? pose.p_W : of_shape.front().vertices.front()) > 0.5L)) return {};
  if (ball == nullptr) {
    const auto surfaces = [&](const ConvexPart& p) {
      return smallest(of_mesh, [&](const ConvexPart& q) { return separation(p, q); });
    };
    if (!(smallest(of_shape, surfaces).gap_m > 0)) return {};
    throw std::invalid_argument("truth: no separation of what is inside of a mesh that is not convex");
  }
  const ConvexPart centre{0, {pose.p_W}, {}, {}, 0};
  Separation found = smallest(of_mesh, [&](const ConvexPart& part) { return separation(centre, part); });
  if (!(found.gap_m > 0)) return {};  // on the surface
  found.gap_m = -found.gap_m - ball->radius_m;
  found.normal = -1 * found.normal;
  found.on_a = pose.p_W + static_cast<Real>(ball->radius_m) * found.normal;
  return found;
}

}  // namespace

std::string no_separation(const Shape& a, const Shape& b) {
  const auto is = [](const Shape& shape, auto kind) { return std::holds_alternative<decltype(kind)>(shape); };
  const bool none = is(a, std::monostate{}) || is(b, std::monostate{});
  const bool planes = is(a, Plane{}) && is(b, Plane{});
  const auto beside_cylinder = [&](const Shape& other) { return is(other, Sphere{}) || is(other, Plane{}); };
  const bool cylinder = (is(a, Cylinder{}) && !beside_cylinder(b)) || (is(b, Cylinder{}) && !beside_cylinder(a));
  return none || planes || cylinder ? std::string(name_of(a)) + " against " + name_of(b) : std::string();
}

Separation separation(const Shape& shape_a, const Pose& pose_a, const Shape& shape_b, const Pose& pose_b, Gap wanted) {
  const Shape a = filled(shape_a), b = filled(shape_b);
  if (std::holds_alternative<Plane>(a)) return swapped(separation(b, pose_b, a, pose_a));
  if (const auto* plane = std::get_if<Plane>(&b)) {
    const HalfSpace half = half_space(*plane);
    if (const auto* cylinder = std::get_if<Cylinder>(&a)) return above(round_bar(*cylinder, pose_a), half);
    return smallest(convex_parts_of(a, pose_a), [&](const ConvexPart& part) { return above(part, half); });
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&b))
    return from_ball(pose_a.p_W, std::get<Sphere>(a).radius_m, round_bar(*cylinder, pose_b));
  if (std::holds_alternative<Cylinder>(a)) return swapped(separation(b, pose_b, a, pose_a));
  if (std::holds_alternative<Mesh>(b))
    if (const auto within = inside_mesh(a, pose_a, std::get<Mesh>(b), pose_b)) return *within;
  if (std::holds_alternative<Mesh>(a))
    if (const auto within = inside_mesh(b, pose_b, std::get<Mesh>(a), pose_a)) return swapped(*within);
  const std::vector<ConvexPart> of_a = convex_parts_of(a, pose_a), of_b = convex_parts_of(b, pose_b);
  return smallest(of_a, [&](const ConvexPart& p) {
    return smallest(of_b, [&](const ConvexPart& q) { return separation(p, q, wanted); });
  });
}

Real given_round_off(const Scene& scene, int body_a, int body_b) {
  const auto numbers = [](const Body& body) {
    if (const auto* plane = std::get_if<Plane>(&body.shape)) return std::fabs(static_cast<Real>(plane->offset_m));
    const Real at = norm({body.position_m[0], body.position_m[1], body.position_m[2]});
    if (const auto* drum = std::get_if<Cylinder>(&body.shape))
      return at + std::hypot(Real(drum->radius_m), Real(drum->half_length_m));
    Real size = 0;
    for (const ConvexPart& part : convex_parts_of(body.shape, Pose{}))
      for (const Vector& v : part.vertices) size = std::max(size, norm(v) + part.radius_m);
    return at + size;
  };
  constexpr Real double_rounding = 0x1p-52L;
  return 4 * double_rounding *
         (numbers(scene.bodies.at(static_cast<std::size_t>(body_a))) +
          numbers(scene.bodies.at(static_cast<std::size_t>(body_b))));
}

Separation separation_between(const Scene& scene, int body_a, int body_b) {
  const Body &a = scene.bodies.at(static_cast<std::size_t>(body_a)),
             &b = scene.bodies.at(static_cast<std::size_t>(body_b));
  require(a.shape, b.shape);
  return separation(a.shape, initial(a), b.shape, initial(b));
}

Separation separation_between(const Scene& scene, const SampleView& sample, int body_a, int body_b) {
  const auto a = static_cast<std::size_t>(body_a), b = static_cast<std::size_t>(body_b);
  const Shape &shape_a = scene.bodies.at(a).shape, &shape_b = scene.bodies.at(b).shape;
  require(shape_a, shape_b);
  return separation(shape_a, sampled(checked(sample.bodies, a)), shape_b, sampled(checked(sample.bodies, b)));
}

Real overlap_depth(const Scene& scene, const SampleView& sample, int body_a, int body_b) {
  const auto a = static_cast<std::size_t>(body_a), b = static_cast<std::size_t>(body_b);
  const Shape &shape_a = scene.bodies.at(a).shape, &shape_b = scene.bodies.at(b).shape;
  require(shape_a, shape_b);
  const Separation found = separation(shape_a, sampled(checked(sample.bodies, a)), shape_b,
                                      sampled(checked(sample.bodies, b)), Gap::of_overlap);
  return std::max<Real>(0, -found.gap_m);
}

namespace {

std::array<Wide, 3> wide(const Vector& v) { return {v[0], v[1], v[2]}; }

void answer_pair(const Scene& scene, int a, int b, const ContactQuery& query, ContactAnswer& answer) {
  if (query.swept) {
    const auto touch = first_touch(scene, a, b, query.t_end_s);
    if (!touch) return;
    if (!touch->decided)
      throw std::invalid_argument("truth: `" + scene.bodies[static_cast<std::size_t>(a)].name + "` and `" +
                                  scene.bodies[static_cast<std::size_t>(b)].name +
                                  "` are near each other for too many steps to tell whether they touch");
    answer.touches.push_back({a, b, touch->t_s, wide(touch->x_m), wide(touch->normal)});
    return;
  }
  const Separation found = separation_between(scene, a, b);
  if (found.gap_m > found.bar_m + given_round_off(scene, a, b)) return;
  const Real depth = found.gap_m < 0 ? -found.gap_m : 0;
  answer.contacts.push_back({a, b, wide(Real(0.5) * (found.on_a + found.on_b)), wide(found.normal), depth});
}

}  // namespace

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query) {
  ContactAnswer answer;
  const int n = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      const Body &one = scene.bodies[static_cast<std::size_t>(a)], &other = scene.bodies[static_cast<std::size_t>(b)];
      const bool shapeless = one.shape.index() == 0 || other.shape.index() == 0;
      if (shapeless || (one.fixed && other.fixed)) continue;
      answer_pair(scene, a, b, query, answer);
    }
  return answer;
}

PairGap pair_gap(const Scene& scene, int body_a, int body_b) {
  const Separation found = separation_between(scene, body_a, body_b);
  return {found.gap_m, wide(found.normal), wide(Real(0.5) * (found.on_a + found.on_b)),
          static_cast<double>(found.bar_m), static_cast<double>(found.margin_m)};
}

}  // namespace atwood::geometry
