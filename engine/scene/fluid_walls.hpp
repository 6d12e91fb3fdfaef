// Points that stand for the solids behind the boundaries of fluids, for methods that fill walls with particles.
//
// D is the spacing of the first fluid. A plane, whose normal is along an axis: layers at the depths (l + 1/2) D for l =
// 0, 1, ... while l D < max_depth, each a square lattice of spacing D whose points stand at (i + 1/2) D from the corner
// of the first fluid's region, of another region than a box that of the box around its particles with D / 2 around each
// (along a periodic axis: at (i + 1/2) L / n, n = round(L / D)). It extends along each open axis over all fluids and
// all planes across that axis, and beyond by four times the largest extent of the fluids and max_depth. A box: cells of
// edges 2 a / n, n = max(1, round(2 a / D)), along its own axes, those whose centre is less than `max_depth` below the
// surface. A ball (a circle in two dimensions): a square lattice through its centre moved by half a D, those inside and
// less than `max_depth` deep. In two dimensions all points have z = 0.
//
// The points less than D deep share the area of the surface: of a plane each has the square of its layer, of a box or
// a ball each the same part. Points that are on or behind another boundary (a plane's: their places on its surface)
// have no area, nor have deeper ones.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

struct WallPoint {
  int boundary = 0;  // index into Scene::fluid_boundaries
  Real3 at_m{};      // world for a fixed body, else in the body's axes, from its centre of mass
  double area_m2{};  // of the surface that the point stands for; in two dimensions for a metre of depth
};

inline constexpr int kMaxWallPoints = 4'000'000;
// The depth in spacings at which a scene's wall points are counted when it is read: no method knows its own by then.
inline constexpr double kCountedSpacings = 4;

// The first boundary with which the wall points are more than kMaxWallPoints, and a sentence with the figure. They are
// counted before any is made: all points of a plane's lattice, all cells of a box, of a ball those of the cube around
// it. Fluids must have their particles.
struct WallCount {
  std::size_t boundary = 0;  // index into Scene::fluid_boundaries
  std::string words;
};
std::optional<WallCount> too_many_wall_points(const Scene& scene, double max_depth_m);

// Fluids must have their particles. Throws std::invalid_argument with the reason for a shape or a plane that it does
// not fill, and for more than kMaxWallPoints.
std::vector<WallPoint> wall_points(const Scene& scene, double max_depth_m);

// The axis of the domain that the plane's normal is along; -1: none.
int normal_axis(const Plane& plane, int dimensions);

// A point of the world in axes of the body at its initial pose, from its centre of mass.
Real3 to_body(const Body& body, const Real3& x_m);

// Depth of a point (world) below the surface of a body at its initial pose; negative outside. Planes, boxes, balls.
double depth_in_body_m(const Body& body, int dimensions, const Real3& x_m);

}  // namespace atwood
