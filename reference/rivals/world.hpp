// One scene inside one engine, and the loop that all adapters run it with.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/applied_forces.hpp"
#include "scene/contact_laws.hpp"

namespace atwood::rivals {

using atwood::laws_in_play;

// Virtual because the set of engines is open.
class World {
 public:
  virtual ~World() = default;
  // One step of h_s. `wrenches` (one a body; empty: none) act during it.
  virtual void step(double h_s, const std::vector<Wrench>& wrenches) = 0;
  virtual Motion motion(int body) const = 0;  // engine state, widened without loss
  virtual void release(int body) = 0;         // a held body starts to move with its scene velocity

  // How often the engine has asked for rates, where it asks for the scene's forces itself at each; then step() gets no
  // wrenches. -1: it does not.
  virtual std::int64_t rate_calls() const { return -1; }

  // Contacts that carried an impulse in the last step, point by point, a < b. Engines find them at the step's
  // beginning, and there x_m, normal and gap_m hold; run_world brings the gap to the step's end, where samples are
  // taken.
  struct Touch {
    int body_a = 0, body_b = 0;
    Real3 x_m{}, normal{};     // unit, from a to b
    double gap_m = 0;          // negative: overlap
    double impulse_n_N_s = 0;  // on b along the normal
    Real3 impulse_t_N_s{};     // friction's, on b, world axes
  };
  virtual std::vector<Touch> touches() const = 0;
};

// Builds a world; called once a run and once a repeat. `observe` asks it to keep what touches() needs.
using WorldMaker = std::function<std::unique_ptr<World>(const Scene&, bool observe)>;

// Runs the scene: an accuracy pass that observes and is not timed, or (repeats > 0) a timed pass that only steps, or
// (the observer has a profile) one that reads the clock every step. `substeps` inner steps make one step; forces are
// evaluated once an inner step.
Outcome run_world(const WorldMaker& make, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
                  std::int64_t substeps);

// What every adapter refuses, with `engine` named; empty when the scene can run. Contacts of a given stiffness are
// refused unless it `gives_way`.
std::string refusal(const std::string& engine, const MethodId& id, const std::string& scalar, const Scene& scene,
                    bool gives_way = false);

// Shapes matter where two bodies have one, not both fixed; elsewhere they can't touch anything and are no obstacle.
bool shapes_matter(const Scene& scene);

// The preset with a method's overrides applied; integers become doubles where the preset has a double. Throws
// std::invalid_argument that names an unknown setting, or a fixed one, or one of the wrong type, and lists the known.
Settings with_overrides(const Settings& preset, const Settings& overrides, const std::set<std::string>& fixed);

bool flag(const Settings& settings, const std::string& name);
double number(const Settings& settings, const std::string& name);
std::int64_t count(const Settings& settings, const std::string& name, std::int64_t at_least);
// Throws std::invalid_argument unless the value is one of `allowed`.
std::string choice(const Settings& settings, const std::string& name, const std::vector<std::string>& allowed);

// Principal axes of a symmetric inertia: I_B = R_BP diag(moments) R_BP^T. Diagonal input gives the identity.
struct PrincipalAxes {
  Real3 moments_kg_m2{};
  Real4 q_BP{1, 0, 0, 0};
};
PrincipalAxes principal_axes(const Real33& inertia_kg_m2);

const char* shape_name(const Shape& shape);
bool has_shape(const Body& body);

}  // namespace atwood::rivals
