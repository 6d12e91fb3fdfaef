#include "fluid/walls.hpp"

#include "fluid/solution.hpp"

namespace atwood::fluid_truth {

template <class S> std::vector<FixedPoint<S>> fixed_points(const Scene& scene, double) {
  require(scene.fluid_boundaries.empty(), "boundaries are not covered");
  return {};
}

template std::vector<FixedPoint<double>> fixed_points(const Scene&, double);
template std::vector<FixedPoint<Narrow>> fixed_points(const Scene&, double);
template std::vector<FixedPoint<Wide>> fixed_points(const Scene&, double);

}  // namespace atwood::fluid_truth
