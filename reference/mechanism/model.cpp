#include "mechanism/model.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::mechanism {

namespace {

using dynamics::widen;

Quaternion<Wide> wide_quaternion(const Real4& q) {
  return normalised<Wide>({Wide(q[0]), Wide(q[1]), Wide(q[2]), Wide(q[3])});
}
template <class S> Quaternion<S> narrowed(const Quaternion<Wide>& q) {
  return {static_cast<S>(q[0]), static_cast<S>(q[1]), static_cast<S>(q[2]), static_cast<S>(q[3])};
}
Triple<Wide> wide_unit(const Real3& v) { return unit<Wide>(widen<Wide>(v)); }

template <class S> JointModel<S> make_joint(const Joint& joint, int world) {
  JointModel<S> made;
  made.kind = joint.kind;
  made.parent = joint.parent < 0 ? world : joint.parent;
  made.child = joint.child;
  made.anchor_parent = widen<S>(joint.anchors_body_m[0]);
  made.anchor_child = widen<S>(joint.anchors_body_m[1]);
  const Quaternion<Wide> frame = wide_quaternion(joint.frame_wxyz);
  made.frame = narrowed<S>(frame);
  if (joint.kind == JointKind::hinge || joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical) {
    const Triple<Wide> axis = wide_unit(joint.axis_body);
    const auto across = orthogonal_pair<Wide>(axis);
    made.axis = converted<S>(axis);
    for (int k = 0; k < 2; ++k) made.across[k] = converted<S>(across[k]);
  }
  if (joint.kind == JointKind::universal) {
    const Triple<Wide> first = wide_unit(joint.axes_body[0]), second = wide_unit(joint.axes_body[1]);
    const Triple<Wide> turned_second = rotate(frame, second);
    made.first = converted<S>(first);
    made.second = converted<S>(second);
    made.second_at_zero = converted<S>(turned_second);
    made.cosine = static_cast<S>(dot(first, turned_second));
  }
  made.driven = joint.driven_rate.has_value();
  made.rate = joint.driven_rate.value_or(0);
  return made;
}

template <class S> RopeEnd<S> make_end(const Pulley& pulley) {
  RopeEnd<S> made;
  made.axle = widen<S>(pulley.axle_m);
  made.radius = pulley.radius_m;
  const Triple<Wide> axis = wide_unit(pulley.axis);
  const auto across = orthogonal_pair<Wide>(axis);  // axis = b1 x b2
  made.axis = converted<S>(axis);
  made.b1 = converted<S>(across[0]);
  made.b2 = converted<S>(across[1]);
  return made;
}

template <class S> RopeModel<S> make_rope(const Rope& rope) {
  RopeModel<S> made;
  made.a = rope.bodies[0];
  made.b = rope.bodies[1];
  made.point_a = widen<S>(rope.points_body_m[0]);
  made.point_b = widen<S>(rope.points_body_m[1]);
  if (rope.over.empty()) {
    made.first.straight = made.last.straight = true;
    return made;
  }
  made.first = make_end<S>(rope.over.front());
  made.last = make_end<S>(rope.over.back());
  Wide inertia = 0;
  for (const Pulley& pulley : rope.over) {
    made.radii.push_back(pulley.radius_m);
    if (pulley.radius_m > 0) inertia += Wide(pulley.inertia_kg_m2) / (Wide(pulley.radius_m) * Wide(pulley.radius_m));
  }
  made.inertia = static_cast<S>(inertia);
  return made;
}

// Joints of the tree, parents before children, in the scene's order otherwise. A cycle leaves joints out.
std::vector<int> tree_order(const Scene& scene, const std::vector<int>& placing) {
  std::vector<int> order;
  std::vector<char> placed(scene.bodies.size(), 0);
  for (std::size_t i = 0; i < placing.size(); ++i) placed[i] = placing[i] < 0;
  for (bool more = true; more;) {
    more = false;
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      if (joint.closes_loop || placed[joint.child] || (joint.parent >= 0 && !placed[joint.parent])) continue;
      if (placing[joint.child] != static_cast<int>(j)) continue;
      placed[joint.child] = 1;
      order.push_back(static_cast<int>(j));
      more = true;
    }
  }
  return order;
}

std::vector<int> placing_joints(const Scene& scene) {
  std::vector<int> placing(scene.bodies.size(), -1);
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (!scene.joints[j].closes_loop) placing[scene.joints[j].child] = static_cast<int>(j);
  return placing;
}

std::string quoted(const Scene& scene, int body) { return "`" + scene.bodies[body].name + "`"; }

// Bodies with shapes that are not joined to each other directly could touch.
std::string touching_pair(const Scene& scene) {
  const auto joined = [&](int a, int b) {
    return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const Joint& joint) {
      return (joint.parent == a && joint.child == b) || (joint.parent == b && joint.child == a);
    });
  };
  const int n = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      const Body &one = scene.bodies[a], &other = scene.bodies[b];
      if (one.shape.index() == 0 || other.shape.index() == 0 || (one.fixed && other.fixed) || joined(a, b)) continue;
      return "contacts in a scene with joints are not covered by this truth: " + quoted(scene, a) + " and " +
             quoted(scene, b) + " have shapes and could touch";
    }
  return "";
}

}  // namespace

