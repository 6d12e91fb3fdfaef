#include "collision/convex_manifold.hpp"

#include <limits>
#include <vector>

namespace atwood {
namespace {

// A vertex of a polygon that is clipped.
template <class S> struct Marked {
  Vec3<S> x;             // A's axes
  std::uint32_t id = 0;  // a hash of the features it comes from: the same contact keeps it from step to step
};
template <class S> using Polygon = std::vector<Marked<S>>;

// A hash of two feature ids.
std::uint32_t hash_ids(std::uint32_t a, std::uint32_t b) {
  return (a ^ (b + 0x9e3779b9u + (a << 6) + (a >> 2))) * 0x85ebca6bu;
}

constexpr int kRimPoints = 16;

// The feature of a part that faces the other part: a polygon, a disc (a cylinder's cap), an edge (of a polyhedron, or
// the line of a cylinder's side), or none of these.
template <class S> struct Feature {
  enum Kind { none, edge, polygon, disc } kind = none;
  int index = 0;
  Vec3<S> normal;         // of the face, outwards
  Vec3<S> center, along;  // disc: its centre; edge: its unit direction
  S misfit{};             // |normal - direction|, or |along . direction|
};

template <class S> struct PlacedPart {
  const ConvexPart<S>& part;
  const Transform<S>& pose;  // in A's axes
};

// The largest sine of the angle between directions that count as parallel.
template <class S> constexpr S parallel_tolerance() { return sizeof(S) == 4 ? S(2e-3) : S(1e-6); }

// The face whose normal is nearest to `outwards`; with at_vertex >= 0 only faces that have this vertex. Of a cylinder:
// the cap on that side.
template <class S> Feature<S> nearest_face(const PlacedPart<S>& body, const Vec3<S>& outwards, int at_vertex = -1) {
  Feature<S> face;
  const Vec3<S> d = to_body(body.pose, outwards);
  if (body.part.polyhedral()) {
    const auto faces = body.part.faces();
    S most{-2};
    for (int f = 0; f < static_cast<int>(faces.size()); ++f) {
      const S here = dot(faces[f].normal, d);
      if (!(here > most)) continue;
      bool touches = at_vertex < 0;
      for (const int corner : body.part.loop(faces[f])) touches = touches || corner == at_vertex;
      if (touches) most = here, face.index = f, face.kind = Feature<S>::polygon;
    }
    if (face.kind == Feature<S>::polygon) face.normal = to_world(body.pose, faces[face.index].normal);
  } else {
    const S sign = d.z < S(0) ? S(-1) : S(1);
    face.kind = Feature<S>::disc;
    face.index = d.z < S(0) ? 1 : 0;
    face.normal = sign * body.pose.axis_W[2];
    face.center = body.pose.p_W + (sign * body.part.half.z) * body.pose.axis_W[2];
  }
  face.misfit = norm(face.normal - outwards);
  return face;
}

// The edge with the vertex at_vertex that is most nearly perpendicular to `outwards`; of a cylinder: the line of its
// side. Kind `none` if none is perpendicular within parallel_tolerance.
template <class S> Feature<S> nearest_edge(const PlacedPart<S>& body, const Vec3<S>& outwards, int at_vertex) {
  Feature<S> found;
  found.misfit = parallel_tolerance<S>();
  if (!body.part.polyhedral()) {
    const S tilt = real::abs(dot(body.pose.axis_W[2], outwards));
    if (tilt <= found.misfit) found.kind = Feature<S>::edge, found.along = body.pose.axis_W[2], found.misfit = tilt;
    return found;
  }
  const auto edges = body.part.edges();
  const Vec3<S> d = to_body(body.pose, outwards);
  for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
    if (edges[e].from != at_vertex && edges[e].to != at_vertex) continue;
    const S tilt = real::abs(dot(edges[e].along, d));
    if (tilt <= found.misfit) found.kind = Feature<S>::edge, found.index = e, found.misfit = tilt;
  }
  if (found.kind == Feature<S>::edge) found.along = to_world(body.pose, edges[found.index].along);
  return found;
}

// Appends the ends of the cylinder's side line that lies farthest along `outwards`; their ids are 101 and 102.
template <class S> void add_side(const PlacedPart<S>& body, const Vec3<S>& outwards, Polygon<S>& out) {
  const Vec3<S> d = to_body(body.pose, outwards), radial = unit_vector(Vec3<S>{d.x, d.y, S(0)});
  const Vec3<S>& h = body.part.half;
  for (const S z : {-h.z, h.z})
    out.push_back({point_to_world(body.pose, {h.x * radial.x, h.x * radial.y, z}), z < S(0) ? 101u : 102u});
}

// The vertices of a feature. Of a disc: kRimPoints points of its rim, of which the first lies farthest along
// `outwards`. Of a part without a feature: all of its vertices.
template <class S>
void outline(const PlacedPart<S>& body, const Feature<S>& feature, const Vec3<S>& outwards, Polygon<S>& out) {
  out.clear();
  const auto vertices = body.part.vertices();
  if (feature.kind == Feature<S>::polygon) {
    for (const int corner : body.part.loop(body.part.faces()[feature.index]))
      out.push_back({point_to_world(body.pose, vertices[corner]), static_cast<std::uint32_t>(corner + 1)});
  } else if (feature.kind == Feature<S>::edge && body.part.polyhedral()) {
    const auto& edge = body.part.edges()[feature.index];
    for (const int corner : {edge.from, edge.to})
      out.push_back({point_to_world(body.pose, vertices[corner]), static_cast<std::uint32_t>(corner + 1)});
  } else if (feature.kind == Feature<S>::edge) {
    add_side(body, outwards, out);
  } else if (feature.kind == Feature<S>::disc) {
    // Rim points start along the projected normal; along the body's x axis where the tilt is round-off.
    const Vec3<S> d = to_body(body.pose, outwards), tilt{d.x, d.y, S(0)};
    const bool level = norm(tilt) <= S(64) * real::epsilon<S>();
    const Vec3<S> u = level ? body.pose.axis_W[0] : to_world(body.pose, unit_vector(tilt)),
                  v = cross(feature.normal, u);
    for (int k = 0; k < kRimPoints; ++k) {
      S sine, cosine;
      real::sin_cos(S(k) * (S(6.283185307179586476925286766559L) / S(kRimPoints)), sine, cosine);
      out.push_back(
          {feature.center + body.part.half.x * (cosine * u + sine * v), 200u + static_cast<std::uint32_t>(k)});
    }
  } else {
    for (std::size_t i = 0; i < vertices.size(); ++i)
      out.push_back({point_to_world(body.pose, vertices[i]), static_cast<std::uint32_t>(i + 1)});
  }
}

// Keeps the part with side . (x - at) <= 0. Two points are a segment; three or more a closed polygon (Sutherland,
// Hodgman 1974). New vertices get ids that are made of `id` and the ends of the edge that was cut.
template <class S>
void clip(Polygon<S>& polygon, const Vec3<S>& at, const Vec3<S>& side, std::uint32_t id, Polygon<S>& scratch) {
  scratch.clear();
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Marked<S>&p = polygon[i], &q = polygon[(i + 1) % n];
    const S hp = dot(side, p.x - at), hq = dot(side, q.x - at);
    if (hp <= S(0)) scratch.push_back(p);
    if (n == 2 && i == 1) break;  // a segment has no second edge
    if ((hp < S(0) && hq > S(0)) || (hp > S(0) && hq < S(0)))
      scratch.push_back(
          {p.x + (hp / (hp - hq)) * (q.x - p.x), hash_ids(id, hash_ids(real::min(p.id, q.id), real::max(p.id, q.id)))});
  }
  if (n == 2 && scratch.size() == 3) scratch.pop_back();
  polygon.swap(scratch);
}

