#include "fluid_truth/particles.hpp"

#include <algorithm>
#include <cmath>

#include "fluid_truth/manufactured.hpp"
#include "fluid_truth/solution.hpp"
#include "scene/fluid_surface.hpp"

namespace atwood::fluid_truth {

template <class S> S FluidLaw<S>::pressure(S density) const {
  if (!tait) return c * c * (density - rho0);
  return rho0 * c * c / gamma * (pow(density / rho0, gamma) - 1);
}
template <class S> S FluidLaw<S>::pressure_slope(S density) const {
  return tait ? c * c * pow(density / rho0, gamma - 1) : c * c;
}
template <class S> S FluidLaw<S>::density_at(S p) const {
  if (!tait) return rho0 + p / (c * c);
  return rho0 * pow(1 + gamma * p / (rho0 * c * c), 1 / gamma);
}
template <class S> S FluidLaw<S>::dynamic_viscosity(S T) const {
  return decay == 0 ? rho0 * nu : rho0 * nu * exp(-decay * (T - T0));
}

namespace {

template <class S> FluidLaw<S> law_of(const Fluid& fluid) {
  FluidLaw<S> made;
  made.tait = fluid.equation_of_state == EquationOfState::tait;
  made.viscous_heat = fluid.viscous_heat;
  made.rho0 = fluid.density_kg_per_m3, made.c = fluid.sound_speed_m_per_s, made.gamma = fluid.tait_exponent;
  made.nu = fluid.viscosity_m2_per_s, made.decay = fluid.viscosity_decay_per_K;
  made.heat_capacity = fluid.heat_capacity_J_per_kg_K, made.conductivity = fluid.conductivity_W_per_m_K;
  made.T0 = fluid.temperature_K, made.expansion = fluid.expansion_per_K;
  return made;
}

void require_covered(const Scene& scene) {
  require(!scene.fluids.empty(), "the scene has no fluid");
  require(scene.forces.empty(), "the scene has forces on bodies");
  for (const Body& body : scene.bodies) require(body.fixed, "`" + body.name + "` can move, which is not covered");
  for (const Fluid& fluid : scene.fluids)
    require(fluid.spacing_m == scene.fluids.front().spacing_m, "the fluids differ in spacing");
}

double wrapped(double x, double period) { return period > 0 ? x - period * std::floor(x / period) : x; }

// The component of the nearest image.
template <class S> S nearest(S difference, S period) {
  if (!(period > 0)) return difference;
  const S turns = difference / period;
  return difference - period * S(std::floor(static_cast<double>(turns) + 0.5));
}

}  // namespace

template <class S> ParticleData<S> particle_data(const Scene& scene, bool density_integrated) {
  require_covered(scene);
  ParticleData<S> made;
  bool heat = false;
  for (std::size_t f = 0; f < scene.fluids.size(); ++f) {
    const Fluid& fluid = scene.fluids[f];
    made.laws.push_back(law_of<S>(fluid));
    made.largest_sound_speed = std::fmax(made.largest_sound_speed, fluid.sound_speed_m_per_s);
    heat = heat || fluid.heat_capacity_J_per_kg_K > 0;
    auto& source = made.source.emplace_back();
    if (!fluid.source.name.empty()) {
      const auto field = manufactured_of<S>(scene, fluid, fluid.source);
      source = [field](S t, const Vec<S>& x) { return field.source(t, x); };
    }
    for (std::size_t i = 0; i < fluid.particles.position_m.size(); ++i) {
      made.fluid.push_back(static_cast<int>(f));
      made.mass.push_back(fluid.particles.mass_kg[i]);
      made.fixed_temperature.push_back(fluid.particles.temperature_K[i]);
      const Real3& v = fluid.particles.velocity_m_per_s[i];
      made.largest_speed = std::fmax(made.largest_speed, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    }
  }
  require(!made.mass.empty(), "the fluid has no particles");
  made.spacing = scene.fluids.front().spacing_m;
  require(made.spacing > 0, "the fluid has no spacing");
  made.gravity = vec<S>(scene.gravity_m_per_s2);
  made.period = vec<S>(scene.domain.periodic_m);
  ParticleLayout& layout = made.layout;
  layout.d = scene.domain.dimensions;
  layout.count = static_cast<int>(made.mass.size());
  layout.velocity = layout.d * layout.count;
  layout.size = 2 * layout.velocity;
  if (density_integrated) layout.density = layout.size, layout.size += layout.count;
  if (heat) layout.temperature = layout.size, layout.size += layout.count;
  return made;
}

template <class S> std::vector<S> initial_state(const Scene& scene, const ParticleLayout& layout) {
  std::vector<S> y(static_cast<std::size_t>(layout.size));
  int i = 0;
  for (const Fluid& fluid : scene.fluids) {
    const Particles& from = fluid.particles;
    for (std::size_t k = 0; k < from.position_m.size(); ++k, ++i) {
      for (int a = 0; a < layout.d; ++a) {
        y[layout.d * i + a] = from.position_m[k][a];
        y[layout.velocity + layout.d * i + a] = from.velocity_m_per_s[k][a];
      }
      if (layout.density >= 0) y[layout.density + i] = from.density_kg_per_m3[k];
      if (layout.temperature >= 0) y[layout.temperature + i] = from.temperature_K[k];
    }
  }
  if (layout.node_count == 0) return y;
  const std::vector<Real3> points = surface_points(scene);
  for (int n = 0; n < layout.node_count; ++n)
    for (int a = 0; a < layout.d; ++a) y[layout.nodes + layout.d * n + a] = points[n][a];
  return y;
}

template <class S>
std::vector<std::vector<Neighbour<S>>> neighbours_of(const ParticleData<S>& data, const std::vector<Vec<S>>& x, S R) {
  const int n = static_cast<int>(x.size());
  std::vector<std::vector<Neighbour<S>>> made(x.size());
  // A double decides which pairs are looked at; those at the border of the support are decided in S.
  const double period[3] = {static_cast<double>(data.period[0]), static_cast<double>(data.period[1]),
                            static_cast<double>(data.period[2])};
  std::vector<Real3> near(x.size());
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) near[i][a] = wrapped(static_cast<double>(x[i][a]), period[a]);
  const double radius = static_cast<double>(R) * (1 + 1e-9), radius2 = radius * radius;
  const auto look = [&](int i, int j) {
    double r2 = 0;
    for (int a = 0; a < 3; ++a) {
      const double gap = nearest(near[i][a] - near[j][a], period[a]);
      r2 += gap * gap;
    }
    if (r2 > radius2) return;
    Neighbour<S> made_one;
    made_one.other = j;
    for (int a = 0; a < data.layout.d; ++a) made_one.x[a] = nearest(x[i][a] - x[j][a], data.period[a]);
    made_one.r = sqrt(dot(made_one.x, made_one.x));
    if (made_one.r < R) made[i].push_back(made_one);
  };
  constexpr int max_pairwise = 100;
  // Cells at least R wide, numbered over the extent of the points; along a period at least three of them.
  int cells[3] = {1, 1, 1};
  double low[3] = {0, 0, 0}, width[3] = {1, 1, 1};
  bool useful = n > max_pairwise;
  for (int a = 0; a < data.layout.d && useful; ++a) {
    double high = period[a];
    if (!(period[a] > 0)) {
      low[a] = high = near[0][a];
      for (const Real3& p : near) low[a] = std::fmin(low[a], p[a]), high = std::fmax(high, p[a]);
    }
    useful = std::isfinite(high - low[a]);
    if (!useful) break;
    cells[a] = std::clamp(static_cast<int>((high - low[a]) / radius), 1, 400);
    width[a] = std::fmax((high - low[a]) / cells[a], 1e-300);
    if (period[a] > 0 && cells[a] < 3) useful = false;
  }
  if (!useful) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (j != i) look(i, j);
    return made;
  }
  const auto cell_of = [&](int i, int a) {
    return std::clamp(static_cast<int>((near[i][a] - low[a]) / width[a]), 0, cells[a] - 1);
  };
  std::vector<std::vector<int>> in(static_cast<std::size_t>(cells[0]) * cells[1] * cells[2]);
  const auto index = [&](int p, int q, int s) { return (static_cast<std::size_t>(p) * cells[1] + q) * cells[2] + s; };
  for (int i = 0; i < n; ++i) in[index(cell_of(i, 0), cell_of(i, 1), cell_of(i, 2))].push_back(i);
  std::vector<int> candidates;
  for (int i = 0; i < n; ++i) {
    candidates.clear();
    const int home[3] = {cell_of(i, 0), cell_of(i, 1), cell_of(i, 2)};
    for (int p = -1; p <= 1; ++p)
      for (int q = -1; q <= 1; ++q)
        for (int s = -1; s <= 1; ++s) {
          int at[3] = {home[0] + p, home[1] + q, home[2] + s};
          bool inside = true;
          for (int a = 0; a < 3; ++a) {
            if (period[a] > 0 && cells[a] >= 3) at[a] = (at[a] + cells[a]) % cells[a];
            inside = inside && at[a] >= 0 && at[a] < cells[a];
          }
          if (!inside) continue;
          const auto& here = in[index(at[0], at[1], at[2])];
          candidates.insert(candidates.end(), here.begin(), here.end());
        }
    std::sort(candidates.begin(), candidates.end());
    for (const int j : candidates)
      if (j != i) look(i, j);
  }
  return made;
}

template <class S> std::unique_ptr<FluidSystem<S>> fluid_system(const Scene& scene, const std::string& text) {
  const Response response = parse_response(text);
  if (response.name == "sph") return sph_system<S>(scene, response);
  require(response.name == "polynomial", "expected the response sph or polynomial; found `" + response.name + "`");
  return polynomial_system<S>(scene, response);
}

#define ATWOOD_INSTANTIATE(S)                                                                                       \
  template struct FluidLaw<S>;                                                                                      \
  template ParticleData<S> particle_data(const Scene&, bool);                                                       \
  template std::vector<S> initial_state(const Scene&, const ParticleLayout&);                                       \
  template std::vector<std::vector<Neighbour<S>>> neighbours_of(const ParticleData<S>&, const std::vector<Vec<S>>&, \
                                                                S);                                                 \
  template std::unique_ptr<FluidSystem<S>> fluid_system(const Scene&, const std::string&);
ATWOOD_INSTANTIATE(double)
ATWOOD_INSTANTIATE(Narrow)
ATWOOD_INSTANTIATE(Wide)

}  // namespace atwood::fluid_truth
