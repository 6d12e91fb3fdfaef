// Runs of +sph: what is conserved, orders in time, reversal, refusals.
#include <catch2/catch.hpp>

#include "fluid/law.hpp"
#include "fluid/options.hpp"
#include "fluid/run.hpp"
#include "integrators/catalogue.hpp"
#include "scenes.hpp"
#include "validation/tests/recorded.hpp"

using namespace atwood;
using namespace atwood::fluid;
using testing::record;
using testing::Recorded;
using testing::require_whole;

namespace {

Recorded try_run(const std::string& id, const Scene& scene, double t_end_s, std::int64_t steps,
                 std::int64_t samples = 1) {
  return record(run_fluid, parse_method_id("atwood/" + id), scene, {t_end_s, steps, samples});
}
std::vector<Sample> run(const std::string& id, const Scene& scene, double t_end_s, std::int64_t steps,
                        std::int64_t samples = 1) {
  const Recorded made = try_run(id, scene, t_end_s, steps, samples);
  require_whole(made, id, {t_end_s, steps, samples});
  return made.samples;
}

struct Momenta {
  double linear = 0, angular = 0;  // of the change, over the sum of sizes
};
// Two dimensions, equal masses.
Momenta change_of_momenta(const Sample& from, const Sample& to) {
  Wide p[2]{}, L = 0, size_p = 0, size_L = 0;
  for (std::size_t i = 0; i < from.particles.size(); ++i) {
    const ParticleSample &a = from.particles[i], &b = to.particles[i];
    for (int c = 0; c < 2; ++c) {
      p[c] += b.v_m_per_s[c] - a.v_m_per_s[c];
      size_p += real::abs(b.v_m_per_s[c]);
    }
    const Wide before = a.p_m[0] * a.v_m_per_s[1] - a.p_m[1] * a.v_m_per_s[0];
    const Wide after = b.p_m[0] * b.v_m_per_s[1] - b.p_m[1] * b.v_m_per_s[0];
    L += after - before;
    size_L += real::abs(after);
  }
  return {static_cast<double>(real::sqrt(p[0] * p[0] + p[1] * p[1]) / size_p),
          static_cast<double>(real::abs(L) / size_L)};
}

// Kinetic, elastic and thermal energy [J] of one fluid.
Wide energy(const Scene& scene, const Sample& sample) {
  const Fluid& fluid = scene.fluids[0];
  const auto law = make_law<Quad>(fluid);
  Wide sum = 0;
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const ParticleSample& one = sample.particles[i];
    Wide v2 = 0;
    for (const Wide v : one.v_m_per_s) v2 += v * v;
    sum += Wide(fluid.particles.mass_kg[i]) *
           (v2 / 2 + law.elastic_energy(one.density_kg_per_m3) + law.heat_capacity * (one.temperature_K - 300));
  }
  return sum;
}

Scene drifting_block(int across) {
  Scene scene = block_scene({.across = across, .spacing_m = 1.0 / across, .periodic = false});
  for (Real3& v : scene.fluids[0].particles.velocity_m_per_s) v[0] += 2;
  return scene;
}

double largest_difference(const Sample& a, const Sample& b) {
  Wide worst = 0;
  for (std::size_t i = 0; i < a.particles.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      worst = real::max(worst, real::abs(a.particles[i].p_m[c] - b.particles[i].p_m[c]));
      worst = real::max(worst, real::abs(a.particles[i].v_m_per_s[c] - b.particles[i].v_m_per_s[c]));
    }
  return static_cast<double>(worst);
}
bool same_motion(const Sample& a, const Sample& b) { return largest_difference(a, b) == 0; }

// The scene as it is in a sample, its velocities turned round.
Scene turned_round(Scene scene, const Sample& sample) {
  Particles& particles = scene.fluids[0].particles;
  for (std::size_t i = 0; i < sample.particles.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      particles.position_m[i][c] = static_cast<double>(sample.particles[i].p_m[c]);
      particles.velocity_m_per_s[i][c] = -static_cast<double>(sample.particles[i].v_m_per_s[c]);
    }
  return scene;
}

