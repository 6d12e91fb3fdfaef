#include "rivals/world.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "protocol/timed_passes.hpp"
#include "rivals/explicit_dampers.hpp"
#include "rivals/vector.hpp"

namespace atwood::rivals {
namespace {

// A world with the scene's time, releases and applied forces.
class Stepper {
 public:
  Stepper(const Scene& scene, const Plan& plan, std::int64_t substeps, World& world)
      : scene_(scene), plan_(plan), world_(world), substeps_(substeps) {
    inner_h_s_ = plan.t_end_s / static_cast<double>(plan.steps) / static_cast<double>(substeps);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (!scene.bodies[i].fixed && scene.bodies[i].release_s > 0) held_.push_back(static_cast<int>(i));
    }
    motions_.resize(scene.bodies.size());
    if (!scene.forces.empty() && world.rate_calls() < 0) wrenches_.resize(scene.bodies.size());
    if (!scene.joint_forces.empty() && !world.joint_forces_inside()) {
      joint_forces_here_ = true;
      wrenches_.resize(scene.bodies.size());
    }
    for (const Joint& joint : scene.joints) joints_.push_back({joint.coordinates, joint.rates});
    follow_joints();
  }

  // Step n of the plan; `before` runs ahead of every inner step, `after` behind it, with the inner step's start time.
  template <class Before, class After> void step(std::int64_t n, const Before& before, const After& after) {
    const bool recorded = !plan_.frame_ends_s.empty();
    const double begin_s = recorded ? step_begin_s<double>(plan_, n) : 0;
    if (recorded) inner_h_s_ = (step_begin_s<double>(plan_, n + 1) - begin_s) / static_cast<double>(substeps_);
    for (std::int64_t k = 0; k < substeps_; ++k) {
      const double t_s = recorded ? begin_s + inner_h_s_ * static_cast<double>(k)
                                  : inner_h_s_ * static_cast<double>(n * substeps_ + k);
      const double middle_s = t_s + 0.5 * inner_h_s_;
      release_due(middle_s);
      before();
      evaluate_wrenches(t_s, middle_s);
      if (observed_ && joint_forces_here_) before_ = joints_;
      world_.starts_at(t_s);
      world_.step(inner_h_s_, wrenches_);
      if (joint_forces_here_ || observed_) follow_joints();
      if (observed_ && joint_forces_here_) add_damper_work();
      after(t_s);
    }
  }

  // Joints are followed through every step: their coordinates are unwrapped.
  void observe() { observed_ = !scene_.joints.empty(); }

  // Coordinates, rates, reactions and applied forces of the joints at a sample, t_s after the start.
  std::vector<JointSample> joint_samples(double t_s) {
    std::vector<JointSample> samples(joints_.size());
    if (joints_.empty()) return samples;
    const double switches_s = t_s + 0.5 * inner_h_s_;
    evaluate_wrenches(t_s, switches_s);
    const std::vector<Reaction> reactions = world_.reactions(t_s, wrenches_);
    const std::vector<Real3> efforts = joint_efforts(scene_, t_s, switches_s, joints_);
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const Reaction reaction = reactions.empty() ? Reaction{} : reactions[j];
      for (int k = 0; k < 4; ++k) samples[j].q[k] = joints_[j].q[k];
      for (int k = 0; k < 3; ++k) {
        samples[j].u[k] = joints_[j].u[k];
        samples[j].force_N[k] = reaction.force_N[k];
        samples[j].torque_N_m[k] = reaction.torque_N_m[k];
        samples[j].applied[k] = efforts[j][k];
      }
    }
    return samples;
  }

  double inner_h_s() const { return inner_h_s_; }
  // The most that the dampers of joints that the adapter evaluates had given up to some step: 0, as dampers only take
  // energy, unless they are explicit and the steps too long for them.
  double given_by_dampers_J() const { return given_by_dampers_J_; }

  // Fixed and held bodies have the scene's pose, also if the engine stores another one.
  Motion motion(int i) const {
    const Body& body = scene_.bodies[i];
    bool stands = body.fixed;
    for (int held : held_) stands = stands || held == i;
    if (!stands) return world_.motion(i);
    return {body.position_m, body.orientation_wxyz, body.velocity_m_per_s, body.angular_velocity_body_rad_per_s};
  }

 private:
  void release_due(double middle_s) {
    for (auto it = held_.begin(); it != held_.end();) {
      if (scene_.bodies[*it].release_s <= middle_s) {
        world_.release(*it);
        it = held_.erase(it);
      } else {
        ++it;
      }
    }
  }

