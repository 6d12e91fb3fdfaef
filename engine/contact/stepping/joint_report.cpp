// What a run of "+impulse" reports of its joints: coordinates, rates, and the mean over the step of what acts at them.
#include "contact/stepping/mechanisms.hpp"

#include <cmath>
#include <limits>

namespace atwood::stepping {
namespace {

template <class S> std::array<Wide, 3> wide(const Vec3<S>& v) { return {Wide(v.x), Wide(v.y), Wide(v.z)}; }

// Marks the components of reactions that another distribution of the impulses could change without changing a motion:
// the null vectors of G^T, one for each equation that depends on others.
template <class S> void mark_open_components(World<S>& world, Mechanism<S>& mechanism, Sample& sample) {
  TiedBodies<S>& tied = *world.tied;
  factor_rows(world, mechanism, S(0), false);
  const int rank = mechanism.qr.rank(), columns = mechanism.qr.columns();
  std::vector<S> w(static_cast<std::size_t>(rank));
  std::vector<Wrench<S>> wrench(tied.joints.size());
  for (int j = rank; j < columns; ++j) {
    mechanism.qr.dependence(j, w.data());
    for (const int at : mechanism.joints) wrench[static_cast<std::size_t>(at)] = {};
    S largest{};
    for (int k = 0; k <= rank; ++k) {
      const TiedRow<S>& row = mechanism.rows[static_cast<std::size_t>(mechanism.qr.equation(k < rank ? k : j))];
      const S share = (k < rank ? -w[static_cast<std::size_t>(k)] : S(1)) * row.scale;
      const TiedBody<S> child = tied_body(world, row.body[1], S(0));
      const Vec3<S> arm = rotate(child.q_WB, tied.joints[static_cast<std::size_t>(row.joint)].constraint.anchor[1]);
      Wrench<S>& sum = wrench[static_cast<std::size_t>(row.joint)];
      sum.force += share * row.on[1].force;
      sum.torque += share * (row.on[1].torque - cross(arm, row.on[1].force));
    }
    const S size = tied.size_m > S(0) ? tied.size_m : S(1);
    for (const int at : mechanism.joints)
      largest = real::max(largest, real::max(norm(wrench[static_cast<std::size_t>(at)].force),
                                             norm(wrench[static_cast<std::size_t>(at)].torque) / size));
    for (const int at : mechanism.joints) {
      const Wrench<S>& of = wrench[static_cast<std::size_t>(at)];
      const S open[6] = {of.force.x,         of.force.y,         of.force.z,
                         of.torque.x / size, of.torque.y / size, of.torque.z / size};
      for (unsigned c = 0; c < 6; ++c)
        if (real::abs(open[c]) > S(1e-4) * largest) sample.joints[static_cast<std::size_t>(at)].not_unique |= 1u << c;
    }
  }
}

}  // namespace

template <class S> void clear_joint_sums(World<S>& world) {
  for (TiedJoint<S>& joint : world.tied->joints) {
    joint.force = joint.torque = {};
    for (S& applied : joint.applied) applied = S(0);
    joint.stop = S(0);
  }
}

template <class S> void report_joints(World<S>& world, S h_s, Sample& sample) {
  sample.joints.assign(world.tied->joints.size(), JointSample{});
  for (std::size_t j = 0; j < sample.joints.size(); ++j) {
    const TiedJoint<S>& joint = world.tied->joints[j];
    const JointKind kind = world.scene->joints[j].kind;
    JointSample& out = sample.joints[j];
    for (int k = 0; k < coordinate_count(kind); ++k) out.q[k] = joint.q[k];
    for (int k = 0; k < rate_count(kind); ++k) out.u[k] = joint.u[k];
    if (!(h_s > S(0))) {
      const Wide none = std::numeric_limits<double>::quiet_NaN();
      out.force_N = out.torque_N_m = out.applied = {none, none, none};
      continue;
    }
    out.force_N = wide((S(1) / h_s) * joint.force);
    out.torque_N_m = wide((S(1) / h_s) * joint.torque);
    for (int k = 0; k < rate_count(kind); ++k) out.applied[k] = joint.applied[k] / h_s;
    out.stop = {joint.stop / h_s, 0, 0};
  }
  if (!(h_s > S(0))) return;
  for (Mechanism<S>& mechanism : world.tied->mechanisms) mark_open_components(world, mechanism, sample);
}

#define ATWOOD_JOINT_REPORT(S)                  \
  template void clear_joint_sums<S>(World<S>&); \
  template void report_joints<S>(World<S>&, S, Sample&);
ATWOOD_JOINT_REPORT(float)
ATWOOD_JOINT_REPORT(double)
#undef ATWOOD_JOINT_REPORT

}  // namespace atwood::stepping
