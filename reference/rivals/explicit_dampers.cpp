#include "rivals/explicit_dampers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rivals/joints.hpp"
#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::rivals {
namespace {

using Load = std::vector<Wrench>;  // one wrench a body

struct Damper {
  std::string name;
  double coefficient = 0;
  Load along;  // the load of a unit effort; its rate is that load's power
};

double power_of(const Load& a, const Load& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += rivals::dot(a[i].force_N, b[i].force_N) + rivals::dot(a[i].torque_N_m, b[i].torque_N_m);
  return sum;
}

void add_load(Load& a, double factor, const Load& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    rivals::add(a[i].force_N, factor * b[i].force_N);
    rivals::add(a[i].torque_N_m, factor * b[i].torque_N_m);
  }
}

class Start {
 public:
  explicit Start(const Scene& scene) : scene_(scene) {
    for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
      const Body& body = scene.bodies[static_cast<std::size_t>(i)];
      motions_.push_back(motion_at_start(scene, i));
      axes_.push_back(rotates(body) && !body.fixed ? principal_axes(body.inertia_kg_m2) : PrincipalAxes{});
    }
    for (const Joint& joint : scene.joints) hold(joint);
  }

  const std::vector<Motion>& motions() const { return motions_; }

  // The accelerations of free bodies under a load.
  Load accelerations(const Load& load) const {
    Load all(load.size());
    for (std::size_t i = 0; i < load.size(); ++i) {
      const Body& body = scene_.bodies[i];
      if (body.fixed) continue;
      all[i].force_N = (1 / body.mass_kg) * load[i].force_N;
      const Real4 q_WP = product(motions_[i].q_WB, axes_[i].q_BP);
      Real3 torque = to_body(q_WP, load[i].torque_N_m);
      for (int k = 0; k < 3; ++k) torque[k] = axes_[i].moments_kg_m2[k] > 0 ? torque[k] / axes_[i].moments_kg_m2[k] : 0;
      all[i].torque_N_m = to_world(q_WP, torque);
    }
    return all;
  }

  // The load less the reactions to it: under what is left free bodies accelerate as the joints let them.
  Load without_reactions(Load load) const {
    for (const auto& [reaction, acceleration] : reactions_) add_load(load, -power_of(acceleration, load), reaction);
    return load;
  }

 private:
  // Orthonormal reactions, a^T M^-1 b, by Gram and Schmidt's process: M^-1 P is the projection onto what joints admit.
  void hold(const Joint& joint) {
    const Motion parent = motion_of(motions_, joint.parent);
    const Motion& child = motions_[static_cast<std::size_t>(joint.child)];
    const JointPlace place = place_of(joint, parent, child);
    for (int k = 0; k < 6; ++k) {
      Reaction unit{{}, {}};
      (k < 3 ? unit.force_N : unit.torque_N_m)[k % 3] = 1;
      const Reaction on = constraint_part(joint, place, unit);
      Load load(scene_.bodies.size());
      const auto put = [&](int body, double sign, const Motion& at) {
        if (body < 0) return;
        Wrench& wrench = load[static_cast<std::size_t>(body)];
        wrench.force_N = sign * on.force_N;
        wrench.torque_N_m = sign * (on.torque_N_m + cross(place.child_anchor_m - at.p_WB, on.force_N));
      };
      put(joint.child, 1, child);
      put(joint.parent, -1, parent);
      const double before = power_of(load, accelerations(load));
      load = without_reactions(without_reactions(std::move(load)));  // twice is enough (Kahan, Parlett)
      Load acceleration = accelerations(load);
      const double squared = power_of(load, acceleration);
      if (!(squared > 1e-12 * before)) continue;  // other reactions do the same
      for (Load* each : {&load, &acceleration}) {
        Load scaled(each->size());
        add_load(scaled, 1 / std::sqrt(squared), *each);
        *each = std::move(scaled);
      }
      reactions_.emplace_back(std::move(load), std::move(acceleration));
    }
  }

  const Scene& scene_;
  std::vector<Motion> motions_;
  std::vector<PrincipalAxes> axes_;
  std::vector<std::pair<Load, Load>> reactions_;  // and the accelerations of free bodies under them
};

void add_joint_dampers(const Scene& scene, const std::vector<Motion>& motions, std::vector<Damper>& dampers) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    for (int k = 0; k < rate_count(joint.kind); ++k) {
      const int coordinate = joint.kind == JointKind::ball ? 0 : k;
      const double damping = passive_force(scene, static_cast<int>(j), coordinate).damping;
      if (damping == 0) continue;
      std::vector<Real3> efforts(scene.joints.size());
      efforts[j][static_cast<std::size_t>(k)] = 1;
      Load along(scene.bodies.size());
      add_joint_wrenches(scene, motions, efforts, along);
      dampers.push_back({"the damper of the joint `" + joint.name + "`", damping, std::move(along)});
    }
  }
}

void add_drag(const Scene& scene, const LinearDrag& drag, std::vector<Damper>& dampers) {
  for (const int i : drag.bodies) {
    const std::string name = "the drag of `" + scene.bodies[static_cast<std::size_t>(i)].name + "`";
    for (std::size_t k = 0; k < 3; ++k) {
      Load force(scene.bodies.size()), torque(scene.bodies.size());
      force[static_cast<std::size_t>(i)].force_N[k] = torque[static_cast<std::size_t>(i)].torque_N_m[k] = 1;
      if (drag.coefficient_kg_per_s > 0) dampers.push_back({name, drag.coefficient_kg_per_s, std::move(force)});
      if (drag.angular_coefficient_N_m_s > 0)
        dampers.push_back({name, drag.angular_coefficient_N_m_s, std::move(torque)});
    }
  }
}