  void evaluate_wrenches(double t_s, double switches_s) {
    if (wrenches_.empty()) return;
    for (std::size_t i = 0; i < motions_.size(); ++i) motions_[i] = motion(static_cast<int>(i));
    applied_wrenches(scene_, t_s, switches_s, motions_, wrenches_);
    if (joint_forces_here_)
      add_joint_wrenches(scene_, motions_, joint_efforts(scene_, t_s, switches_s, joints_), wrenches_);
  }
  void add_damper_work() {
    for (const JointForce& force : scene_.joint_forces) {
      const auto* spring = std::get_if<JointSpring>(&force);
      if (!spring) continue;
      const auto j = static_cast<std::size_t>(spring->joint);
      const bool ball = scene_.joints[j].kind == JointKind::ball;
      for (int k = ball ? 0 : spring->coordinate; k < (ball ? 3 : spring->coordinate + 1); ++k)
        damper_work_J_ -= spring->damping * before_[j].u[k] * 0.5 * (before_[j].u[k] + joints_[j].u[k]) * inner_h_s_;
    }
    given_by_dampers_J_ = std::max(given_by_dampers_J_, damper_work_J_);
  }
  void follow_joints() {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const Joint& joint = scene_.joints[j];
      std::optional<JointState> now = world_.joint(static_cast<int>(j));
      const bool stored = now.has_value();
      if (!stored) {
        const auto of = [&](int body) { return body < 0 ? Motion{} : motion(body); };
        now = state_from_motions(joint, of(joint.parent), of(joint.child));
      }
      if (!stored || joint.kind == JointKind::ball) continue_coordinates(joint.kind, joints_[j], *now);
      joints_[j] = *now;
    }
  }

  const Scene& scene_;
  const Plan& plan_;
  World& world_;
  std::int64_t substeps_;
  double inner_h_s_ = 0;
  std::vector<int> held_;
  std::vector<Motion> motions_;
  std::vector<Wrench> wrenches_;
  std::vector<JointState> joints_, before_;
  double damper_work_J_ = 0, given_by_dampers_J_ = 0;
  bool joint_forces_here_ = false, observed_ = false;
};

bool finite(const Motion& m) {
  for (double x : m.p_WB)
    if (!std::isfinite(x)) return false;
  for (double x : m.q_WB)
    if (!std::isfinite(x)) return false;
  for (double x : m.v_WB)
    if (!std::isfinite(x)) return false;
  for (double x : m.w_WB_B)
    if (!std::isfinite(x)) return false;
  return true;
}

// A sentence with the first body whose state is NaN or infinite; empty: none.
std::optional<std::string> not_finite(const Scene& scene, const Stepper& stepper, std::int64_t steps) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!finite(stepper.motion(static_cast<int>(i)))) {
      return "the state of `" + scene.bodies[i].name + "` is not finite after " + std::to_string(steps) + " steps";
    }
  }
  return std::nullopt;
}

// Of body b against body a at the contact point, as the bodies move now.
Real3 relative_velocity(const World::Touch& touch, const Motion& a, const Motion& b) {
  const auto velocity = [&](const Motion& m) { return m.v_WB + cross(to_world(m.q_WB, m.w_WB_B), touch.x_m - m.p_WB); };
  return velocity(b) - velocity(a);
}

// The contacts of the last inner step: forces are its mean; the gap, found at its beginning, goes on with the velocity
// that the step ended with, as semi-implicit engines move their bodies.
std::vector<ContactSample> contacts_of(const World& world, const Stepper& stepper) {
  std::vector<ContactSample> contacts;
  const double h_s = stepper.inner_h_s();
  for (const auto& touch : world.touches()) {
    const Real3 u = relative_velocity(touch, stepper.motion(touch.body_a), stepper.motion(touch.body_b));
    contacts.push_back({touch.body_a, touch.body_b, touch.x_m, touch.normal, touch.gap_m + h_s * dot(u, touch.normal),
                        touch.impulse_n_N_s / h_s, (1 / h_s) * touch.impulse_t_N_s});
  }
  return contacts;
}

Sample sample_of(const Scene& scene, const Stepper& stepper, Wide t_s) {
  Sample sample;
  sample.t_s = t_s;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Motion m = stepper.motion(static_cast<int>(i));
    BodySample body;
    for (int k = 0; k < 3; ++k) {
      body.p_m[k] = m.p_WB[k];
      body.v_m_per_s[k] = m.v_WB[k];
      body.w_rad_per_s[k] = m.w_WB_B[k];
    }
    for (int k = 0; k < 4; ++k) body.q_wxyz[k] = m.q_WB[k];
    sample.bodies.push_back(body);
  }
  return sample;
}

