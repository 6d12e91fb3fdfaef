// The engine's rate of particles and the reference's, written from one page of equations and sharing no code, agree to
// round-off on random states.
#include <catch2/catch.hpp>

#include "fluid/polynomial.hpp"
#include "fluid/sph.hpp"
#include "fluid_truth/particles.hpp"
#include "validation/tests/fluid/scenes.hpp"

using namespace atwood;

namespace {

// The largest difference of the two rates in each part of the state, relative to the part's largest rate.
template <class Engine> double apart(const Scene& scene, Engine& engine, const std::string& response, double t = 0.3) {
  REQUIRE(engine.unsupported() == "");
  const auto reference = fluid_truth::fluid_system<Wide>(scene, response);
  const auto& layout = reference->data.layout;
  REQUIRE(engine.system().size == layout.size);
  std::vector<double> y(layout.size), f(layout.size);
  engine.initial_state(y.data());
  const std::vector<Wide> wide = fluid_truth::initial_state<Wide>(scene, layout);
  for (int i = 0; i < layout.size; ++i) REQUIRE(y[i] == static_cast<double>(wide[i]));
  engine.system().rate(t, y.data(), f.data());
  std::vector<Wide> g(layout.size);
  reference->rate(t, wide.data(), g.data());
  double worst = 0;
  std::vector<int> borders{0, layout.velocity};
  if (layout.density >= 0) borders.push_back(layout.density);
  if (layout.temperature >= 0) borders.push_back(layout.temperature);
  if (layout.node_count > 0) borders.push_back(layout.nodes);
  borders.push_back(layout.size);
  for (std::size_t part = 0; part + 1 < borders.size(); ++part) {
    double difference = 0, largest = 0;
    for (int i = borders[part]; i < borders[part + 1]; ++i) {
      difference = std::fmax(difference, std::fabs(f[i] - static_cast<double>(g[i])));
      largest = std::fmax(largest, std::fabs(static_cast<double>(g[i])));
    }
    REQUIRE(largest > 0);
    worst = std::fmax(worst, difference / largest);
  }
  return worst;
}

const std::pair<const char*, fluid::KernelShape> kKernels[] = {{"cubic", fluid::KernelShape::cubic},
                                                               {"quintic", fluid::KernelShape::quintic},
                                                               {"wendland-c2", fluid::KernelShape::wendland_c2},
                                                               {"wendland-c4", fluid::KernelShape::wendland_c4},
                                                               {"wendland-c6", fluid::KernelShape::wendland_c6}};

}  // namespace

TEST_CASE("+sph: the engine and the reference agree on every kernel, density, viscosity and option") {
  for (const int dimensions : {2, 3})
    for (const auto& [name, shape] : kKernels) {
      Scene scene = block_scene({dimensions, dimensions == 2 ? 9 : 6, 0.125, 0.3});
      heat(scene.fluids[0]);
      scene.gravity_m_per_s2 = {0.3, -9.81, 0};
      scene.fluids[0].equation_of_state = dimensions == 2 ? EquationOfState::tait : EquationOfState::linear;
      const std::string start = std::string("sph{kernel=") + name + ",smoothing=" + (name[0] == 'q' ? "0.9" : "1.2");
      fluid::SphOptions options;
      options.kernel = shape;
      options.smoothing = name[0] == 'q' ? 0.9 : 1.2;
      INFO(start << " in " << dimensions);
      {
        fluid::Sph<double> engine(scene, options);
        CHECK(apart(scene, engine, start + "}") < 1e-12);
      }
      options.viscosity = fluid::Viscosity::central;
      options.summation = true;
      {
        fluid::Sph<double> engine(scene, options);
        CHECK(apart(scene, engine, start + ",viscosity=central,density=summation}") < 1e-12);
      }
      options.summation = false;
      options.density_diffusion = 0.1;
      options.shift = 0.7;
      {
        fluid::Sph<double> engine(scene, options);
        CHECK(apart(scene, engine, start + ",viscosity=central,density_diffusion=0.1,shift=0.7}") < 1e-12);
      }
      options.shift = 0;
      options.corrected = true;
      {
        fluid::Sph<double> engine(scene, options);
        CHECK(apart(scene, engine, start + ",viscosity=central,density_diffusion=0.1,corrected=true}") < 1e-12);
      }
    }
}

