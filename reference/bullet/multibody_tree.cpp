#include "bullet/multibody_tree.hpp"

#include "bullet/narrow.hpp"
#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::bullet {
namespace {

using rivals::operator*;
using rivals::operator+;
using rivals::conjugate;
using rivals::JointState;
using rivals::Motion;
using rivals::product;

bool two_links(JointKind kind) { return kind == JointKind::universal || kind == JointKind::cylindrical; }

// A point mass is given an inertia that no torque meets.
Real3 moments_of(const Body& body) {
  if (!rotates(body)) return {body.mass_kg, body.mass_kg, body.mass_kg};
  return rivals::principal_axes(body.inertia_kg_m2).moments_kg_m2;
}

}  // namespace

MultibodyTrees::MultibodyTrees(const Scene& scene) : scene_(scene) {
  find_axes();
  plan();
  build();
}

void MultibodyTrees::find_axes() {
  for (const Body& body : scene_.bodies)
    q_BL_.push_back(rotates(body) ? rivals::principal_axes(body.inertia_kg_m2).q_BP : Real4{1, 0, 0, 0});
}

// All joints to the world or to fixed bodies share one multibody.
void MultibodyTrees::plan() {
  const std::vector<int> placing = rivals::placing_joints(scene_);
  tree_.assign(scene_.bodies.size(), -1);
  link_.assign(scene_.bodies.size(), -1);
  int grounded = -1;
  const auto new_tree = [&](int root) {
    roots_.push_back(root);
    sizes_.push_back(0);
    return static_cast<int>(roots_.size()) - 1;
  };
  for (const int b : rivals::parents_first(scene_)) {
    const auto i = static_cast<std::size_t>(b);
    if (scene_.bodies[i].fixed) continue;
    if (placing[i] < 0) {
      tree_[i] = new_tree(b);
      continue;
    }
    const Joint& joint = scene_.joints[static_cast<std::size_t>(placing[i])];
    const bool on_ground = joint.parent < 0 || scene_.bodies[static_cast<std::size_t>(joint.parent)].fixed;
    if (on_ground && grounded < 0) grounded = new_tree(-1);
    tree_[i] = on_ground ? grounded : tree_[static_cast<std::size_t>(joint.parent)];
    int& size = sizes_[static_cast<std::size_t>(tree_[i])];
    size += two_links(joint.kind) ? 2 : 1;
    link_[i] = size - 1;
  }
}

void MultibodyTrees::build() {
  for (std::size_t t = 0; t < roots_.size(); ++t) {
    const int root = roots_[t];
    const Body* base = root < 0 ? nullptr : &scene_.bodies[static_cast<std::size_t>(root)];
    bodies_.push_back(std::make_unique<btMultiBody>(sizes_[t], narrow(base ? base->mass_kg : 0),
                                                    narrow(base ? moments_of(*base) : Real3{}), !base, false));
    if (!base) continue;
    const Motion start = rivals::motion_at_start(scene_, root);
    const Real4 q_WL = product(start.q_WB, q_BL_[static_cast<std::size_t>(root)]);
    bodies_[t]->setBasePos(narrow(start.p_WB));
    bodies_[t]->setWorldToBaseRot(narrow(conjugate(q_WL)).normalized());
  }
  for (std::size_t j = 0; j < scene_.joints.size(); ++j)
    if (!scene_.joints[j].closes_loop) set_up(static_cast<int>(j));
  for (std::size_t t = 0; t < roots_.size(); ++t) {
    bodies_[t]->finalizeMultiDof();
    if (roots_[t] < 0) continue;
    const Motion start = rivals::motion_at_start(scene_, roots_[t]);
    bodies_[t]->setBaseVel(narrow(start.v_WB));
    if (rotates(scene_.bodies[static_cast<std::size_t>(roots_[t])]))
      bodies_[t]->setBaseOmega(narrow(rivals::to_world(start.q_WB, start.w_WB_B)));
  }
  for (std::size_t j = 0; j < scene_.joints.size(); ++j)
    if (!scene_.joints[j].closes_loop) start(static_cast<int>(j));
}

