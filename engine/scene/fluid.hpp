// Fluids as they are simulated: what fills which region, its law, and its particles at one spacing. Plain data, SI
// units.
//
// In two dimensions the domain is the plane z = 0: every z is 0, gravity and bodies have no component out of the plane,
// and mass, force and energy are per metre of depth.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace atwood {

// The periods of space. A period of 0: not periodic along that axis. The periodic cell begins at the origin:
// coordinates are equivalent modulo the period, and states keep them unwrapped.
struct Domain {
  int dimensions = 3;  // 2 or 3
  std::array<double, 3> periodic_m{};
};

// clang-format off
struct BoxRegion { std::array<double, 3> min_m{}, max_m{}; };
struct BallRegion { std::array<double, 3> center_m{}; double radius_m = 0; };  // a circle in two dimensions
struct EllipsoidRegion { std::array<double, 3> center_m{}, semi_axes_m{}; };   // an ellipse in two dimensions
struct PointsRegion { std::string file; };                                     // CSV of positions, resolved path
// clang-format on
using FluidRegion = std::variant<BoxRegion, BallRegion, EllipsoidRegion, PointsRegion>;

enum class Arrangement {
  lattice,    // at the centres of cubes of the spacing
  disturbed,  // the lattice, each coordinate moved by a uniform random number in [0, disturbance spacing)
  rings,      // concentric rings around the region's centre, one spacing apart (two dimensions)
  file        // as the file says
};

enum class EquationOfState {
  linear,  // p = c^2 (rho - rho0)
  tait     // p = rho0 c^2 / gamma ((rho / rho0)^gamma - 1)
};

// A named initial field with its parameters ("taylor-green": speed_m_per_s). Positions are of the particles.
struct InitialField {
  std::string name;  // empty: uniform velocity, with the gradient
  std::map<std::string, double> parameters;
  std::array<double, 3> velocity_m_per_s{};
  std::array<double, 9> velocity_gradient_per_s{};  // row-major: v_i = velocity_i + sum_j gradient_ij x_j
};

// The particles of a fluid at one spacing: the state at t = 0. All vectors have one entry a particle.
struct Particles {
  std::vector<std::array<double, 3>> position_m, velocity_m_per_s;
  std::vector<double> mass_kg, density_kg_per_m3, temperature_K;  // mass is per metre of depth in two dimensions
};

struct Fluid {
  std::string name;
  FluidRegion region;
  Arrangement arrangement = Arrangement::lattice;
  double disturbance = 0;  // of the spacing; [0, 1)
  std::int64_t seed = 1;   // of SplitMix64
  double spacing_m = 0;    // > 0, of this resolution

  double density_kg_per_m3 = 0;    // rho0, > 0
  double sound_speed_m_per_s = 0;  // c at rho0, > 0
  EquationOfState equation_of_state = EquationOfState::linear;
  double tait_exponent = 7;
  double viscosity_m2_per_s = 0;  // kinematic, >= 0

  // Heat. No temperature is integrated where the heat capacity is 0.
  double heat_capacity_J_per_kg_K = 0;
  double conductivity_W_per_m_K = 0;
  double temperature_K = 0;          // at t = 0, and the reference of the two laws below
  bool viscous_heat = false;         // the viscous dissipation raises the temperature
  double expansion_per_K = 0;        // Boussinesq: gravity acts as g (1 - expansion (T - temperature_K))
  double viscosity_decay_per_K = 0;  // viscosity exp(-decay (T - temperature_K))

  InitialField initial;
  // A body acceleration that is a named field of position and time ("mms-2d"); empty: gravity alone.
  InitialField source;

  Particles particles;  // filled by place_particles()
};

enum class Slip { no_slip, free_slip };

// A body of the scene whose surface bounds the fluids.
struct FluidBoundary {
  int body = 0;  // index into Scene::bodies
  Slip slip = Slip::no_slip;
  std::optional<double> temperature_K, heat_flux_W_per_m2;  // at most one; neither: insulated. Flux into the fluid.
};

enum class ProbeKind { pressure, velocity, front, column_height, force_on_body, marker };
struct FluidProbe {
  std::string name;
  ProbeKind kind = ProbeKind::pressure;
  std::array<double, 3> position_m{};  // pressure, velocity, column_height; marker: at t = 0
  int body = -1;                       // force_on_body
};

}  // namespace atwood
