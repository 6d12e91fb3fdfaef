// Figures of fluids against answers known by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>

#include "scene/files.hpp"
#include "scene/fluid_points.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/fluid_picture.hpp"

using namespace atwood;
using Catch::Contains;

namespace {

// Four particles of 1, 2, 1, 2 kg on a square of 1 m in the plane; three samples at 0, 1, 2 s.
Scenario four_particles() {
  Scenario s;
  s.id = "four";
  s.t_end_s = 2, s.steps = {2}, s.samples = 2;
  s.scene.materials.push_back({"default", 0, 0, 0});
  s.scene.domain.dimensions = 2;
  Fluid fluid;
  fluid.name = "water";
  fluid.region = BoxRegion{{0, 0, 0}, {2, 2, 0}};
  fluid.spacing_m = 1;
  fluid.density_kg_per_m3 = 1000;
  fluid.sound_speed_m_per_s = 10;
  fluid.particles.position_m = {{0.5, 0.5, 0}, {0.5, 1.5, 0}, {1.5, 0.5, 0}, {1.5, 1.5, 0}};
  fluid.particles.velocity_m_per_s.assign(4, {1, 0, 0});
  fluid.particles.mass_kg = {1, 2, 1, 2};
  fluid.particles.density_kg_per_m3.assign(4, 1000);
  fluid.particles.temperature_K.assign(4, 0);
  s.scene.fluids.push_back(fluid);
  s.truth = {TruthKind::closed_form, "a-field", ""};
  return s;
}

Recording still(const Scenario& s) {
  Recording run;
  for (int k = 0; k <= 2; ++k) {
    Sample sample;
    sample.t_s = k;
    const Particles& p = s.scene.fluids[0].particles;
    for (std::size_t i = 0; i < p.position_m.size(); ++i) {
      ParticleSample& one = sample.particles.emplace_back();
      for (std::size_t a = 0; a < 3; ++a) one.p_m[a] = p.position_m[i][a], one.v_m_per_s[a] = p.velocity_m_per_s[i][a];
      one.density_kg_per_m3 = p.density_kg_per_m3[i];
    }
    run.values.push_back(sample);
  }
  return run;
}

// A field of this velocity along x everywhere, and of the pressure 100 Pa.
FieldAtParticles field(double u, const std::vector<Wide>& t_s, const std::vector<std::vector<FieldPosition>>& at) {
  FieldAtParticles made;
  made.known.velocity = made.known.pressure = true;
  made.source = "a test";
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    FieldSample& sample = made.samples.emplace_back();
    sample.t_s = t_s[k];
    sample.values.resize(at[k].size());
    sample.bars.resize(at[k].size());
    for (ParticleSample& p : sample.values) p.v_m_per_s[0] = u, p.pressure_Pa = 100;
    for (ParticleSample& p : sample.bars) p.v_m_per_s[0] = 0.001;
  }
  return made;
}

double value_of(const std::vector<Row>& rows, const std::string& metric, const std::string& body = "") {
  for (const Row& row : rows)
    if (row.metric == metric && row.body == body && !row.t_s) return row.value;
  return std::numeric_limits<double>::quiet_NaN();
}

const AskField kNoField = [](TruthKind, const std::vector<Wide>&, const std::vector<std::vector<FieldPosition>>&) {
  FieldAtParticles none;
  none.outcome.status = Status::unsupported;
  return none;
};
const auto kNoTruth = [] {
  Truth none;
  none.outcome.status = Status::unsupported;
  return none;
};

}  // namespace

