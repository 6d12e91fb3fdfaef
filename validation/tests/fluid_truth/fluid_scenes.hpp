// Scenes of fluids made by hand, and derivatives of exact fields by central differences in quad.
#pragma once

#include <functional>
#include <string>

#include "fluid_truth/solution.hpp"
#include "scene/scene.hpp"
#include "scene/split_mix.hpp"

namespace atwood::fluid_truth {

inline Scenario fluid_scenario(const std::string& solution, double Lx = 1, double Ly = 1) {
  Scenario made;
  made.id = "test";
  made.t_end_s = 1;
  made.truth.kind = TruthKind::closed_form;
  made.truth.solution = solution;
  made.scene.domain = {2, {Lx, Ly, 0}};
  Fluid& fluid = made.scene.fluids.emplace_back();
  fluid.name = "water";
  fluid.region = BoxRegion{{0, 0, 0}, {Lx > 0 ? Lx : 1, Ly > 0 ? Ly : 1, 0}};
  fluid.density_kg_per_m3 = 1000;
  fluid.sound_speed_m_per_s = 10;
  fluid.viscosity_m2_per_s = 0.01;
  fluid.initial.name = solution;
  return made;
}

// Two planes at y = low and y = high around the fluid; the velocity of each along x.
inline void add_channel(Scenario& scenario, double low, double high, double u_low, double u_high) {
  Scene& scene = scenario.scene;
  scene.domain.periodic_m[1] = 0;
  for (const bool lower : {true, false}) {
    Body& body = scene.bodies.emplace_back();
    body.name = lower ? "floor" : "lid";
    body.fixed = true;
    body.shape = lower ? Plane{{0, 1, 0}, low} : Plane{{0, -1, 0}, -high};
    body.velocity_m_per_s = {lower ? u_low : u_high, 0, 0};
    scene.fluid_boundaries.push_back({lower ? 0 : 1, Slip::no_slip, {}, {}});
  }
}

inline Field<Wide> wide_field(const Scenario& scenario, const Solution& solution, const std::string& response = "") {
  return solution.wide({scenario, response});
}

// Central differences of order 4 in quad: with h = 1e-6 the error is some h^4 and some 1e-33 / h^2.
struct Differences {
  Wide h = 1e-6;
  using Function = std::function<Wide(Wide)>;
  Wide first(const Function& f) const { return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h); }
  Wide second(const Function& f) const {
    return (16 * (f(h) + f(-h)) - (f(2 * h) + f(-2 * h)) - 30 * f(0)) / (12 * h * h);
  }
};

// What is left of rho (u_t + u.grad u) + grad p - rho0 nu lap u - rho a = 0 and of rho_t + div(rho u) = 0 at one point.
// `a`: gravity and sources. The density is the field's.
struct Residual {
  double momentum = 0, mass = 0, largest_term = 0;
};
inline Residual flow_residual(const Field<Wide>& field, const Fluid& fluid, Wide t, const Vec<Wide>& x,
                              const Vec<Wide>& a = {}, const Differences& by = {}) {
  const auto at = [&](int axis, Wide d) {
    Vec<Wide> moved = x;
    moved[axis] += d;
    return field.at(t)(moved);
  };
  const Point<Wide> here = field.at(t)(x);
  Residual made;
  Wide mass = by.first([&](Wide d) { return field.at(t + d)(x).density; });
  for (int j = 0; j < 3; ++j)
    mass += by.first([&](Wide d) {
      const Point<Wide> p = at(j, d);
      return p.density * p.v[j];
    });
  made.mass = static_cast<double>(magnitude(mass));
  for (int i = 0; i < 3; ++i) {
    const Wide unsteady = by.first([&](Wide d) { return field.at(t + d)(x).v[i]; });
    Wide convection = 0, diffusion = 0;
    for (int j = 0; j < 3; ++j) {
      convection += here.v[j] * by.first([&](Wide d) { return at(j, d).v[i]; });
      diffusion += by.second([&](Wide d) { return at(j, d).v[i]; });
    }
    const Wide push = by.first([&](Wide d) { return at(i, d).p; }), rho = here.density,
               viscous = Wide(fluid.density_kg_per_m3) * Wide(fluid.viscosity_m2_per_s) * diffusion;
    const Wide left = rho * (unsteady + convection) + push - viscous - rho * a[i];
    made.momentum = std::max(made.momentum, static_cast<double>(magnitude(left)));
    for (const Wide& term : {rho * unsteady, rho * convection, push, viscous, rho * a[i]})
      made.largest_term = std::max(made.largest_term, static_cast<double>(magnitude(term)));
  }
  return made;
}

struct Draw {  // reproducible
  SplitMix64 random;
  explicit Draw(std::uint64_t seed) : random{seed} {}
  double operator()(double low, double high) { return low + (high - low) * random.next_unit(); }
};

}  // namespace atwood::fluid_truth
