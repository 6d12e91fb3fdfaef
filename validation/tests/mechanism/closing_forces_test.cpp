// Springs, dampers and motors along joints that close loops: the motion does not depend on which joint of a loop closes
// it, and is that of IDA and of the extended truth.
#include <catch2/catch.hpp>
#include <cmath>

#include "dynamics/invariants.hpp"
#include "extended/mechanism_truth.hpp"
#include "ida/ida.hpp"
#include "mechanism_loops.hpp"
#include "rigid/model.hpp"
#include "runs.hpp"
#include "scenes.hpp"
#include "simulation.hpp"

using namespace atwood;

namespace {

double distance(Wide a, Wide b) { return std::fabs(static_cast<double>(a - b)); }

// Largest differences over all samples and joints: coordinates and rates; forces along joints, and reactions.
struct Apart {
  double motion = 0, load = 0;
};
Apart apart(const SampleSeries& a, const SampleSeries& b) {
  Apart made;
  REQUIRE(a.size() == b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    const SampleView one = a[k], other = b[k];
    for (std::size_t j = 0; j < one.joints.size(); ++j) {
      const JointSample &x = one.joints[j], &y = other.joints[j];
      for (int c = 0; c < 4; ++c) made.motion = std::max(made.motion, distance(x.q[c], y.q[c]));
      for (int c = 0; c < 3; ++c) made.motion = std::max(made.motion, distance(x.u[c], y.u[c]));
      for (int c = 0; c < 3; ++c) {
        made.load = std::max(made.load, distance(x.applied[c], y.applied[c]));
        if (!(((x.not_unique | y.not_unique) >> c) & 1u))
          made.load = std::max(made.load, distance(x.force_N[c], y.force_N[c]));
        if (!(((x.not_unique | y.not_unique) >> (c + 3)) & 1u))
          made.load = std::max(made.load, distance(x.torque_N_m[c], y.torque_N_m[c]));
      }
    }
  }
  return made;
}

// A four-bar whose joint 3 closes it, between coupler and rocker, with a spring, a damper and two motors there.
Scenario planar(double t_end_s) {
  Scenario made = four_bar(t_end_s, 0);
  made.scene = settled(made.scene);
  made.scene.joint_forces = {JointSpring{3, 0, 30, 0.8, 0.6}, JointTorque{3, 0, -2.5, 0, 0, {}},
                             JointTorque{3, 0, 3, 4, 0.3, {{0.25, 0.5}}}};
  return made;
}

// A tree in space whose last body a joint of the kind ties to the first; both move.
std::optional<Scenario> in_space(std::uint64_t seed, JointKind kind, double t_end_s) {
  Scenario made;
  made.t_end_s = t_end_s;
  made.scene = random_tree(seed, 6);
  Draw draw(seed);
  if (!close_a_loop(made.scene, draw, kind)) return {};
  try {
    made.scene = settled(made.scene);
  } catch (const MechanismError&) {  // redundant, up to rounding
    return {};
  }
  double fastest = 0;
  for (const double rate : made.scene.joints.back().rates) fastest = std::max(fastest, std::fabs(rate));
  if (fastest < 0.1) return {};
  return made;
}

// The joint that places the child of the last joint, which closes a loop.
int placing_joint(const Scene& scene) {
  return placing_joints(scene)[static_cast<std::size_t>(scene.joints.back().child)];
}

}  // namespace

TEST_CASE("a four-bar with forces along one hinge moves alike, whether that hinge closes it or another one does") {
  const Scenario closing = planar(1);
  Scenario in_tree = closing;
  in_tree.scene = exchanged(closing.scene, 3, 2);
  REQUIRE(in_tree.scene.joints[2].closes_loop);
  for (const auto& [method, steps, motion, load] :
       {std::tuple{"atwood/dop853", 1600, 1e-12, 1e-10}, std::tuple{"atwood/dopri5:1e-12", 1600, 1e-10, 1e-8},
        std::tuple{"atwood/gauss8", 400, 1e-12, 1e-10}, std::tuple{"atwood/gbs", 400, 1e-12, 1e-10},
        std::tuple{"atwood/radau15", 400, 1e-12, 1e-10}, std::tuple{"atwood/adams-bashforth4", 6400, 1e-7, 1e-5},
        std::tuple{"atwood/bdf4", 6400, 1e-6, 1e-4}, std::tuple{"atwood/dop853@long-double", 800, 1e-12, 1e-10},
        std::tuple{"atwood/rk4@float", 400, 1e-3, 1e-1}}) {
    const Recorded one = run(atwood_engine(), method, closing, steps, 8);
    const Recorded other = run(atwood_engine(), method, in_tree, steps, 8);
    const Apart found = apart(one.samples, other.samples);
    INFO(method);
    CHECK(found.motion < motion);
    CHECK(found.load < load);
  }
  Scenario without = closing;
  without.scene.joint_forces.clear();
  const Recorded one = run(atwood_engine(), "atwood/dop853", closing, 1600, 8);
  CHECK(apart(one.samples, run(atwood_engine(), "atwood/dop853", without, 1600, 8).samples).motion > 1);
}