// Along the spring, or along every axis where its ends coincide.
void add_dashpot(const Scene& scene, const Spring& spring, const std::vector<Motion>& motions,
                 std::vector<Damper>& dampers) {
  if (spring.damping_N_s_per_m == 0) return;
  std::vector<Real3> arms, ends;
  for (std::size_t k = 0; k < spring.bodies.size(); ++k) {
    const Motion& body = motions[static_cast<std::size_t>(spring.bodies[k])];
    arms.push_back(k < spring.points_body_m.size() ? to_world(body.q_WB, spring.points_body_m[k]) : Real3{});
    ends.push_back(body.p_WB + arms.back());
  }
  const Real3 d = ends[0] - (ends.size() > 1 ? ends[1] : spring.anchor_m);
  std::vector<Real3> directions{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (length(d) > 0) directions = {(1 / length(d)) * d};
  const std::string& name = scene.bodies[static_cast<std::size_t>(spring.bodies[0])].name;
  for (const Real3& direction : directions) {
    Load along(scene.bodies.size());
    for (std::size_t k = 0; k < ends.size(); ++k) {
      Wrench& wrench = along[static_cast<std::size_t>(spring.bodies[k])];
      rivals::add(wrench.force_N, (k == 0 ? 1.0 : -1.0) * direction);
      rivals::add(wrench.torque_N_m, (k == 0 ? 1.0 : -1.0) * cross(arms[k], direction));
    }
    dampers.push_back({"the damping of the spring of `" + name + "`", spring.damping_N_s_per_m, std::move(along)});
  }
}

// The largest eigenvalue of a symmetric matrix whose eigenvalues are 0 or more, by the power method. It is no less than
// any element of the diagonal.
double largest_eigenvalue(const std::vector<std::vector<double>>& matrix) {
  std::vector<double> v(matrix.size());
  double value = 0, diagonal = 0;
  for (std::size_t k = 0; k < v.size(); ++k) {
    v[k] = 1 + std::fmod(0.618 * static_cast<double>(k), 1);  // no symmetry of a scene is orthogonal to it
    diagonal = std::max(diagonal, matrix[k][k]);
  }
  for (int sweep = 0; sweep < 200; ++sweep) {
    std::vector<double> next(v.size());
    double norm = 0, product = 0, squared = 0;
    for (std::size_t k = 0; k < v.size(); ++k) {
      for (std::size_t l = 0; l < v.size(); ++l) next[k] += matrix[k][l] * v[l];
      product += v[k] * next[k];
      squared += v[k] * v[k];
      norm += next[k] * next[k];
    }
    if (!(norm > 0)) break;
    const double last = std::exchange(value, product / squared);
    if (std::fabs(value - last) <= 1e-9 * value) break;
    for (std::size_t k = 0; k < v.size(); ++k) v[k] = next[k] / std::sqrt(norm);
  }
  return std::max(value, diagonal);
}

}  // namespace

std::optional<ExplicitDampers> explicit_dampers(const Scene& scene, bool joint_forces, bool body_forces) {
  std::vector<Motion> motions;
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) motions.push_back(motion_at_start(scene, i));
  std::vector<Damper> dampers;
  if (joint_forces) add_joint_dampers(scene, motions, dampers);
  for (const Force& force : scene.forces) {
    if (!body_forces) break;
    if (const auto* drag = std::get_if<LinearDrag>(&force)) add_drag(scene, *drag, dampers);
    if (const auto* spring = std::get_if<Spring>(&force)) add_dashpot(scene, *spring, motions, dampers);
  }
  if (dampers.empty()) return {};
  const Start start(scene);
  std::vector<Load> left, accelerations;
  for (const Damper& damper : dampers) {
    left.push_back(start.without_reactions(damper.along));
    accelerations.push_back(start.accelerations(left.back()));
  }
  std::vector<std::vector<double>> rates(dampers.size(), std::vector<double>(dampers.size()));
  std::size_t stiffest = 0;
  for (std::size_t k = 0; k < dampers.size(); ++k) {
    for (std::size_t l = 0; l < dampers.size(); ++l)
      rates[k][l] = std::sqrt(dampers[k].coefficient * dampers[l].coefficient) * power_of(left[k], accelerations[l]);
    if (rates[k][k] > rates[stiffest][stiffest]) stiffest = k;
  }
  double free = 0;
  for (const Damper& damper : dampers)
    free = std::max(free, damper.coefficient * power_of(damper.along, start.accelerations(damper.along)));
  const double fastest = largest_eigenvalue(rates);
  if (!(fastest > 1e-12 * free)) return {};  // the joints leave no rate to damp
  return ExplicitDampers{dampers[stiffest].name, 2 / fastest};
}

std::string beyond_explicit_dampers(const std::optional<ExplicitDampers>& dampers, double h_s) {
  if (!dampers || !(h_s > dampers->largest_step_s)) return "";
  return fmt::format(
      "{} is explicit, evaluated by the adapter once a step, and unstable beyond c h = 2 I: h = {:.3g} s; the step is "
      "{:.3g} s",
      dampers->stiffest, dampers->largest_step_s, h_s);
}

}  // namespace atwood::rivals
