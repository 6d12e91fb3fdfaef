#include "collision/convex_piece.hpp"

#include <cmath>

#include "collision/triangle_mesh.hpp"

namespace atwood {
namespace {

// Vertex i of the box lies at +x where bit 0 of i is set, +y where bit 1 is, +z where bit 2 is.
template <class S> const Hull<S>& unit_box() {
  static const Hull<S> hull = make_hull<S>(
      {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}});
  return hull;
}
template <class S> const Hull<S>& unit_rectangle() {
  static const Hull<S> hull = make_hull<S>({{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}});
  return hull;
}
template <class S> const Hull<S>& unit_segment() {
  static const Hull<S> hull = make_hull<S>({{0, 0, -1}, {0, 0, 1}});
  return hull;
}
template <class S> const Hull<S>& unit_point() {
  static const Hull<S> hull = make_hull<S>(std::vector<Real3>{{0, 0, 0}});
  return hull;
}
// Loops alone: front 0 1 2, back 2 1 0.
template <class S> const Hull<S>& triangle_loops() {
  static const Hull<S> hull = [] {
    Hull<S> loops;
    loops.corners = {0, 1, 2, 2, 1, 0};
    return loops;
  }();
  return hull;
}

template <class S> S signed_as(S size, S sign) { return sign < S(0) ? -size : size; }

template <class S> void set_vertices(ConvexPiece<S>& piece, const Hull<S>& form) {
  piece.form = &form;
  piece.own_count = static_cast<int>(form.vertices.size());
  for (int i = 0; i < piece.own_count; ++i) {
    const Vec3<S>& v = form.vertices[i];
    piece.own[i] = {v.x * piece.half.x, v.y * piece.half.y, v.z * piece.half.z};
  }
}

}  // namespace

template <class S> ConvexPiece<S> box_piece(const Vec3<S>& half_extents) {
  ConvexPiece<S> piece;
  piece.core = half_extents.z > S(0) ? Core::box : Core::rectangle;
  piece.half = half_extents;
  set_vertices(piece, piece.core == Core::box ? unit_box<S>() : unit_rectangle<S>());
  return piece;
}

template <class S> bool convex_piece(const Geometry<S>& geometry, ConvexPiece<S>& piece) {
  switch (geometry.kind) {
    case ShapeKind::sphere:
      piece.core = Core::point;
      piece.radius = geometry.radius;
      set_vertices(piece, unit_point<S>());
      return true;
    case ShapeKind::capsule:
      piece.core = Core::segment;
      piece.radius = geometry.radius;
      piece.half = {S(0), S(0), geometry.half_length};
      set_vertices(piece, unit_segment<S>());
      return true;
    case ShapeKind::rectangle:
    case ShapeKind::box: piece = box_piece(geometry.half_extents); return true;
    case ShapeKind::cylinder:
      piece.core = Core::cylinder;
      piece.half = {geometry.radius, geometry.radius, geometry.half_length};
      return true;
    case ShapeKind::convex:
      piece.core = Core::hull;
      piece.form = geometry.hull.get();
      return piece.form && !piece.form->vertices.empty();
    case ShapeKind::mesh:
      piece.core = Core::hull;
      piece.form = geometry.mesh ? geometry.mesh->solid.get() : nullptr;
      return piece.form != nullptr;
    default: return false;
  }
}

template <class S>
ConvexPiece<S> triangle_piece(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, const Vec3<S>& normal) {
  ConvexPiece<S> piece;
  piece.core = Core::triangle;
  piece.form = &triangle_loops<S>();
  piece.own_count = 3;
  piece.own[0] = a, piece.own[1] = b, piece.own[2] = c;
  piece.sides[0] = {normal, dot(normal, a), 0, 3};
  piece.sides[1] = {-normal, -dot(normal, a), 3, 3};
  for (int k = 0; k < 3; ++k) piece.rim[k] = {k, (k + 1) % 3, 0, 1, unit_vector(piece.own[(k + 1) % 3] - piece.own[k])};
  return piece;
}

template <class S> Vec3<S> support(const ConvexPiece<S>& piece, const Vec3<S>& d, int& vertex) {
  const Vec3<S>& h = piece.half;
  switch (piece.core) {
    case Core::point: vertex = 0; return {};
    case Core::segment: vertex = d.z > S(0) ? 1 : 0; return piece.own[vertex];
    case Core::rectangle: vertex = (d.x > S(0) ? 1 : 0) + (d.y > S(0) ? 2 : 0); return piece.own[vertex];
    case Core::box:
      vertex = (d.x > S(0) ? 1 : 0) + (d.y > S(0) ? 2 : 0) + (d.z > S(0) ? 4 : 0);
      return piece.own[vertex];
    case Core::triangle: {
      const S a = dot(d, piece.own[0]), b = dot(d, piece.own[1]), c = dot(d, piece.own[2]);
      vertex = a >= b ? (a >= c ? 0 : 2) : (b >= c ? 1 : 2);
      return piece.own[vertex];
    }
    case Core::hull:
      vertex = farthest_vertex(*piece.form, d, real::max(vertex, 0));
      return piece.form->vertices[vertex];
    case Core::cylinder: break;
  }
  vertex = -1;
  const Vec3<S> radial = unit_vector(Vec3<S>{d.x, d.y, S(0)});
  return {h.x * radial.x, h.x * radial.y, signed_as(h.z, d.z)};
}

template <class S> Placement<S> relative_placement(const Placement<S>& place_a, const Placement<S>& place_b) {
  return {turned_back(place_a, place_b.p_W - place_a.p_W),
          {turned_back(place_a, place_b.axis_W[0]), turned_back(place_a, place_b.axis_W[1]),
           turned_back(place_a, place_b.axis_W[2])}};
}

#define ATWOOD_PIECE(S)                                                                                      \
  template bool convex_piece<S>(const Geometry<S>&, ConvexPiece<S>&);                                        \
  template ConvexPiece<S> box_piece<S>(const Vec3<S>&);                                                      \
  template ConvexPiece<S> triangle_piece<S>(const Vec3<S>&, const Vec3<S>&, const Vec3<S>&, const Vec3<S>&); \
  template Vec3<S> support<S>(const ConvexPiece<S>&, const Vec3<S>&, int&);                                  \
  template Placement<S> relative_placement<S>(const Placement<S>&, const Placement<S>&);
ATWOOD_PIECE(float)
ATWOOD_PIECE(double)
ATWOOD_PIECE(long double)
#undef ATWOOD_PIECE

}  // namespace atwood
