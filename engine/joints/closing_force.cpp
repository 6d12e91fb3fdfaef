#include "joints/closing_force.hpp"

#include <algorithm>

#include "forces/lanes.hpp"

namespace atwood {
namespace {

template <class S> Vec3<S> direction(const Real3& axis) {
  const Vec3<S> a = narrow3<S>(axis);
  return (S(1) / norm(a)) * a;
}

template <class S, class B> TiedBody<S> tied_body(const B& body, int lane) {
  const Quat<S> q_WB = body.q_WB(lane);
  return {body.p_WB(lane), q_WB, body.v_WB(lane), rotate(q_WB, body.w_WB_B(lane))};
}

template <class S, class L> void add_wrench(const L& load, int lane, const Quat<S>& q_WB, const Wrench<S>& wrench) {
  load.force_W(lane) += wrench.force;
  load.torque_B(lane) += rotate_back(q_WB, wrench.torque);
}

}  // namespace

template <class S> ClosingForce<S>::ClosingForce(const JointForce& force, const Scene& scene) {
  std::visit([&](const auto& f) { joint_ = f.joint, coordinate_ = f.coordinate; }, force);
  of_ = scene.joints[static_cast<std::size_t>(joint_)];
  for (int k = 0; k < 4; ++k) last_.q[k] = S(of_.coordinates[k]);
  for (int k = 0; k < 3; ++k) last_.u[k] = S(of_.rates[k]);
  if (const auto* spring = std::get_if<JointSpring>(&force)) {
    stiffness_ = S(spring->stiffness), rest_ = S(spring->rest), damping_ = S(spring->damping);
    return;
  }
  const auto& motor = std::get<JointTorque>(force);
  torque_ = S(motor.torque), frequency_ = S(motor.angular_frequency_rad_per_s), phase_ = S(motor.phase_rad);
  this->on_s = motor.on_s;
}

template <class S> std::array<S, 3> ClosingForce<S>::along_rates(const JointState& at) const {
  std::array<S, 3> along{};
  if (of_.kind == JointKind::ball) {
    for (int k = 0; k < 3; ++k) along[k] = -damping_ * at.u[k];
    return along;
  }
  const S angle = frequency_ * at.t_s + phase_;
  const S motor = angle == S(0) ? torque_ : torque_ * real::cos(angle);
  along[coordinate_] = motor - (stiffness_ * (at.q[coordinate_] - rest_) + damping_ * at.u[coordinate_]);
  return along;
}

template <class S>
auto ClosingForce<S>::state_at(S t_s, const TiedBody<S>& parent, const TiedBody<S>& child) const -> JointState {
  JointState now = last_;
  now.t_s = t_s;
  coordinates_of(of_, parent, child, now.q.data(), now.u.data());
  if (of_.kind == JointKind::ball || stiffness_ == S(0)) return now;
  const S expected = last_.q[coordinate_] + (t_s - last_.t_s) * (last_.u[coordinate_] + now.u[coordinate_]) / S(2);
  if (real::abs(expected - now.q[coordinate_]) > S(3)) {  // nearly half a turn; an offset is found again as it was
    now.q[coordinate_] = expected;
    coordinates_of(of_, parent, child, now.q.data(), now.u.data());
  }
  return now;
}

// Its force acts through the parent's anchor; world axes.
template <class S>
Wrench<S> ClosingForce<S>::on_child(const std::array<S, 3>& along, const Quat<S>& q_parent,
                                    const Quat<S>& q_child) const {
  if (of_.kind == JointKind::ball) return {{}, rotate(q_child, Vec3<S>{along[0], along[1], along[2]})};
  if (of_.kind == JointKind::universal) {
    const Vec3<S> first = rotate(q_parent, direction<S>(of_.axes_body[0]));
    const Vec3<S> second = rotate(q_child, direction<S>(of_.axes_body[1]));
    const S c = dot(first, second), inverse = S(1) / (S(1) - c * c);
    return {{}, inverse * (along[0] * (first - c * second) + along[1] * (second - c * first))};
  }
  const Vec3<S> size = along[coordinate_] * rotate(q_child, direction<S>(of_.axis_body));
  const bool slides = of_.kind == JointKind::slider || coordinate_ == 1;
  return slides ? Wrench<S>{size, {}} : Wrench<S>{{}, size};
}

template <class S>
template <class M, class L>
void ClosingForce<S>::add(const M& motion, const L& loads, int lane) const {
  const bool from_body = of_.parent >= 0;
  const TiedBody<S> child = tied_body<S>(motion.body(of_.child), lane);
  const TiedBody<S> parent = from_body ? tied_body<S>(motion.body(of_.parent), lane) : TiedBody<S>{};
  const Wrench<S> wrench = on_child(along_rates(state_at(motion.t_s[lane], parent, child)), parent.q_WB, child.q_WB);
  // From the centres of mass of parent and child to the parent's anchor.
  const Vec3<S> from_parent = rotate(parent.q_WB, narrow3<S>(of_.anchors_body_m[0]));
  const Vec3<S> from_child = (parent.p_WB - child.p_WB) + from_parent;
  add_wrench(loads.body(of_.child), lane, child.q_WB,
             Wrench<S>{wrench.force, wrench.torque + cross(from_child, wrench.force)});
  if (from_body)
    add_wrench(loads.body(of_.parent), lane, parent.q_WB,
               Wrench<S>{-wrench.force, -(wrench.torque + cross(from_parent, wrench.force))});
}

template <class S> void ClosingForce<S>::add_loads(const Motion<S>& motion, Load<S>* loads) const {
  add(OneMotion<S>{motion, &motion.t_s}, OneLoads<S>{loads}, 0);
}

template <class S> void ClosingForce<S>::add_lane_loads(const LaneMotion<S>& motion, S* loads) const {
  for (int lane = 0; lane < motion.count; ++lane) add(MotionLanes<S>{motion, motion.t_s}, LoadsLanes<S>{loads}, lane);
}

template <class S> S ClosingForce<S>::potential_energy(const Motion<S>& motion) const {
  if (stiffness_ == S(0) || of_.kind == JointKind::ball) return S(0);
  const OneMotion<S> one{motion, &motion.t_s};
  const TiedBody<S> parent = of_.parent < 0 ? TiedBody<S>{} : tied_body<S>(one.body(of_.parent), 0);
  const S stretch = state_at(last_.t_s, parent, tied_body<S>(one.body(of_.child), 0)).q[coordinate_] - rest_;
  return stiffness_ * stretch * stretch / S(2);
}

template class ClosingForce<float>;
template class ClosingForce<double>;
template class ClosingForce<long double>;
template class ClosingForce<Quad>;

}  // namespace atwood