TEST_CASE("norms of fields: weighted by the masses, over the exact field's own") {
  const Scenario s = four_particles();
  Recording run = still(s);
  const auto end = run.values.back().particles;
  end[0].v_m_per_s = {3, 0, 0};  // off by 1 from the field of 2, its mass 1
  end[1].v_m_per_s = {2, 3, 0};  // off by 3, its mass 2
  end[2].v_m_per_s = end[3].v_m_per_s = {2, 0, 0};
  for (auto& p : end) p.pressure_Pa = 110;
  const AskField ask = [](TruthKind kind, const std::vector<Wide>& t_s, const auto& at) {
    return kind == TruthKind::closed_form ? field(2, t_s, at) : kNoField(kind, t_s, at);
  };
  const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, ask, kNoTruth), run);
  CHECK(value_of(rows, "velocity-l1") == Approx((1 * 1 + 2 * 3) / 12.0));
  CHECK(value_of(rows, "velocity-l2") == Approx(std::sqrt(19.0 / 24)));
  CHECK(value_of(rows, "velocity-linf") == Approx(1.5));
  CHECK(value_of(rows, "pressure-l1") == Approx(0.1));
  CHECK(std::isnan(value_of(rows, "temperature-l1")));
  CHECK(std::isnan(value_of(rows, "model-error")));
  CHECK(value_of(rows, "space-error") == Approx(value_of(rows, "velocity-l1")));
  CHECK(value_of(rows, "kinetic-energy-error") == Approx((0.5 * (9 + 2 * 13 + 3 * 4) - 12) / 12));
  int timed = 0;
  for (const Row& row : rows) {
    timed += row.metric == "velocity-l1" && row.t_s ? 1 : 0;
    if (row.metric == "velocity-l1") CHECK_THAT(row.reason, Contains("of the exact field's own norm, 2 m/s"));
    if (row.metric == "velocity-l1") CHECK(row.truth_bar == Approx(0.0005));
  }
  CHECK(timed == 2);
}

TEST_CASE("norms on a grid: polynomials of degree 4 have no error of interpolation, others the bar") {
  for (const int d : {2, 3}) {
    Scenario s = four_particles();
    s.scene.domain = {d, {1, 1, d == 2 ? 0.0 : 1.0}};
    Fluid& fluid = s.scene.fluids[0];
    fluid.region = BoxRegion{{0, 0, 0}, {1, 1, d == 2 ? 0.0 : 1.0}};
    fluid.spacing_m = 0.1;
    fluid.arrangement = Arrangement::disturbed;
    fluid.disturbance = 0.2;
    place_particles(s.scene);
    Recording run = still(s);
    const std::vector<FieldPosition> grid = comparison_grid(s.scene);
    REQUIRE(grid.size() == (d == 2 ? 100 : 1000));
    CHECK(static_cast<double>(grid[0][0]) == Approx(0.05));
    CHECK(static_cast<double>(grid[0][2]) == Approx(d == 2 ? 0 : 0.05));
    // The pressure 1000 + wave, a period of which has 10 particles; the velocity 2 everywhere. The run's pressure is
    // 1 % larger and its velocity off by 0.5.
    const auto pressure = [](const FieldPosition& x) {
      return 1000 +
             100 * std::sin(2 * M_PI * static_cast<double>(x[0])) * std::cos(2 * M_PI * static_cast<double>(x[1]));
    };
    const AskField ask = [&](TruthKind kind, const std::vector<Wide>& t_s,
                             const std::vector<std::vector<FieldPosition>>& at) {
      if (kind != TruthKind::closed_form) return kNoField(kind, t_s, at);
      FieldAtParticles made = field(2, t_s, at);
      for (std::size_t k = 0; k < at.size(); ++k)
        for (std::size_t i = 0; i < at[k].size(); ++i) made.samples[k].values[i].pressure_Pa = pressure(at[k][i]);
      return made;
    };
    for (const SampleReference sample : run.values)
      for (ParticleSample& p : sample.particles)
        p.v_m_per_s = {2, 0.5, 0}, p.pressure_Pa = 1.01 * pressure({p.p_m[0], p.p_m[1], p.p_m[2]});
    const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, ask, kNoTruth), run);
    CHECK(value_of(rows, "velocity-grid-l1") == Approx(0.25).epsilon(1e-10));
    CHECK(value_of(rows, "velocity-grid-linf") == Approx(0.25).epsilon(1e-10));
    CHECK(value_of(rows, "pressure-grid-l1") == Approx(0.01).epsilon(0.02));
    CHECK(value_of(rows, "pressure-grid-linf") < 0.012);
    for (const Row& row : rows) {
      if (row.metric == "velocity-grid-l2") CHECK(row.truth_bar < 1e-12);
      if (row.metric == "pressure-grid-l2") CHECK((row.truth_bar > 1e-7 && row.truth_bar < 1e-3));
    }
    CHECK(std::isnan(value_of(rows, "temperature-grid-l1")));
  }
  CHECK(comparison_grid(four_particles().scene).empty());  // no period
}