std::string unsupported(const Scene& scene) {
  if (!scene.problem.empty()) return "joints beside a bare problem are not covered";
  if (!scene.fluids.empty()) return "joints beside fluids are not covered by this truth";
  std::vector<char> part(scene.bodies.size(), 0);
  for (const Joint& joint : scene.joints) {
    part[joint.child] = 1;
    if (joint.parent >= 0) part[joint.parent] = 1;
    const Body& child = scene.bodies[joint.child];
    if (child.fixed) return "joint `" + joint.name + "`: its child " + quoted(scene, joint.child) + " is fixed";
    if (!rotates(child))
      return "joint `" + joint.name + "`: its child " + quoted(scene, joint.child) + " has no inertia";
    if (joint.parent >= 0 && !scene.bodies[joint.parent].fixed && !rotates(scene.bodies[joint.parent]))
      return "joint `" + joint.name + "`: its parent " + quoted(scene, joint.parent) + " has no inertia";
    if (joint.driven_rate && joint.limits) return "joint `" + joint.name + "` is driven and has limits: not covered";
    if (joint.closes_loop && joint.limits)
      return "joint `" + joint.name +
             "` closes a loop and has limits: stops are covered at joints that place bodies; " +
             "let another joint of the loop close it";
    if (joint.closes_loop && joint.driven_rate)
      return "joint `" + joint.name + "` closes a loop and is driven: prescribed motion is covered at joints that " +
             "place bodies; drive another joint of the loop";
  }
  for (const Rope& rope : scene.ropes)
    for (int end = 0; end < 2; ++end) {
      const Body& body = scene.bodies[rope.bodies[end]];
      part[rope.bodies[end]] = 1;
      if (!body.fixed && !rotates(body) && rope.points_body_m[end] != Real3{})
        return "rope `" + rope.name + "`: a point beside the centre of the point mass " +
               quoted(scene, rope.bodies[end]);
    }
  for (std::size_t i = 0; i < part.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (part[i] && body.release_s > 0)
      return quoted(scene, static_cast<int>(i)) + " is held and part of a mechanism: not covered";
    if (part[i] && body.fixed && (body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{}))
      return quoted(scene, static_cast<int>(i)) + " is moved by prescription and part of a mechanism: not covered";
  }
  const std::vector<int> placing = placing_joints(scene);
  std::size_t placed = 0;
  for (const Joint& joint : scene.joints) placed += !joint.closes_loop;
  if (tree_order(scene, placing).size() != placed) return "the joints that place bodies form no tree";
  return touching_pair(scene);
}

template <class S> Model<S> make_model(const Scene& scene) {
  Model<S> made;
  made.scene = &scene;
  made.world = static_cast<int>(scene.bodies.size());
  for (const Joint& joint : scene.joints) made.joints.push_back(make_joint<S>(joint, made.world));
  for (const Rope& rope : scene.ropes) made.ropes.push_back(make_rope<S>(rope));
  made.placing = placing_joints(scene);
  made.tree = tree_order(scene, made.placing);
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (scene.joints[j].closes_loop) made.closing.push_back(static_cast<int>(j));
  for (const Body& body : scene.bodies) {
    made.mobile.push_back(!body.fixed);
    made.turns.push_back(!body.fixed && rotates(body));
    made.mass.push_back(S(body.mass_kg));
    Matrix<Wide> I{}, inverse{};
    for (int k = 0; k < 9; ++k) I[k] = body.inertia_kg_m2[k];
    if (rotates(body)) {  // the adjugate over the determinant
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
          inverse[3 * i + j] = I[3 * a + c] * I[3 * b + d] - I[3 * a + d] * I[3 * b + c];
        }
      const Wide determinant = I[0] * inverse[0] + I[1] * inverse[3] + I[2] * inverse[6];
      for (Wide& x : inverse) x /= determinant;
    }
    Matrix<S>& narrow = made.inertia.emplace_back();
    Matrix<S>& narrow_inverse = made.inverse_inertia.emplace_back();
    for (int k = 0; k < 9; ++k) {
      narrow[k] = static_cast<S>(I[k]);
      narrow_inverse[k] = static_cast<S>(inverse[k]);
    }
  }
  made.mobile.push_back(0);  // the world
  made.turns.push_back(0);
  made.mass.push_back(S(0));
  made.inertia.emplace_back();
  made.inverse_inertia.emplace_back();
  return made;
}

template <class S> Memory begin_at(Model<S>& model, const Sample& start) {
  Memory made;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    model.joints[j].start = static_cast<S>(start.joints[j].q[0]);
    std::array<double, 4>& near = made.joints.emplace_back();
    for (int k = 0; k < 4; ++k) near[k] = static_cast<double>(start.joints[j].q[k]);
  }
  made.ropes.resize(model.ropes.size());
  return made;
}

template Model<double> make_model(const Scene&);
template Model<long double> make_model(const Scene&);
template Model<Wide> make_model(const Scene&);
template Memory begin_at(Model<double>&, const Sample&);
template Memory begin_at(Model<long double>&, const Sample&);
template Memory begin_at(Model<Wide>&, const Sample&);

}  // namespace atwood::mechanism