template <class S>
void clip_to_polygon(Polygon<S>& polygon, const Polygon<S>& face, const Vec3<S>& normal, Polygon<S>& scratch) {
  for (std::size_t i = 0; i < face.size() && !polygon.empty(); ++i) {
    const Marked<S>&p = face[i], &q = face[(i + 1) % face.size()];
    clip(polygon, p.x, cross(q.x - p.x, normal), 1000u + p.id, scratch);
  }
}

// Clips a point, segment or polygon to the prism over a cylinder's cap along `axis` (nearly the cap's normal). The
// result has the vertices inside the rim, the intersections of edges with the rim, and the rim's points inside the
// polygon.
template <class S>
void clip_to_disc(Polygon<S>& polygon, const PlacedPart<S>& body, const Feature<S>& disc, const Vec3<S>& axis,
                  Polygon<S>& scratch) {
  scratch.clear();
  const S r = body.part.half.x;
  const std::size_t n = polygon.size();
  const S upright = S(1) / dot(axis, disc.normal);
  const auto onto_cap = [&](const Vec3<S>& x) { return x - (dot(x, disc.normal) * upright) * axis; };
  for (std::size_t i = 0; i < n; ++i) {
    const Marked<S>&p = polygon[i], &q = polygon[(i + 1) % n];
    const Vec3<S> from = onto_cap(p.x - disc.center), along = onto_cap(q.x - p.x);
    if (dot(from, from) <= r * r) scratch.push_back(p);
    if (n == 1 || (n == 2 && i == 1)) break;
    const S a = dot(along, along), half_b = dot(from, along), c = dot(from, from) - r * r, d = half_b * half_b - a * c;
    if (!(a > S(0)) || !(d > S(0))) continue;
    const S root = real::sqrt(d);
    for (const S t : {(-half_b - root) / a, (-half_b + root) / a})
      if (t > S(0) && t < S(1)) scratch.push_back({p.x + t * (q.x - p.x), hash_ids(300u + (root > S(0)), p.id)});
  }
  if (n > 2) {
    static thread_local Polygon<S> rim;
    outline(body, disc, disc.normal, rim);
    Vec3<S> across = cross(polygon[1].x - polygon[0].x, polygon[2].x - polygon[0].x);
    for (std::size_t i = 3; i < n; ++i) across += cross(polygon[i - 1].x - polygon[0].x, polygon[i].x - polygon[0].x);
    const S slope = dot(across, axis);
    for (const Marked<S>& x : rim) {
      bool inside = real::abs(slope) > S(0);
      for (std::size_t i = 0; i < n && inside; ++i) {
        const Vec3<S> side = cross(polygon[(i + 1) % n].x - polygon[i].x, axis);
        inside = (slope < S(0) ? -dot(side, x.x - polygon[i].x) : dot(side, x.x - polygon[i].x)) <= S(0);
      }
      if (!inside) continue;
      // The rim's point is moved along the axis into the polygon's plane. It is left out where an edge crosses the rim
      // at this point.
      const Vec3<S> onto = x.x + (dot(across, polygon[0].x - x.x) / slope) * axis;
      bool known = false;
      for (const Marked<S>& other : scratch) known = known || norm(other.x - onto) <= parallel_tolerance<S>() * r;
      if (!known) scratch.push_back({onto, x.id});
    }
  }
  polygon.swap(scratch);
}

