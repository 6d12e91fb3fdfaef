#include "scene/fluid_fields.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace atwood {
namespace {

using std::cos, std::sin;

constexpr double kPi = std::numbers::pi;

FieldParameter speed() { return {"speed_m_per_s", "largest speed U [m/s]; 1 unless given", 1}; }
FieldParameter length(const char* axis) {
  return {"length_m", std::string("wavelength of mode 1 [m]; the period along ") + axis + " unless given", 0, true,
          true};
}
FieldParameter mode() {
  return {"mode", "wavelengths in the length, a whole number; 1 unless given", 1, false, true, true};
}
FieldParameter rate(const char* what, double otherwise) { return {"rate_per_s", what, otherwise}; }
FieldParameter amplitude_K() { return {"amplitude_K", "amplitude A [K]; 1 unless given", 1}; }

double parameter(const InitialField& field, const char* name) { return field.parameters.at(name); }

// 2 pi mode / length
double wave_number(const InitialField& field) {
  return 2 * kPi * parameter(field, "mode") / parameter(field, "length_m");
}

// ---- the fields -----------------------------------------------------------------------------------------------------
// Taylor and Green 1937: u = -U cos kx sin ky, v = U sin kx cos ky, p = -rho0 U^2 / 4 (cos 2kx + cos 2ky).
FluidState taylor_green(const Fluid& fluid, const Real3& x) {
  const double k = wave_number(fluid.initial), speed = parameter(fluid.initial, "speed_m_per_s");
  const double p = -fluid.density_kg_per_m3 * speed * speed / 4 * (cos(2 * k * x[0]) + cos(2 * k * x[1]));
  return {{-speed * cos(k * x[0]) * sin(k * x[1]), speed * sin(k * x[0]) * cos(k * x[1]), 0},
          density_of(fluid, p),
          fluid.temperature_K};
}

FluidState shear(const Fluid& fluid, const Real3& x) {
  const double k = wave_number(fluid.initial);
  return {
      {parameter(fluid.initial, "speed_m_per_s") * sin(k * x[1]), 0, 0}, fluid.density_kg_per_m3, fluid.temperature_K};
}

// A standing sound wave when all of its energy is elastic: rho = rho0 (1 + a cos kx), at rest.
FluidState standing_wave(const Fluid& fluid, const Real3& x) {
  const double a = parameter(fluid.initial, "amplitude");
  return {{}, fluid.density_kg_per_m3 * (1 + a * cos(wave_number(fluid.initial) * x[0])), fluid.temperature_K};
}

// Monaghan 1994: u = -A x, v = A y about the centre; p = rho0 A^2 / 2 (R^2 - r^2).
FluidState elliptic_drop(const Fluid& fluid, const Real3& x) {
  const double rate = parameter(fluid.initial, "rate_per_s");
  const Real3 center = center_of(fluid);
  const double dx = x[0] - center[0], dy = x[1] - center[1];
  const auto* ball = std::get_if<BallRegion>(&fluid.region);
  const double radius = ball ? ball->radius_m : 0;
  const double p = fluid.density_kg_per_m3 * rate * rate / 2 * (radius * radius - dx * dx - dy * dy);
  return {{-rate * dx, rate * dy, 0}, density_of(fluid, p), fluid.temperature_K};
}

// Colagrossi 2005: a square of side L that rotates, u = w y, v = -w x about its centre, and the pressure of an
// incompressible fluid under it, p = 0 at the sides:
//   p = -32 rho0 w^2 / pi^2 sum over odd m, n of sin(m pi x / L) sin(n pi y / L) / (m n ((m pi / L)^2 + (n pi / L)^2))
// with x and y from the corner, summed for m, n < 100.
FluidState square_patch(const Fluid& fluid, const Real3& x) {
  constexpr int terms = 50;
  const double rate = parameter(fluid.initial, "rate_per_s");
  const Real3 center = center_of(fluid);
  const RegionBounds bounds = bounds_of(fluid);
  const double side = bounds.max_m[0] - bounds.min_m[0];
  std::array<double, terms> sine_x, sine_y;
  for (std::size_t i = 0; i < terms; ++i) {
    const double wave = static_cast<double>(2 * i + 1) * kPi / side;
    sine_x[i] = sin(wave * (x[0] - bounds.min_m[0])), sine_y[i] = sin(wave * (x[1] - bounds.min_m[1]));
  }
  double sum = 0;
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t j = 0; j < terms; ++j) {
      const double m = static_cast<double>(2 * i + 1), n = static_cast<double>(2 * j + 1);
      sum += sine_x[i] * sine_y[j] / (m * n * (m * m + n * n));
    }
  const double p = -32 * fluid.density_kg_per_m3 * rate * rate / (kPi * kPi) * (side / kPi) * (side / kPi) * sum;
  return {{rate * (x[1] - center[1]), -rate * (x[0] - center[0]), 0}, density_of(fluid, p), fluid.temperature_K};
}

