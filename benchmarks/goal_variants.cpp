#include "benchmarks/goal_variants.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/stopwatch.hpp"
#include "scene/fluid_points.hpp"

namespace atwood {
namespace {

Scenario with_seed(Scenario scenario, std::int64_t seed) {
  for (Fluid& fluid : scenario.scene.fluids) fluid.seed = seed;
  scenario.scene = at_resolution(scenario, 0, 0);
  return scenario;
}

Scenario in_phase(Scenario scenario, std::int64_t phase) {
  const double faster = 1 + static_cast<double>(phase) / 6400;
  for (Body& body : scenario.scene.bodies) {
    for (double& x : body.velocity_m_per_s) x *= faster;
    for (double& x : body.angular_velocity_body_rad_per_s) x *= faster;
  }
  for (Joint& joint : scenario.scene.joints)
    for (double& rate : joint.rates) rate *= faster;
  return scenario;
}

Scenario from_start(Scenario scenario, std::int64_t start) {
  for (Joint& joint : scenario.scene.joints)
    for (int i = 0; i < coordinate_count(joint.kind); ++i)
      for (std::int64_t n = 0; n < start; ++n)
        joint.coordinates[static_cast<std::size_t>(i)] = std::nextafter(
            joint.coordinates[static_cast<std::size_t>(i)],
            std::copysign(std::numeric_limits<double>::max(), joint.coordinates[static_cast<std::size_t>(i)]));
  return scenario;
}

}  // namespace

std::int64_t variant_count(const Goal& goal) {
  return std::max({goal.seeds, goal.phases, goal.starts, std::int64_t{1}});
}

Scenario variant_of(const Goal& goal, Scenario scenario, std::int64_t k) {
  if (goal.seeds > 1) return with_seed(std::move(scenario), k + 1);
  if (goal.phases > 1) return in_phase(std::move(scenario), k);
  return from_start(std::move(scenario), k);
}

double combined_error(const Goal& goal, std::vector<double> errors, std::int64_t count) {
  if (std::ssize(errors) != count) return std::numeric_limits<double>::quiet_NaN();
  if (goal.phases > 1) return *std::max_element(errors.begin(), errors.end());
  if (goal.starts > 1) {
    double squares = 0;
    for (const double error : errors) squares += error * error;
    return std::sqrt(squares / static_cast<double>(errors.size()));
  }
  return median_time(errors);
}

}  // namespace atwood
