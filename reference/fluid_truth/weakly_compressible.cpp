#include "fluid_truth/weakly_compressible.hpp"

#include <cmath>
#include <memory>
#include <numbers>

#include "fluid_truth/solution.hpp"
#include "fluid_truth/spectral.hpp"
#include "protocol/refusal.hpp"
#include "scene/files.hpp"

namespace atwood {

using namespace fluid_truth;

namespace {

constexpr int kPoints[] = {17, 25, 37, 55, 81};
constexpr double kTarget = 1e-8;  // of the largest speed: differences below it need no more points
constexpr double kTolerance = 1e-12, kLoose = 1e-9;
constexpr double kStretches = 16;

double narrow(Wide value) { return static_cast<double>(value); }

// u, v, rho at t = 0, as the scene's named field says (in quad, rounded once).
std::function<std::array<double, 3>(double, double)> initial_of(const Scene& scene, const Fluid& fluid) {
  const InitialField& field = fluid.initial;
  const Wide rho0 = fluid.density_kg_per_m3, U = parameter(field, "speed_m_per_s", 1);
  if (field.name == "taylor-green") {
    const Wide k = wave_number<Wide>(scene, field, 0);
    require_period(scene, k, 0), require_period(scene, k, 1);
    return [=, &fluid](double x, double y) -> std::array<double, 3> {
      const Wide sx = sin(k * x), sy = sin(k * y), p = -rho0 * U * U / 2 * (1 - sx * sx - sy * sy);
      return {narrow(-U * cos(k * x) * sy), narrow(U * sx * cos(k * y)), narrow(density_of(fluid, p))};
    };
  }
  if (field.name == "shear") {
    const Wide k = wave_number<Wide>(scene, field, 1);
    require_period(scene, k, 1);
    return [=](double, double y) -> std::array<double, 3> { return {narrow(U * sin(k * y)), 0, narrow(rho0)}; };
  }
  if (field.name == "standing-wave") {
    const Wide k = wave_number<Wide>(scene, field, 0), a = parameter(field, "amplitude", 1e-4);
    require_period(scene, k, 0);
    return [=](double x, double) -> std::array<double, 3> { return {0, 0, narrow(rho0 * (1 + a * cos(k * x)))}; };
  }
  const auto made = manufactured_of<Wide>(scene, fluid, field);
  require_period(scene, made.k, 0), require_period(scene, made.k, 1);
  return [=](double x, double y) -> std::array<double, 3> {
    const auto u = made.velocity(0, {x, y, 0});
    return {narrow(u[0]), narrow(u[1]), narrow(made.density({x, y, 0}))};
  };
}

SpectralProblem problem_of(const Scene& scene, const std::string& response) {
  const Fluid& fluid = only_fluid(scene);
  require(scene.domain.dimensions == 2 && scene.domain.periodic_m[0] > 0 && scene.domain.periodic_m[1] > 0,
          "expected a doubly periodic box in two dimensions");
  require(!has_boundaries(scene) && scene.bodies.empty(), "expected no boundary and no body");
  require(fluid.expansion_per_K == 0 && fluid.viscosity_decay_per_K == 0, "density or viscosity of temperature");
  require(fluid.heat_capacity_J_per_kg_K == 0, "the temperature is not solved for");
  SpectralProblem made;
  made.period_x = scene.domain.periodic_m[0], made.period_y = scene.domain.periodic_m[1];
  made.rho0 = fluid.density_kg_per_m3, made.c = fluid.sound_speed_m_per_s;
  made.gamma = fluid.equation_of_state == EquationOfState::tait ? fluid.tait_exponent : 1;
  const ViscousTerm term = viscous_term_of(response);
  made.nu = term == ViscousTerm::none ? 0 : fluid.viscosity_m2_per_s;
  made.beta = term == ViscousTerm::monaghan_gingold ? 2 : 0;
  made.gravity = {scene.gravity_m_per_s2[0], scene.gravity_m_per_s2[1]};
  made.initial = initial_of(scene, fluid);
  if (!fluid.source.name.empty()) {
    const auto field = manufactured_of<double>(scene, fluid, fluid.source);
    made.source = [=](double t, double x, double y) -> std::array<double, 2> {
      const auto s = field.source(t, {x, y, 0});
      return {s[0], s[1]};
    };
  }
  return made;
}

struct Run {
  std::unique_ptr<Spectral> coarse, fine;
  std::unique_ptr<Spectral> loose;  // the points of `fine`
};

// The largest difference of the coarse solution from the fine one at its own points, relative to the largest speed (and
// of the density times c).
double disagreement(Run& run, const SpectralProblem& problem, std::size_t level, double t) {
  const std::vector<double>&fine = run.fine->state_at(t), &coarse = run.coarse->state_at(t);
  double worst = 0, speed = 0;
  const int n = kPoints[level];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = problem.period_x * (i + 0.5) / n, y = problem.period_y * (j + 0.5) / n;
      const SpectralPoint a = run.fine->interpolate(fine, x, y), b = run.coarse->interpolate(coarse, x, y);
      worst = std::fmax(worst, std::fmax(std::fabs(a.u - b.u), std::fabs(a.v - b.v)));
      worst = std::fmax(worst, problem.c * std::fabs(a.rho - b.rho) / problem.rho0);
      speed = std::fmax(speed, std::fmax(std::hypot(a.u, a.v), problem.c * std::fabs(a.rho / problem.rho0 - 1)));
    }
  return speed > 0 ? worst / speed : worst;
}

FieldSample evaluate(Run& run, const SpectralProblem& problem, const Fluid& fluid, Wide t_s,
                     const std::vector<FieldPosition>& positions) {
  const double t = static_cast<double>(t_s);
  const std::vector<double>&fine = run.fine->state_at(t), &coarse = run.coarse->state_at(t),
        &loose = run.loose->state_at(t);
  FieldSample made;
  made.t_s = t_s;
  double dv = 0, dr = 0, speed = 0;
  for (const FieldPosition& at : positions) {
    // Whole periods are taken off in quad, so that an unwrapped position loses nothing.
    const Wide Lx = problem.period_x, Ly = problem.period_y;
    const double x = narrow(at[0] - Lx * floor(at[0] / Lx)), y = narrow(at[1] - Ly * floor(at[1] / Ly));
    const SpectralPoint w = run.fine->interpolate(fine, x, y);
    for (const SpectralPoint& other : {run.coarse->interpolate(coarse, x, y), run.loose->interpolate(loose, x, y)}) {
      dv = std::fmax(dv, std::fmax(std::fabs(w.u - other.u), std::fabs(w.v - other.v)));
      dr = std::fmax(dr, std::fabs(w.rho - other.rho));
    }
    speed = std::fmax(speed, std::hypot(w.u, w.v));
    made.values.push_back({at, {w.u, w.v, 0}, w.rho, pressure_of<Wide>(fluid, w.rho), 0});
  }
  const double bar_v = 2 * dv + 1e-13 * speed, bar_r = 2 * dr + 1e-14 * problem.rho0;
  for (const ParticleSample& value : made.values) {
    const double stiffness =
        problem.c * problem.c * std::pow(narrow(value.density_kg_per_m3) / problem.rho0, problem.gamma - 1);
    made.bars.push_back({{}, {bar_v, bar_v, 0}, bar_r, stiffness * bar_r, 0});
  }
  return made;
}

// What the solution depends on: not how the particles stand, nor what is probed.
std::string key_of(const Scenario& scenario, const std::string& response) {
  Scene scene = scenario.scene;
  scene.probes.clear();
  for (Fluid& fluid : scene.fluids) {
    fluid.particles = {};
    fluid.arrangement = Arrangement::lattice;
    fluid.disturbance = fluid.spacing_m = 0;
    fluid.seed = 1;
  }
  return scene_to_json(scene) + " " + format_double(scenario.t_end_s) + " " +
         std::to_string(static_cast<int>(viscous_term_of(response)));
}

struct Solved {
  std::string key;
  std::shared_ptr<const Scenario> scenario;  // to which the problem's fields refer
  std::shared_ptr<Run> run;
  int points = 0;
};

std::shared_ptr<const Solved> solve(const Scenario& given, const std::string& response) {
  const auto scenario = std::make_shared<const Scenario>(given);
  const SpectralProblem problem = problem_of(scenario->scene, response);
  const double stride_s = given.t_end_s / kStretches;
  const auto solution = [&](std::size_t level, double tolerance) {
    return std::make_unique<Spectral>(problem, kPoints[level], tolerance, stride_s);
  };
  // Points are added until the end of the run asks for no more.
  auto run = std::make_shared<Run>();
  run->coarse = solution(0, kTolerance);
  std::size_t level = 0;
  for (;; ++level) {
    run->fine = solution(level + 1, kTolerance);
    if (level + 2 == std::size(kPoints) || disagreement(*run, problem, level, given.t_end_s) < kTarget) break;
    run->coarse = std::move(run->fine);
  }
  run->loose = solution(level + 1, kLoose);
  return std::make_shared<const Solved>(Solved{key_of(given, response), scenario, run, kPoints[level + 1]});
}

// The cells of a study ask for one field again and again, at the positions of their own particles: the last solution of
// each thread is kept.
std::shared_ptr<const Solved> solved(const Scenario& given, const std::string& response) {
  thread_local std::shared_ptr<const Solved> last;
  if (last == nullptr || last->key != key_of(given, response)) last = solve(given, response);
  return last;
}

}  // namespace

FluidField weakly_compressible_field(const Scenario& given, const std::string& response) {
  FluidField made;
  const auto scenario = std::make_shared<const Scenario>(given);
  try {
    require(given.t_end_s > 0, "expected t_end_s > 0");
    const SpectralProblem problem = problem_of(scenario->scene, response);
    const std::shared_ptr<const Solved> made_once = solved(given, response);
    made.source =
        "weakly compressible equations, Fourier collocation of " + std::to_string(made_once->points) + "^2 points";
    made.note = "the bar is a difference between two numbers of points and two tolerances";
    made.known = {true, true, true, false};
    made.at = [=](Wide t_s, const std::vector<FieldPosition>& positions) {
      if (!(t_s >= 0)) throw std::invalid_argument("a field is asked for at a time before 0");
      FieldSample sample = evaluate(*made_once->run, problem, scenario->scene.fluids.front(), t_s, positions);
      sample.probes.resize(scenario->scene.probes.size());
      return sample;
    };
  } catch (const Refused& refusal) {
    made.outcome = refused("weakly compressible: " + refusal.why);
  } catch (const std::invalid_argument& error) {
    made.outcome = refused(std::string("weakly compressible: ") + error.what());
  }
  return made;
}

}  // namespace atwood
