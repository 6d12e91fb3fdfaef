// The catalogue's mechanisms with closed forms: each has a truth with narrow bars, whose samples satisfy the laws of
// motion.
#include <catch2/catch.hpp>

#include "joint_scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

double widest(const Truth& truth) {
  Wide bar = 0;
  for (const SampleView sample : truth.bars) {
    for (const BodySample& body : sample.bodies)
      for (int k = 0; k < 3; ++k) bar = fmaxq(bar, fmaxq(body.p_m[k], fmaxq(body.v_m_per_s[k], body.q_wxyz[k])));
    for (const JointSample& joint : sample.joints) bar = fmaxq(bar, fmaxq(joint.q[0], joint.u[0]));
  }
  return static_cast<double>(bar);
}

}  // namespace

TEST_CASE("Every mechanism of the catalogue that names a closed form has one") {
  for (const char* id : {"pendulum-1",
                         "pendulum-179deg",
                         "pendulum-turning",
                         "pendulum-a01",
                         "physical-pendulum",
                         "spherical-pendulum",
                         "conical-pendulum",
                         "heavy-top-cusp",
                         "heavy-top-loop",
                         "heavy-top-wave",
                         "heavy-top-fast",
                         "sleeping-top",
                         "sleeping-top-falls",
                         "four-bar-1",
                         "four-bar-2",
                         "four-bar-40",
                         "slider-crank",
                         "slider-on-turning-rod",
                         "hooke-shaft",
                         "welded-bodies",
                         "door-stop",
                         "flywheel",
                         "joint-oscillator",
                         "atwood-machine",
                         "atwood-machine-heavy-pulley"}) {
    const Scenario given = catalogued(id);
    const Truth truth = closed_form_truth(given, given.samples);
    INFO(id << ": " << truth.outcome.reason << " " << widest(truth));
    CHECK(truth.outcome.status == Status::ok);
    CHECK(widest(truth) > 0);
    CHECK(widest(truth) < 1e-20);
    for (const std::string& note : given.notes) {
      INFO(note);
      CHECK(note.empty());
    }
    // The scene's own doubles are the start, rounded.
    for (std::size_t i = 0; i < given.scene.bodies.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(static_cast<double>(truth.values[0].bodies[i].p_m[k]) ==
              Approx(given.scene.bodies[i].position_m[k]).margin(1e-15));
        CHECK(static_cast<double>(truth.values[0].bodies[i].v_m_per_s[k]) ==
              Approx(given.scene.bodies[i].velocity_m_per_s[k]).margin(1e-14));
        CHECK(static_cast<double>(truth.values[0].bodies[i].w_rad_per_s[k]) ==
              Approx(given.scene.bodies[i].angular_velocity_body_rad_per_s[k]).margin(1e-13));
      }
  }
}

TEST_CASE("The catalogue's mechanisms satisfy the laws of motion") {
  for (const char* id : {"physical-pendulum", "spherical-pendulum", "heavy-top-loop", "four-bar-2", "slider-crank",
                         "slider-on-turning-rod", "flywheel", "joint-oscillator", "hooke-shaft", "welded-bodies"}) {
    Scenario given = catalogued(id);
    given.t_end_s = std::fmin(given.t_end_s, 2.0);
    const Truth truth = closed_form_truth(given, 1024);
    INFO(id << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(deviations(given, truth).worst() < 1e-14);
  }
}