TEST_CASE("+sph unless told otherwise: the engine and the reference shift the same particles") {
  for (const bool periodic : {true, false})
    for (const bool moves : {true, false}) {
      const Scene scene = block_scene({.speed_m_per_s = moves ? 1.0 : 0.0, .periodic = periodic});
      fluid::SphOptions options;
      options.shift = options.density_diffusion = -1;
      fluid::Sph<double> engine(scene, options);
      CHECK(engine.options().shift == (periodic && moves ? 1 : 0));
      CHECK(engine.options().density_diffusion == (periodic && moves ? 0.1 : 0));
      if (!moves) continue;  // no rate of the positions to compare
      CHECK(apart(scene, engine, "sph{kernel=wendland-c2,smoothing=1.3,shift=-1,density_diffusion=-1}") < 1e-12);
    }
}

TEST_CASE("The source of a manufactured field: the engine and the reference agree in two and three dimensions") {
  for (const int dimensions : {2, 3})
    for (const EquationOfState law : {EquationOfState::linear, EquationOfState::tait}) {
      Scene scene = block_scene({dimensions, dimensions == 2 ? 9 : 6, 0.125, 0.25});
      Fluid& fluid = scene.fluids[0];
      fluid.equation_of_state = law;
      fluid.source.name = dimensions == 2 ? "mms-2d" : "mms-3d";
      fluid.source.parameters = {{"speed_m_per_s", 3},
                                 {"length_m", scene.domain.periodic_m[0]},
                                 {"mode", 2},
                                 {"angular_frequency_rad_per_s", 4},
                                 {"density_amplitude", 0.03}};
      fluid::Sph<double> pairs(scene, {});
      CHECK(apart(scene, pairs, "sph{kernel=wendland-c2,smoothing=1.3}") < 1e-12);
      fluid::PolynomialOptions options;
      options.degree = 2;
      fluid::Polynomial<double> fits(scene, options);
      CHECK(apart(scene, fits, "polynomial{degree=2}") < 1e-11);
    }
}

TEST_CASE("+sph between walls: the engine and the reference agree, no-slip and free-slip, with heat") {
  for (const Slip slip : {Slip::no_slip, Slip::free_slip})
    for (const bool flux : {false, true}) {
      Scene scene = block_scene({2, 8, 0.125, 0.2});
      scene.domain.periodic_m = {1, 0, 0};
      scene.gravity_m_per_s2 = {0.2, -1, 0};
      heat(scene.fluids[0]);
      scene.fluids[0].expansion_per_K = 0;
      scene.fluids[0].region = BoxRegion{{0, 0, 0}, {1, 1, 0}};
      for (const bool lower : {true, false}) {
        Body& wall = scene.bodies.emplace_back();
        wall.name = lower ? "floor" : "lid";
        wall.fixed = true;
        wall.shape = lower ? Plane{{0, 1, 0}, -0.01} : Plane{{0, -1, 0}, -1.02};
        wall.velocity_m_per_s = {lower ? 0 : 0.7, 0, 0};
        FluidBoundary& boundary = scene.fluid_boundaries.emplace_back();
        boundary.body = lower ? 0 : 1;
        boundary.slip = slip;
        if (flux) boundary.heat_flux_W_per_m2 = lower ? 30 : -20;
        if (!flux) boundary.temperature_K = lower ? 310 : 290;
      }
      fluid::SphOptions options;
      options.smoothing = 1.2;
      fluid::Sph<double> engine(scene, options);
      CHECK(apart(scene, engine, "sph{kernel=wendland-c2,smoothing=1.2}") < 1e-12);
    }
}

