// One scene inside one engine, and the loop with which all adapters run it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/applied_forces.hpp"
#include "rivals/joints.hpp"
#include "scene/contact_laws.hpp"

namespace atwood::rivals {

using atwood::laws_in_play;

// Virtual because the set of engines is open.
class World {
 public:
  virtual ~World() = default;
  // One step of h_s. `wrenches` (one per body; empty: none) act during it.
  virtual void step(double h_s, const std::vector<Wrench>& wrenches) = 0;
  virtual Motion motion(int body) const = 0;  // engine state, widened without loss
  virtual void release(int body) = 0;         // a held body starts to move with its scene velocity

  // Told ahead of each step: its time, which an engine's own clock sums up with rounding errors.
  virtual void starts_at(double /*t_s*/) {}

  // Number of rate evaluations of an engine that evaluates the scene's forces itself; step() then gets no wrenches. -1:
  // the engine does not.
  virtual std::int64_t rate_calls() const { return -1; }

  // Contact points with an impulse in the last step, a < b. Engines find them at the start of the step, to which x_m,
  // normal and gap_m belong; run_world extrapolates the gap to the end of the step, where samples are taken.
  struct Touch {
    int body_a = 0, body_b = 0;
    Real3 x_m{}, normal{};     // unit, from a to b
    double gap_m = 0;          // negative: overlap
    double impulse_n_N_s = 0;  // on b along the normal
    Real3 impulse_t_N_s{};     // of friction, on b, world axes
  };
  virtual std::vector<Touch> touches() const = 0;

  // A joint's coordinates and rates as the engine stores them; nothing: they follow from the motions of its bodies.
  virtual std::optional<JointState> joint(int) const { return std::nullopt; }
  // Whether the engine evaluates the forces of joints; otherwise they are a part of the wrenches that step() gets.
  virtual bool joint_forces_inside() const { return false; }
  // Of each joint at the present state, t_s, under these wrenches (as in step()). Empty: the engine does not report
  // them.
  virtual std::vector<Reaction> reactions(double /*t_s*/, const std::vector<Wrench>& /*wrenches*/) { return {}; }
  virtual std::vector<RopeSample> ropes() { return {}; }
  // Why the motion is no longer that of the scene (a rope is slack); empty: it is. Asked at samples.
  virtual std::string broken() { return ""; }
};

// Builds a world; called once per run and repeat. `observe`: touches() will be called.
using WorldMaker = std::function<std::unique_ptr<World>(const Scene&, bool observe)>;

// Runs the scene: an accuracy pass that observes and is not timed, or (repeats > 0) a timed pass that only steps, or
// (the observer has a profile) one that reads the clock every step. `substeps` inner steps make one step; forces are
// evaluated once per inner step.
Outcome run_world(const WorldMaker& make, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
                  std::int64_t substeps);

// The refusals of every adapter, with the name of the engine; none when the scene can run. Compliant contact laws are
// refused unless the engine is `compliant`.
std::optional<Fault> refusal(const std::string& engine, const MethodId& id, const std::string& scalar,
                             const Scene& scene, bool compliant = false);

// What the cell of an engine states that has its own order for impacts of one instant where the scene states a
// sequence; "": nothing. (A scene whose simultaneous impacts are one problem is refused.)
std::string convention_note(const std::string& engine, const Scene& scene);

// Whether shapes have an effect: two bodies have one, and at least one of them is mobile.
bool shapes_matter(const Scene& scene);

Setting substeps_setting();  // of every rival: inner steps of a step

// Settings of the type that the name has; std::bad_variant_access for another type.
bool flag(const Settings& settings, const std::string& name);
double number(const Settings& settings, const std::string& name);
std::int64_t count(const Settings& settings, const std::string& name);
const std::string& word(const Settings& settings, const std::string& name);

// Principal axes of a symmetric inertia: I_B = R_BP diag(moments) R_BP^T. Diagonal input gives the identity.
struct PrincipalAxes {
  Real3 moments_kg_m2{};
  Real4 q_BP{1, 0, 0, 0};
};
PrincipalAxes principal_axes(const Real33& inertia_kg_m2);

const char* shape_name(const Shape& shape);
bool has_shape(const Body& body);

}  // namespace atwood::rivals