TEST_CASE("loops in space with forces along the closing joint: another one may close them") {
  int compared[6] = {};
  for (const JointKind kind :
       {JointKind::ball, JointKind::hinge, JointKind::slider, JointKind::cylindrical, JointKind::universal}) {
    for (std::uint64_t seed = 300; seed < 340 && compared[static_cast<int>(kind)] < 2; ++seed) {
      const auto closing = in_space(seed, kind, 0.25);
      if (!closing) continue;
      Scenario in_tree = *closing;
      const int last = static_cast<int>(closing->scene.joints.size()) - 1;
      in_tree.scene = exchanged(closing->scene, last, placing_joint(closing->scene));
      const Recorded one = run(atwood_engine(), "atwood/dop853", *closing, 1600, 4);
      const Recorded other = run(atwood_engine(), "atwood/dop853", in_tree, 1600, 4);
      INFO("seed " << seed << ", kind " << static_cast<int>(kind));
      const Apart found = apart(one.samples, other.samples);
      CHECK(found.motion < 1e-10);
      CHECK(found.load < 1e-8);
      ++compared[static_cast<int>(kind)];
    }
    CHECK(compared[static_cast<int>(kind)] > 0);
  }
}

// The crank turns about the coupler; a weak spring of their hinge winds up and slows it down.
TEST_CASE("the spring of a closing hinge counts whole turns") {
  Scenario closing = four_bar(2.5, 2);
  closing.scene.joints[0].rates[0] = 12;
  closing.scene.joints[3].hold = {0};
  closing.scene = settled(closing.scene);
  closing.scene.joint_forces = {JointSpring{3, 0, 0.02, 0, 0}};
  Scenario in_tree = closing;
  in_tree.scene = exchanged(closing.scene, 3, 2);
  for (const auto& [method, steps, samples, bound] :
       {std::tuple{"atwood/dop853", 4000, 50, 1e-9}, std::tuple{"atwood/dop853", 4000, 1, 1e-9},
        std::tuple{"atwood/dopri5:1e-11", 4000, 1, 1e-7}, std::tuple{"atwood/gauss4", 8000, 1, 1e-6},
        std::tuple{"atwood/gbs:1e-12", 400, 1, 1e-8}}) {
    const Recorded one = run(atwood_engine(), method, closing, steps, samples);
    const Recorded other = run(atwood_engine(), method, in_tree, steps, samples);
    INFO(method << ", samples: " << samples);
    CHECK(apart(one.samples, other.samples).motion < bound);
    CHECK(std::fabs(static_cast<double>(one.samples.back().joints[3].q[0])) > 3 * 6.28);
  }
}

// Within a step an angle may change by more than half a turn: rates lead to the right turn.
TEST_CASE("a rate of a state that is far from the last step's end takes the angle to which the rates lead") {
  constexpr double t_s = 0.35;
  Scenario closing = four_bar(t_s, 2);
  closing.scene.joints[0].rates[0] = 12;
  closing.scene.joints[3].hold = {0};
  closing.scene = settled(closing.scene);
  closing.scene.joint_forces = {JointSpring{3, 0, 0.02, 0, 0}};
  const Recorded ran = run(atwood_engine(), "atwood/dop853", closing, 1000, 1);
  const std::vector<JointSample>& end = ran.samples.back().joints;
  CHECK(std::fabs(static_cast<double>(end[3].q[0]) - closing.scene.joints[3].coordinates[0]) > 3.5);
  std::vector<double> accelerations[2];
  for (const bool in_tree : {false, true}) {
    RigidModel<double> model(in_tree ? exchanged(closing.scene, 3, 2) : closing.scene);
    std::vector<double> y(static_cast<std::size_t>(model.state_size())), dydt(y);
    model.initial_state(y.data());
    for (const Link<double>& link : model.tree()->links()) {
      y[static_cast<std::size_t>(link.at_q)] = static_cast<double>(end[static_cast<std::size_t>(link.joint)].q[0]);
      y[static_cast<std::size_t>(link.at_u)] = static_cast<double>(end[static_cast<std::size_t>(link.joint)].u[0]);
    }
    model.system().rate(t_s, y.data(), dydt.data());
    for (const int joint : {0, 1}) {
      const Link<double>& link = model.tree()->links()[static_cast<std::size_t>(model.tree()->link_of_joint(joint))];
      accelerations[in_tree].push_back(dydt[static_cast<std::size_t>(link.at_u)]);
    }
  }
  for (const int k : {0, 1}) CHECK(std::fabs(accelerations[0][k] - accelerations[1][k]) < 1e-9);
}

