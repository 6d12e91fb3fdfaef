#include "contact/stepping/run.hpp"

#include <algorithm>
#include <chrono>

#include "contact/options.hpp"
#include "contact/stepping/points.hpp"
#include "scene/contact_laws.hpp"
#include "simulation.hpp"

namespace atwood {
namespace {

using namespace stepping;

Outcome unsupported(const std::string& reason) { return {Status::unsupported, reason, 0, 0, {}}; }

// Impacts that bounce are taken one after another, those that do not are solved at once: whichever convention for
// simultaneous impacts the scene names, it has to be that of all its pairs.
std::string other_convention(const Scene& scene) {
  const SimultaneousImpacts named = scene.simultaneous_impacts;
  if (named == SimultaneousImpacts::unspecified) return "";
  for (const PairLaw& law : laws_in_play(scene)) {
    if (named == SimultaneousImpacts::together && law.restitution > 0)
      return "the scene's simultaneous_impacts is together: +impulse takes impacts with restitution one after another";
    if (named == SimultaneousImpacts::sequential && !(law.restitution > 0))
      return "the scene's simultaneous_impacts is sequential: +impulse solves contacts without restitution together";
  }
  return "";
}

// What +impulse has no answer for, by name; "" otherwise.
std::string missing(const Scene& scene) {
  if (const std::string other = other_convention(scene); !other.empty()) return other;
  for (const PairLaw& pair : scene.pairs)
    if (pair.rolling_friction_m > 0) return "atwood's +impulse has no rolling friction";
  // A pair of shapes is met or not whoever has them: the first moving and the first fixed body of each kind stand for
  // all.
  std::vector<const Body*> one;
  for (const Body& body : scene.bodies) {
    const auto alike = [&](const Body* other) {
      return other->shape.index() == body.shape.index() && other->fixed == body.fixed;
    };
    if (body.shape.index() != 0 && std::count_if(one.begin(), one.end(), alike) < 2) one.push_back(&body);
  }
  for (std::size_t a = 0; a < one.size(); ++a)
    for (std::size_t b = a + 1; b < one.size(); ++b) {
      if (one[a]->fixed && one[b]->fixed) continue;
      const char* what =
          no_contact_test(static_cast<ShapeKind>(one[a]->shape.index()), static_cast<ShapeKind>(one[b]->shape.index()));
      if (what != nullptr)
        return "atwood has no contact test for `" + one[a]->name + "` and `" + one[b]->name + "`: " + what;
    }
  return "";
}

template <class S>
void build_world(World<S>& world, const Scene& scene, Simulation<S>& simulation, const std::string& scheme) {
  world.scene = &scene;
  world.model = simulation.model.get();
  world.stepper = scheme == "symplectic-euler" ? nullptr : simulation.stepper.get();
  world.by_mean = world.stepper != nullptr;
  world.width = widest_vectors();
  world.gravity_W = world.model->uniform_gravity();
  world.materials = static_cast<int>(scene.materials.size());
  world.laws.resize(scene.materials.size() * scene.materials.size());
  for (const PairLaw& pair : scene.pairs) {
    const Law law{pair.restitution, pair.friction};
    world.laws[static_cast<std::size_t>(pair.a * world.materials + pair.b)] = law;
    world.laws[static_cast<std::size_t>(pair.b * world.materials + pair.a)] = law;
    world.bounces = world.bounces || law.restitution > 0;
  }
  const std::size_t count = scene.bodies.size();
  for (const Body& body : scene.bodies) {
    world.geometry.push_back(make_geometry<S>(body.shape));
    world.material.push_back(body.material);
  }
  Bodies<S>& bodies = world.bodies;
  bodies.count = static_cast<int>(count);
  for (auto* rows : {&bodies.velocity, &bodies.place, &bodies.inertia, &bodies.kick, &bodies.rest, &bodies.shift,
                     &bodies.before, &bodies.swept})
    rows->assign(count + 1, Row<S>{});
  bodies.q_WB.resize(count);
  bodies.moves.resize(count);
  bodies.isotropic.resize(count);
  bodies.reach.resize(count);
  Rolling<S>& rolling = world.rolling;
  for (const Body& body : scene.bodies)
    rolling.some_round =
        rolling.some_round ||
        (!body.fixed && (std::holds_alternative<Capsule>(body.shape) || std::holds_alternative<Cylinder>(body.shape)));
  if (rolling.some_round) {
    rolling.rolls.resize(count);
    for (auto* rates : {&rolling.by_forces, &rolling.by_contacts, &rolling.kicked, &rolling.turned})
      rates->resize(count);
  }
  if (world.options.sleeping) {
    world.sleep.island.resize(count);
    world.sleep.still_s.resize(count);
    world.sleep.parent.resize(count);
  }
  world.margin.resize(count);
  world.turned.resize(count);
  world.found_at.resize(count);
  world.y.resize(world.model->state_size());
  world.y_free.resize(world.model->state_size());
  world.broad_phase = make_broad_phase<S>(world.options.broad_phase, world.team);
}

template <class S> void restart(World<S>& world) {
  RigidModel<S>& model = *world.model;
  model.system().evaluations = 0;
  ++model.system().epoch;
  model.initial_state(world.y.data());
  world.candidates_hold = false;
  wake_all(world);
  world.refused_points = 0;
  world.balls.clear();
  world.ball_pairs.clear();
  world.plane_pairs.clear();
  world.other_pairs.clear();
  world.manifolds.clear();
  world.manifolds_before.clear();
  world.manifold_batches.clear();
  std::fill(world.rolling.rolls.begin(), world.rolling.rolls.end(), 0);
  world.rolling.bodies.clear();
  world.rolling.manifolds.clear();
}

// From the initial state to the end, with or without looking.
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
  const bool tells = observer.sample != nullptr;
  observe(model, plan, 0, world.y.data(), sample, observer);
  for (std::int64_t n = 0; n < plan.steps; ++n) {
    const S from_s = time_at<S>(plan, n), to_s = time_at<S>(plan, n + 1), h_s = to_s - from_s;
    const auto begin = world.profile ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
    model.select_interval(from_s, to_s);
    if (model.system().epoch != epoch || h_s != world.h_s) {
      world.h_s = h_s;
      world.substeps = substeps_of(world.options, static_cast<double>(h_s));
      world.sub_s = h_s / S(world.substeps);
      if (model.system().epoch != epoch) {  // other forces, somebody released
        if (n > 0) store_bodies(world);
        world.candidates_hold = false;
        wake_all(world);
        load_bodies(world);
        epoch = model.system().epoch;
      } else {
        set_kicks(world);
      }
    }
    world.sums_impulses = tells && (n + 1) % stride == 0;
    if (!step(world, from_s, h_s)) return {Status::diverged, "an implicit step has no solution", n, 0, {}};
    if (world.profile) {
      const auto busy = std::chrono::steady_clock::now() - begin;
      world.profile->step_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count());
    }
    if (world.refused_points > 0)
      return unsupported("+impulse{solver=direct}: an island has " + std::to_string(world.refused_points) +
                         " contact points, direct_points is " + std::to_string(world.options.direct_points));
    outcome.steps_taken = n + 1;
    if ((n + 1) % stride != 0) continue;
    store_bodies(world);
    if (!healthy(world.y.data(), model.state_size(), scale, to_s, outcome)) break;
    if (tells) tell_contacts(world, h_s, sample);
    observe(model, plan, (n + 1) / stride, world.y.data(), sample, observer);
  }
  outcome.rate_evaluations = model.system().evaluations;
  return outcome;
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const Result<Settings> settings = response_settings(id);
  if (!settings) return unsupported(settings.fault().reason);
  const Options options = options_of(*settings);
  if (id.rtol) return unsupported("+impulse takes equal steps, no tolerance");
  if (const std::string why = missing(scene); !why.empty()) return unsupported(why);
  if (options.sleeping && !scene.forces.empty())
    return unsupported(
        "+impulse{sleeping=true}: only gravity and contacts may act, for a force that changes would not wake anybody");
  Simulation<S> simulation = prepare<S>(integrator_part(id), scene);
  if (simulation.outcome.status != Status::ok) return simulation.outcome;
  const std::unique_ptr<Team> team = options.threads > 1 ? std::make_unique<Team>(options.threads) : nullptr;
  World<S> world;
  world.options = options;
  world.team = team.get();
  build_world(world, scene, simulation, id.scheme);
  if (repeats <= 0) return run_once(world, plan, observer);

  const Observer nobody;
  Outcome outcome = run_once(world, plan, nobody);  // warm-up
  for (int i = 0; i < repeats && outcome.status == Status::ok; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const Outcome timed = run_once(world, plan, nobody);
    const auto busy = std::chrono::steady_clock::now() - start;
    outcome.busy_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count());
    if (timed.status != Status::ok) outcome = timed;
  }
  return outcome;
}

}  // namespace

Outcome run_impulse(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.scalar == "float") return run_in<float>(id, scene, plan, observer, repeats);
  if (id.scalar.empty() || id.scalar == "double") return run_in<double>(id, scene, plan, observer, repeats);
  return unsupported("atwood's +impulse runs in float and double, not in " + id.scalar);
}

}  // namespace atwood