TEST_CASE("an exact field of zero: relative to the fluid's own scale") {
  const Scenario s = four_particles();
  const Recording run = still(s);  // 1 m/s everywhere; the sound speed is 10
  const AskField ask = [](TruthKind, const std::vector<Wide>& t_s, const auto& at) { return field(0, t_s, at); };
  const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, ask, kNoTruth), run);
  CHECK(value_of(rows, "velocity-linf") == Approx(0.1));
  CHECK(value_of(rows, "velocity-l1") == Approx(0.1));
  CHECK(value_of(rows, "velocity-l2") == Approx(0.1));
}

TEST_CASE("model, space and time add to the whole, particle by particle") {
  Scenario s = four_particles();
  s.truth.kind = TruthKind::semi_discrete;
  Recording run = still(s);
  const std::array<double, 4> u{2.5, 2.75, 3, 1};
  for (std::size_t i = 0; i < 4; ++i) run.values.back().particles[i].v_m_per_s = {u[i], 0, 0};
  const AskField ask = [](TruthKind kind, const std::vector<Wide>& t_s, const auto& at) {
    return field(kind == TruthKind::closed_form ? 2 : 2.1, t_s, at);
  };
  const auto particles = [&] {
    Truth truth;
    truth.values = still(s).values;
    truth.bars = truth.values;
    for (const SampleReference bar : truth.bars)
      for (ParticleSample& p : bar.particles) p = {};
    for (ParticleSample& p : truth.values.back().particles) p.v_m_per_s = {2.4, 0, 0};
    return truth;
  };
  const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, ask, particles), run);
  CHECK(value_of(rows, "model-error") == Approx(0.1 / 2));
  CHECK(value_of(rows, "space-error") == Approx(0.3 / 2));
  CHECK(value_of(rows, "time-error") == Approx((0.1 + 2 * 0.35 + 0.6 + 2 * 1.4) / 12));
  CHECK(value_of(rows, "time-error", "linf") == Approx(1.4 / 2));
  CHECK(value_of(rows, "closing-residual") < 1e-15);
}

TEST_CASE("a particle that is not finite ends the cell with where and when") {
  const Scenario s = four_particles();
  Recording run = still(s);
  run.values[1].particles[2].density_kg_per_m3 = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].status == Status::not_finite);
  CHECK(rows[0].reason == "particle 2 of the fluid `water` at t = 1 s");
}

TEST_CASE("momenta: an imbalance of one particle, of the sum of sizes") {
  const Scenario s = four_particles();
  Recording run = still(s);
  run.values[1].particles[0].v_m_per_s[1] += 0.006;  // 0.006 kg m/s of 6 kg m/s and 0.003 of |m x v| = 7 kg m^2/s
  const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run);
  CHECK(value_of(rows, "fluid-momentum-error") == Approx(0.001).epsilon(1e-4));
  const double sizes = 0.5 + 2 * 1.5 + 0.5 + 2 * 1.5;
  CHECK(value_of(rows, "fluid-angular-momentum-error") == Approx(0.003 / sizes).epsilon(1e-2));
}

