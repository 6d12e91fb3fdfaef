// Candidate contacts of a scene: which features of which body may touch which surface of which other.
#include "contact/event/proximity.hpp"

#include <algorithm>
#include <cmath>

#include "collision/contacts.hpp"
#include "collision/hull_triangles.hpp"

namespace atwood::event {

namespace {

const char* shape_name(const Shape& shape) {
  constexpr const char* names[] = {"point",   "sphere",   "plane",  "rectangle", "box",
                                   "capsule", "cylinder", "convex", "mesh",      "compound"};
  return names[shape.index()];
}

template <class S> ContactFeature<S> vertex(const Vec3<S>& at_B) { return {at_B, S(0), false, false, {}}; }

template <class S>
void box_vertices(const Real3& half, const Vec3<S>& p, const Quat<S>& q, std::vector<ContactFeature<S>>& features) {
  for (int i = 0; i < 8; ++i) {
    const Vec3<S> at{S(i & 1 ? half[0] : -half[0]), S(i & 2 ? half[1] : -half[1]), S(i & 4 ? half[2] : -half[2])};
    features.push_back(vertex(p + rotate(q, at)));
  }
}

template <class S> void sphere_ends(double radius_m, double half_length_m, std::vector<ContactFeature<S>>& features) {
  for (const double z : {-half_length_m, half_length_m})
    features.push_back({{S(0), S(0), S(z)}, S(radius_m), false, z == 0, {}});
}

// The features of a shape that may touch a plane: vertices, spheres at ends, circles.
template <class S> std::vector<ContactFeature<S>> features_of_shape(const Shape& shape) {
  std::vector<ContactFeature<S>> features;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) features.push_back({{}, S(sphere->radius_m), false, true, {}});
  if (const auto* box = std::get_if<Box>(&shape)) box_vertices<S>(box->half_extents_m, {}, {}, features);
  if (const auto* sheet = std::get_if<Rectangle>(&shape)) {
    for (int i = 0; i < 4; ++i)
      features.push_back(vertex(Vec3<S>{S(i & 1 ? 1 : -1) * S(sheet->half_extents_m[0]),
                                        S(i & 2 ? 1 : -1) * S(sheet->half_extents_m[1]), S(0)}));
  }
  if (const auto* capsule = std::get_if<Capsule>(&shape))
    sphere_ends(capsule->radius_m, capsule->half_length_m, features);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape))
    for (const double z : {-cylinder->half_length_m, cylinder->half_length_m})
      features.push_back({{S(0), S(0), S(z)}, S(cylinder->radius_m), true, false, {S(0), S(0), S(1)}});
  if (const auto* hull = std::get_if<Convex>(&shape))
    for (const Real3& point : hull->points_m) features.push_back(vertex(narrow3<S>(point)));
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    for (const Real3& point : mesh->points_m) features.push_back(vertex(narrow3<S>(point)));
  if (const auto* compound = std::get_if<Compound>(&shape))
    for (const auto& part : compound->boxes) {
      const Real4& q = part.orientation_wxyz;
      box_vertices<S>(part.half_extents_m, narrow3<S>(part.position_body_m),
                      normalised(Quat<S>{S(q[0]), S(q[1]), S(q[2]), S(q[3])}), features);
    }
  return features;
}

template <class S> bool is_flat(const std::vector<FacetTriangle<S>>& mesh) {
  if (mesh.empty()) return false;
  const FacetTriangle<S>& first = mesh.front();
  return std::all_of(mesh.begin(), mesh.end(), [&](const FacetTriangle<S>& triangle) {
    return std::all_of(triangle.corner_B, triangle.corner_B + 3, [&](const Vec3<S>& corner) {
      const Vec3<S> from = corner - first.corner_B[0];
      return real::abs(dot(from, first.normal_B)) <= S(64) * real::epsilon<S>() * (norm(from) + norm(corner));
    });
  });
}

template <class S> Surface<S> mesh_surface(const Mesh& mesh) {
  Surface<S> surface;
  surface.kind = SurfaceKind::mesh;
  for (const auto& corners : mesh.triangles) {
    FacetTriangle<S> triangle;
    for (int i = 0; i < 3; ++i) triangle.corner_B[i] = narrow3<S>(mesh.points_m[static_cast<std::size_t>(corners[i])]);
    const Vec3<S> n = cross(triangle.corner_B[1] - triangle.corner_B[0], triangle.corner_B[2] - triangle.corner_B[0]);
    if (!(norm(n) > S(0))) continue;
    triangle.normal_B = (S(1) / norm(n)) * n;
    surface.mesh.push_back(triangle);
  }
  surface.flat = is_flat(surface.mesh);
  return surface;
}

