// Triangle meshes: adjacency, and a bounding-volume tree over the triangles.
//
// A mesh is closed if every edge joins two triangles that traverse it in opposite directions: the surface of a solid.
// The front of a triangle (where its corners run anticlockwise) is outside, and contacts push outwards only. An open
// mesh is a two-sided sheet: contacts push to the side of the smaller depth.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "collision/contacts.hpp"

namespace atwood {

enum class EdgeKind : unsigned char { convex, flat, concave, border };  // seen from the front

// Body axes [m].
template <class S> struct TriangleMesh {
  struct Triangle {
    std::array<int, 3> corner;
    std::array<int, 3> across;  // the triangle beyond the edge corner[k] -> corner[k + 1]; -1: none, or more than one
    std::array<EdgeKind, 3> edge;
    Vec3<S> normal;  // unit; the anticlockwise side
  };
  struct Node {  // depth first: the left child follows its parent
    Aabb<S> box;
    int right = -1;            // inner node: the right child; leaf: -1
    int first = 0, count = 0;  // leaf: triangles[first ... first + count)
  };
  std::vector<Vec3<S>> points;
  std::vector<Triangle> triangles;  // in the tree's order
  std::vector<int> scene_index;     // the index each triangle had in the scene
  std::vector<Node> nodes;
  // Points that an edge joins to point i: neighbour_points[first_neighbour[i] ... first_neighbour[i + 1]).
  std::vector<int> neighbour_points;
  std::vector<int> first_neighbour;
  std::vector<Vec3<S>> point_pseudonormals;  // weighted by angle (Baerentzen, Aanaes 2005): decides inside or outside
  bool closed = false, convex = false;       // convex: closed, and no point lies before any triangle
  std::shared_ptr<const Hull<S>> solid;      // of a convex mesh of at most 64 corners: its hull
  S bounding_radius{};                       // about the body's origin
};

// Coincident points are merged; triangles without area are left out.
template <class S>
TriangleMesh<S> build_triangle_mesh(const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& triangles);
template <class S> std::shared_ptr<const TriangleMesh<S>> make_triangle_mesh(const Mesh& mesh) {
  return std::make_shared<const TriangleMesh<S>>(build_triangle_mesh<S>(mesh.points_m, mesh.triangles));
}

// A mesh (first) against any kind but compound, planes included. A mesh that bounds a convex solid of few corners is
// treated as that solid, as `convex` shapes are. Otherwise there is one manifold for each triangle in contact (for each
// pair of triangles of two meshes; one for the whole mesh against a plane), with `part_a` its index in the scene. At
// an inner edge or corner a normal is accepted only inside the feature's Voronoi region, so a body that slides over a
// triangulated plane has the contacts of the plane. A shape inside a closed mesh has one contact: the least penetration
// of a convex mesh, else through the point nearest to its centre. The separation in overlap is that of the deepest one.
template <class S>
void mesh_contacts(const Geometry<S>& mesh, const Transform<S>& pose_mesh, const Geometry<S>& b,
                   const Transform<S>& pose_b, S margin, std::vector<Manifold<S>>& out);
template <class S>
Separation<S> mesh_separation(const Geometry<S>& mesh, const Transform<S>& pose_mesh, const Geometry<S>& b,
                              const Transform<S>& pose_b);

}  // namespace atwood
