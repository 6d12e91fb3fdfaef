// The links of a scene: their order, their constants, their places in the state.
#include "math/dual.hpp"  // before templates that use it

#include "joints/tree.hpp"

namespace atwood {
namespace {

template <class S> Quat<S> unit_quaternion(const std::array<double, 4>& q) {
  return normalised(Quat<S>{S(q[0]), S(q[1]), S(q[2]), S(q[3])});
}

// Of length 1 to round-off of double; normalised again in S.
template <class S> Vec3<S> unit_vector(const std::array<double, 3>& a) {
  const Vec3<S> v = narrow3<S>(a);
  return (S(1) / norm(v)) * v;
}

template <class S> Sym3<S> symmetric(const Real33& I) { return {S(I[0]), S(I[1]), S(I[2]), S(I[4]), S(I[5]), S(I[8])}; }

std::string joint_fault(const Scene& scene) {
  std::vector<char> placed(scene.bodies.size(), 0);
  for (const Joint& joint : scene.joints) {
    if (joint.closes_loop) continue;
    const Body& child = scene.bodies[joint.child];
    const std::string named = "joint `" + joint.name + "`";
    if (child.fixed) return named + " moves `" + child.name + "`, which is fixed";
    if (placed[joint.child]++) return "body `" + child.name + "` is placed by two joints";
    if (child.release_s > 0) return "release_s is not supported for bodies on joints: `" + child.name + "`";
    for (const int body : {joint.parent, joint.child})
      if (body >= 0 && !scene.bodies[body].fixed && !rotates(scene.bodies[body]))
        return named + " ties the point mass `" + scene.bodies[body].name + "`: a body on a joint needs an inertia";
  }
  return "";
}

}  // namespace

template <class S>
Tree<S>::Tree(const Scene& scene, const std::vector<int>& offsets, int first_free)
    : refusal_(joint_fault(scene)), link_of_body_(scene.bodies.size(), -1), link_of_joint_(scene.joints.size(), -1),
      state_end_(first_free) {
  if (!refusal_.empty()) return;
  for (const Body& body : scene.bodies)
    resting_.push_back({narrow3<S>(body.position_m), unit_quaternion<S>(body.orientation_wxyz)});
  order_links(scene, offsets);
  lay_out(scene, first_free);
  motion_.resize(links_.size());
  articulated_.resize(links_.size());
  response_.resize(links_.size());
  held_.assign(links_.size(), 0);
  columns_.resize(state_of_rate_.size());
}

// Depth first from the free bodies and the joints on bodies at rest, so that a chain's links are neighbours.
template <class S> void Tree<S>::order_links(const Scene& scene, const std::vector<int>& offsets) {
  const int bodies = static_cast<int>(scene.bodies.size());
  std::vector<std::vector<int>> joints_of(scene.bodies.size() + 1);  // by parent; the last: the world
  std::vector<char> placed(scene.bodies.size(), 0);
  for (int j = static_cast<int>(scene.joints.size()) - 1; j >= 0; --j) {
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop) continue;
    placed[joint.child] = 1;
    joints_of[joint.parent < 0 ? bodies : joint.parent].push_back(j);
  }
  struct Visit {
    int body, joint;
  };
  std::vector<Visit> open;
  const auto open_joints_of = [&](int body) {
    for (const int j : joints_of[body]) open.push_back({scene.joints[j].child, j});
  };
  const auto follow = [&] {
    while (!open.empty()) {
      const Visit visit = open.back();
      open.pop_back();
      Link<S> link;
      link.body = visit.body;
      link.joint = visit.joint;
      link.rotates = atwood::rotates(scene.bodies[visit.body]);
      link_of_body_[visit.body] = static_cast<int>(links_.size());
      if (visit.joint >= 0) {
        link_of_joint_[visit.joint] = static_cast<int>(links_.size());
        set_joint(scene, scene.joints[visit.joint], link);
      } else {
        link.at_q = offsets[visit.body];
      }
      link.mass_kg = S(scene.bodies[visit.body].mass_kg);
      link.J_B = symmetric<S>(scene.bodies[visit.body].inertia_kg_m2);
      add_outer(link.J_B, -link.mass_kg, link.to_centre_B);
      const S moment = link.mass_kg * dot(link.to_centre_B, link.to_centre_B);
      link.J_B += {moment, S(0), S(0), moment, S(0), moment};
      links_.push_back(link);
      open_joints_of(visit.body);
    }
  };
  open_joints_of(bodies);
  follow();
  for (int i = 0; i < bodies; ++i) {
    if (placed[i]) continue;
    if (scene.bodies[i].fixed) open_joints_of(i);
    else open.push_back({i, -1});
    follow();
  }
  for (int i = 0; i < bodies; ++i)
    if (placed[i] && link_of_body_[i] < 0)
      refusal_ =
          "the joints of body `" + scene.bodies[i].name + "` lead back to it: no joint may close a cycle unnamed";
}