// Bullet's quaternions turn vectors of the parent link into those of the link at coordinate 0: with body axes
// R_child = R_parent F and link axes R_child C, R_parent P, that is C^T F^T P.
void MultibodyTrees::set_up(int j) {
  const Joint& joint = scene_.joints[static_cast<std::size_t>(j)];
  const auto c = static_cast<std::size_t>(joint.child);
  const Body& child = scene_.bodies[c];
  btMultiBody& tree = *bodies_[static_cast<std::size_t>(tree_[c])];
  const int link = link_[c];
  const MultibodyLink at = link_of(joint.parent);
  // Of the parent in its link, or of a fixed body in the world.
  const Motion ground = at.tree ? Motion{} : rivals::motion_at_start(scene_, joint.parent);
  const Real4 to_parent = at.tree ? turn_to_link(joint.parent) : ground.q_WB;
  int parent = at.tree ? at.link : -1;
  const Real4 from_child = q_BL_[c];
  const auto in_child = [&](const Real3& v) { return narrow(rivals::to_body(from_child, v)); };
  const btScalar mass = narrow(child.mass_kg);
  const btVector3 moments = narrow(moments_of(child)), none(0, 0, 0);
  btVector3 to_pivot = narrow(ground.p_WB + rivals::to_world(to_parent, joint.anchors_body_m[0]));
  const btVector3 from_pivot = -in_child(joint.anchors_body_m[1]), axis = in_child(joint.axis_body);
  const Real4 frame = product(conjugate(joint.frame_wxyz), conjugate(to_parent));
  const btQuaternion turn = narrow(product(conjugate(from_child), frame)).normalized();
  switch (joint.kind) {
    case JointKind::fixed: tree.setupFixed(link, mass, moments, parent, turn, to_pivot, from_pivot); break;
    case JointKind::hinge:
      tree.setupRevolute(link, mass, moments, parent, turn, axis, to_pivot, from_pivot, true);
      break;
    case JointKind::slider:
      tree.setupPrismatic(link, mass, moments, parent, turn, axis, to_pivot, from_pivot, true);
      break;
    case JointKind::ball: tree.setupSpherical(link, mass, moments, parent, turn, to_pivot, from_pivot, true); break;
    case JointKind::cylindrical:  // slides in the axes of R_parent F, then turns
      tree.setupPrismatic(link - 1, 0, none, parent, narrow(frame).normalized(), narrow(joint.axis_body), to_pivot,
                          none, true);
      tree.setupRevolute(link, mass, moments, link - 1, narrow(conjugate(from_child)), axis, none, from_pivot, true);
      break;
    case JointKind::universal:  // turns in the axes of R_parent about the first axis, then about the second
      tree.setupRevolute(link - 1, 0, none, parent, narrow(conjugate(to_parent)).normalized(),
                         narrow(joint.axes_body[0]), to_pivot, none, true);
      tree.setupRevolute(link, mass, moments, link - 1,
                         narrow(product(conjugate(from_child), conjugate(joint.frame_wxyz))).normalized(),
                         in_child(joint.axes_body[1]), none, from_pivot, true);
      break;
  }
}

// A ball's Q in link axes is C^T Q C.
void MultibodyTrees::start(int j) {
  const Joint& joint = scene_.joints[static_cast<std::size_t>(j)];
  const MultibodyLink at = link_of(joint.child);
  const Real4& from_child = q_BL_[static_cast<std::size_t>(joint.child)];
  const auto set = [&](int link, double q, double u) {
    btScalar position[1] = {narrow(q)}, rate[1] = {narrow(u)};
    at.tree->setJointPosMultiDof(link, position);
    at.tree->setJointVelMultiDof(link, rate);
  };
  const auto &q = joint.coordinates, u = Real4{joint.rates[0], joint.rates[1], joint.rates[2], 0};
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge:
    case JointKind::slider: set(at.link, q[0], u[0]); break;
    case JointKind::cylindrical:
      set(at.link - 1, q[1], u[1]);
      set(at.link, q[0], u[0]);
      break;
    case JointKind::universal:
      set(at.link - 1, q[0], u[0]);
      set(at.link, q[1], u[1]);
      break;
    case JointKind::ball: {
      const Real4 in_link = product(conjugate(from_child), product(q, from_child));
      const Real3 rate = rivals::to_body(from_child, joint.rates);
      btScalar position[4] = {narrow(in_link[1]), narrow(in_link[2]), narrow(in_link[3]), narrow(in_link[0])};
      btScalar rates[3] = {narrow(rate[0]), narrow(rate[1]), narrow(rate[2])};
      at.tree->setJointPosMultiDof(at.link, position);
      at.tree->setJointVelMultiDof(at.link, rates);
      break;
    }
  }
}