TEST_CASE("the budget of energy: elastic energy by its integral, heat, gravity") {
  Scenario s = four_particles();
  s.scene.gravity_m_per_s2 = {0, -10, 0};
  Fluid& fluid = s.scene.fluids[0];
  for (const EquationOfState state : {EquationOfState::linear, EquationOfState::tait}) {
    fluid.equation_of_state = state;
    Recording run = still(s);
    // Particle 0 is compressed to 1010 kg/m^3; the work of p against 1/rho by Simpson's rule.
    const auto pressure = [&](double rho) {
      return state == EquationOfState::linear ? 100 * (rho - 1000) : 1e5 / 7 * (std::pow(rho / 1000, 7) - 1);
    };
    double work = 0;
    constexpr int kParts = 1000;
    for (int i = 0; i <= kParts; ++i) {
      const double rho = 1000 + 10.0 * i / kParts, weight = i == 0 || i == kParts ? 1 : i % 2 == 1 ? 4 : 2;
      work += weight * pressure(rho) / (rho * rho) * (10.0 / kParts) / 3;
    }
    const auto end = run.values.back().particles;
    end[0].density_kg_per_m3 = 1010;
    end[1].v_m_per_s = {0, 0, 0};      // 2 kg lose 1 J
    end[2].p_m[1] += (1 - work) / 10;  // 1 kg takes what is not elastic
    const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run);
    CHECK(value_of(rows, "energy-budget") < 1e-12);
    end[2].p_m[1] += 0.1;  // 1 J from nowhere
    const std::vector<Row> open = measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run);
    CHECK(value_of(open, "energy-budget") == Approx(1 / (2 + (1 - work) + 1 + work)).epsilon(0.2));
  }
}

TEST_CASE("a budget that something from outside feeds is not told") {
  Scenario s = four_particles();
  s.scene.fluids[0].viscosity_m2_per_s = 0.1;
  const Recording run = still(s);
  CHECK(std::isnan(value_of(measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run), "energy-budget")));
}

TEST_CASE("heat that entered: flux times the area of the box's face, of walls that enclose it") {
  Scenario s = four_particles();
  s.scene.domain.periodic_m = {0, 2, 0};
  Fluid& fluid = s.scene.fluids[0];
  fluid.heat_capacity_J_per_kg_K = 5;
  for (const double side : {1.0, -1.0}) {
    Body& wall = s.scene.bodies.emplace_back();
    wall.shape = Plane{{side, 0, 0}, side > 0 ? 0.0 : -2.0};
    wall.fixed = true;
    s.scene.fluid_boundaries.emplace_back().body = side > 0 ? 0 : 1;
  }
  s.scene.fluid_boundaries[0].heat_flux_W_per_m2 = 30;   // 60 W, 120 J in 2 s
  s.scene.fluid_boundaries[1].heat_flux_W_per_m2 = -10;  // 20 W out
  Recording run = still(s);
  const auto error = [&] {
    std::vector<Sample> samples;
    for (const SampleView sample : run.values) samples.push_back(copy_of(sample)), samples.back().bodies.resize(2);
    run.values = samples;
    return value_of(measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run), "heat-entered-error");
  };
  for (ParticleSample& p : run.values.back().particles) p.temperature_K = Wide(80) / 30;  // 6 kg, 30 J/K
  CHECK(error() == Approx(0).margin(1e-14));
  run.values.back().particles[1].temperature_K += 1;  // 10 J
  CHECK(error() == Approx(10.0 / 160).epsilon(1e-12));
  s.scene.bodies[1].shape = Plane{{-1, 0, 0}, -2.5};  // the fluid does not fill what the walls enclose
  CHECK(std::isnan(error()));
  s.scene.bodies[1].shape = Plane{{-1, 0, 0}, -2};
  s.scene.fluid_boundaries[1].heat_flux_W_per_m2.reset();
  s.scene.fluid_boundaries[1].temperature_K = 3;
  CHECK(std::isnan(error()));
  s.scene.fluid_boundaries[1].temperature_K.reset();
  s.scene.domain.periodic_m = {};  // open above and below
  CHECK(std::isnan(error()));
}

TEST_CASE("integrals over samples: Simpson's rule is exact for cubics, of any number of intervals from 2 on") {
  for (const int intervals : {2, 3, 4, 5, 7, 40}) {
    INFO(intervals);
    std::vector<double> values;
    const double h = 2.0 / intervals;
    for (int k = 0; k <= intervals; ++k) values.push_back(1 + std::pow(h * k, 3));
    const Integral found = integral_of(values, h);
    CHECK(found.simpson == Approx(2 + 4).epsilon(1e-14));
    CHECK(found.trapezoid == Approx(6 + h * h).epsilon(1e-12));  // h^2 / 12 (f'(2) - f'(0))
  }
  CHECK(integral_of({1, 3}, 0.5).simpson == 1);
  CHECK(integral_of({}, 0.5).simpson == 0);
}

