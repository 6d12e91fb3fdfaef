// Triangle meshes: who is next to whom, and a tree of boxes over the triangles.
//
// A mesh whose every edge joins two triangles that run along it in opposite ways is closed: the surface of a solid,
// whose outside is where the triangles' anticlockwise sides look, and which pushes out of itself alone. An open mesh is
// a sheet: it pushes to the side that needs less.
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
  std::vector<int> given;           // the index each triangle had in the scene
  std::vector<Node> nodes;
  std::vector<int> around, first_around;  // points joined to point i by an edge: around[first_around[i] ... )
  std::vector<Vec3<S>> point_normals;  // weighted by angle (Baerentzen, Aanaes 2005): tells the inside of a closed mesh
  bool closed = false, convex = false;   // convex: closed, and no point lies before any triangle
  std::shared_ptr<const Hull<S>> solid;  // what a convex one bounds, unless it has very many corners
  S bounding_radius{};                   // about the body's origin
};

// Points that coincide are one; triangles without area are left out.
template <class S>
TriangleMesh<S> build_triangle_mesh(const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& triangles);
template <class S> std::shared_ptr<const TriangleMesh<S>> make_triangle_mesh(const Mesh& mesh) {
  return std::make_shared<const TriangleMesh<S>>(build_triangle_mesh<S>(mesh.points_m, mesh.triangles));
}

// A mesh (first) against any kind but compound, planes included. What bounds a convex solid of few corners is that
// solid, as `convex` shapes are. Of others there is one manifold for each triangle that touches (a pair of triangles
// for two meshes; one for all of the mesh against a plane), `piece_a` its index in the scene. At an inner edge or
// corner the normal stays within what the neighbouring triangles leave to it, so what slides over a triangulated plane
// meets the plane. A shape all inside of a closed mesh meets it once: by the least way out of a convex one, else by
// that from its centre. The separation of what overlaps a mesh is that of its deepest contact.
template <class S>
void mesh_contacts(const Geometry<S>& mesh, const Placement<S>& place_mesh, const Geometry<S>& b,
                   const Placement<S>& place_b, S margin, std::vector<Manifold<S>>& out);
template <class S>
Separation<S> mesh_separation(const Geometry<S>& mesh, const Placement<S>& place_mesh, const Geometry<S>& b,
                              const Placement<S>& place_b);

}  // namespace atwood
