#include "fluid_truth/walls.hpp"

#include <stdexcept>

#include "fluid_truth/solution.hpp"
#include "scene/fluid_walls.hpp"

namespace atwood::fluid_truth {

template <class S> std::vector<FixedPoint<S>> fixed_points(const Scene& scene, double max_depth_m) {
  std::vector<FixedPoint<S>> made;
  if (scene.fluid_boundaries.empty()) return made;
  std::vector<WallPoint> points;
  try {
    points = wall_points(scene, max_depth_m);
  } catch (const std::invalid_argument& error) {
    throw Refused{error.what()};
  }
  for (const WallPoint& point : points) {
    const FluidBoundary& boundary = scene.fluid_boundaries[static_cast<std::size_t>(point.boundary)];
    const Body& body = scene.bodies[static_cast<std::size_t>(boundary.body)];
    require(body.fixed, "the boundary `" + body.name + "` can move, which is not covered");
    FixedPoint<S>& to = made.emplace_back();
    // The surface of a fixed body slides in itself: v + w x r, w from the body's axes. In quad, rounded once.
    const Vec<Wide> spin = rotate(quat<Wide>(body.orientation_wxyz), vec<Wide>(body.angular_velocity_body_rad_per_s));
    const Vec<Wide> v =
        vec<Wide>(body.velocity_m_per_s) + cross(spin, vec<Wide>(point.at_m) - vec<Wide>(body.position_m));
    to.x = vec<S>(point.at_m);
    for (int a = 0; a < 3; ++a) to.velocity[a] = static_cast<S>(v[a]);
    to.boundary = point.boundary;
    to.area = point.area_m2;
    to.no_slip = boundary.slip == Slip::no_slip;
    if (boundary.temperature_K) to.temperature = *boundary.temperature_K;
    if (boundary.heat_flux_W_per_m2) to.heat_flux = *boundary.heat_flux_W_per_m2;
  }
  return made;
}

template std::vector<FixedPoint<double>> fixed_points(const Scene&, double);
template std::vector<FixedPoint<Narrow>> fixed_points(const Scene&, double);
template std::vector<FixedPoint<Wide>> fixed_points(const Scene&, double);

}  // namespace atwood::fluid_truth