TEST_CASE(
    "integrals over samples: the bar holds the error of a power that dies out within a few samples, or within one") {
  for (const double rate : {3.0, 10.0, 30.0, 1000.0})
    for (const int intervals : {8, 9, 20}) {
      INFO(rate << ", " << intervals);
      std::vector<double> values;
      const double h = 1.0 / intervals;
      for (int k = 0; k <= intervals; ++k) values.push_back(std::exp(-rate * h * k));
      const Integral found = integral_of(values, h);
      CHECK(std::fabs(found.simpson + std::expm1(-rate) / rate) <= found.bar);
      CHECK(found.bar < 1);
    }
}

TEST_CASE("rows of work: what a term takes is accounted for") {
  Scenario s = four_particles();
  Recording run = still(s);
  Sample one = copy_of(run.values.front());
  run.values.clear();
  for (int k = 0; k < 9; ++k) {
    one.t_s = Wide(k) / 4;
    run.values.push_back(one);
  }
  const std::string plain = "sph{kernel=wendland-c2,smoothing=1.3,density_diffusion=", term = "0.1,shift=0}";
  for (const SampleReference sample : run.values) sample.particles[0].density_kg_per_m3 = 1010;
  CHECK(fluid_work_rows(s.scene, run, plain + "0,shift=0}").empty());
  CHECK(fluid_work_rows(s.scene, run, "polynomial{degree=2}").empty());
  // Every state has the same power P < 0: the work is 2 s of it. A recording that loses as much accounts for it.
  const std::vector<Row> still_rows = fluid_work_rows(s.scene, run, plain + term);
  REQUIRE(still_rows.size() == 1);  // the energy of these samples never changes
  CHECK(still_rows[0].metric == "energy-unaccounted");
  CHECK(still_rows[0].reason.find("do not resolve the motion") != std::string::npos);
  const double lost = still_rows[0].value * 3;  // of a kinetic energy of 3 J
  CHECK(lost > 0);
  ParticleSample& end = run.values.back().particles[1];  // 2 kg at 1 m/s
  end.v_m_per_s[0] = std::sqrt(1 - lost);
  const std::vector<Row> rows = fluid_work_rows(s.scene, run, plain + term);
  CHECK(value_of(rows, "work-by-diffusion") == Approx(-lost / 3).epsilon(1e-10));
  CHECK(value_of(rows, "energy-unaccounted") < 1e-12);
  // One that loses a tenth more: what is unaccounted for is in the bar of the work.
  run.values.back().particles[1].v_m_per_s[0] = std::sqrt(1 - 1.1 * lost);
  const std::vector<Row> off = fluid_work_rows(s.scene, run, plain + term);
  REQUIRE(off.size() == 2);
  CHECK(off[0].metric == "work-by-diffusion");
  CHECK(off[0].truth_bar == Approx(0.1 * lost / 3).epsilon(1e-6));
}

TEST_CASE("how particles lie") {
  const Scenario s = four_particles();
  Recording run = still(s);
  CHECK(value_of(measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run), "particle-order") ==
        Approx(0).margin(1e-15));
  run.values.back().particles[0].p_m[0] = 1.0;  // 0.5 m from particle 2; particle 1 keeps 1 m to particle 3
  const std::vector<Row> rows = measure_fluid(s, fluid_truths(s, run, kNoField, kNoTruth), run);
  CHECK(value_of(rows, "spacing-min") == Approx(0.5));
  CHECK(value_of(rows, "particle-order") == Approx(0.25 / 0.75));
  CHECK(value_of(rows, "speed-max") == Approx(1));
  CHECK(value_of(rows, "volume-error") == Approx(0).margin(1e-15));
}