// Impact events from contacts: a pair with an impulse in this step and none in the step before. Engines resolve the
// contacts found at the start of a step, therefore this is the time of the impact.
class ImpactLog {
 public:
  ImpactLog(const Scene& scene, const Observer& observer) : scene_(scene), observer_(observer) {}
  bool wanted() const { return static_cast<bool>(observer_.event); }
  void before(const Stepper& stepper) { before_ = motions(stepper); }
  void after(double t_s, const World& world, const Stepper& stepper) {
    std::map<std::pair<int, int>, Met> touching;
    for (const auto& touch : world.touches()) {
      if (touch.impulse_n_N_s > 0) touching[{touch.body_a, touch.body_b}].take(touch);
    }
    for (const auto& [pair, met] : touching) {
      if (last_.count(pair)) continue;
      Event event;
      event.t_s = t_s;
      event.body_a = pair.first;
      event.body_b = pair.second;
      for (int k = 0; k < 3; ++k) {
        event.x_m[k] = met.touch.x_m[k];
        event.normal[k] = met.touch.normal[k];
      }
      event.impulse_n_N_s = met.impulse_n_N_s;
      event.impulse_t_N_s = met.impulse_t_N_s;
      event.vn_before_m_per_s = normal_speed(met.touch, before_[pair.first], before_[pair.second]);
      event.vn_after_m_per_s = normal_speed(met.touch, stepper.motion(pair.first), stepper.motion(pair.second));
      observer_.event(event);
    }
    last_ = std::move(touching);
  }

 private:
  // The point with the largest impulse represents the pair.
  struct Met {
    World::Touch touch;
    double impulse_n_N_s = 0, impulse_t_N_s = 0;
    void take(const World::Touch& point) {
      if (point.impulse_n_N_s > touch.impulse_n_N_s) touch = point;
      impulse_n_N_s += point.impulse_n_N_s;
      impulse_t_N_s += length(point.impulse_t_N_s);
    }
  };
  std::vector<Motion> motions(const Stepper& stepper) const {
    std::vector<Motion> all;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) all.push_back(stepper.motion(static_cast<int>(i)));
    return all;
  }
  static double normal_speed(const World::Touch& touch, const Motion& a, const Motion& b) {
    return dot(relative_velocity(touch, a, b), touch.normal);
  }

  const Scene& scene_;
  const Observer& observer_;
  std::vector<Motion> before_;
  std::map<std::pair<int, int>, Met> last_;
};

// `given_by_dampers_J`: by those of joints that the adapter evaluates.
Outcome accuracy_pass(const WorldMaker& make, const Scene& scene, const Plan& plan, const Observer& observer,
                      std::int64_t substeps, double& given_by_dampers_J) {
  Outcome outcome;
  const auto world = make(scene, true);
  Stepper stepper(scene, plan, substeps, *world);
  ImpactLog impacts(scene, observer);
  const bool log = impacts.wanted() && shapes_matter(scene);
  const std::int64_t samples = plan.samples > 0 ? plan.samples : 1;
  const std::int64_t stride = plan.steps / samples;
  stepper.observe();
  if (observer.sample) {
    Sample sample = sample_of(scene, stepper, 0);
    sample.joints = stepper.joint_samples(0);
    sample.ropes = world->ropes();
    observer.sample(sample);
  }
  for (std::int64_t n = 0; n < plan.steps; ++n) {
    stepper.step(
        n,
        [&] {
          if (log) impacts.before(stepper);
        },
        [&](double t_s) {
          if (log) impacts.after(t_s, *world, stepper);
        });
    outcome.steps_taken = n + 1;
    given_by_dampers_J = stepper.given_by_dampers_J();
    if ((n + 1) % stride != 0) continue;
    if (const auto reason = not_finite(scene, stepper, n + 1)) {
      outcome.status = Status::not_finite;
      outcome.reason = *reason;
      return outcome;
    }
    const Wide t_s = Wide(plan.t_end_s) * Wide((n + 1) / stride) / Wide(samples);
    if (const std::string reason = world->broken(); !reason.empty()) {
      outcome.status = Status::diverged;
      outcome.reason = reason + " at t = " + format_double(static_cast<double>(t_s)) + " s";
      return outcome;
    }
    if (!observer.sample) continue;
    Sample sample = sample_of(scene, stepper, t_s);
    sample.contacts = contacts_of(*world, stepper);
    sample.joints = stepper.joint_samples(static_cast<double>(t_s));
    sample.ropes = world->ropes();
    observer.sample(sample);
  }
  outcome.rate_evaluations = std::max<std::int64_t>(0, world->rate_calls());
  return outcome;
}

