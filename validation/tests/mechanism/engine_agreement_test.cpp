// The engine's mechanisms against the reference's, which share no code with them, at random states in quad: forward
// dynamics (accelerations of all coordinates), and from the accelerations back to the joints' wrenches.
#include <catch2/catch.hpp>

#include "mechanism/reduced.hpp"
#include "mechanism/start.hpp"
#include "mechanism_loops.hpp"
#include "rigid/model.hpp"
#include "scene/mechanism.hpp"

using namespace atwood;

namespace {

struct Apart {
  double acceleration = 0, reaction = 0, applied = 0, place = 0;
  int rates = 0, closings = 0;
};

double distance(Wide a, Wide b) { return std::fabs(static_cast<double>(a - b)); }
double size(Wide a) { return std::fabs(static_cast<double>(a)); }

// Relative to the largest of its kind.
Apart compare(const Scene& scene) {
  Apart made;
  RigidModel<Wide> engine(scene);
  INFO(engine.unsupported());
  REQUIRE(engine.unsupported().empty());
  engine.select_interval(Wide(0), Wide(0));
  std::vector<Wide> y(engine.state_size()), dydt(engine.state_size());
  engine.initial_state(y.data());
  engine.system().rate(Wide(0), y.data(), dydt.data());
  Sample ours;
  engine.write(Wide(0), y.data(), ours);

  const Sample start = mechanism::start_sample(scene);
  mechanism::Reduced<Wide> reference(scene, 1, start);
  std::vector<Wide> z = reference.initial(start);
  reference.choose(0, z.data());
  std::vector<Wide> dzdt(z.size());
  reference.rate(0, z.data(), dzdt.data());
  const Sample theirs = reference.sample(0, z.data());

  double scale = 0, load = 0;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const JointSample &a = ours.joints[j], &b = theirs.joints[j];
    for (int k = 0; k < 3; ++k) load = std::max({load, size(b.force_N[k]), size(b.torque_N_m[k]), size(b.applied[k])});
    if (scene.joints[j].closes_loop) ++made.closings;
    for (int k = 0; k < 4; ++k) made.place = std::max(made.place, distance(a.q[k], b.q[k]));
    for (int k = 0; k < 3; ++k) made.place = std::max(made.place, distance(a.u[k], b.u[k]));
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const JointSample &a = ours.joints[j], &b = theirs.joints[j];
    for (int k = 0; k < 3; ++k) {
      made.reaction = std::max({made.reaction, distance(a.force_N[k], b.force_N[k]) / load,
                                distance(a.torque_N_m[k], b.torque_N_m[k]) / load});
      made.applied = std::max(made.applied, distance(a.applied[k], b.applied[k]) / load);
    }
    if (scene.joints[j].closes_loop) continue;
    const Link<Wide>& link = engine.tree()->links()[engine.tree()->link_of_joint(static_cast<int>(j))];
    const int slot = rate_count(scene.joints[j].kind) > 0 ? reference.rate_slot(static_cast<int>(j)) : 0;
    for (int k = 0; k < link.rates; ++k, ++made.rates) {
      scale = std::max(scale, size(dzdt[slot + k]));
      made.acceleration = std::max(made.acceleration, distance(dydt[link.at_u + k], dzdt[slot + k]));
    }
  }
  if (scale > 1e-20) made.acceleration /= scale;  // else nothing can move
  return made;
}

}  // namespace

TEST_CASE("engine and reference agree on random mechanisms of all kinds of joints, in quad") {
  int kinds[6] = {}, rates = 0;
  for (int seed = 100; seed < 160; ++seed) {
    const Scene scene = random_tree(seed, 1 + seed % 9);
    INFO("seed " << seed);
    for (const Joint& joint : scene.joints) ++kinds[static_cast<int>(joint.kind)];
    const Apart found = compare(scene);
    CHECK(found.place < 1e-30);
    CHECK(found.acceleration < 1e-29);
    CHECK(found.reaction < 1e-29);
    CHECK(found.applied < 1e-30);
    rates += found.rates;
  }
  for (const int count : kinds) CHECK(count > 10);
  CHECK(rates > 200);
}

TEST_CASE("engine and reference agree on loops closed by joints of all kinds, with forces along them, in quad") {
  int loops[6] = {};
  for (int seed = 200; seed < 320; ++seed) {
    const JointKind kind = kAllKinds[seed % 6];
    Scene scene = random_tree(seed, 6);
    Draw draw(static_cast<std::uint64_t>(seed));
    if (!close_a_loop(scene, draw, kind)) continue;
    try {
      (void)mechanism_start(scene);
    } catch (const MechanismError&) {  // fewer rates around the loop than the joint takes: redundant, up to rounding
      continue;
    }
    INFO("seed " << seed);
    const Apart found = compare(scene);
    loops[static_cast<int>(kind)] += found.closings;
    CHECK(found.acceleration < 1e-24);  // rates off the loop by rounding: each side has its own start
    CHECK(found.reaction < 1e-24);
    CHECK(found.applied < 1e-24);
  }
  for (const int count : loops) CHECK(count > 2);
}