TEST_CASE("neighbours: on lattices, across periods, in few cells, of one particle") {
  const auto lattice = [](int across, int layers, double shift) {
    std::vector<std::array<double, 3>> places;
    for (int i = 0; i < across; ++i)
      for (int j = 0; j < across; ++j)
        for (int k = 0; k < layers; ++k) places.push_back({i + shift, j + 0.5, layers > 1 ? k + 0.5 : 0.0});
    return places;
  };
  const Domain flat{2, {8, 8, 0}}, open{2, {0, 0, 0}}, cube{3, {6, 6, 6}};
  for (const double shift : {0.5, -0.5, 1000.25}) {  // unwrapped coordinates are the same places
    CHECK(mean_neighbours(flat, lattice(8, 1, shift), 1.1) == 4);
    CHECK(mean_neighbours(flat, lattice(8, 1, shift), 1.5) == 8);
    CHECK(mean_neighbours(flat, lattice(8, 1, shift), 2.6) == 20);
    CHECK(mean_neighbours(flat, lattice(8, 1, shift), 3.1) == 28);  // two cells along each axis: each once
    CHECK(mean_neighbours(cube, lattice(6, 6, shift), 2.6) == 80);
  }
  CHECK(mean_neighbours(open, lattice(2, 1, 0), 1.1) == 2);
  CHECK(mean_neighbours(open, {{0, 0, 0}, {1e9, 0, 0}}, 1) == 0);  // a lost particle
  CHECK(mean_neighbours(open, {}, 1) == 0);
}

TEST_CASE("neighbours: the support that a response's settings mean") {
  const auto support = [](const char* kernel, double smoothing) {
    return kernel_support_m({{"kernel", std::string(kernel)}, {"smoothing", smoothing}}, 0.5);
  };
  CHECK(support("wendland-c2", 1.3) == Approx(1.3));
  CHECK(support("quintic", 1.0) == Approx(1.5));
  CHECK(kernel_support_m({{"kernel", std::string("cubic")}, {"smoothing", 0.0}, {"degree", std::int64_t{2}}}, 1) ==
        Approx(3.0));
  CHECK(kernel_support_m({{"kernel", std::string("cubic")}, {"smoothing", 0.0}, {"degree", std::int64_t{4}}}, 1) ==
        Approx(3.1));
  CHECK(kernel_support_m({}, 1) == 0);
}

TEST_CASE("pictures: the last sample, the error of what moves, wrapped into the period") {
  Scenario s = four_particles();
  Recording run = still(s);
  run.values.back().particles[2].v_m_per_s = {3, 4, 0};
  run.values.back().particles[2].p_m[0] = 1.5 + 6;
  s.scene.domain.periodic_m = {2, 2, 0};
  std::vector<std::vector<FieldPosition>> at(3, std::vector<FieldPosition>(4));
  FieldAtParticles exact = field(1, {0, 1, 2}, at);
  const FluidPicture picture = picture_of(s, exact, run);
  CHECK(picture.particles == 4);
  CHECK(picture.t_s == 2);
  CHECK(picture.x_m == std::vector<float>{0.5, 0.5, 1.5, 1.5});
  CHECK(picture.speed_m_per_s == std::vector<float>{1, 1, 5, 1});
  CHECK(picture.error_of == "velocity [m/s]");
  REQUIRE(picture.error.size() == 4);
  CHECK(picture.error[2] == Approx(std::sqrt(4.0 + 16)));
  CHECK(picture.error[0] == 0);
  CHECK(picture.temperature_K.empty());  // no heat capacity
  CHECK(picture.high_m == std::array<double, 2>{2, 2});
  exact = field(0, {0, 1, 2}, at);  // at rest: the error of the pressure
  CHECK(picture_of(s, exact, run).error_of == "pressure [Pa]");
  CHECK(picture_of(s, exact, run).error[0] == Approx(100));
  exact.outcome.status = Status::unsupported;
  CHECK(picture_of(s, exact, run).error.empty());
  run.outcome.status = Status::diverged;
  CHECK(picture_of(s, exact, run).empty());
}