// The surface of a shape for contacts with spheres. False: it has none.
template <class S> bool surface_for_spheres(const Shape& shape, Surface<S>& surface) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    surface.kind = SurfaceKind::point;
    surface.radius = S(sphere->radius_m);
    return true;
  }
  if (const auto* box = std::get_if<Box>(&shape)) {
    surface.kind = SurfaceKind::slab;
    surface.half_extents = narrow3<S>(box->half_extents_m);
    return true;
  }
  if (const auto* sheet = std::get_if<Rectangle>(&shape)) {
    surface.kind = SurfaceKind::slab;
    surface.half_extents = {S(sheet->half_extents_m[0]), S(sheet->half_extents_m[1]), S(0)};
    return true;
  }
  if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    surface.kind = SurfaceKind::segment;
    surface.radius = S(capsule->radius_m);
    surface.half_extents = {S(0), S(0), S(capsule->half_length_m)};
    return true;
  }
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    surface = mesh_surface<S>(*mesh);
    return true;
  }
  if (const auto* hull = std::get_if<Convex>(&shape)) {
    surface = mesh_surface<S>(Mesh{{}, hull->points_m, hull_triangles(hull->points_m)});
    surface.convex = true;
    surface.flat = false;
    return !surface.mesh.empty();
  }
  return false;
}

bool has_features_for_faces(const Shape& shape) {
  return std::holds_alternative<Box>(shape) || std::holds_alternative<Convex>(shape) ||
         std::holds_alternative<Capsule>(shape) || std::holds_alternative<Cylinder>(shape);
}
template <class S> bool has_faces(const Shape& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return mesh_surface<S>(*mesh).flat;
  return std::holds_alternative<Rectangle>(shape) || std::holds_alternative<Box>(shape);
}

template <class S> S bounding_radius_of(const Shape& shape) {
  S radius = S(0);
  for (const ContactFeature<S>& feature : features_of_shape<S>(shape))
    radius = real::max(radius, norm(feature.center_B) + feature.radius);
  return radius;
}

struct Builder {
  const Scene& scene;

  template <class S>
  void add(Proximity<S>& proximity, ShapePair<S>& pair, int index, int feature_body, int surface_body,
           std::vector<ContactFeature<S>> features, Surface<S> surface) const {
    proximity.surfaces.push_back(std::move(surface));
    if (std::holds_alternative<Cylinder>(scene.bodies[feature_body].shape)) {
      proximity.has_circles = true;
      pair.flat_end_refusal = "an end of cylinder `" + scene.bodies[feature_body].name + "` lies flat on " +
                              shape_name(scene.bodies[surface_body].shape) + " `" + scene.bodies[surface_body].name +
                              "`: +event has contacts of single points of its rim";
    }
    for (const ContactFeature<S>& feature : features) {
      Candidate<S> candidate;
      candidate.pair = index;
      candidate.feature_body = feature_body;
      candidate.surface_body = surface_body;
      candidate.surface = static_cast<int>(proximity.surfaces.size()) - 1;
      candidate.feature = feature;
      proximity.candidates.push_back(candidate);
      ++pair.count;
    }
  }

  // Candidates of one body's features over the other's surface. False: there are none this way round.
  template <class S>
  bool meet(Proximity<S>& proximity, ShapePair<S>& pair, int index, int feature_body, int surface_body) const {
    const Shape &k = scene.bodies[feature_body].shape, &s = scene.bodies[surface_body].shape;
    Surface<S> surface;
    if (const auto* plane = std::get_if<Plane>(&s)) {
      const Vec3<S> normal = narrow3<S>(plane->normal);
      const S length = norm(normal);
      surface.normal_W = (S(1) / length) * normal;
      surface.offset = S(plane->offset_m) / length;
      auto features = features_of_shape<S>(k);
      if (features.empty()) return false;
      add(proximity, pair, index, feature_body, surface_body, std::move(features), std::move(surface));
      pair.plane = static_cast<int>(proximity.surfaces.size()) - 1;
      pair.plane_is_a = surface_body == pair.a;
      return true;
    }
    if (std::holds_alternative<Sphere>(k) && surface_for_spheres(s, surface)) {
      if (has_concave_edges(surface))
        pair.boundary_refusal = std::string("sphere `") + scene.bodies[feature_body].name +
                                "` touches two facets of mesh `" + scene.bodies[surface_body].name + "` at once";
      add(proximity, pair, index, feature_body, surface_body, features_of_shape<S>(k), std::move(surface));
      return true;
    }
    return meet_faces(proximity, pair, index, feature_body, surface_body);
  }

