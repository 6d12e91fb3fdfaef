// The interface of the closed forms of fluids, and what several of them read from a scene.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "fluid_truth/number.hpp"
#include "protocol/fluid_field.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid_truth {

// The field at one place. `neglected`: a bound (or, where the solution's note says so, an estimate) of what the formula
// leaves out, in each quantity.
template <class S> struct Point {
  Vec<S> v{};
  S density{}, p{}, T{};
  S neglected_v{}, neglected_density{}, neglected_p{}, neglected_T{};
};

template <class S> using FieldAt = std::function<Point<S>(const Vec<S>& x)>;

template <class S> struct ProbeAt { S value{}, neglected{}; };

template <class S> struct Field {
  std::string note;
  // The field at t >= 0, prepared once a time: what depends on t alone is computed here.
  std::function<FieldAt<S>(S t)> at;
  std::function<std::optional<ProbeAt<S>>(S t, const FluidProbe& probe)> probe;  // may be empty
  std::function<std::string(S t)> undefined;  // why there is no field at t; "": there is one; empty: always
  bool bounded = true;                        // false: a comparison; every bar is infinite
};

// What a solution is asked for: the scenario and the particles' equations (protocol/fluid_field.hpp).
struct Asked {
  const Scenario& scenario;
  const std::string& response;
  const Scene& scene = scenario.scene;
};

struct Solution {
  const char* id;
  const char* citation;
  FieldKnown known;
  Field<Narrow> (*narrow)(const Asked&);
  Field<Wide> (*wide)(const Asked&);
};

// ---- what a scene has -------------------------------------------------------------------------------------------
// The scene's only fluid; throws Refused where there are none or several.
const Fluid& only_fluid(const Scene& scene);
double parameter(const InitialField& field, const char* name, double otherwise);

// A solution that does not cover a scene says so by this exception; the catalogue turns it into a refusal.
struct Refused {
  std::string why;
};
void require(bool holds, const std::string& why);

// k = 2 pi mode / length_m of a field's parameters; the length is the scene's period along `axis` unless given.
template <class S> S wave_number(const Scene& scene, const InitialField& field, int axis);
// Refuses a period along `axis` that is not a multiple of the wave's length.
template <class S> void require_period(const Scene& scene, S k, int axis);
// conductivity / (density heat capacity); refuses a fluid without heat capacity.
template <class S> S thermal_diffusivity(const Fluid& fluid);
// Minus gravity is along this axis, upwards or downwards along it; refuses any other direction.
struct Upwards {
  int axis = 1;
  double sign = 1, g = 0;  // [m/s^2], > 0
};
Upwards upwards_of(const Scene& scene);

// Two parallel fixed planes that bound the fluid along one axis: where they are, how they move, how they heat.
template <class S> struct Channel {
  int axis = 1;  // of the normal
  S low{}, high{};
  Vec<S> v_low{}, v_high{};
  std::optional<double> T_low, T_high;  // [K]; empty: insulated, but for a flux
  double q_low = 0, q_high = 0;         // [W/m^2] into the fluid
  bool no_slip = true;                  // both
};
// Refuses a flux unless told otherwise.
template <class S> Channel<S> channel_of(const Scene& scene, bool with_flux = false);
bool has_boundaries(const Scene& scene);

// Pressure of a density and density of a pressure by the fluid's equation of state.
template <class S> S pressure_of(const Fluid& fluid, S density);
template <class S> S density_of(const Fluid& fluid, S pressure);

// ---- the catalogue ----------------------------------------------------------------------------------------------
Solution taylor_green();
Solution shear();
Solution poiseuille();
Solution couette();
Solution heat_sine();
Solution heat_step();
Solution heat_flux();
Solution standing_wave();
Solution elliptic_drop();
Solution hydrostatic();
Solution square_patch();
Solution ritter();
Solution floating();
Solution couette_thermal();
Solution viscous_heating();
Solution mms_2d();
Solution mms_3d();

}  // namespace atwood::fluid_truth
