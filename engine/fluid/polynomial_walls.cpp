#include "fluid/polynomial_walls.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scene/fluid_walls.hpp"

namespace atwood::fluid {
namespace {

constexpr double kDeepestParticle = 0.5;  // behind a wall, in spacings: one that is deeper ends the run
constexpr double kShiftReach = 2;         // of the sums for shifting, in spacings

}  // namespace

template <class S>
PolynomialWalls<S>::PolynomialWalls(const Scene& scene, const ParticleSet<S>& set, KernelShape shape, int degree,
                                    S support)
    : scene_(scene), set_(set), dimensions_(scene.domain.dimensions),
      support_(support), fits_{shape,  dimensions_,          degree == 2 ? 2 : kWallDegree,
                               degree, set.layout.particles, (S(1) + S(kWidening)) * support} {
  spacing_ = S(scene.fluids.front().spacing_m);
  const Fluid& fluid = scene.fluids.front();
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[boundary.body];
    const auto* plane = std::get_if<Plane>(&body.shape);
    if (plane == nullptr || !body.fixed) {
      unsupported_ = "+polynomial has walls along fixed planes only; the boundary `" + body.name + "` is another";
      return;
    }
    Wall wall{};
    wall.body = boundary.body;
    wall.axis = normal_axis(*plane, dimensions_);
    if (wall.axis < 0) {
      unsupported_ = "the plane of the boundary `" + body.name + "` is not perpendicular to a coordinate axis";
      return;
    }
    wall.sign = S(plane->normal[wall.axis]);
    wall.offset = S(plane->offset_m);
    for (int c = 0; c < dimensions_; ++c) wall.velocity[c] = S(body.velocity_m_per_s[c]);
    wall.no_slip = boundary.slip == Slip::no_slip;
    wall.has_temperature = boundary.temperature_K.has_value();
    wall.temperature = S(boundary.temperature_K.value_or(0));
    if (boundary.heat_flux_W_per_m2.value_or(0) != 0 && !(fluid.conductivity_W_per_m_K > 0)) {
      unsupported_ = "+polynomial gives a flux by the slope of the temperature; the fluid `" + fluid.name +
                     "` conducts no heat, so that the flux of the boundary `" + body.name + "` has none";
      return;
    }
    if (boundary.heat_flux_W_per_m2.has_value() && fluid.conductivity_W_per_m_K > 0)
      wall.slope = -S(*boundary.heat_flux_W_per_m2) / S(fluid.conductivity_W_per_m_K);
    walls_.push_back(wall);
  }
  // The first layer of the walls' points, moved to the surface, carries the nodes.
  try {
    const double spacing = fluid.spacing_m;
    std::vector<S> dummies;
    for (const WallPoint& point : wall_points(scene, static_cast<double>(support))) {
      const Wall& wall = walls_[point.boundary];
      const Body& own = scene.bodies[wall.body];
      Real3 at = point.at_m;
      const double depth = depth_in_body_m(own, dimensions_, at);
      if (is_reached(at))
        for (int c = 0; c < dimensions_; ++c) dummies.push_back(S(at[c]));
      if (depth > spacing) continue;
      at[wall.axis] = static_cast<double>(wall.sign * wall.offset);
      bool behind = false;
      for (const Wall& other : walls_)
        behind =
            behind || (&other != &wall && depth_in_body_m(scene.bodies[other.body], dimensions_, at) > -1e-9 * spacing);
      if (behind) continue;
      for (int c = 0; c < dimensions_; ++c) positions_.push_back(S(at[c]));
      wall_of_.push_back(point.boundary);
    }
    nodes_ = static_cast<int>(wall_of_.size());
    positions_.insert(positions_.end(), dummies.begin(), dummies.end());
  } catch (const std::invalid_argument& error) {
    unsupported_ = error.what();
  }
}

template <class S> bool PolynomialWalls<S>::is_reached(const Real3& x) const {
  return std::all_of(walls_.begin(), walls_.end(), [&](const Wall& wall) {
    return wall.sign * S(x[wall.axis]) - wall.offset > -(S(kShiftReach) + S(kDeepestParticle) - S(1e-6)) * spacing_;
  });
}

template <class S> S PolynomialWalls<S>::support_at(const S* x) const {
  S near{};
  for (const Wall& wall : walls_) {
    const S s = real::abs(wall.sign * x[wall.axis] - wall.offset) / support_;
    if (s < S(1)) near = real::max(near, (S(1) - s) * (S(1) - s) * (S(1) + S(2) * s));
  }
  return (S(1) + S(kWidening) * near) * support_;
}

template <class S> void PolynomialWalls<S>::fill(const Neighbours<S>& lists, S* records, SlotWeight<S>* weights) const {
  const int d = dimensions_, particles = set_.layout.particles;
  NodeWeights<S> around;
  for (int w = 0; w < count(); ++w) {
    const int slot = lists.slot_of()[particles + w];
    weights[slot] = {S(0), w < nodes_ ? S(0) : S(1), S(0)};
    if (w >= nodes_) continue;
    const Wall& wall = walls_[wall_of_[w]];
    const bool by_slope = !wall.no_slip || (set_.layout.temperature && !wall.has_temperature);
    if (!fits_.around(lists, records, slot, by_slope ? wall.axis : -1, wall.sign, around)) continue;  // dry
    weights[slot].fit = S(1);
    S* const own = records + std::ptrdiff_t(slot) * kFitRecord;
    const auto value = [&](const std::vector<S>& by, int field, S slope) {
      S sum{};
      for (std::size_t n = 0; n < around.slots.size(); ++n)
        sum += by[n] * (records[std::ptrdiff_t(around.slots[n]) * kFitRecord + field] - slope * around.distance[n]);
      return sum;
    };
    for (int c = 0; c < d; ++c)
      own[d + c] = wall.no_slip || c == wall.axis ? wall.velocity[c] : value(around.given_slope, d + c, S(0));
    own[2 * d] = value(around.unconstrained, 2 * d, S(0));
    if (set_.layout.temperature)
      own[2 * d + 1] = wall.has_temperature ? wall.temperature : value(around.given_slope, 2 * d + 1, wall.slope);
  }
}

template <class S> const std::string* PolynomialWalls<S>::boundary_behind(const S* x) const {
  for (const Wall& wall : walls_)
    if (wall.sign * x[wall.axis] - wall.offset < -S(kDeepestParticle) * spacing_) return &scene_.bodies[wall.body].name;
  return nullptr;
}

template class PolynomialWalls<float>;
template class PolynomialWalls<double>;
template class PolynomialWalls<long double>;
template class PolynomialWalls<Quad>;

}  // namespace atwood::fluid