// The ends of the common part of two parallel edges, as points of b. `a` and `b` hold the ends of the edges.
template <class S>
void common_segment(const Polygon<S>& a, const Polygon<S>& b, const Vec3<S>& along, std::vector<Marked<S>>& on_b,
                    Polygon<S>& scratch) {
  on_b = b;
  const bool forward = dot(along, a[1].x - a[0].x) >= S(0);
  clip(on_b, a[forward ? 0 : 1].x, -along, 2000u + a[forward ? 0 : 1].id, scratch);
  if (on_b.size() == 2) clip(on_b, a[forward ? 1 : 0].x, along, 2000u + a[forward ? 1 : 0].id, scratch);
}

template <class S> struct Scratch {
  Polygon<S> reference, incident, spare;
  std::vector<ContactPoint<S>> candidates;
};

// The contact point halfway between two surfaces. on_a: the point of a's core; core_gap: the distance of the two cores
// along the normal.
template <class S>
ContactPoint<S> between_surfaces(const Vec3<S>& on_a, S core_gap, const NearestFeatures<S>& features, S radius_a,
                                 S radius_b, std::uint32_t id) {
  const S gap = core_gap - radius_a - radius_b;
  return {on_a + (radius_a + gap / S(2)) * features.normal, gap, id};
}