double order_of(const std::string& id, const Scene& scene, double t_end_s, std::int64_t steps) {
  const Sample middle = run(id, scene, t_end_s, 2 * steps).back();
  const double coarse = largest_difference(run(id, scene, t_end_s, steps).back(), middle);
  const double fine = largest_difference(middle, run(id, scene, t_end_s, 4 * steps).back());
  return std::log2(coarse / fine);
}

}  // namespace

TEST_CASE("linear momentum is kept to round-off by explicit methods") {
  const Scene scene = drifting_block(24);
  for (const char* method : {"rk4+sph", "dopri5+sph{viscosity=central}"}) {
    const auto samples = run(method, scene, 1, 1000);
    CHECK(change_of_momenta(samples.front(), samples.back()).linear < 3e-16);
  }
}

TEST_CASE("angular momentum is kept to round-off by leapfrog with summed densities; Morris's viscosity loses it") {
  Scene scene = drifting_block(24);
  const auto viscous = run("rk4+sph", scene, 0.5, 200);
  CHECK(change_of_momenta(viscous.front(), viscous.back()).angular > 1e-6);
  scene.fluids[0].viscosity_m2_per_s = 0;
  const auto samples = run("leapfrog+sph{density=summation}", scene, 1, 1000);
  const Momenta change = change_of_momenta(samples.front(), samples.back());
  CHECK(change.linear < 3e-16);
  CHECK(change.angular < 3e-16);
}

TEST_CASE("the budget of energy closes to the error of time") {
  for (const char* settings : {"viscosity=central", "viscosity=morris", "density=summation"}) {
    Scene scene = block_scene();
    heat(scene.fluids[0]);
    scene.fluids[0].equation_of_state = EquationOfState::tait;
    const std::string id = "rk4+sph{kernel=wendland-c4,shift=0," + std::string(settings) + "}";
    double change[2];
    for (const int n : {0, 1}) {
      const auto samples = run(id, scene, 0.25, n == 0 ? 50 : 100);
      const Wide start = energy(scene, samples.front());
      change[n] = static_cast<double>(real::abs((energy(scene, samples.back()) - start) / start));
    }
    INFO(settings << ": " << change[0] << " " << change[1]);
    CHECK(change[0] < 5e-5);
    CHECK(change[1] < change[0] / 12);
  }
}

TEST_CASE("orders in time") {
  const Scene scene = block_scene({.disturbance = 0.1});
  CHECK(order_of("rk4+sph{smoothing=1.6}", scene, 0.1, 128) == Approx(4).margin(0.02));
  Scene ideal = scene;
  ideal.fluids[0].viscosity_m2_per_s = 0;
  CHECK(order_of("leapfrog+sph{density=summation}", ideal, 0.1, 64) == Approx(2).margin(0.05));
  CHECK(order_of("yoshida4+sph{density=summation}", ideal, 0.1, 64) == Approx(4).margin(0.2));
}

// Order of the geometric mean over 16 seeds of the largest error, between steps n and 2 n, against 16 n steps.
double mean_order(const std::string& id, const std::string& finest, BlockOptions block, double t_end_s,
                  std::int64_t steps) {
  double sum = 0;
  for (block.seed = 1; block.seed <= 16; ++block.seed) {
    const Scene scene = block_scene(block);
    const Sample exact = run(finest, scene, t_end_s, 16 * steps).back();
    const double coarse = largest_difference(run(id, scene, t_end_s, steps).back(), exact);
    const double fine = largest_difference(run(id, scene, t_end_s, 2 * steps).back(), exact);
    sum += std::log2(coarse / fine);
  }
  return sum / 16;
}

TEST_CASE("the kernel's smoothness bounds the order in time: a method of order 8, the mean of 16 seeds") {
  const auto order = [](const std::string& kernel) {
    const std::string id = "dop853+sph{kernel=" + kernel + "}";
    return mean_order(id, id, {.across = 6, .spacing_m = 1.0 / 6}, 0.05, 24);
  };
  const double cubic = order("cubic");
  CHECK(cubic < 3.3);
  CHECK(cubic > 2.7);
  CHECK(order("wendland-c2") == Approx(4).margin(0.3));
  // Its errors are below round-off in doubles, and its support of three smoothing lengths fits half the period.
  const std::string quintic = "dop853+sph@long-double{kernel=quintic,smoothing=0.8}";
  CHECK(mean_order(quintic, quintic, {.across = 6, .spacing_m = 1.0 / 6}, 0.05, 24) == Approx(5).margin(0.4));
}