FluidState heat_sine(const Fluid& fluid, const Real3& x) {
  const double rise = parameter(fluid.initial, "amplitude_K") * sin(wave_number(fluid.initial) * x[0]);
  return {{}, fluid.density_kg_per_m3, fluid.temperature_K + rise};
}

FluidState heat_step(const Fluid& fluid, const Real3& x) {
  const bool hot = x[0] < parameter(fluid.initial, "position_m");
  return {{}, fluid.density_kg_per_m3, fluid.temperature_K + (hot ? parameter(fluid.initial, "amplitude_K") : 0)};
}

double norm(const Real3& v) { return std::hypot(v[0], v[1], v[2]); }

// How far the region reaches against gravity: the height of the free surface, measured along -g from the origin.
double surface_height(const Scene& scene, const Fluid& fluid) {
  const double g = norm(scene.gravity_m_per_s2);
  if (!(g > 0)) return 0;
  const RegionBounds bounds = bounds_of(fluid);
  double height = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double up = -scene.gravity_m_per_s2[i] / g;
    height += up * (up > 0 ? bounds.max_m[i] : bounds.min_m[i]);
  }
  return height;
}

// Vortices in x and y that know of no gravity: u = K sin qx cos qy, v = -K cos qx sin qy, q = 2 pi / knock_length_m.
Real3 knock(const InitialField& field, const Real3& x) {
  const double speed = parameter(field, "knock_m_per_s"), q = 2 * kPi / parameter(field, "knock_length_m");
  return {speed * sin(q * x[0]) * cos(q * x[1]), -speed * cos(q * x[0]) * sin(q * x[1]), 0};
}

// At rest under gravity, d below the surface, dp/dd = rho g. Linear: rho = rho0 exp(g d / c^2). Tait:
// (rho / rho0)^(gamma - 1) = 1 + (gamma - 1) g d / c^2.
FluidState hydrostatic(const Scene& scene, const Fluid& fluid, const Real3& x) {
  const double g = norm(scene.gravity_m_per_s2), c = fluid.sound_speed_m_per_s;
  double height = 0;
  for (std::size_t i = 0; i < 3; ++i) height -= g > 0 ? scene.gravity_m_per_s2[i] / g * x[i] : 0;
  const double head = g * (parameter(fluid.initial, "surface_m") - height) / (c * c);
  const double gamma = fluid.equation_of_state == EquationOfState::linear ? 1 : fluid.tait_exponent;
  const double ratio = gamma == 1 ? std::exp(head) : std::pow(1 + (gamma - 1) * head, 1 / (gamma - 1));
  return {knock(fluid.initial, x), fluid.density_kg_per_m3 * ratio, fluid.temperature_K};
}

// A manufactured motion: u = U cos(wt) dpsi/dy, v = -U cos(wt) dpsi/dx, psi = sin kx sin ky / k, under which a density
// that is constant along the stream lines, rho0 (1 + a sin kx sin ky), stays as it is: continuity holds exactly, and a
// body acceleration makes up for the rest of the momentum.
FluidState manufactured_2d(const Fluid& fluid, const Real3& x) {
  const double k = wave_number(fluid.initial), speed = parameter(fluid.initial, "speed_m_per_s");
  const double sx = sin(k * x[0]), cx = cos(k * x[0]), sy = sin(k * x[1]), cy = cos(k * x[1]);
  const double a = parameter(fluid.initial, "density_amplitude");
  return {{speed * sx * cy, -speed * cx * sy, 0}, fluid.density_kg_per_m3 * (1 + a * sx * sy), fluid.temperature_K};
}

// The same in three dimensions: f = sin kx sin ky sin kz, u = U cos(wt) / k^2 grad f x grad(cos kx + cos ky + cos kz).
FluidState manufactured_3d(const Fluid& fluid, const Real3& x) {
  const double k = wave_number(fluid.initial), speed = parameter(fluid.initial, "speed_m_per_s");
  const double sx = sin(k * x[0]), cx = cos(k * x[0]), sy = sin(k * x[1]), cy = cos(k * x[1]);
  const double sz = sin(k * x[2]), cz = cos(k * x[2]), a = parameter(fluid.initial, "density_amplitude");
  return {{speed * sx * (cz * sy * sy - cy * sz * sz), speed * sy * (cx * sz * sz - cz * sx * sx),
           speed * sz * (cy * sx * sx - cx * sy * sy)},
          fluid.density_kg_per_m3 * (1 + a * sx * sy * sz),
          fluid.temperature_K};
}