TEST_CASE("pictures: of many particles one in each square of a grid, at most so many") {
  Scenario s = four_particles();
  s.scene.domain.periodic_m = {100, 100, 0};
  s.scene.fluids[0].spacing_m = 1;
  Recording run;
  Sample sample;
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j) sample.particles.emplace_back().p_m = {Wide(i) + 0.5, Wide(j) + 0.5, 0};
  run.values.push_back(sample);
  const FluidPicture picture = picture_of(s, {}, run);
  CHECK(picture.particles == 10000);
  CHECK(picture.x_m.size() <= kMaxDrawn);
  CHECK(picture.x_m.size() > 2000);
  CHECK(picture.side_m == Approx(2).epsilon(0.1));
  // Both directions are thinned alike: as many different places along x as along y.
  const std::set<float> columns(picture.x_m.begin(), picture.x_m.end()), rows(picture.y_m.begin(), picture.y_m.end());
  CHECK(std::abs(static_cast<int>(columns.size()) - static_cast<int>(rows.size())) <= 2);
  s.scene.domain = {3, {100, 100, 0}};  // in space: the middle plane
  const std::span<ParticleSample> particles = run.values[0].particles;
  for (std::size_t i = 0; i < particles.size(); ++i) particles[i].p_m[2] = Wide(i % 5);
  CHECK(picture_of(s, {}, run).x_m.size() == 2000);
}

TEST_CASE("probes: exact for linear fields, in a corner and across a period") {
  Scene scene = four_particles().scene;
  scene.domain.periodic_m = {8, 0, 0};
  Sample sample;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      ParticleSample& p = sample.particles.emplace_back();
      p.p_m = {Wide(i + 0.5), Wide(j + 0.5 + 0.1 * std::sin(3.0 * i + j)), 0};
      p.pressure_Pa = 3 + 2 * p.p_m[1];
      p.v_m_per_s = {3, 4 * p.p_m[1], 0};
    }
  FluidProbe probe;
  probe.position_m = {0, 0, 0};
  CHECK(probe_value(scene, probe, sample) == Approx(3).epsilon(1e-12));
  probe.kind = ProbeKind::velocity;
  probe.position_m = {8, 2, 0};
  CHECK(probe_value(scene, probe, sample) == Approx(std::hypot(3, 8)).epsilon(1e-12));
  probe.kind = ProbeKind::front;
  CHECK(probe_value(scene, probe, sample) == 8);
  probe.kind = ProbeKind::column_height;
  double highest = 0;
  for (int i : {0, 7}) highest = std::max(highest, 7.5 + 0.1 * std::sin(3.0 * i + 7) + 0.5);
  probe.position_m = {0, 0, 0};
  CHECK(probe_value(scene, probe, sample) == Approx(highest));
  probe.kind = ProbeKind::pressure;
  probe.position_m = {0, 20, 0};
  CHECK(std::isnan(probe_value(scene, probe, sample)));
  CHECK_THAT(probe_gap(scene, probe), Catch::Contains(" m of [0, 20"));
}

// A floor under a fluid of 4 kg and a ball of 3 kg, g = 10 m/s^2, samples .5 s apart.
TEST_CASE("the force on a body is what changes its momentum; on the only fixed boundary, what the fluid loses") {
  Scene scene = four_particles().scene;
  scene.fluids[0].particles.mass_kg.assign(4, 1);
  scene.gravity_m_per_s2 = {0, -10, 0};
  scene.bodies.resize(2);
  scene.bodies[0].mass_kg = 3;
  scene.bodies[1].fixed = true;
  scene.fluid_boundaries.resize(2);
  scene.fluid_boundaries[0].body = 0, scene.fluid_boundaries[1].body = 1;
  std::vector<Sample> samples(2);
  samples[1].t_s = 0.5;
  for (Sample& sample : samples) sample.particles.resize(4), sample.bodies.resize(2);
  samples[1].bodies[0].v_m_per_s = {1, -2, 0};    // 3 (1 / .5) = 6 N; 3 (-2 / .5 + 10) = 18 N
  samples[1].particles[2].v_m_per_s = {3, 1, 0};  // fluid: gravity -40 N less (6, 2) N, less the ball's (6, 18) N
  FluidProbe probe;
  probe.kind = ProbeKind::force_on_body;
  probe.body = 0;
  CHECK(std::isnan(probe_values(scene, probe, samples)[0]));
  CHECK(probe_values(scene, probe, samples)[1] == Approx(std::hypot(6, 18)).epsilon(1e-12));
  probe.body = 1;
  CHECK(probe_values(scene, probe, samples)[1] == Approx(std::hypot(12, 60)).epsilon(1e-12));
  scene.forces.push_back(PointForce{0, {}, {6, 8, 0}, {}});  // then the fluid's part is (0, 10) N
  probe.body = 0;
  CHECK(probe_values(scene, probe, samples)[1] == Approx(10).epsilon(1e-12));
  scene.bodies[0].fixed = true;
  CHECK(std::isnan(probe_values(scene, probe, samples)[1]));
}

