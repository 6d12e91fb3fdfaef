#include "closed_form/joint_bars.hpp"

namespace atwood::closed_form {

namespace {

const Wide kNotReported = std::numeric_limits<double>::quiet_NaN();

template <class A, class B> void include(Spread& of, const A& wide, const B& narrow, int count) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    of.include(std::array<Wide, 1>{wide[i]}, std::array<Narrow, 1>{narrow[i]});
}

template <class A> void fill(A& bars, const Spread& of, double safety, int count) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) bars[i] = of.bar(safety);
}

bool is_angle(JointKind kind, int coordinate) {
  return kind == JointKind::hinge || kind == JointKind::universal || kind == JointKind::ball ||
         (kind == JointKind::cylindrical && coordinate == 0);
}

// Components that not all evaluations determine are left out: the value and its bar are NaN.
void include_reaction(Spread& of, const Vec<Wide>& wide, const std::vector<const Vec<Narrow>*>& narrow,
                      std::array<Wide, 3>& value, std::array<bool, 3>& known) {
  for (std::size_t i = 0; i < 3; ++i) {
    known[i] = is_finite(wide[i]);
    for (const Vec<Narrow>* each : narrow) known[i] = known[i] && is_finite((*each)[i]);
    value[i] = known[i] ? wide[i] : kNotReported;
    if (!known[i]) continue;
    for (const Vec<Narrow>* each : narrow) of.include(std::array<Wide, 1>{wide[i]}, std::array<Narrow, 1>{(*each)[i]});
  }
}

}  // namespace

JointBars::JointBars(const Scene& scene, double safety, bool loops)
    : scene_(scene), safety_(safety), loops_(loops), joints_(scene.joints.size()), ropes_(scene.ropes.size()) {}

void JointBars::add_joint(std::size_t k, std::size_t j, const Motion<Wide>& wide,
                          const std::vector<Motion<Narrow>>& narrow, const MotionScales& scales, JointSample& value,
                          JointSample& bar) {
  const JointState<Wide>& w = wide.joints[k][j];
  const JointKind kind = scene_.joints[j].kind;
  const int coordinates = coordinate_count(kind), rates = rate_count(kind);
  Spreads& of = joints_[j];
  std::vector<const Vec<Narrow>*> forces, torques;
  for (const Motion<Narrow>& realisation : narrow) {
    const JointState<Narrow>& n = realisation.joints[k][j];
    include(of.q, w.q, n.q, coordinates);
    include(of.u, w.u, n.u, rates);
    include(of.applied, w.applied, n.applied, rates);
    of.stop.include(std::array<Wide, 1>{w.stop}, std::array<Narrow, 1>{n.stop});
    forces.push_back(&n.force_N);
    torques.push_back(&n.torque_N_m);
    value.not_unique |= n.not_unique;
  }
  value.q = w.q;
  value.u = w.u;
  value.applied = w.applied;
  value.stop = {w.stop, 0, 0};
  value.not_unique |= w.not_unique;
  // At rest at a stop its force is taken out of the reaction, and what is left may be round-off of weight and motor.
  if (const Joint& joint = scene_.joints[j]; joint.limits) {
    const Wide weight =
        Wide(scene_.bodies[static_cast<std::size_t>(joint.child)].mass_kg) * norm(vec<Wide>(scene_.gravity_m_per_s2));
    const Wide arm = norm(vec<Wide>(joint.anchors_body_m[1])), applied = of.applied.scale;
    of.force.scale = larger(of.force.scale, weight + applied);
    of.torque.scale = larger(of.torque.scale, weight * arm + applied * (kind == JointKind::slider ? arm : Wide(1)));
  }
  std::array<bool, 3> known_force{}, known_torque{};
  include_reaction(of.force, w.force_N, forces, value.force_N, known_force);
  include_reaction(of.torque, w.torque_N_m, torques, value.torque_N_m, known_torque);
  for (int c = 0; loops_ && c < rates; ++c) {
    const bool angle = is_angle(kind, c);
    of.q.scale = larger(of.q.scale, angle ? Wide(1) : scales.place_m);
    of.u.scale = larger(of.u.scale, angle ? scales.rate_rad_per_s : scales.speed_m_per_s);
  }
  fill(bar.q, of.q, safety_, coordinates);
  fill(bar.u, of.u, safety_, rates);
  fill(bar.applied, of.applied, safety_, rates);
  bar.stop = {of.stop.bar(safety_), 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    bar.force_N[i] = known_force[i] ? of.force.bar(safety_) : kNotReported;
    bar.torque_N_m[i] = known_torque[i] ? of.torque.bar(safety_) : kNotReported;
  }
}

std::string JointBars::add(std::size_t k, const Motion<Wide>& wide, const std::vector<Motion<Narrow>>& narrow,
                           const MotionScales& scales, Sample& value, Sample& bar) {
  if (!wide.joints.empty())
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      add_joint(k, j, wide, narrow, scales, value.joints.emplace_back(), bar.joints.emplace_back());
      const Spreads& of = joints_[j];
      const Wide size = is_angle(scene_.joints[j].kind, 0) ? Wide(1) : of.q.scale,
                 noise = 1024 * unit_round_off<Narrow>() / kMeasureLimit;
      if (k > 0 &&
          (!of.q.is_measure(of.u.scale * value.t_s + noise * size) || !of.u.is_measure(of.u.scale + noise * size)))
        return scene_.joints[j].name;
    }
  if (wide.ropes.empty()) return "";
  for (std::size_t r = 0; r < ropes_.size(); ++r) {
    const RopeState<Wide>& w = wide.ropes[k][r];
    auto& [tension, angle] = ropes_[r];
    for (const Motion<Narrow>& realisation : narrow) {
      const RopeState<Narrow>& n = realisation.ropes[k][r];
      tension.include(std::array<Wide, 1>{w.tension_N}, std::array<Narrow, 1>{n.tension_N});
      for (std::size_t i = 0; i < w.pulley_angle_rad.size(); ++i)
        angle.include(std::array<Wide, 1>{w.pulley_angle_rad[i]}, std::array<Narrow, 1>{n.pulley_angle_rad[i]});
    }
    value.ropes.push_back({w.tension_N, w.pulley_angle_rad});
    bar.ropes.push_back({tension.bar(safety_), std::vector<Wide>(w.pulley_angle_rad.size(), angle.bar(safety_))});
    if (!tension.is_measure(tension.scale)) return scene_.ropes[r].name;
  }
  return "";
}

void add_stop_jump(const Scene& scene, const ContactEvent<Wide>& at, const SampleReference& value,
                   const SampleReference& bar) {
  const Wide jump = magnitude(at.vn_after_m_per_s - at.vn_before_m_per_s);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.child != at.body_b) continue;
    bar.joints[j].u[0] += jump;
    for (auto* values : {&value.joints[j].force_N, &value.joints[j].torque_N_m, &value.joints[j].stop,
                         &bar.joints[j].force_N, &bar.joints[j].torque_N_m, &bar.joints[j].stop})
      values->fill(kNotReported);
    const auto child = static_cast<std::size_t>(joint.child);
    const bool turns = joint.kind == JointKind::hinge;
    const Wide lever = turns ? norm(vec<Wide>(joint.anchors_body_m[1])) : Wide(1);
    for (Wide& v : bar.bodies[child].v_m_per_s) v += jump * lever;
    if (turns)
      for (Wide& w : bar.bodies[child].w_rad_per_s) w += jump;
  }
}

}  // namespace atwood::closed_form
