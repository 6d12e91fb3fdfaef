#include "fluid_truth/powers.hpp"

#include <array>
#include <stdexcept>

#include "fluid_truth/particles.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood {

using namespace fluid_truth;

// The whole system, then without one term more each: without diffusion, shift, viscosity, boundaries, sources.
struct FluidPowersOf::Systems {
  std::array<std::unique_ptr<FluidSystem<double>>, 6> of;
};

FluidPowersOf::~FluidPowersOf() = default;

FluidPowersOf::FluidPowersOf(const Scene& scene, const std::string& response) {
  try {
    Response asked = parse_response(response);
    require(asked.name == "sph", "the terms of +sph alone have powers");
    require(word(asked, "density", "continuity") == "continuity", "a density by summation is no unknown");
    auto systems = std::make_unique<Systems>();
    systems->of[0] = sph_system<double>(scene, asked);
    asked.settings["density_diffusion"] = "0";
    systems->of[1] = sph_system<double>(scene, asked);
    asked.settings["shift"] = "0";
    systems->of[2] = sph_system<double>(scene, asked);
    asked.settings["viscosity"] = "none";
    systems->of[3] = sph_system<double>(scene, asked);
    Scene open = scene;
    open.fluid_boundaries.clear();
    systems->of[4] = sph_system<double>(open, asked);
    for (Fluid& fluid : open.fluids) fluid.source = {}, fluid.expansion_per_K = 0;
    systems->of[5] = sph_system<double>(open, asked);
    systems_ = std::move(systems);
  } catch (const Refused& refused) {
    unsupported_ = refused.why;
  } catch (const std::invalid_argument& refused) {
    unsupported_ = refused.what();
  }
}

FluidPowers FluidPowersOf::at(double t_s, std::span<const ParticleSample> particles) const {
  const ParticleData<double>& data = systems_->of[0]->data;
  const ParticleLayout& layout = data.layout;
  const auto size = static_cast<std::size_t>(layout.size), d = static_cast<std::size_t>(layout.d);
  const auto velocity = static_cast<std::size_t>(layout.velocity), density = static_cast<std::size_t>(layout.density);
  std::vector<double> y(size), slope(size);  // slope: grad E
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const ParticleSample& p = particles[i];
    const FluidLaw<double>& law = data.laws[static_cast<std::size_t>(data.fluid[i])];
    const double m = data.mass[i], rho = static_cast<double>(p.density_kg_per_m3);
    for (std::size_t a = 0; a < d; ++a) {
      y[d * i + a] = static_cast<double>(p.p_m[a]);
      y[velocity + d * i + a] = static_cast<double>(p.v_m_per_s[a]);
      slope[d * i + a] = -m * data.gravity[a];
      slope[velocity + d * i + a] = m * y[velocity + d * i + a];
    }
    y[density + i] = rho;
    slope[density + i] = m * law.pressure(rho) / (rho * rho);
    if (layout.temperature < 0) continue;
    y[static_cast<std::size_t>(layout.temperature) + i] = static_cast<double>(p.temperature_K);
    slope[static_cast<std::size_t>(layout.temperature) + i] = m * law.heat_capacity;
  }
  std::array<double, 6> power{};
  std::vector<double> rate(size);
  for (std::size_t k = 0; k < power.size(); ++k) {
    systems_->of[k]->rate(t_s, y.data(), rate.data());
    for (std::size_t n = 0; n < size; ++n) power[k] += slope[n] * rate[n];
  }
  return {power[0] - power[1], power[1] - power[2], power[2] - power[3], power[3] - power[4], power[4] - power[5]};
}

}  // namespace atwood