TEST_CASE("+polynomial: the engine and the reference agree in two and three dimensions, of degree 2 and 4") {
  for (const int dimensions : {2, 3})
    for (const int degree : {2, 4}) {
      const int across = dimensions == 2 ? 9 : degree == 2 ? 6 : 7;
      Scene scene = block_scene({dimensions, across, 0.125, 0.25});
      heat(scene.fluids[0]);
      scene.gravity_m_per_s2 = {0.3, -9.81, 0};
      scene.fluids[0].equation_of_state = EquationOfState::tait;
      fluid::PolynomialOptions options;
      options.degree = degree;
      fluid::Polynomial<double> engine(scene, options);
      CHECK(apart(scene, engine, "polynomial{degree=" + std::to_string(degree) + "}") < (degree == 2 ? 1e-11 : 1e-9));
    }
}

TEST_CASE(
    "+polynomial between walls and in a corner: the engine and the reference agree, no-slip and free-slip, with heat") {
  for (const int dimensions : {2, 3})
    for (const int degree : {2, 4})
      for (const Slip slip : {Slip::no_slip, Slip::free_slip})
        for (const bool flux : {false, true}) {
          if (dimensions == 3 && (slip == Slip::free_slip) != flux) continue;
          const int across = dimensions == 2 ? 10 : 6;
          const double size = 0.125 * across;
          const Plane planes[] = {{{0, 1, 0}, -0.01},         {{0, -1, 0}, -0.02 - size}, {{1, 0, 0}, -0.02},
                                  {{-1, 0, 0}, -0.03 - size}, {{0, 0, 1}, -0.01},         {{0, 0, -1}, -0.01 - size}};
          Scene scene = block_scene({dimensions, across, 0.125, 0.2});
          scene.domain.periodic_m = {};
          scene.gravity_m_per_s2 = {0.2, -1, 0};
          heat(scene.fluids[0]);
          scene.fluids[0].region = BoxRegion{{0, 0, 0}, {size, size, dimensions == 3 ? size : 0}};
          for (int k = 0; k < 2 * dimensions; ++k) {
            Body& wall = scene.bodies.emplace_back();
            wall.name = "wall " + std::to_string(k);
            wall.fixed = true;
            wall.shape = planes[k];
            if (k == 1) wall.velocity_m_per_s = {0.7, 0, 0};
            FluidBoundary& boundary = scene.fluid_boundaries.emplace_back();
            boundary.body = k;
            boundary.slip = slip;
            if (k > 2) continue;  // insulated
            if (flux) boundary.heat_flux_W_per_m2 = 30 - 20 * k;
            if (!flux) boundary.temperature_K = 310 - 10 * k;
          }
          fluid::PolynomialOptions options;
          options.degree = degree;
          fluid::Polynomial<double> engine(scene, options);
          CAPTURE(dimensions, degree, slip == Slip::no_slip, flux);
          CHECK(apart(scene, engine, "polynomial{degree=" + std::to_string(degree) + "}") <
                (degree == 2 ? 1e-11 : 1e-9));
        }
}

TEST_CASE("+polynomial with a free surface: the engine and the reference agree, its nodes included") {
  for (const int dimensions : {2, 3}) {
    Scene scene = block_scene({dimensions, dimensions == 2 ? 10 : 7, 0.125, 0.25});
    const double side = dimensions == 2 ? 1.25 : 0.875;
    scene.domain.periodic_m = {};
    scene.fluids[0].region = BoxRegion{{0, 0, 0}, {side, side, dimensions == 2 ? 0 : side}};
    heat(scene.fluids[0]);
    scene.fluids[0].equation_of_state = EquationOfState::tait;
    fluid::PolynomialOptions options;
    options.degree = 2;
    options.shift = 0.7;
    fluid::Polynomial<double> engine(scene, options);
    CHECK(apart(scene, engine, "polynomial{degree=2,shift=0.7}") < 1e-11);
  }
}