template <class S>
void copy_four(const std::vector<ContactPoint<S>>& candidates, const Vec3<S>& normal, Manifold<S>& manifold) {
  const int n = static_cast<int>(candidates.size());
  manifold.count = real::min(n, 4);
  if (n <= 4) {
    for (int i = 0; i < n; ++i) manifold.points[i] = candidates[i];
    return;
  }
  const auto best = [&](auto measure) {
    int found = 0;
    S most = measure(candidates[0]);
    for (int i = 1; i < n; ++i)
      if (const S here = measure(candidates[i]); here > most) most = here, found = i;
    return candidates[found];
  };
  const ContactPoint<S> first = best([](const ContactPoint<S>& p) { return -p.gap; });
  const auto from_first = [&](const ContactPoint<S>& p) { return p.x_W - first.x_W; };
  const ContactPoint<S> second = best([&](const ContactPoint<S>& p) { return dot(from_first(p), from_first(p)); });
  const Vec3<S> across = cross(normal, from_first(second));
  const ContactPoint<S> left = best([&](const ContactPoint<S>& p) { return dot(across, from_first(p)); });
  const ContactPoint<S> right = best([&](const ContactPoint<S>& p) { return -dot(across, from_first(p)); });
  manifold.points[0] = first, manifold.points[1] = second;
  manifold.count = 2;
  if (dot(across, from_first(left)) > S(0)) manifold.points[manifold.count++] = left;
  if (dot(across, from_first(right)) < S(0)) manifold.points[manifold.count++] = right;
}

}  // namespace

template <class S>
void keep_four(const std::vector<ContactPoint<S>>& candidates, const Vec3<S>& normal, Manifold<S>& manifold) {
  copy_four(candidates, normal, manifold);
  manifold.type = manifold.count > 2    ? ManifoldType::face
                  : manifold.count == 2 ? ManifoldType::edge
                                        : ManifoldType::point;
}