// Two planes with temperatures that face each other, one along +axis and one along -axis; false: the scene has none.
struct HeatedPlates {
  std::size_t axis = 0;
  double low_m = 0, high_m = 0, low_K = 0, high_K = 0;
  Real3 low_m_per_s{}, high_m_per_s{};
};
bool find_plates(const Scene& scene, HeatedPlates& plates) {
  bool low = false, high = false;
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[static_cast<std::size_t>(boundary.body)];
    const auto* plane = std::get_if<Plane>(&body.shape);
    if (!plane || !boundary.temperature_K) return false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(plane->normal[axis]) != 1) continue;
      plates.axis = axis;
      if (plane->normal[axis] > 0)
        plates.low_m = plane->offset_m, plates.low_K = *boundary.temperature_K,
        plates.low_m_per_s = body.velocity_m_per_s, low = true;
      else
        plates.high_m = -plane->offset_m, plates.high_K = *boundary.temperature_K,
        plates.high_m_per_s = body.velocity_m_per_s, high = true;
    }
  }
  return low && high;
}

// Steady flow between plates of two temperatures whose viscosity is exp(-decay (T - T0)): T linear, and with
// s = (x - low) / (high - low), b = decay (T_high - T_low): u = u_low + (u_high - u_low) (exp(b s) - 1) / (exp(b) - 1).
FluidState couette_thermal(const Scene& scene, const Fluid& fluid, const Real3& x) {
  HeatedPlates plates;
  FluidState state{{}, fluid.density_kg_per_m3, fluid.temperature_K};
  if (!find_plates(scene, plates)) return state;
  const double s = (x[plates.axis] - plates.low_m) / (plates.high_m - plates.low_m);
  const double b = fluid.viscosity_decay_per_K * (plates.high_K - plates.low_K);
  const double share = b == 0 ? s : std::expm1(b * s) / std::expm1(b);
  for (std::size_t i = 0; i < 3; ++i)
    state.velocity_m_per_s[i] = plates.low_m_per_s[i] + (plates.high_m_per_s[i] - plates.low_m_per_s[i]) * share;
  state.temperature_K = plates.low_K + (plates.high_K - plates.low_K) * s;
  return state;
}

}  // namespace

const std::vector<FieldInfo>& fluid_fields() {
  static const std::vector<FieldInfo> fields = {
      {"taylor-green",
       "vortices that decay: u = -U cos kx sin ky, v = U sin kx cos ky, and their pressure",
       {speed(), length("x"), mode()}},
      {"shear", "a shear wave that decays: u = U sin ky", {speed(), length("y"), mode()}},
      {"standing-wave",
       "a sound wave at rest: rho = rho0 (1 + amplitude cos kx)",
       {{"amplitude", "of the density, relative; 1e-4 unless given", 1e-4}, length("x"), mode()}},
      {"elliptic-drop",
       "u = -A x, v = A y about the middle of a circle, and their pressure (Monaghan 1994)",
       {rate("rate A [1/s]; 100 unless given", 100)}},
      {"square-patch",
       "a rotating square, u = w y, v = -w x about its middle, and its pressure (Colagrossi 2005)",
       {rate("angular rate w [1/s]; 5 unless given", 5)}},
      {"heat-sine", "T = temperature_K + A sin kx, at rest", {amplitude_K(), length("x"), mode()}, false, true},
      {"heat-step",
       "T = temperature_K + A where x < position_m, at rest",
       {amplitude_K(), {"position_m", "of the step [m]; the middle of the region unless given", 0, true}},
       false,
       true},
      {"hydrostatic",
       "at rest under gravity, with the density of the equation of state",
       {{"surface_m", "height of the free surface against gravity [m]; the region's top unless given", 0, true},
        {"knock_m_per_s", "largest speed of vortices that disturb the rest [m/s]; 0 unless given", 0},
        {"knock_length_m", "their wavelength [m]; 1 unless given", 1, false, true}}},
      {"couette-thermal",
       "steady flow between two planes of given temperatures, viscosity exp(-decay (T - T0))",
       {},
       false,
       true},
      {"mms-2d",
       "a manufactured motion: u = U cos(wt) sin kx cos ky, v = -U cos(wt) cos kx sin ky, rho = rho0 (1 + a sin kx sin ky)",
       {speed(),
        length("x"),
        mode(),
        {"angular_frequency_rad_per_s", "w [rad/s]; 1 unless given", 1},
        {"density_amplitude", "a, relative; 0 unless given", 0}},
       true},
      {"mms-3d",
       "a manufactured motion in three dimensions: u = U cos(wt) / k^2 grad f x grad(cos kx + cos ky + cos kz), "
       "f = sin kx sin ky sin kz, rho = rho0 (1 + a f)",
       {speed(),
        length("x"),
        mode(),
        {"angular_frequency_rad_per_s", "w [rad/s]; 1 unless given", 1},
        {"density_amplitude", "a, relative; 0 unless given", 0}},
       true},
  };
  return fields;
}