TEST_CASE("a scheme claims an order for fluids exactly if it steps one") {
  Scene scene = block_scene({.across = 6, .spacing_m = 1.0 / 6});
  scene.fluids[0].viscosity_m2_per_s = 0;
  for (const MethodInfo& info : integrator_catalogue()) {
    INFO(info.id);
    const std::string scheme = info.id.substr(info.id.find('/') + 1);
    const Recorded made = try_run(scheme + "+sph{density=summation,viscosity=none}", scene, 0.001, 4);
    CHECK((made.outcome.status != Status::unsupported) == claimed_order(info).has_value());
  }
}

TEST_CASE("a tolerance, and what steps by multistep, extrapolation and implicit methods, end in the same state") {
  const Scene scene = block_scene({.across = 6});
  const Sample exact = run("rk4+sph", scene, 0.1, 2000).back();
  for (const char* id : {"dopri5:1e-9+sph", "gbs:1e-9+sph", "adams-bashforth4+sph", "gauss4+sph"}) {
    INFO(id);
    const Recorded made = try_run(id, scene, 0.1, 100);
    INFO(made.outcome.reason);
    REQUIRE(made.outcome.status == Status::ok);
    CHECK(largest_difference(made.samples.back(), exact) < 1e-5);
  }
}

TEST_CASE("leapfrog returns: to round-off in doubles, to the same bits on the lattice") {
  Scene scene = block_scene({.across = 12});
  scene.fluids[0].viscosity_m2_per_s = 0;
  const auto there = run("leapfrog+sph{density=summation}", scene, 0.4, 400).back();
  const auto back = run("leapfrog+sph{density=summation}", turned_round(scene, there), 0.4, 400).back();
  const Sample start = run("leapfrog+sph{density=summation}", scene, 0.4, 400).front();
  Sample turned = back;
  for (ParticleSample& one : turned.particles)
    for (Wide& v : one.v_m_per_s) v = -v;
  const double moved = largest_difference(turned, start);
  CHECK(moved > 0);
  CHECK(moved < 1e-12);
  for (const char* method : {"leapfrog", "velocity-verlet", "yoshida4"}) {
    const std::string id = std::string(method) + "+sph{density=summation,reversible=true}";
    const auto forth = run(id, scene, 0.4, 400);
    Sample returned = run(id, turned_round(scene, forth.back()), 0.4, 400).back();
    for (ParticleSample& one : returned.particles)
      for (Wide& v : one.v_m_per_s) v = -v;
    CHECK(same_motion(returned, forth.front()));
    CHECK_FALSE(same_motion(forth.back(), forth.front()));
  }
}

TEST_CASE("what cannot be kept is refused by name") {
  const Scene scene = block_scene();
  const auto reason = [](const std::string& id, const Scene& of, double t_end_s = 0.1, std::int64_t steps = 100) {
    const Recorded made = try_run(id, of, t_end_s, steps);
    CHECK(made.outcome.status == Status::unsupported);
    return made.outcome.reason;
  };
  CHECK_THAT(reason("leapfrog+sph", scene), Catch::Contains("density=summation"));
  CHECK_THAT(reason("leapfrog+sph{density=summation}", scene), Catch::Contains("viscosity=none"));
  CHECK_THAT(reason("rk4+sph{reversible=true}", scene), Catch::Contains("kick-drift"));
  CHECK_THAT(reason("symplectic-euler+sph{density=summation,viscosity=none,reversible=true}", scene),
             Catch::Contains("not symmetric"));
  CHECK_THAT(reason("rk4", scene), Catch::Contains("+sph"));
  CHECK_THAT(reason("taylor+sph", scene), Catch::Contains("taylor"));
  CHECK_THAT(reason("rk4+sph{smoothing=2.1}", scene), Catch::Contains("period of 1 m"));
  Scene still = scene;
  still.fluids[0].sound_speed_m_per_s = 0;
  CHECK_THAT(reason("rk4+sph", still), Catch::Contains("sound speed"));
}