template <class S> void Tree<S>::set_joint(const Scene& scene, const Joint& joint, Link<S>& link) {
  link.kind = joint.kind;
  link.parent = joint.parent < 0 ? -1 : link_of_body_[joint.parent];
  link.root_body = link.parent < 0 ? joint.parent : -1;
  // The reference points are anchors, so the way from the parent's to the child's runs from anchor to anchor.
  link.from_parent_P = narrow3<S>(joint.anchors_body_m[0]);
  if (link.parent >= 0 && links_[link.parent].joint >= 0) link.from_parent_P += links_[link.parent].to_centre_B;
  link.to_centre_B = -narrow3<S>(joint.anchors_body_m[1]);
  link.frame = unit_quaternion<S>(joint.frame_wxyz);
  const bool one_axis =
      joint.kind == JointKind::hinge || joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical;
  if (one_axis) link.axis_B = unit_vector<S>(joint.axis_body);
  if (joint.kind == JointKind::universal) {
    link.axis_P = unit_vector<S>(joint.axes_body[0]);
    link.axis_B = unit_vector<S>(joint.axes_body[1]);
  }
  link.frame_axis = link.frame * Quat<S>{S(0), link.axis_B.x, link.axis_B.y, link.axis_B.z};
  link.driven = joint.driven_rate.has_value();
  if (link.driven) {
    link.driven_start = S(joint.coordinates[0]);
    link.driven_rate = S(*joint.driven_rate);
    if (joint.kind != JointKind::hinge && joint.kind != JointKind::slider)
      refusal_ = "joint `" + joint.name + "` is driven, which only a hinge or a slider can be";
  }
  if (link.root_body >= 0) {
    const Body& root = scene.bodies[link.root_body];
    if (root.velocity_m_per_s != Real3{} || root.angular_velocity_body_rad_per_s != Real3{})
      refusal_ = "a joint cannot be attached to a fixed body that moves: `" + root.name + "` has a velocity";
  }
}

// Coordinates in the order of the scene's joints, rates of generalised vectors in the order of the links.
template <class S> void Tree<S>::lay_out(const Scene& scene, int first_free) {
  const auto has_place = [&](std::size_t j, bool ball) {
    return link_of_joint_[j] >= 0 && (scene.joints[j].kind == JointKind::ball) == ball;
  };
  state_end_ = scalars_at_ = first_free;
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (has_place(j, false)) scalar_count_ += atwood::rate_count(scene.joints[j].kind);
  for (const bool ball : {false, true}) {
    if (ball) state_end_ += scalar_count_;  // the rates
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      if (!has_place(j, ball)) continue;
      Link<S>& link = links_[link_of_joint_[j]];
      link.at_q = state_end_;
      link.at_u = state_end_ + (ball ? 4 : scalar_count_);
      state_end_ += ball ? 7 : coordinate_count(link.kind);
    }
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (link_of_joint_[j] < 0) continue;
    const Joint& joint = scene.joints[j];
    Link<S>& link = links_[link_of_joint_[j]];
    link.rates = atwood::rate_count(joint.kind);
    for (int k = 0; k < coordinate_count(joint.kind); ++k) start_.push_back({link.at_q + k, S(joint.coordinates[k])});
    for (int k = 0; k < link.rates; ++k)
      start_.push_back({link.at_u + k, S(joint.driven_rate ? *joint.driven_rate : joint.rates[k])});
    if (joint.kind == JointKind::ball) {
      const Quat<S> q = unit_quaternion<S>(joint.coordinates);
      for (int k = 0; k < 4; ++k) start_[start_.size() - 7 + k].value = (&q.w)[k];
    }
  }
  for (Link<S>& link : links_) {
    link.first_rate = static_cast<int>(state_of_rate_.size());
    if (link.joint >= 0) {
      for (int k = 0; k < link.rates; ++k) state_of_rate_.push_back(link.at_u + k);
      continue;
    }
    link.rates = link.rotates ? 6 : 3;
    for (int k = 0; k < 3; ++k) state_of_rate_.push_back(link.at_q + 3 + k);
    for (int k = 3; k < link.rates; ++k) state_of_rate_.push_back(link.at_q + 7 + k);
  }
}

template <class S> void Tree<S>::initial_state(S* y) const {
  for (const Start& start : start_) y[start.at] = start.value;
}

template <class S> void Tree<S>::set_held(int body, bool held) {
  if (link_of_body_[body] >= 0) held_[link_of_body_[body]] = held;
}

template class Tree<float>;
template class Tree<double>;
template class Tree<long double>;
template class Tree<Quad>;
template class Tree<Dual<double>>;

}  // namespace atwood