MultibodyLink MultibodyTrees::link_of(int body) const {
  if (body < 0 || tree_[static_cast<std::size_t>(body)] < 0) return {};
  const auto i = static_cast<std::size_t>(body);
  return {bodies_[static_cast<std::size_t>(tree_[i])].get(), link_[i]};
}

Real4 MultibodyTrees::turn_to_link(int body) const {
  return body < 0 ? Real4{1, 0, 0, 0} : conjugate(q_BL_[static_cast<std::size_t>(body)]);
}

void MultibodyTrees::update() const {
  frames_.resize(bodies_.size());
  for (std::size_t t = 0; t < bodies_.size(); ++t) {
    const btMultiBody& tree = *bodies_[t];
    const int links = tree.getNumLinks();
    std::vector<Frame>& frames = frames_[t];
    frames.resize(static_cast<std::size_t>(links) + 1);
    omega_.resize(frames.size());
    velocity_.resize(frames.size());
    tree.compTreeLinkVelocities(omega_.data(), velocity_.data());
    frames[0].p_WL = widen(tree.getBasePos());
    frames[0].q_WL = conjugate(widen(tree.getWorldToBaseRot()));
    for (int k = 0; k < links; ++k) {
      const Frame& parent = frames[static_cast<std::size_t>(tree.getParent(k) + 1)];
      Frame& frame = frames[static_cast<std::size_t>(k) + 1];
      frame.q_WL = product(parent.q_WL, conjugate(widen(tree.getParentToLocalRot(k))));
      frame.p_WL = parent.p_WL + rivals::to_world(frame.q_WL, widen(tree.getRVector(k)));
    }
    for (std::size_t k = 0; k < frames.size(); ++k) {
      frames[k].v_L = widen(velocity_[k]);
      frames[k].w_L = widen(omega_[k]);
    }
  }
  known_ = true;
}

const MultibodyTrees::Frame& MultibodyTrees::frame_of(int body) const {
  if (!known_) update();
  const auto i = static_cast<std::size_t>(body);
  return frames_[static_cast<std::size_t>(tree_[i])][static_cast<std::size_t>(link_[i] + 1)];
}

Motion MultibodyTrees::motion(int body) const {
  const Frame& frame = frame_of(body);
  const Real4& q_BL = q_BL_[static_cast<std::size_t>(body)];
  return {frame.p_WL, product(frame.q_WL, conjugate(q_BL)), rivals::to_world(frame.q_WL, frame.v_L),
          rivals::to_world(q_BL, frame.w_L)};
}

JointState MultibodyTrees::joint(int j) const {
  const Joint& joint = scene_.joints[static_cast<std::size_t>(j)];
  const MultibodyLink at = link_of(joint.child);
  const Real4& from_child = q_BL_[static_cast<std::size_t>(joint.child)];
  const auto q = [&](int link) { return static_cast<double>(at.tree->getJointPosMultiDof(link)[0]); };
  const auto u = [&](int link) { return static_cast<double>(at.tree->getJointVelMultiDof(link)[0]); };
  JointState state;
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge:
    case JointKind::slider:
      state.q[0] = q(at.link);
      state.u[0] = u(at.link);
      break;
    case JointKind::cylindrical:
    case JointKind::universal: {
      const int first = joint.kind == JointKind::universal ? 0 : 1;  // the coordinate of the link without mass
      state.q[first] = q(at.link - 1), state.u[first] = u(at.link - 1);
      state.q[1 - first] = q(at.link), state.u[1 - first] = u(at.link);
      break;
    }
    case JointKind::ball: {
      const btScalar *x = at.tree->getJointPosMultiDof(at.link), *w = at.tree->getJointVelMultiDof(at.link);
      state.q = product(from_child, product(Real4{x[3], x[0], x[1], x[2]}, conjugate(from_child)));
      state.u = rivals::to_world(from_child, Real3{w[0], w[1], w[2]});
      break;
    }
  }
  return state;
}

Real3 MultibodyTrees::link_to_world(int body, const Real3& v) const { return rivals::to_world(frame_of(body).q_WL, v); }

}  // namespace atwood::bullet