TEST_CASE("turns are counted where nothing is sampled") {
  Scenario scenario = four_bar(2.5, 2);
  scenario.scene.joints[0].rates[0] = 12;
  scenario.scene.joints[3].hold = {0};
  scenario.scene = settled(scenario.scene);
  scenario.scene.joint_forces = {JointSpring{3, 0, 0.02, 0, 0}};
  const Recorded sampled = run(atwood_engine(), "atwood/dopri5:1e-9", scenario, 4000, 1);
  const MethodId id = parse_method_id("atwood/dopri5:1e-9");
  for (const int timed_passes : {0, 2}) {
    const Outcome alone =
        atwood_engine().run(id, scenario.scene, {scenario.t_end_s, 4000, 1}, Observer{}, timed_passes);
    CHECK(alone.steps_taken == sampled.outcome.steps_taken);
  }
}

TEST_CASE("the energy of a closing joint's spring is counted") {
  Scenario scenario = four_bar(2, 2);
  scenario.scene.joints[0].rates[0] = 12;
  scenario.scene.joints[3].hold = {0};
  scenario.scene = settled(scenario.scene);
  scenario.scene.joint_forces = {JointSpring{3, 0, 0.2, 1, 0}};
  const Recorded ran = run(atwood_engine(), "atwood/dop853", scenario, 4000, 20);
  const auto energy = [&](const SampleView& sample) {
    const dynamics::Energy e = dynamics::energy(scenario.scene, sample);
    return static_cast<double>(e.kinetic_J + e.potential_J);
  };
  for (std::size_t k = 0; k < ran.samples.size(); ++k)
    CHECK(std::fabs(energy(ran.samples[k]) - energy(ran.samples[0])) < 1e-10);
  RigidModel<double> model(scenario.scene);
  std::vector<double> y(static_cast<std::size_t>(model.state_size()));
  model.initial_state(y.data());
  CHECK(std::fabs(model.energy(y.data()) - energy(ran.samples[0])) < 1e-12);
}

TEST_CASE("rates of several states at once have the bits of each, with forces along a closing joint") {
  for (const Scene& scene : {planar(1).scene, in_space(302, JointKind::ball, 1)->scene}) {
    RigidModel<double> model(scene);
    REQUIRE(model.unsupported().empty());
    model.select_interval(0.25, 0.5);
    constexpr int count = 11;
    const auto size = static_cast<std::size_t>(model.state_size());
    std::vector<double> first(size), t_s, states(size * count), rates(size * count), scratch(4 * size * count),
        at(size), rate(size);
    model.initial_state(first.data());
    const auto state = [&](int k, std::size_t i) {
      return first[i] + 1e-4 * k * std::cos(1.0 + static_cast<double>(i));
    };
    for (int k = 0; k < count; ++k) {
      t_s.push_back(0.25 + 0.001 * k);
      for (std::size_t i = 0; i < size; ++i) states[i * count + static_cast<std::size_t>(k)] = state(k, i);
    }
    model.system().rates(count, t_s.data(), states.data(), rates.data(), scratch.data());
    int differ = 0;
    for (int k = 0; k < count; ++k) {
      for (std::size_t i = 0; i < size; ++i) at[i] = state(k, i);
      model.system().rate(t_s[static_cast<std::size_t>(k)], at.data(), rate.data());
      for (std::size_t i = 0; i < size; ++i)
        differ += rates[i * count + static_cast<std::size_t>(k)] == rate[i] ? 0 : 1;
    }
    CHECK(differ == 0);
  }
}

TEST_CASE("forces along closing joints: the engine, IDA and the extended truth agree") {
  std::vector<Scenario> scenarios{planar(0.75)};
  for (std::uint64_t seed = 300; scenarios.size() < 2; ++seed)
    if (const auto made = in_space(seed, JointKind::ball, 0.25)) scenarios.push_back(*made);
  for (const Scenario& scenario : scenarios) {
    const Truth truth = mechanism_truth(scenario, 2);  // no sample on a switch
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const Recorded ours = run(atwood_engine(), "atwood/dop853", scenario, 1500, 2);
    const Apart found = apart(ours.samples, truth.values);
    CHECK(found.motion < 1e-11);
    CHECK(found.load < 1e-9);
    const Recorded ida = run(ida_engine(), "ida/bdf:1e-10", scenario, 2, 2);
    CHECK(apart(ours.samples, ida.samples).motion < 1e-6);
  }
}