TEST_CASE("a scene whose kernel leaves the range of float is refused in float alone") {
  // Times and viscosity in proportion to lengths, at equal speeds. Just within the range a run ends as in double.
  const auto scaled = [](int dimensions, double spacing) {
    Scene scene = block_scene({.dimensions = dimensions, .spacing_m = spacing, .disturbance = 0.1});
    scene.fluids[0].viscosity_m2_per_s = 0.08 * spacing;
    return scene;
  };
  struct Case {
    int dimensions;
    double inside, outside;
  };
  for (const Case& one : {Case{2, 2e-8, 5e-9}, Case{2, 1e7, 5e7}, Case{3, 1e-6, 1e-7}, Case{3, 2e5, 2e6}})
    for (const std::string response : {"+sph", "+polynomial@{degree=2}"}) {
      const auto id = [&](const std::string& scalar) {
        const std::size_t at = response.find('@');
        return at == std::string::npos ? "rk4+sph" + scalar : "rk4+polynomial" + scalar + "{degree=2}";
      };
      INFO(id("@float") << " in " << one.dimensions << " dimensions");
      const Recorded refused = try_run(id("@float"), scaled(one.dimensions, one.outside), 0.4 * one.outside, 20);
      CHECK(refused.outcome.status == Status::unsupported);
      CHECK_THAT(refused.outcome.reason,
                 Catch::Contains("leaves the range of @float: 1 / support^" + std::to_string(one.dimensions + 2)));
      const Scene scene = scaled(one.dimensions, one.inside);
      const Recorded rough = try_run(id("@float"), scene, 0.4 * one.inside, 20),
                     fine = try_run(id(""), scene, 0.4 * one.inside, 20);
      REQUIRE(rough.outcome.status == Status::ok);
      REQUIRE(fine.outcome.status == Status::ok);
      const auto& exact = fine.samples.back().particles;
      for (std::size_t i = 0; i < exact.size(); ++i)
        for (int c = 0; c < 3; ++c)
          CHECK(static_cast<double>(rough.samples.back().particles[i].v_m_per_s[c]) ==
                Approx(static_cast<double>(exact[i].v_m_per_s[c])).margin(1e-3));
    }
}

TEST_CASE("equal steps beyond the limit are refused with it, and a step below it is stable") {
  Scene scene = block_scene();
  scene.fluids[0].viscosity_m2_per_s = 0;
  // Sound: explicit Euler and Heun have no interval on the imaginary axis.
  for (const char* scheme : {"rk4", "explicit-euler", "heun", "dopri5"}) {
    const Recorded coarse = try_run(std::string(scheme) + "+sph", scene, 1, 20);
    INFO(scheme << coarse.outcome.reason);
    CHECK(coarse.outcome.status == Status::unsupported);
    CHECK_THAT(coarse.outcome.reason, Catch::Contains("stability limit"));
  }
  CHECK(try_run("heun+sph{shift=0}", scene, 1, 200).outcome.status == Status::unsupported);
  CHECK(try_run("rk4+sph", scene, 1, 200).outcome.status == Status::ok);
  scene.fluids[0].viscosity_m2_per_s = 3;
  const Recorded viscous = try_run("rk4+sph", scene, 1, 200);
  CHECK(viscous.outcome.status == Status::unsupported);
  CHECK_THAT(viscous.outcome.reason, Catch::Contains("by viscosity"));
  CHECK_THAT(viscous.outcome.reason, Catch::Contains("(of all effects together; each alone: by sound 0."));
}

TEST_CASE("a run that goes wrong says which particle, where and when") {
  Scene scene = block_scene({.periodic = false});
  scene.fluids[0].particles.velocity_m_per_s[5] = {-1e308, 0, 0};
  const Recorded made = try_run("rk4+sph", scene, 1e-2, 100);
  CHECK(made.outcome.status == Status::not_finite);
  CHECK_THAT(made.outcome.reason, Catch::Contains("of `water`") && Catch::Contains("at t = "));
}