// x = 1 + t and readings of the same front .2 s later, the last of which is 30 % ahead.
TEST_CASE("the delay of a front leaves no late reading out") {
  Scenario s = four_particles();
  s.truth = {TruthKind::literature, "", ""};
  s.scene.fluids[0].particles.mass_kg = {1};
  s.scene.probes.push_back({"front", ProbeKind::front, {0, 0, 0}, -1});
  const int samples = 40;
  for (const double ahead : {1.0, 1.3}) {
    Recording run;
    FieldAtParticles readings;
    for (int k = 0; k <= samples; ++k) {
      const double t = 0.05 * k;
      Sample sample;
      sample.t_s = t;
      sample.particles.resize(1);
      sample.particles[0].p_m = {Wide(0.5 + t), 0.5, 0};  // its front is half a spacing further
      run.values.push_back(sample);
      FieldSample& reading = readings.samples.emplace_back();
      reading.t_s = t;
      reading.probes.resize(1);
      const double x = 1 + std::max(0., t - 0.2);
      if (k > 0) reading.probes[0] = {Wide(k == samples ? x * ahead : x), Wide(0)};
    }
    std::vector<Row> rows;
    metrics::append_probes(s, readings, run, rows);
    if (ahead == 1) CHECK(value_of(rows, "front-delay") == Approx(0.2).margin(0.01));
    if (ahead == 1) CHECK(value_of(rows, "front-delayed-error") < 0.004);
    else CHECK(value_of(rows, "front-delayed-error") > 0.1);
  }
}

TEST_CASE("orders along the three ladders") {
  std::vector<Row> rows;
  const auto add = [&](const char* metric, double spacing, double speed, std::int64_t steps, double value) {
    Row row;
    row.scenario = "s", row.method = "m", row.metric = metric, row.steps = steps,
    row.h_s = 1.0 / static_cast<double>(steps);
    row.spacing_m = spacing, row.sound_speed_m_per_s = speed, row.value = value;
    rows.push_back(row);
  };
  for (const double speed : {10.0, 20.0, 40.0, 80.0})
    for (int n : {8, 16, 32, 64, 128})
      for (const int finer : {1, 2}) {
        const double dx = 1.0 / n;
        add("space-error", dx, speed, finer * n,
            (finer == 1 ? 100 : 1) * dx * dx * (1 + dx));  // the finest steps count
        add("model-error", dx, speed, finer * n, 0.1 / (speed * speed) * (1 + 1 / speed));
      }
  for (int n : {10, 20, 40, 80, 160}) add("time-error", 0.125, 10, n, std::pow(n, -4) * (1 + 1.0 / n));
  std::map<std::string, int> found;
  for (const Row& row : fit_fluid_orders(rows)) {
    ++found[row.metric];
    CHECK(row.steps == 0);
    if (row.metric == "order-space") CHECK(row.value == Approx(2).margin(0.05));
    if (row.metric == "order-space") CHECK((row.sound_speed_m_per_s && !row.spacing_m));
    if (row.metric == "order-model") CHECK(row.value == Approx(2).margin(0.05));
    if (row.metric == "order-time") CHECK(row.value == Approx(4).margin(0.05));
    if (row.metric == "order-time") CHECK((row.spacing_m == 0.125 && row.sound_speed_m_per_s == 10));
  }
  CHECK(found["order-space"] == 4);
  CHECK(found["order-model"] == 5);
  CHECK(found["order-time"] == 1);
}
