#include "math/dual.hpp"  // before templates that use it

#include "joints/joint_forces.hpp"

#include <algorithm>
#include <cmath>

#include "joints/tree.hpp"

namespace atwood {
namespace {

// The coordinate and the rate of a joint at (t, y), with prescribed motion where it is driven.
template <class S> S coordinate_of(const Link<S>& link, int k, S t_s, const S* y) {
  return link.driven ? link.driven_start + t_s * link.driven_rate : y[link.at_q + k];
}
template <class S> S rate_of(const Link<S>& link, int k, const S* y) {
  return link.driven ? link.driven_rate : y[link.at_u + k];
}

}  // namespace

template <class S> JointForces<S>::JointForces(const Scene& scene) {
  const auto closes_loop = [&](int joint) { return scene.joints[static_cast<std::size_t>(joint)].closes_loop; };
  for (const JointForce& force : scene.joint_forces) {
    if (std::visit([&](const auto& f) { return closes_loop(f.joint); }, force)) continue;
    if (const auto* spring = std::get_if<JointSpring>(&force)) {
      springs_.push_back(
          {spring->joint, spring->coordinate, S(spring->stiffness), S(spring->rest), S(spring->damping)});
      continue;
    }
    const auto& motor = std::get<JointTorque>(force);
    torques_.push_back({motor.joint, motor.coordinate, S(motor.torque), S(motor.angular_frequency_rad_per_s),
                        S(motor.phase_rad), motor.on_s});
    for (const Interval& on : motor.on_s)
      for (const double t : {on.from_s, on.to_s})
        if (t > 0 && std::isfinite(t)) switch_times_s_.push_back(t);
  }
}

template <class S> void JointForces<S>::select(double middle_s) {
  for (TorqueForce& motor : torques_)
    motor.on = motor.on_s.empty() || std::any_of(motor.on_s.begin(), motor.on_s.end(), [&](const Interval& i) {
                 return i.from_s <= middle_s && middle_s < i.to_s;
               });
}

template <class S> void JointForces<S>::add(const Tree<S>& tree, S t_s, const S* y, S* applied) const {
  for (const SpringForce& spring : springs_) {
    const Link<S>& link = tree.links()[tree.link_of_joint(spring.joint)];
    S* along = applied + link.first_rate;
    if (link.kind == JointKind::ball) {
      for (int k = 0; k < 3; ++k) along[k] -= spring.damping * y[link.at_u + k];
      continue;
    }
    const int k = spring.coordinate;
    along[k] -=
        spring.stiffness * (coordinate_of(link, k, t_s, y) - spring.rest) + spring.damping * rate_of(link, k, y);
  }
  for (const TorqueForce& motor : torques_) {
    if (!motor.on) continue;
    const Link<S>& link = tree.links()[tree.link_of_joint(motor.joint)];
    const S angle = motor.frequency * t_s + motor.phase;
    applied[link.first_rate + motor.coordinate] += angle == S(0) ? motor.torque : motor.torque * real::cos(angle);
  }
}

template <class S> S JointForces<S>::potential_energy(const Tree<S>& tree, const S* y) const {
  S energy = S(0);
  for (const SpringForce& spring : springs_) {
    const Link<S>& link = tree.links()[tree.link_of_joint(spring.joint)];
    if (link.kind == JointKind::ball) continue;
    const S stretch = y[link.at_q + spring.coordinate] - spring.rest;
    energy += spring.stiffness * stretch * stretch / S(2);
  }
  return energy;
}

template class JointForces<float>;
template class JointForces<double>;
template class JointForces<long double>;
template class JointForces<Quad>;
template class JointForces<Dual<double>>;

}  // namespace atwood
