#include "fluid_truth/powers.hpp"

#include <array>
#include <stdexcept>

#include "fluid_truth/particles.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood {

using namespace fluid_truth;

namespace {

template <std::size_t N> std::array<double, N> narrowed(const std::array<Wide, N>& values) {
  std::array<double, N> made{};
  for (std::size_t k = 0; k < N; ++k) made[k] = static_cast<double>(values[k]);
  return made;
}

// A point of a body that can move, from its centre of mass and in its axes.
struct Carried {
  std::size_t point;  // index into ParticleData::points
  std::size_t body;   // index into Scene::bodies
  Vec<double> at_m;
};

struct System {
  std::unique_ptr<FluidSystem<double>> equations;
  std::vector<Carried> carried;
};

// Of the equations at an instant: bodies are held where they are, and their surfaces have a velocity.
Scene held(Scene scene) {
  scene.forces.clear();
  for (Body& body : scene.bodies) body.fixed = true;
  return scene;
}

System system_of(const Scene& scene, const Response& response) {
  System made{sph_system<double>(held(scene), response), {}};
  const auto& points = made.equations->data.points;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int body = scene.fluid_boundaries[static_cast<std::size_t>(points[k].boundary)].body;
    const Body& of = scene.bodies[static_cast<std::size_t>(body)];
    if (of.fixed) continue;
    const Vec<double> from = points[k].x - vec<double>(of.position_m);
    made.carried.push_back(
        {k, static_cast<std::size_t>(body), rotate(conjugate(Quat<double>(of.orientation_wxyz)), from)});
  }
  return made;
}

void carry(System& system, std::span<const BodySample> bodies) {
  for (const Carried& carried : system.carried) {
    const BodySample& body = bodies[carried.body];
    const Quat<double> q = narrowed(body.q_wxyz);
    const Vec<double> arm = rotate(q, carried.at_m);
    FixedPoint<double>& point = system.equations->data.points[carried.point];
    point.x = narrowed(body.p_m) + arm;
    point.velocity = narrowed(body.v_m_per_s) + cross(rotate(q, narrowed(body.w_rad_per_s)), arm);
  }
}

void require_summation_covered(const Scene& scene, const Response& asked) {
  require(number(asked, "shift", 0) <= 0, "shift with a density by summation");
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[static_cast<std::size_t>(boundary.body)];
    require(!body.fixed || (body.velocity_m_per_s == Real3{} && body.angular_velocity_body_rad_per_s == Real3{}),
            "the points of `" + body.name + "` stay where they are while its surface slides, and count in the density");
  }
}

}  // namespace

// The whole system, then without one term more each: without diffusion, shift, viscosity, boundaries that move, other
// boundaries, sources.
struct FluidPowersOf::Systems {
  std::array<System, 7> of;
};

FluidPowersOf::~FluidPowersOf() = default;

FluidPowersOf::FluidPowersOf(const Scene& scene, const std::string& response) {
  try {
    Response asked = parse_response(response);
    require(asked.name == "sph", "only the terms of +sph have powers");
    const auto without = [&](const char* setting, const char* value) { asked.settings[setting] = value; };
    if (word(asked, "density", "continuity") == "summation") {
      require_summation_covered(scene, asked);
      without("density", "continuity"), without("shift", "0"), without("density_diffusion", "0");
    }
    auto systems = std::make_unique<Systems>();
    systems->of[0] = system_of(scene, asked);
    without("density_diffusion", "0");
    systems->of[1] = system_of(scene, asked);
    without("shift", "0");
    systems->of[2] = system_of(scene, asked);
    without("viscosity", "none");
    systems->of[3] = system_of(scene, asked);
    Scene open = scene;
    std::erase_if(open.fluid_boundaries, [&](const FluidBoundary& boundary) {
      return !scene.bodies[static_cast<std::size_t>(boundary.body)].fixed;
    });
    systems->of[4] = system_of(open, asked);
    open.fluid_boundaries.clear();
    systems->of[5] = system_of(open, asked);
    for (Fluid& fluid : open.fluids) fluid.source = {}, fluid.expansion_per_K = 0;
    systems->of[6] = system_of(open, asked);
    systems_ = std::move(systems);
  } catch (const Refused& refused) {
    unsupported_ = refused.why;
  } catch (const std::invalid_argument& refused) {
    unsupported_ = refused.what();
  }
}

FluidPowers FluidPowersOf::at(double t_s, std::span<const ParticleSample> particles,
                              std::span<const BodySample> bodies) const {
  const ParticleData<double>& data = systems_->of[0].equations->data;
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
  std::array<double, 7> power{};
  std::vector<double> rate(size);
  for (std::size_t k = 0; k < power.size(); ++k) {
    carry(systems_->of[k], bodies);
    systems_->of[k].equations->rate(t_s, y.data(), rate.data());
    for (std::size_t n = 0; n < size; ++n) power[k] += slope[n] * rate[n];
  }
  return {power[0] - power[1], power[1] - power[2], power[2] - power[3],
          power[3] - power[4], power[4] - power[5], power[5] - power[6]};
}

}  // namespace atwood
