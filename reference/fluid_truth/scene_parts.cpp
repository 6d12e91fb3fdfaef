#include <cmath>

#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

void require(bool holds, const std::string& why) {
  if (!holds) throw Refused{why};
}

const Fluid& only_fluid(const Scene& scene) {
  require(scene.fluids.size() == 1, "expected one fluid; found " + std::to_string(scene.fluids.size()));
  return scene.fluids.front();
}

double parameter(const InitialField& field, const char* name, double otherwise) {
  const auto found = field.parameters.find(name);
  return found == field.parameters.end() ? otherwise : found->second;
}

template <class S> S wave_number(const Scene& scene, const InitialField& field, int axis) {
  const double length = parameter(field, "length_m", scene.domain.periodic_m[axis]);
  require(length > 0, "the field `" + field.name + "` has no length and the scene no period along it");
  return 2 * pi<S>() * S(parameter(field, "mode", 1)) / S(length);
}

template <class S> void require_period(const Scene& scene, S k, int axis) {
  const double waves = static_cast<double>(k * S(scene.domain.periodic_m[axis]) / (2 * pi<S>()));
  require(waves >= 0.5 && std::fabs(waves - std::round(waves)) < 1e-12 * waves,
          "expected a period of a whole number of waves along axis " + std::to_string(axis) + "; found " +
              format_double(waves));
}

template <class S> S thermal_diffusivity(const Fluid& fluid) {
  require(fluid.heat_capacity_J_per_kg_K > 0, "the fluid has no heat capacity");
  return S(fluid.conductivity_W_per_m_K) / (S(fluid.density_kg_per_m3) * S(fluid.heat_capacity_J_per_kg_K));
}

Upwards upwards_of(const Scene& scene) {
  Upwards made;
  int found = 0;
  for (int k = 0; k < 3; ++k) {
    const double g = scene.gravity_m_per_s2[k];
    if (g == 0) continue;
    ++found;
    made = {k, g < 0 ? 1.0 : -1.0, std::fabs(g)};
  }
  require(found == 1, "expected gravity along one axis");
  return made;
}

bool has_boundaries(const Scene& scene) { return !scene.fluid_boundaries.empty(); }

template <class S> Channel<S> channel_of(const Scene& scene, bool with_flux) {
  require(scene.fluid_boundaries.size() == 2,
          "expected two boundaries; found " + std::to_string(scene.fluid_boundaries.size()));
  Channel<S> made;
  bool seen[2] = {false, false};
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies.at(static_cast<std::size_t>(boundary.body));
    require(body.fixed, "the boundary `" + body.name + "` is not fixed");
    require(body.angular_velocity_body_rad_per_s == Real3{}, "the boundary `" + body.name + "` turns");
    require(with_flux || !boundary.heat_flux_W_per_m2.value_or(0), "the boundary `" + body.name + "` has a heat flux");
    const auto* plane = std::get_if<Plane>(&body.shape);
    require(plane != nullptr, "the boundary `" + body.name + "` is not a plane");
    int axis = -1;
    for (int k = 0; k < 3; ++k)
      if (std::fabs(plane->normal[k]) == 1) axis = k;
    require(axis >= 0, "the normal of `" + body.name + "` is not along an axis");
    require(!(seen[0] || seen[1]) || axis == made.axis, "the two boundaries are not parallel");
    made.axis = axis;
    const bool is_low = plane->normal[axis] > 0;  // the fluid is on the side of the normal
    require(!seen[is_low], "the two boundaries face the same way");
    seen[is_low] = true;
    (is_low ? made.low : made.high) = S(plane->offset_m) * S(plane->normal[axis]);
    (is_low ? made.v_low : made.v_high) = vec<S>(body.velocity_m_per_s);
    (is_low ? made.T_low : made.T_high) = boundary.temperature_K;
    (is_low ? made.q_low : made.q_high) = boundary.heat_flux_W_per_m2.value_or(0);
    require(body.velocity_m_per_s[axis] == 0, "the boundary `" + body.name + "` moves along its normal");
    made.no_slip = made.no_slip && boundary.slip == Slip::no_slip;
  }
  require(made.high > made.low, "there is no space between the two boundaries");
  return made;
}

// Tait: p = rho0 c^2 / gamma ((rho / rho0)^gamma - 1); linear: p = c^2 (rho - rho0).
template <class S> S pressure_of(const Fluid& fluid, S density) {
  const S rho0 = fluid.density_kg_per_m3, c = fluid.sound_speed_m_per_s, gamma = fluid.tait_exponent;
  if (fluid.equation_of_state == EquationOfState::linear) return c * c * (density - rho0);
  return rho0 * c * c / gamma * expm1(gamma * log1p((density - rho0) / rho0));
}

template <class S> S density_of(const Fluid& fluid, S pressure) {
  const S rho0 = fluid.density_kg_per_m3, c = fluid.sound_speed_m_per_s, gamma = fluid.tait_exponent;
  if (fluid.equation_of_state == EquationOfState::linear) return rho0 + pressure / (c * c);
  return rho0 * exp(log1p(gamma * pressure / (rho0 * c * c)) / gamma);
}

template Narrow wave_number(const Scene&, const InitialField&, int);
template Wide wave_number(const Scene&, const InitialField&, int);
template void require_period(const Scene&, Narrow, int);
template void require_period(const Scene&, Wide, int);
template Narrow thermal_diffusivity(const Fluid&);
template Wide thermal_diffusivity(const Fluid&);
template Channel<Narrow> channel_of(const Scene&, bool);
template Channel<Wide> channel_of(const Scene&, bool);
template Narrow pressure_of(const Fluid&, Narrow);
template Wide pressure_of(const Fluid&, Wide);
template Narrow density_of(const Fluid&, Narrow);
template Wide density_of(const Fluid&, Wide);

}  // namespace atwood::fluid_truth
