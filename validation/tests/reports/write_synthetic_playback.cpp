// Writes pages of known motion for player_test.py and player_choices_test.py: write_synthetic_playback FOLDER
//
// smooth.html    a box on a circle of radius 1 m, w = 2 rad/s, that turns about z at 3 rad/s. Method `m/near` is 1e-9 t
// m
//                further in z and turned by 1e-7 t rad about its own x; `m/ends` has diverged at half the time; the
//                truth
//                ends at 3/4 of it, and from there on methods stand alone.
// bounces.html   a ball released at 0.5 s from 1 m over a floor, with one impact; no truth.
// forces.html    a cart that moves along x at 0.2 m/s with an arm on a hinge, and one of everything that is drawn: a
//                thruster (0.5 s to 1.5 s), a point force, a drive, a spring, an attractor, a contact with friction, at
//                1 s
//                an impact and the begin of slip; 64 particles whose speeds and densities differ. Method `m/two` is 0.1
//                m
//                further in y.
#include <cmath>
#include <iostream>

#include "reports/render/playback.hpp"
#include "validation/study/write_file.hpp"

namespace {

using namespace atwood;

constexpr const char* kHostile = "</script><img src=x onerror=alert(1)>";
constexpr std::int64_t kSamples = 240;

Body body_of(const std::string& name, const Shape& shape, bool fixed) {
  Body body;
  body.name = name, body.shape = shape, body.fixed = fixed;
  return body;
}

BodySample on_circle(double t, double off_z, double about_x) {
  BodySample body;
  body.p_m = {Wide(std::cos(2 * t)), Wide(std::sin(2 * t)), Wide(1) + Wide(off_z)};
  const double c = std::cos(1.5 * t), s = std::sin(1.5 * t), a = std::cos(about_x / 2), b = std::sin(about_x / 2);
  body.q_wxyz = {c * a, c * b, s * b, s * a};  // about z, then about the body's own x
  return body;
}

PlayedRun smooth_run(const std::string& name, std::int64_t samples, double off, double turn) {
  PlayedRun run;
  run.name = name, run.steps = name == "truth" ? 0 : 4 * kSamples;
  for (std::int64_t k = 0; k <= samples; ++k) {
    const double t = 4.0 * static_cast<double>(k) / kSamples;
    run.values.push_back(Sample{Wide(t), {BodySample{}, on_circle(t, off * t, turn * t)}});
    run.position_error_m.push_back(off * t), run.attitude_error_rad.push_back(turn * t),
        run.energy.push_back(-1e-8 * t);
  }
  return run;
}

Playback smooth() {
  Playback playback;
  playback.scenario.id = "smooth", playback.scenario.title = kHostile, playback.scenario.claim = kHostile;
  playback.scenario.t_end_s = 4;
  playback.scenario.scene.gravity_m_per_s2 = {0, 0, -9.81};
  playback.scenario.scene.bodies = {body_of("floor", Plane{}, true), body_of(kHostile, Box{{0.3, 0.2, 0.1}}, false)};
  playback.samples = kSamples, playback.truth = true, playback.command = "atwood play smooth";
  playback.runs = {smooth_run("truth", kSamples * 3 / 4, 0, 0), smooth_run("m/near", kSamples, 1e-9, 1e-7),
                   smooth_run("m/ends", kSamples / 2, 0.1, 0)};
  playback.runs[0].source = kHostile;
  playback.runs[0].position_bar_m.assign(playback.runs[0].values.size(), 1e-12);
  playback.runs[2].outcome = {Status::diverged, kHostile, 0, 0, {}};
  return playback;
}

Playback bounces() {
  Playback playback;
  playback.scenario.id = "bounces", playback.scenario.title = "Let go & bounce", playback.scenario.t_end_s = 2;
  playback.scenario.scene.gravity_m_per_s2 = {0, 0, -8};
  playback.scenario.scene.bodies = {body_of("floor", Plane{}, true), body_of("ball", Sphere{0.1}, false)};
  playback.scenario.scene.bodies[1].release_s = 0.5;
  playback.samples = kSamples, playback.command = "atwood play bounces";
  PlayedRun run;
  run.name = "m/one", run.steps = kSamples;
  for (std::int64_t k = 0; k <= kSamples; ++k) {
    const double t = 2.0 * static_cast<double>(k) / kSamples, free = std::max(0.0, t - 0.5), after = free - 0.5;
    BodySample ball;
    ball.p_m = {0, 0, Wide(after < 0 ? 1.1 - 4 * free * free : 0.1 + 4 * after - 4 * after * after)};
    Sample sample{Wide(t), {BodySample{}, ball}};
    if (k == kSamples) sample.contacts.push_back({0, 1, {0, 0, 0}, {0, 0, 1}, 0, 8, {0, 0, 0}});
    run.values.push_back(sample);
  }
  run.events.push_back({Wide(1), EventKind::impact, 0, 1, {0, 0, 0}, {0, 0, 1}, 8, 0, -4, 4});
  playback.runs = {run};
  return playback;
}

Scene scene_of_forces() {
  Scene scene;
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies = {body_of("cart", Box{{0.3, 0.2, 0.1}}, false), body_of("arm", Box{{0.05, 0.05, 0.3}}, false)};
  Joint hinge;
  hinge.name = "hinge", hinge.parent = 0, hinge.child = 1;
  hinge.anchors_body_m = {{{0, 0, 0.1}, {0, 0, -0.3}}}, hinge.axis_body = {0, 1, 0};
  scene.joints = {hinge};
  Spring spring;
  spring.bodies = {0}, spring.anchor_m = {-1, 0, 0.1};
  scene.forces = {Thruster{0, {-0.3, 0, 0}, {1, 0, 0}, 5, {{0.5, 1.5}}}, PointForce{0, {0, 0.2, 0}, {0, 0, 4}, {}},
                  Drive{{1}, {3, 0, 0}, 0.5, 0}, spring, Attractor{{0}, {1, 0, 1}, 1}};
  return scene;
}

PlayedRun run_of_forces(const std::string& name, double off_y) {
  PlayedRun run;
  run.name = name, run.steps = kSamples;
  for (std::int64_t k = 0; k <= kSamples; ++k) {
    const double t = 2.0 * static_cast<double>(k) / kSamples;
    BodySample cart, arm;
    cart.p_m = {Wide(0.2 * t), Wide(off_y), Wide(0.1)}, arm.p_m = {Wide(0.2 * t), Wide(off_y), Wide(0.5)};
    Sample sample{Wide(t), {cart, arm}};
    sample.contacts.push_back({0, 1, {0.2 * t, off_y, 0}, {0, 0, 1}, 0, 8, {-3, 0, 0}});
    for (int i = 0; i < 64; ++i) {
      ParticleSample particle;
      particle.p_m = {Wide(0.1 * (i % 8)), Wide(0.6 + off_y), Wide(0.1 * (i / 8))};
      particle.v_m_per_s = {Wide(0.1 * (i % 8)), Wide(0), Wide(0)};
      particle.density_kg_per_m3 = Wide(1000 + i / 8);
      sample.particles.push_back(particle);
    }
    run.values.push_back(sample), run.energy.push_back(1e-6 * t);
  }
  run.events.push_back({Wide(1), EventKind::impact, 0, 1, {0.2, Wide(off_y), 0}, {0, 0, 1}, 8, 0, -4, 4});
  run.events.push_back({Wide(1), EventKind::slip, 0, 1, {0.3, Wide(off_y), 0}, {0, 0, 1}, 0, 0, 0, 0});
  return run;
}

Playback forces() {
  Playback playback;
  playback.scenario.id = "forces", playback.scenario.title = "One of everything", playback.scenario.t_end_s = 2;
  playback.scenario.claim = "everything is drawn", playback.scenario.scene = scene_of_forces();
  playback.samples = kSamples, playback.command = "atwood play forces";
  playback.runs = {run_of_forces("m/one", 0), run_of_forces("m/two", 0.1)};
  return playback;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_synthetic_playback FOLDER\n";
    return 2;
  }
  for (const Playback& playback : {smooth(), bounces(), forces()}) {
    const PlaybackPage page = render_playback(playback);
    write_file(std::string(argv[1]) + "/" + playback.scenario.id + ".html", page.html);
    std::cout << playback.scenario.id << ": " << page.html.size() << " bytes, " << page.frames << " frames\n";
  }
}