// Building the worlds is not timed; the first run is a warm-up of caches and allocators.
Outcome timed_pass(const WorldMaker& make, const Scene& scene, const Plan& plan, int repeats, std::int64_t substeps) {
  return timed_passes(repeats, [&](std::chrono::nanoseconds& busy) {
    Outcome outcome;
    outcome.steps_taken = plan.steps;
    const auto world = make(scene, false);
    Stepper stepper(scene, plan, substeps, *world);
    const auto start = std::chrono::steady_clock::now();
    for (std::int64_t n = 0; n < plan.steps; ++n)
      stepper.step(
          n, [] {}, [](double) {});
    busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start);
    outcome.rate_evaluations = std::max<std::int64_t>(0, world->rate_calls());
    if (const auto reason = not_finite(scene, stepper, plan.steps)) {
      outcome.status = Status::not_finite;
      outcome.reason = *reason;
    }
    return outcome;
  });
}

// One run, the clock read around every step of the plan.
Outcome profile_pass(const WorldMaker& make, const Scene& scene, const Plan& plan, std::int64_t substeps,
                     Profile& profile) {
  Outcome outcome;
  const auto world = make(scene, false);
  Stepper stepper(scene, plan, substeps, *world);
  profile.step_ns.clear();
  profile.step_ns.reserve(static_cast<std::size_t>(plan.steps));
  auto before = std::chrono::steady_clock::now();
  for (std::int64_t n = 0; n < plan.steps; ++n) {
    stepper.step(
        n, [] {}, [](double) {});
    const auto after = std::chrono::steady_clock::now();
    profile.step_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(after - before).count());
    before = after;
  }
  outcome.steps_taken = plan.steps;
  if (const auto reason = not_finite(scene, stepper, plan.steps)) {
    outcome.status = Status::not_finite;
    outcome.reason = *reason;
  }
  return outcome;
}

double longest_step_s(const Plan& plan) {
  if (plan.frame_ends_s.empty()) return plan.t_end_s / static_cast<double>(plan.steps);
  double longest_s = 0;
  for (std::int64_t n = 0; n < plan.steps; ++n)
    longest_s = std::max(longest_s, step_begin_s<double>(plan, n + 1) - step_begin_s<double>(plan, n));
  return longest_s;
}

}  // namespace

Outcome run_world(const WorldMaker& make, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
                  std::int64_t substeps) {
  bool joint_forces_outside = false, forces_outside = false;
  const WorldMaker watched = [&](const Scene& s, bool observe) {
    auto world = make(s, observe);
    joint_forces_outside = !s.joint_forces.empty() && !world->joint_forces_inside();
    forces_outside = !s.forces.empty() && world->rate_calls() < 0;
    return world;
  };
  double given_by_dampers_J = 0;
  Outcome outcome = observer.profile ? profile_pass(watched, scene, plan, substeps, *observer.profile)
                    : repeats > 0    ? timed_pass(watched, scene, plan, repeats, substeps)
                                     : accuracy_pass(watched, scene, plan, observer, substeps, given_by_dampers_J);
  std::string names = names_of_forces(scene);
  if (joint_forces_outside) names += (names.empty() ? "" : ", ") + names_of_joint_forces(scene);
  if (!names.empty()) {
    const bool at_each_rate_call = outcome.rate_evaluations > 0;
    if (!at_each_rate_call) outcome.rate_evaluations = outcome.steps_taken * substeps;
    if (outcome.status == Status::ok) {
      outcome.reason = std::string("forces evaluated by the adapter ") +
                       (at_each_rate_call ? "at every rate call: " : "once a step: ") + names;
    }
  }
  if (joint_forces_outside || forces_outside) {
    const std::string beyond = beyond_explicit_dampers(explicit_dampers(scene, joint_forces_outside, forces_outside),
                                                       longest_step_s(plan) / static_cast<double>(substeps));
    if (!beyond.empty()) {
      if (outcome.status == Status::ok && given_by_dampers_J > 0) {
        outcome.status = Status::diverged;
        outcome.reason =
            "the dampers of joints gave " + format_double(given_by_dampers_J) + " J, and can only take energy";
      }
      outcome.reason += (outcome.reason.empty() ? "" : "; ") + beyond;
    }
  }
  return outcome;
}

}  // namespace atwood::rivals