template <class S>
void contact_points(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                    const NearestFeatures<S>& features, S margin, Manifold<S>& manifold) {
  static thread_local Scratch<S> scratch;
  const Transform<S> own;
  const PlacedPart<S> body_a{a, own}, body_b{b, b_in_a};
  const Vec3<S>& n = features.normal;
  manifold.normal_W = n;
  manifold.count = 0;
  manifold.solve = features.solve;
  std::vector<ContactPoint<S>>& found = scratch.candidates;
  found.clear();
  const auto add = [&](const Vec3<S>& on_a, S core_gap, std::uint32_t id) {
    if (core_gap - a.radius - b.radius > margin) return;
    const ContactPoint<S> made = between_surfaces(on_a, core_gap, features, a.radius, b.radius, id);
    // Two edges that are cut at their common corner give one point.
    const S same = S(64) * real::epsilon<S>() * (norm(made.x_W) + norm(b_in_a.p_W));
    for (const ContactPoint<S>& other : found)
      if (norm(other.x_W - made.x_W) <= same) return;
    found.push_back(made);
  };
  int vertex_a = 0, vertex_b = 0;
  support(a, n, vertex_a);
  support(b, to_body(b_in_a, -n), vertex_b);
  const Feature<S> face_a = nearest_face(body_a, n), face_b = nearest_face(body_b, -n);
  const bool flat_a = face_a.kind != Feature<S>::none && face_a.misfit <= parallel_tolerance<S>();
  const bool flat_b = face_b.kind != Feature<S>::none && face_b.misfit <= parallel_tolerance<S>();
  bool by_edges = false;
  if (flat_a || flat_b) {
    // The reference face is the one that is better aligned with the normal; a polygon goes before a cap.
    const bool to_a =
        flat_a &&
        (!flat_b || (face_a.kind == Feature<S>::disc) < (face_b.kind == Feature<S>::disc) ||
         ((face_a.kind == Feature<S>::disc) == (face_b.kind == Feature<S>::disc) && face_a.misfit <= face_b.misfit));
    const Feature<S>& face = to_a ? face_a : face_b;
    const PlacedPart<S>&reference = to_a ? body_a : body_b, &other = to_a ? body_b : body_a;
    const Vec3<S> towards = to_a ? -n : n;  // from the other to the reference
    Feature<S> incident = nearest_face(other, towards, to_a ? vertex_b : vertex_a);
    if (!other.part.polyhedral() && dot(incident.normal, towards) < S(0.7))
      incident.kind = Feature<S>::edge;  // its side
    outline(other, incident, towards, scratch.incident);
    if (face.kind == Feature<S>::disc) {
      clip_to_disc(scratch.incident, reference, face, -towards, scratch.spare);
    } else {
      outline(reference, face, -towards, scratch.reference);
      clip_to_polygon(scratch.incident, scratch.reference, -towards, scratch.spare);
    }
    const Vec3<S> at = face.kind == Feature<S>::disc ? face.center : scratch.reference[0].x;
    const S upright = S(1) / -dot(face.normal, towards);
    for (const Marked<S>& p : scratch.incident) {
      const S height = dot(face.normal, p.x - at) * upright;  // over the reference face, along the contact's normal
      add(to_a ? p.x + height * towards : p.x, height,
          hash_ids(p.id, (to_a ? 1u : 2u) + 8u * static_cast<std::uint32_t>(face.index)));
    }
  } else {
    const Feature<S> edge_a = nearest_edge(body_a, n, vertex_a), edge_b = nearest_edge(body_b, -n, vertex_b);
    by_edges = edge_a.kind == Feature<S>::edge && edge_b.kind == Feature<S>::edge;
    if (by_edges && norm(cross(edge_a.along, edge_b.along)) <= parallel_tolerance<S>()) {
      outline(body_a, edge_a, n, scratch.reference);
      outline(body_b, edge_b, -n, scratch.incident);
      static thread_local Polygon<S> common;
      common_segment(scratch.reference, scratch.incident, edge_a.along, common, scratch.spare);
      for (const Marked<S>& p : common) {
        const S gap = dot(n, p.x - scratch.reference[0].x);
        add(p.x - gap * n, gap, p.id);
      }
    }
  }
  // Of faces that are nearly parallel the deepest vertex may lie outside the reference face and have been clipped away:
  // then the nearest features' point replaces the points near it.
  S deepest = std::numeric_limits<S>::infinity();
  for (const ContactPoint<S>& p : found) deepest = real::min(deepest, p.gap);
  const S size = norm(features.on_a) + norm(b_in_a.p_W) + (found.empty() ? S(0) : norm(found.front().x_W));
  const S round_off = S(256) * real::epsilon<S>() * size;
  const bool lost = real::is_finite(features.gap) && deepest > features.gap - a.radius - b.radius + round_off;
  if (lost)
    std::erase_if(found, [&](const auto& p) {
      return norm(p.x_W - (features.on_a + a.radius * n)) <= parallel_tolerance<S>() * size;
    });
  if (found.empty() || lost)
    add(features.on_a, features.gap,
        hash_ids(static_cast<std::uint32_t>(vertex_a + 2), static_cast<std::uint32_t>(vertex_b + 2)));
  keep_four(found, n, manifold);
  if (by_edges && manifold.count < 2) manifold.type = ManifoldType::edge_edge;
}

#define ATWOOD_CONVEX_MANIFOLD(S)                                                                  \
  template void contact_points<S>(const ConvexPart<S>&, const ConvexPart<S>&, const Transform<S>&, \
                                  const NearestFeatures<S>&, S, Manifold<S>&);                     \
  template void keep_four<S>(const std::vector<ContactPoint<S>>&, const Vec3<S>&, Manifold<S>&);
ATWOOD_CONVEX_MANIFOLD(float)
ATWOOD_CONVEX_MANIFOLD(double)
ATWOOD_CONVEX_MANIFOLD(long double)
#undef ATWOOD_CONVEX_MANIFOLD

}  // namespace atwood
