// Named fields: what a fluid is at t = 0, as velocity, density and temperature of a position, and the body
// accelerations that keep a manufactured field going. Formulas stand in fluid_fields.cpp.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

struct FieldParameter {
  std::string name, doc;
  double otherwise = 0;     // unless given
  bool from_scene = false;  // unless given it follows from the scene (a period, a middle)
  bool positive = false;    // must be above 0
  bool whole = false;       // must be a whole number
};
struct FieldInfo {
  std::string name, doc;
  std::vector<FieldParameter> parameters;
  bool has_source = false;  // also names an acceleration (Fluid::source)
  bool needs_heat = false;  // is a temperature: the fluid must have a heat capacity
};
const std::vector<FieldInfo>& fluid_fields();
const FieldInfo* find_field(const std::string& name);  // null: there is none of this name

// What a parameter is in this scene unless it is given; NaN where the scene does not say (no period).
double default_parameter(const Scene& scene, const Fluid& fluid, const InitialField& field,
                         const FieldParameter& parameter);

struct FluidState {
  Real3 velocity_m_per_s{};
  double density_kg_per_m3 = 0, temperature_K = 0;
};
// Of the fluid's initial field, whose parameters are all there, at a position.
FluidState initial_state(const Scene& scene, const Fluid& fluid, const Real3& position_m);

// The density of a pressure by the fluid's equation of state, and back. Tait: the argument of the root must be
// positive.
double density_of(const Fluid& fluid, double pressure_Pa);
double pressure_of(const Fluid& fluid, double density_kg_per_m3);

// Middle of the region's bounding box, and its least and largest coordinates. A region of points: of its particles.
struct RegionBounds {
  Real3 min_m{}, max_m{};
};
RegionBounds bounds_of(const Fluid& fluid);
Real3 center_of(const Fluid& fluid);

}  // namespace atwood