  // Vertices, sphere ends and circles over faces: all contacts of a shape with faces as long as no body overlaps a
  // boundary (surface_boundaries.hpp); in both directions where both shapes have both.
  template <class S>
  bool meet_faces(Proximity<S>& proximity, ShapePair<S>& pair, int index, int feature_body, int surface_body) const {
    const Shape &k = scene.bodies[feature_body].shape, &s = scene.bodies[surface_body].shape;
    Surface<S> surface;
    if (!has_features_for_faces(k) || !has_faces<S>(s) || !surface_for_spheres(s, surface)) return false;
    // Without a distance test between the two, an overlapped boundary would go unseen.
    if (missing_contact_test(make_geometry<S>(k).kind, make_geometry<S>(s).kind) != nullptr) return false;
    pair.boundary_refusal = std::string("atwood's +event has no contact of ") + shape_name(k) + " `" +
                            scene.bodies[feature_body].name + "` with the end of " + shape_name(s) + " `" +
                            scene.bodies[surface_body].name + "`, over which it lies";
    FaceBoundary<S> boundary{index, feature_body,      surface_body, make_geometry<S>(k), make_geometry<S>(s),
                             {},    {S(0), S(0), S(1)}};
    boundary.thick = surface.kind != SurfaceKind::mesh && !std::holds_alternative<Rectangle>(s);
    if (surface.kind == SurfaceKind::mesh) {
      boundary.on_it_B = surface.mesh.front().corner_B[0];
      boundary.normal_B = surface.mesh.front().normal_B;
    }
    proximity.boundaries.push_back(std::move(boundary));
    add(proximity, pair, index, feature_body, surface_body, features_of_shape<S>(k), std::move(surface));
    Surface<S> back;
    if (proximity.boundaries.back().thick && has_features_for_faces(s) && has_faces<S>(k) &&
        surface_for_spheres(k, back))
      add(proximity, pair, index, surface_body, feature_body, features_of_shape<S>(s), std::move(back));
    return true;
  }
};

}  // namespace

template <class S> void build_candidates(Bodies<S>& bodies, Proximity<S>& proximity, const Scene& scene) {
  const int n = static_cast<int>(scene.bodies.size());
  const Builder builder{scene};
  bodies.bounding_radius.resize(static_cast<std::size_t>(n));
  bodies.length_scale = S(0);
  for (int i = 0; i < n; ++i) {
    const Body& body = scene.bodies[i];
    bodies.bounding_radius[i] = bounding_radius_of<S>(body.shape);
    bodies.length_scale = real::max(bodies.length_scale, norm(narrow3<S>(body.position_m)) + bodies.bounding_radius[i]);
    if (const auto* plane = std::get_if<Plane>(&body.shape))
      bodies.length_scale =
          real::max(bodies.length_scale, real::abs(S(plane->offset_m)) / norm(narrow3<S>(plane->normal)));
  }
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      const Body &body_a = scene.bodies[a], &body_b = scene.bodies[b];
      if (body_a.shape.index() == 0 || body_b.shape.index() == 0 || (body_a.fixed && body_b.fixed)) continue;
      ShapePair<S> pair;
      pair.a = a;
      pair.b = b;
      const PairLaw& law = pair_law(scene, a, b);
      pair.restitution = S(law.restitution);
      pair.friction = S(law.friction);
      pair.rolling_friction_m = S(law.rolling_friction_m);
      pair.bounding_radii = bodies.bounding_radius[a] + bodies.bounding_radius[b];
      pair.first = static_cast<int>(proximity.candidates.size());
      pair.names = std::string(shape_name(body_a.shape)) + " `" + body_a.name + "` and " + shape_name(body_b.shape) +
                   " `" + body_b.name + "`";
      const int index = static_cast<int>(proximity.pairs.size());
      if (!builder.meet(proximity, pair, index, b, a) && !builder.meet(proximity, pair, index, a, b))
        pair.refusal = "atwood's +event has no contact between " + pair.names;
      proximity.pairs.push_back(std::move(pair));
    }
}

#define ATWOOD_CANDIDATES(S) template void build_candidates<S>(Bodies<S>&, Proximity<S>&, const Scene&);
ATWOOD_CANDIDATES(float)
ATWOOD_CANDIDATES(double)
ATWOOD_CANDIDATES(long double)
#undef ATWOOD_CANDIDATES

}  // namespace atwood::event