const FieldInfo* find_field(const std::string& name) {
  const auto& fields = fluid_fields();
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const FieldInfo& field) { return field.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

double default_parameter(const Scene& scene, const Fluid& fluid, const InitialField& field,
                         const FieldParameter& parameter) {
  if (!parameter.from_scene) return parameter.otherwise;
  if (parameter.name == "position_m") return center_of(fluid)[0];
  if (parameter.name == "surface_m") return surface_height(scene, fluid);
  const double period = scene.domain.periodic_m[field.name == "shear" ? 1 : 0];
  return period > 0 ? period : std::numeric_limits<double>::quiet_NaN();
}

FluidState initial_state(const Scene& scene, const Fluid& fluid, const Real3& x) {
  const std::string& name = fluid.initial.name;
  if (name == "taylor-green") return taylor_green(fluid, x);
  if (name == "shear") return shear(fluid, x);
  if (name == "standing-wave") return standing_wave(fluid, x);
  if (name == "elliptic-drop") return elliptic_drop(fluid, x);
  if (name == "square-patch") return square_patch(fluid, x);
  if (name == "heat-sine") return heat_sine(fluid, x);
  if (name == "heat-step") return heat_step(fluid, x);
  if (name == "hydrostatic") return hydrostatic(scene, fluid, x);
  if (name == "mms-2d") return manufactured_2d(fluid, x);
  if (name == "mms-3d") return manufactured_3d(fluid, x);
  if (name == "couette-thermal") return couette_thermal(scene, fluid, x);
  FluidState state{fluid.initial.velocity_m_per_s, fluid.density_kg_per_m3, fluid.temperature_K};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      state.velocity_m_per_s[i] += fluid.initial.velocity_gradient_per_s[3 * i + j] * x[j];
  return state;
}

double density_of(const Fluid& fluid, double pressure_Pa) {
  const double rho0 = fluid.density_kg_per_m3, c = fluid.sound_speed_m_per_s;
  if (fluid.equation_of_state == EquationOfState::linear) return rho0 + pressure_Pa / (c * c);
  const double gamma = fluid.tait_exponent;
  return rho0 * std::pow(1 + gamma * pressure_Pa / (rho0 * c * c), 1 / gamma);
}

double pressure_of(const Fluid& fluid, double density_kg_per_m3) {
  const double rho0 = fluid.density_kg_per_m3, c = fluid.sound_speed_m_per_s;
  if (fluid.equation_of_state == EquationOfState::linear) return c * c * (density_kg_per_m3 - rho0);
  const double gamma = fluid.tait_exponent;
  return rho0 * c * c / gamma * (std::pow(density_kg_per_m3 / rho0, gamma) - 1);
}

RegionBounds bounds_of(const Fluid& fluid) {
  if (const auto* box = std::get_if<BoxRegion>(&fluid.region)) return {box->min_m, box->max_m};
  RegionBounds bounds;
  const auto around = [&](const Real3& center, const Real3& half_extents) {
    for (std::size_t i = 0; i < 3; ++i)
      bounds.min_m[i] = center[i] - half_extents[i], bounds.max_m[i] = center[i] + half_extents[i];
  };
  if (const auto* ball = std::get_if<BallRegion>(&fluid.region))
    around(ball->center_m, {ball->radius_m, ball->radius_m, ball->radius_m});
  if (const auto* ellipsoid = std::get_if<EllipsoidRegion>(&fluid.region))
    around(ellipsoid->center_m, ellipsoid->semi_axes_m);
  if (std::holds_alternative<PointsRegion>(fluid.region) && !fluid.particles.position_m.empty()) {
    bounds.min_m = bounds.max_m = fluid.particles.position_m.front();
    for (const Real3& x : fluid.particles.position_m)
      for (std::size_t i = 0; i < 3; ++i) {
        bounds.min_m[i] = std::min(bounds.min_m[i], x[i]);
        bounds.max_m[i] = std::max(bounds.max_m[i], x[i]);
      }
  }
  return bounds;
}

Real3 center_of(const Fluid& fluid) {
  const RegionBounds bounds = bounds_of(fluid);
  Real3 center{};
  for (std::size_t i = 0; i < 3; ++i) center[i] = 0.5 * (bounds.min_m[i] + bounds.max_m[i]);
  return center;
}

}  // namespace atwood
