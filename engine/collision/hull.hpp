// Convex polyhedra: the hull of points, its faces as whole polygons.
#pragma once

#include <memory>
#include <vector>

#include "math/vec3.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Body axes [m]. Coplanar points give a polygon with two faces, its front and its back; collinear points one edge
// without faces (left = right = -1); coincident points one vertex.
template <class S> struct Hull {
  struct Face {
    Vec3<S> normal;            // unit, outwards
    S offset{};                // n . x = offset on the face; no vertex lies beyond by more than round-off
    int first = 0, count = 0;  // corners[first ... first + count), anticlockwise from outside
  };
  struct Edge {
    int from = 0, to = 0;     // vertices
    int left = 0, right = 0;  // faces; the left one's loop runs from -> to
    Vec3<S> along;            // unit, from -> to
  };
  std::vector<Vec3<S>> vertices;  // corners of the hull alone: none inside a face or within an edge
  std::vector<Face> faces;
  std::vector<int> corners;
  std::vector<Edge> edges;
  std::vector<int> neighbours;  // of vertex i: neighbours[first_neighbour[i] ... first_neighbour[i + 1])
  std::vector<int> first_neighbour;
  Vec3<S> inside;       // the mean of the vertices
  S bounding_radius{};  // about the body's origin
};

// The hull of `points`, computed exactly, except that triangles within round-off of one plane are one face.
template <class S> Hull<S> make_hull(const std::vector<Real3>& points);
template <class S> std::shared_ptr<const Hull<S>> make_hull(const Convex& convex) {
  return std::make_shared<const Hull<S>>(make_hull<S>(convex.points_m));
}

// The vertex farthest along `direction` (body axes), by climbing from `start`.
template <class S> int farthest_vertex(const Hull<S>& hull, const Vec3<S>& direction, int start = 0);

}  // namespace atwood
