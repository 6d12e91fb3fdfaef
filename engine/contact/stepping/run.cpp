#include "contact/stepping/run.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "contact/options.hpp"
#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"
#include "scene/contact_laws.hpp"
#include "smooth/run.hpp"

namespace atwood {
namespace {

using namespace stepping;

constexpr const char *kJointsNotMet = "the joint constraints were not satisfied",
                     *kImpactsStalled = "10000 impacts or more followed each other without the time advancing";

// Impacts with restitution are resolved one after another, contacts without it are solved together. A scene that
// names a convention for simultaneous impacts is refused where one of its pairs follows the other convention.
std::optional<Fault> convention_fault(const Scene& scene) {
  const SimultaneousImpacts named = scene.simultaneous_impacts;
  if (named == SimultaneousImpacts::unspecified) return {};
  for (const PairLaw& law : laws_in_play(scene)) {
    if (named == SimultaneousImpacts::together && law.restitution > 0)
      return Fault{
          "the scene's simultaneous_impacts is together: +impulse takes impacts with restitution one after another"};
    if (named == SimultaneousImpacts::sequential && !(law.restitution > 0))
      return Fault{
          "the scene's simultaneous_impacts is sequential: +impulse solves contacts without restitution together"};
  }
  return {};
}

// Why +impulse does not take the scene.
std::optional<Fault> scene_fault(const Scene& scene) {
  if (const auto fault = convention_fault(scene)) return fault;
  for (const PairLaw& pair : scene.pairs)
    if (pair.rolling_friction_m > 0) return Fault{"atwood's +impulse has no rolling friction"};
  // Whether a pair of shapes has a contact test depends on their kinds alone: two moving and two fixed bodies of each
  // kind stand for all.
  std::vector<const Body*> representatives;
  for (const Body& body : scene.bodies) {
    const auto alike = [&](const Body* other) {
      return other->shape.index() == body.shape.index() && other->fixed == body.fixed;
    };
    if (body.shape.index() != 0 && std::count_if(representatives.begin(), representatives.end(), alike) < 2)
      representatives.push_back(&body);
  }
  for (std::size_t a = 0; a < representatives.size(); ++a)
    for (std::size_t b = a + 1; b < representatives.size(); ++b) {
      if (representatives[a]->fixed && representatives[b]->fixed) continue;
      const char* what = missing_contact_test(static_cast<ShapeKind>(representatives[a]->shape.index()),
                                              static_cast<ShapeKind>(representatives[b]->shape.index()));
      if (what != nullptr)
        return Fault{"atwood has no contact test for `" + representatives[a]->name + "` and `" +
                     representatives[b]->name + "`: " + what};
    }
  return {};
}

std::optional<Fault> joints_fault(const MethodId& id, const Scene& scene, const Options& options) {
  if (!scene.ropes.empty()) return Fault{"+impulse takes no ropes; use +penalty"};
  if (scene.joints.empty()) return {};
  if (id.scheme != "symplectic-euler")
    return Fault{"+impulse steps mechanisms only by symplectic-euler; found atwood/" + id.scheme};
  if (options.sleeping) return Fault{"+impulse{sleeping=true} takes no bodies on joints"};
  return {};
}

template <class S>
void build_world(World<S>& world, const Scene& scene, Simulation<S>& simulation, const std::string& scheme) {
  world.scene = &scene;
  world.model = simulation.model.get();
  world.stepper = scheme == "symplectic-euler" ? nullptr : simulation.stepper.get();
  world.positions_by_mean_velocity = world.stepper != nullptr;
  world.width = widest_vectors();
  world.gravity_W = world.model->uniform_gravity();
  world.materials = static_cast<int>(scene.materials.size());
  world.pair_coefficients.resize(scene.materials.size() * scene.materials.size());
  for (const PairLaw& pair : scene.pairs) {
    const PairCoefficients coefficients{pair.restitution, pair.friction};
    world.pair_coefficients[static_cast<std::size_t>(pair.a * world.materials + pair.b)] = coefficients;
    world.pair_coefficients[static_cast<std::size_t>(pair.b * world.materials + pair.a)] = coefficients;
    world.has_restitution = world.has_restitution || coefficients.restitution > 0;
  }
  const std::size_t count = scene.bodies.size();
  for (const Body& body : scene.bodies) {
    world.geometry.push_back(make_geometry<S>(body.shape));
    world.material.push_back(body.material);
  }
  BodyRows<S>& bodies = world.bodies;
  bodies.count = static_cast<int>(count);
  for (auto* rows :
       {&bodies.velocity, &bodies.pose, &bodies.inertia, &bodies.velocity_increment, &bodies.pose_increment,
        &bodies.impact_shift, &bodies.velocity_before, &bodies.velocity_before_sweep})
    rows->assign(count + 1, Row<S>{});
  bodies.q_WB.resize(count);
  bodies.moves.resize(count);
  bodies.isotropic.resize(count);
  bodies.motion_bound.resize(count);
  Rolling<S>& rolling = world.rolling;
  for (const Body& body : scene.bodies)
    rolling.has_round_bodies =
        rolling.has_round_bodies ||
        (!body.fixed && (std::holds_alternative<Capsule>(body.shape) || std::holds_alternative<Cylinder>(body.shape)));
  if (rolling.has_round_bodies) {
    rolling.rolls.resize(count);
    for (auto* rates : {&rolling.rate_change_by_forces, &rolling.acceleration_by_contacts, &rolling.rate_after_forces,
                        &rolling.rotation_before_drift})
      rates->resize(count);
  }
  if (world.options.sleeping) {
    world.sleep.sleeping_island.resize(count);
    world.sleep.time_at_rest_s.resize(count);
    world.sleep.parent.resize(count);
  }
  world.candidates.margin.resize(count);
  world.candidates.rotation_path.resize(count);
  world.candidates.position_at_detection.resize(count);
  world.y.resize(world.model->state_size());
  world.y_free.resize(world.model->state_size());
  world.tied = make_tied_bodies<S>(scene);
  if (world.tied != nullptr) world.has_restitution = world.has_restitution || world.tied->has_stop_restitution;
  world.candidates.broad_phase = make_broad_phase<S>(world.options.broad_phase, world.team);
}

template <class S> void restart(World<S>& world) {
  RigidModel<S>& model = *world.model;
  model.system().evaluations = 0;
  model.system().solvers = {};
  ++model.system().epoch;
  model.initial_state(world.y.data());
  world.candidates.valid = false;
  wake_all(world);
  world.end = {};
  if (world.tied != nullptr) world.tied->failed = false;
  world.sphere_contacts.clear();
  world.candidates.sphere_pairs.clear();
  world.candidates.plane_pairs.clear();
  world.candidates.manifold_pairs.clear();
  world.manifolds.clear();
  world.manifolds_before.clear();
  world.manifold_contacts.clear();
  std::fill(world.rolling.rolls.begin(), world.rolling.rolls.end(), 0);
  world.rolling.bodies.clear();
  world.rolling.manifolds.clear();
}

// Runs from the initial state to the end of the plan; reports samples and events where `observer` wants them.
template <class S> Outcome run_once(World<S>& world, const Plan& plan, const Observer& observer) {
  RigidModel<S>& model = *world.model;
  Outcome outcome;
  restart(world);
  world.profile = observer.profile;
  world.observer = observer.sample || observer.event ? &observer : nullptr;
  const S scale = state_scale(world.y.data(), model.state_size());
  const std::int64_t stride = plan.steps / plan.samples;
  std::int64_t epoch = -1;
  Sample sample;
  const bool reports_samples = observer.sample != nullptr;
  if (world.tied != nullptr)
    if (const std::string fault = set_mechanism_start(world, world.y.data()); !fault.empty()) return refused(fault);
  const auto observe_at = [&](std::int64_t k, S step_s) {
    if (world.tied == nullptr || !reports_samples) return observe(model, plan, k, world.y.data(), sample, observer);
    Observer with_joints;
    with_joints.sample = [&](const Sample& bodies) {
      Sample whole = bodies;
      report_joints(world, step_s, whole);
      observer.sample(whole);
    };
    observe(model, plan, k, world.y.data(), sample, with_joints);
  };
  observe_at(0, S(0));
  for (std::int64_t n = 0; n < plan.steps; ++n) {
    const S from_s = time_at<S>(plan, n), to_s = time_at<S>(plan, n + 1), h_s = to_s - from_s;
    const auto begin = world.profile ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
    model.select_interval(from_s, to_s);
    if (model.system().epoch != epoch || h_s != world.h_s) {
      world.h_s = h_s;
      world.substeps = substeps_of(world.options, static_cast<double>(h_s));
      world.sub_s = h_s / S(world.substeps);
      if (model.system().epoch != epoch) {  // other forces act, or a body was released
        if (n > 0) store_bodies(world);
        world.candidates.valid = false;
        wake_all(world);
        load_bodies(world);
        epoch = model.system().epoch;
      } else {
        set_gravity_increments(world);
      }
    }
    world.records_impulses = reports_samples && (n + 1) % stride == 0;
    if (!step(world, from_s, h_s)) {
      std::string reason = unsolved_step(model.system().solvers, static_cast<double>(from_s));
      model.system().solvers.keep_capped();
      return {Status::diverged, std::move(reason), n, 0, {}, named_tallies(model.system().solvers)};
    }
    if (world.profile) {
      const auto busy = std::chrono::steady_clock::now() - begin;
      world.profile->step_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count());
    }
    if (world.end.points_beyond_limit > 0)
      return refused("+impulse{solver=direct}: an island has " + std::to_string(world.end.points_beyond_limit) +
                     " contact points, more than direct_points = " + std::to_string(world.options.direct_points));
    const bool joints_failed = world.tied != nullptr && world.tied->failed;
    if (const char* fault = joints_failed               ? kJointsNotMet
                            : world.end.impacts_stalled ? kImpactsStalled
                                                        : nullptr;
        fault != nullptr) {
      outcome.status = Status::diverged;
      const S at_s = joints_failed ? to_s : world.end.stall_time_s;
      outcome.reason = fault + (" at t = " + format_double(static_cast<double>(at_s)) + " s");
      break;
    }
    outcome.steps_taken = n + 1;
    if ((n + 1) % stride != 0) continue;
    store_bodies(world);
    if (!healthy(world.y.data(), model.state_size(), scale, to_s, outcome)) break;
    if (reports_samples) report_contacts(world, h_s, sample);
    observe_at((n + 1) / stride, h_s);
  }
  outcome.rate_evaluations = model.system().evaluations;
  outcome.solvers = named_tallies(model.system().solvers);
  return outcome;
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const Result<Settings> settings = response_settings(id);
  if (!settings) return refused(settings.fault());
  const Options options = options_of(*settings);
  if (id.rtol) return refused("+impulse takes equal steps; found a tolerance");
  if (const auto fault = scene_fault(scene)) return refused(*fault);
  if (options.sleeping && !scene.forces.empty())
    return refused(
        "+impulse{sleeping=true}: only gravity and contacts may act, for a change of a force would not wake a body");
  if (const auto fault = joints_fault(id, scene, options)) return refused(*fault);
  Scene free = scene;  // every body has its own coordinates
  free.joints.clear();
  free.joint_forces.clear();
  Simulation<S> simulation = prepare<S>(integrator_part(id), scene.joints.empty() ? scene : free);
  if (simulation.outcome.status != Status::ok) return simulation.outcome;
  const std::unique_ptr<Team> team = options.threads > 1 ? std::make_unique<Team>(options.threads) : nullptr;
  World<S> world;
  world.options = options;
  world.team = team.get();
  build_world(world, scene, simulation, id.scheme);
  if (repeats <= 0) return run_once(world, plan, observer);

  const Observer no_observer;
  return timed_passes(repeats, whole_pass([&] { return run_once(world, plan, no_observer); }));
}

}  // namespace

Outcome run_impulse(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.scalar == "float") return run_in<float>(id, scene, plan, observer, repeats);
  if (id.scalar.empty() || id.scalar == "double") return run_in<double>(id, scene, plan, observer, repeats);
  return refused("atwood's +impulse runs in float and double, not in " + id.scalar);
}

}  // namespace atwood
