// Symmetric projection of Gauss's methods on loops and ropes: reversal, order, energy over long times.
#include <catch2/catch.hpp>

#include "scene/files.hpp"
#include "step_checks.hpp"

namespace atwood::testing {
namespace {

Scene catalogue_scene(const std::string& id) { return read_scenario(ATWOOD_SCENARIO_DIR "/" + id + ".toml").scene; }

TEST_CASE("Gauss's methods reverse on loops and ropes, with the ordinary projection they do not") {
  for (const char* id : {"slider-crank-free", "bricard", "swinging-atwood-machine", "atwood-machine-heavy-pulley"})
    for (const char* scheme : {"implicit-midpoint", "gauss4"}) {
      INFO(id << ", " << scheme);
      CHECK(back_and_forth(scheme, catalogue_scene(id), 0.01, 60) < 1e-11);
    }
  const Settings standard{{"projection", std::string("standard")}};
  CHECK(back_and_forth("implicit-midpoint", catalogue_scene("slider-crank-free"), 0.01, 60, standard) > 1e-8);
}

TEST_CASE("the trapezoid reverses on loops of hinges and sliders with the symmetric projection alone") {
  const Settings symmetric{{"projection", std::string("symmetric")}};
  for (const char* id : {"slider-crank-free", "bricard", "four-bar-crank"}) {
    INFO(id);
    CHECK(back_and_forth("trapezoid", catalogue_scene(id), 0.01, 60, symmetric) < 1e-11);
  }
  CHECK(back_and_forth("trapezoid", catalogue_scene("slider-crank-free"), 0.01, 60) > 1e-8);
  const Scene scene = catalogue_scene("slider-crank-free");
  const Recorded fine = run("dop853", scene, {0.5, 2048, 1}, "long-double");
  const auto error = [&](std::int64_t steps) {
    const MethodId id = parse_method_id("atwood/trapezoid@long-double{projection=symmetric}");
    return end_error(try_run(id, scene, {0.5, steps, 1}), fine);
  };
  CHECK(std::log2(error(32) / error(64)) == Approx(2.0).margin(0.15));
  const Recorded turned = try_run(parse_method_id("atwood/trapezoid{projection=symmetric}"),
                                  catalogue_scene("swinging-atwood-machine"), {0.1, 10, 1});
  CHECK(turned.outcome.status == Status::unsupported);
  CHECK(turned.outcome.reason.find("states without quaternions") != std::string::npos);
}

TEST_CASE("symmetric projection keeps the order of Gauss's methods, and closes loops to round-off") {
  const Scene scene = catalogue_scene("slider-crank-free");
  const Recorded fine = run("dop853", scene, {0.5, 2048, 1}, "long-double");
  for (const auto& [scheme, order] : {std::pair{"implicit-midpoint", 2.0}, {"gauss4", 4.0}, {"gauss6", 6.0}}) {
    INFO(scheme);
    const auto error = [&](std::int64_t steps) {
      return end_error(run(scheme, scene, {0.5, steps, 1}, "long-double"), fine);
    };
    CHECK(std::log2(error(32) / error(64)) == Approx(order).margin(0.15));
  }
  const Recorded coarse = run("gauss4", scene, {0.5, 16, 16});
  const SolveTally& tally = coarse.outcome.solvers.at("invariant-projection");
  CHECK(tally.solves() == 16);
  CHECK(tally.capped == 0);
}

double energy(const Scene& scene, const Sample& sample) {
  double total = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    for (int k = 0; k < 3; ++k) {
      const double v = static_cast<double>(sample.bodies[i].v_m_per_s[k]);
      const double w = static_cast<double>(sample.bodies[i].w_rad_per_s[k]);
      total += body.mass_kg * v * v / 2 + body.inertia_kg_m2[4 * k] * w * w / 2;
      total -= body.mass_kg * scene.gravity_m_per_s2[k] * static_cast<double>(sample.bodies[i].p_m[k]);
    }
  }
  return total;
}

// Energy's mean over the last tenth of 100 s less that over the first, of a mechanism that oscillates with some 15 J.
TEST_CASE("the symmetric projection has no drift of the energy, the ordinary one has") {
  const Scene scene = catalogue_scene("slider-crank-free");
  const auto drift = [&](const std::string& method) {
    const Recorded r = run(parse_method_id(method), scene, {100, 4000, 4000});
    double first = 0, last = 0;
    for (int n = 0; n < 400; ++n) {
      first += energy(scene, r.samples[n]) / 400;
      last += energy(scene, r.samples[3600 + n]) / 400;
    }
    return std::fabs(last - first);
  };
  CHECK(drift("atwood/implicit-midpoint") < 2e-3);
  CHECK(drift("atwood/implicit-midpoint{projection=standard}") > 0.08);
}

TEST_CASE("both at once, compensated sums and the symmetric projection, are refused") {
  const Recorded r =
      try_run(parse_method_id("atwood/gauss4{compensated=true}"), catalogue_scene("slider-crank-free"), {0.1, 10, 1});
  CHECK(r.outcome.status == Status::unsupported);
  CHECK(r.outcome.reason.find("symmetric projection") != std::string::npos);
}

}  // namespace
}  // namespace atwood::testing
