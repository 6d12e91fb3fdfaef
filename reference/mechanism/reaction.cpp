#include "mechanism/reaction.hpp"

#include <algorithm>

namespace atwood::mechanism {

template <class S>
void add_applied(const Model<S>& model, int joint, const std::vector<Motion<S>>& now, const StepChoice& choice,
                 const S& t_s, std::vector<Wrench<S>>& loads) {
  const auto acts = [&](const JointForce& force) {
    return std::visit([&](const auto& f) { return f.joint == joint; }, force);
  };
  if (std::none_of(model.scene->joint_forces.begin(), model.scene->joint_forces.end(), acts)) return;
  const auto q = coordinates(model, joint, now, choice.memory);
  const auto u = rates(model, joint, now);
  const auto along = applied(model, joint, q, u, t_s, choice.interval_s);
  const std::vector<Row<S>> rows = rate_rows(model, joint, now);
  for (std::size_t k = 0; k < rows.size(); ++k) add_load(rows[k], along[k], loads);
}

template <class S>
void fill_joints(const Model<S>& model, const std::vector<Motion<S>>& now, const StepChoice& choice, const S& t_s,
                 Sample& sample) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const int joint = static_cast<int>(j);
    const auto q = coordinates(model, joint, now, choice.memory);
    const auto u = rates(model, joint, now);
    const auto along = applied(model, joint, q, u, t_s, choice.interval_s);
    JointSample& made = sample.joints.emplace_back();
    std::copy(q.begin(), q.end(), made.q.begin());
    std::copy(u.begin(), u.end(), made.u.begin());
    std::copy(along.begin(), along.end(), made.applied.begin());
    made.stop = {};
  }
  sample.ropes.resize(model.ropes.size());
}

template <class S>
void set_reaction(const Model<S>& model, int joint, const std::vector<Motion<S>>& now, const Wrench<S>& on_child,
                  JointSample& sample) {
  const JointModel<S>& of = model.joints[joint];
  const Triple<S> r = rotate(now[of.child].q, of.anchor_child);
  const Triple<S> torque = on_child.torque - cross(r, on_child.force);
  std::copy(on_child.force.begin(), on_child.force.end(), sample.force_N.begin());
  std::copy(torque.begin(), torque.end(), sample.torque_N_m.begin());
}

// The rope's way from the first body to the last turns every pulley: by the length that left the first side, over r.
template <class S>
void fill_pulleys(const Model<S>& model, int rope, const std::vector<Motion<S>>& now, const Memory& memory,
                  RopeSample& sample) {
  const RopeModel<S>& of = model.ropes[rope];
  const std::vector<Pulley>& over = model.scene->ropes[rope].over;
  const S way = over.empty() ? S(0) : of.length_a - rope_lengths(model, rope, now, memory)[0];
  sample.pulley_angle_rad.clear();
  for (std::size_t k = 0; k < over.size(); ++k)
    sample.pulley_angle_rad.push_back(Wide(over[k].angle_rad) +
                                      (of.radii[k] > 0 ? static_cast<Wide>(way / of.radii[k]) : Wide(0)));
}

template <class S>
void mark_open_components(const Model<S>& model, const std::vector<Motion<S>>& now, const std::vector<Row<S>>& rows,
                          const std::vector<S>& null, std::vector<JointSample>& joints) {
  std::vector<Wrench<S>> on_child(model.joints.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (const int j = rows[i].joint; j >= 0) {
      on_child[j].force += null[i] * rows[i].lb;
      on_child[j].torque += null[i] * rows[i].ab;
    }
  S largest{};
  std::vector<JointSample> open(model.joints.size());
  for (std::size_t j = 0; j < open.size(); ++j) {
    set_reaction(model, static_cast<int>(j), now, on_child[j], open[j]);
    for (int k = 0; k < 3; ++k)
      largest = std::max({largest, dynamics::magnitude(static_cast<S>(open[j].force_N[k])),
                          dynamics::magnitude(static_cast<S>(open[j].torque_N_m[k]))});
  }
  const S least = S(1e-10) * largest;  // others are of the size of round-off
  for (std::size_t j = 0; j < open.size(); ++j)
    for (int k = 0; k < 3; ++k) {
      if (dynamics::magnitude(static_cast<S>(open[j].force_N[k])) > least) joints[j].not_unique |= 1u << k;
      if (dynamics::magnitude(static_cast<S>(open[j].torque_N_m[k])) > least) joints[j].not_unique |= 8u << k;
    }
}

#define ATWOOD_REACTION(S)                                                                                         \
  template void add_applied(const Model<S>&, int, const std::vector<Motion<S>>&, const StepChoice&, const S&,      \
                            std::vector<Wrench<S>>&);                                                              \
  template void fill_joints(const Model<S>&, const std::vector<Motion<S>>&, const StepChoice&, const S&, Sample&); \
  template void set_reaction(const Model<S>&, int, const std::vector<Motion<S>>&, const Wrench<S>&, JointSample&); \
  template void fill_pulleys(const Model<S>&, int, const std::vector<Motion<S>>&, const Memory&, RopeSample&);     \
  template void mark_open_components(const Model<S>&, const std::vector<Motion<S>>&, const std::vector<Row<S>>&,   \
                                     const std::vector<S>&, std::vector<JointSample>&);
ATWOOD_REACTION(double)
ATWOOD_REACTION(long double)
ATWOOD_REACTION(__float128)
#undef ATWOOD_REACTION

}  // namespace atwood::mechanism
