#include "scene/loop_rows.hpp"

#include <numeric>

#include "scene/union_find.hpp"

namespace atwood::loop_rows {

using namespace quad;

std::vector<bool> involved_bodies(const Scene& scene) {
  const std::size_t n = scene.bodies.size();
  std::vector<int> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  const auto moves = [&](int b) { return b >= 0 && !scene.bodies[static_cast<std::size_t>(b)].fixed; };
  const auto join = [&](int a, int b) {
    if (moves(a) && moves(b)) unite(parent, a, b);
  };
  for (const Joint& joint : scene.joints) join(joint.parent, joint.child);
  for (const Rope& rope : scene.ropes) join(rope.bodies[0], rope.bodies[1]);
  std::vector<bool> root(n), involved(n);
  const auto mark = [&](int b) {
    if (moves(b)) root[static_cast<std::size_t>(find_root(parent, b))] = true;
  };
  for (const Joint& joint : scene.joints)
    if (joint.closes_loop) mark(joint.parent), mark(joint.child);
  for (const Rope& rope : scene.ropes) mark(rope.bodies[0]), mark(rope.bodies[1]);
  for (std::size_t b = 0; b < n; ++b)
    involved[b] = root[static_cast<std::size_t>(find_root(parent, static_cast<int>(b)))];
  return involved;
}

std::vector<bool> held_joints(const Scene& scene) {
  std::vector<bool> held(scene.joints.size());
  for (std::size_t j = 0; j < held.size(); ++j) {
    if (scene.joints[j].driven_rate) held[j] = true;
    for (const int other : scene.joints[j].hold) held[static_cast<std::size_t>(other)] = true;
  }
  return held;
}

void add_freedoms(Loops& loops) {
  const Scene& scene = loops.scene;
  loops.movers.resize(scene.bodies.size());
  const auto add = [&](Freedom freedom) {
    loops.movers[static_cast<std::size_t>(freedom.body)].push_back(static_cast<int>(loops.freedoms.size()));
    loops.freedoms.push_back(freedom);
  };
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (!loops.involved[b] || loops.placing[b] >= 0) continue;
    const std::size_t count = rotates(scene.bodies[b]) ? 6 : 3;
    for (std::size_t k = 0; k < count; ++k) add({static_cast<int>(b), -1, k, k < 3});
  }
  const std::vector<bool> held = held_joints(scene);
  for (const int j : loops.order) {
    const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
    const auto child = static_cast<std::size_t>(joint.child);
    if (!loops.involved[child]) continue;
    if (joint.parent >= 0) loops.movers[child] = loops.movers[static_cast<std::size_t>(joint.parent)];
    if (held[static_cast<std::size_t>(j)]) continue;
    for (int k = 0; k < rate_count(joint.kind); ++k) {
      const bool slides = joint.kind == JointKind::slider || (joint.kind == JointKind::cylindrical && k == 1);
      add({joint.child, j, static_cast<std::size_t>(k), slides});
    }
  }
}

Vector world_point(const MechanismStart& start, int body, const Real3& point_body) {
  const BodyMotion world = world_motion();
  const BodyMotion& m = motion_of(start.bodies, body, world);
  return m.p_m + rotate(m.q_wxyz, wide(point_body));
}
Vector point_velocity(const MechanismStart& start, int body, const Real3& point_body) {
  const BodyMotion world = world_motion();
  const BodyMotion& m = motion_of(start.bodies, body, world);
  return m.v_m_per_s + rotate(m.q_wxyz, cross(m.w_rad_per_s, wide(point_body)));
}

Real mechanism_size(const Scene& scene, const std::vector<bool>& involved, const MechanismStart& start) {
  Vector low{}, high{};
  bool first = true;
  each_point(scene, involved, [&](int body, const Real3& point) {
    const Vector x = world_point(start, body, point);
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = first ? x[i] : fminq(low[i], x[i]);
      high[i] = first ? x[i] : fmaxq(high[i], x[i]);
    }
    first = false;
  });
  const Real diagonal = norm(high - low);
  return diagonal > 0 ? diagonal : Real(1);
}

void set_screws(Loops& loops, const MechanismStart& start) {
  const auto unit_axis = [](std::size_t i) {
    Vector e{};
    e[i] = 1;
    return e;
  };
  for (Freedom& freedom : loops.freedoms) {
    const BodyMotion& body = start.bodies[static_cast<std::size_t>(freedom.body)];
    if (freedom.joint < 0) {
      freedom.axis =
          freedom.slides ? unit_axis(freedom.component) : rotate(body.q_wxyz, unit_axis(freedom.component - 3));
      freedom.point = body.p_m;
      continue;
    }
    const Joint& joint = loops.scene.joints[static_cast<std::size_t>(freedom.joint)];
    const BodyMotion world = world_motion();
    freedom.point = world_point(start, joint.child, joint.anchors_body_m[1]);
    if (joint.kind == JointKind::ball) {
      freedom.axis = rotate(body.q_wxyz, unit_axis(freedom.component));
    } else if (joint.kind == JointKind::universal) {
      const BodyMotion& of = freedom.component == 0 ? motion_of(start.bodies, joint.parent, world) : body;
      freedom.axis = rotate(of.q_wxyz, unit(wide(joint.axes_body[freedom.component])));
    } else {
      freedom.axis = rotate(body.q_wxyz, unit(wide(joint.axis_body)));
    }
  }
}

// ---- rows ---------------------------------------------------------------------------------------------------------
namespace {

Row tilt_row(const Joint& joint, const Vector& torque_on_child, Real residual) {
  Row row;
  row.bodies = {joint.parent, joint.child};
  row.torque = {Real(-1) * torque_on_child, torque_on_child};
  row.residual = residual;
  row.is_length = false;
  return row;
}

// The component along `direction`, fixed in the child (world), of the way from the parent's anchor to the child's:
// e . R_child^T x has the rate E . (v_child - v_parent at the parent's anchor), E = R_child e.
Row gap_row(const Joint& joint, const MechanismStart& start, const Vector& direction) {
  const BodyMotion world = world_motion();
  const Vector at = world_point(start, joint.parent, joint.anchors_body_m[0]);
  const Vector apart = world_point(start, joint.child, joint.anchors_body_m[1]) - at;
  Row row;
  row.bodies = {joint.parent, joint.child};
  row.force = {Real(-1) * direction, direction};
  row.torque = {cross(motion_of(start.bodies, joint.parent, world).p_m - at, direction),
                cross(at - motion_of(start.bodies, joint.child, world).p_m, direction)};
  row.residual = dot(direction, apart);
  return row;
}

void add_orientation_rows(const Joint& joint, const BodyMotion& parent, const BodyMotion& child,
                          std::vector<Row>& rows) {
  const Quaternion frame = product(parent.q_wxyz, normalised(wide(joint.frame_wxyz)));
  if (joint.kind == JointKind::fixed || joint.kind == JointKind::slider) {
    // 2 vec(q) of the orientation from the frame to the child, w >= 0, has the rate w0 w + vec x w, w in the child's
    // axes.
    Quaternion turned = product(conjugate(frame), child.q_wxyz);
    if (turned[0] < 0)
      for (Real& x : turned) x = -x;
    const Vector vec{turned[1], turned[2], turned[3]};
    for (std::size_t i = 0; i < 3; ++i) {
      Vector e{};
      e[i] = 1;
      rows.push_back(tilt_row(joint, rotate(child.q_wxyz, turned[0] * e + cross(e, vec)), 2 * vec[i]));
    }
  }
  if (joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical) {
    const Vector axis = unit(wide(joint.axis_body)), on_child = rotate(child.q_wxyz, axis);
    for (const Vector& across : orthogonal_pair(axis)) {
      const Vector on_parent = rotate(frame, across);
      rows.push_back(tilt_row(joint, cross(on_child, on_parent), dot(on_parent, on_child)));
    }
  }
  if (joint.kind == JointKind::universal) {
    const Vector a1 = unit(wide(joint.axes_body[0])), a2 = unit(wide(joint.axes_body[1]));
    const Vector on_parent = rotate(parent.q_wxyz, a1), on_child = rotate(child.q_wxyz, a2);
    const Real at_start = dot(a1, rotate(normalised(wide(joint.frame_wxyz)), a2));
    rows.push_back(tilt_row(joint, cross(on_child, on_parent), dot(on_parent, on_child) - at_start));
  }
}

// The prescribed coordinate of a closing joint.
void add_driven_row(const Joint& joint, const MechanismStart& start, const BodyMotion& parent, const BodyMotion& child,
                    std::vector<Row>& rows) {
  JointMotion given;
  given.q[0] = joint.coordinates[0];
  const Vector axis = rotate(child.q_wxyz, unit(wide(joint.axis_body)));
  const Real residual = joint_motion(joint, parent, child, given).q[0] - given.q[0];
  Row row = joint.kind == JointKind::hinge ? tilt_row(joint, axis, residual) : gap_row(joint, start, axis);
  row.residual = residual;
  row.target = *joint.driven_rate;
  rows.push_back(row);
}

}  // namespace

std::vector<Row> joint_rows(const Joint& joint, const MechanismStart& start) {
  const BodyMotion world = world_motion();
  const BodyMotion& parent = motion_of(start.bodies, joint.parent, world);
  const BodyMotion& child = motion_of(start.bodies, joint.child, world);
  std::vector<Row> rows;
  const bool slides = joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical;
  const Vector axis = slides ? unit(wide(joint.axis_body)) : Vector{0, 0, 1};
  for (const Vector& across : orthogonal_pair(axis))
    rows.push_back(gap_row(joint, start, rotate(child.q_wxyz, across)));
  if (!slides) rows.push_back(gap_row(joint, start, rotate(child.q_wxyz, axis)));
  add_orientation_rows(joint, parent, child, rows);
  if (joint.driven_rate) add_driven_row(joint, start, parent, child, rows);
  return rows;
}

RopePath path_of(const Scene& scene, const MechanismStart& start, std::size_t index) {
  const Rope& rope = scene.ropes[index];
  RopePath path;
  const std::string problem = rope_path(rope,
                                        {world_point(start, rope.bodies[0], rope.points_body_m[0]),
                                         world_point(start, rope.bodies[1], rope.points_body_m[1])},
                                        path);
  if (!problem.empty()) throw MechanismError("rope `" + rope.name + "` " + problem, -1, static_cast<int>(index));
  return path;
}

Row rope_row(const Scene& scene, const MechanismStart& start, std::size_t index, const RopePath& path) {
  const Rope& rope = scene.ropes[index];
  Row row;
  row.bodies = rope.bodies;
  row.force = {Real(-1) * path.directions.front(), path.directions.back()};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector lever =
        rotate(start.bodies[static_cast<std::size_t>(rope.bodies[i])].q_wxyz, wide(rope.points_body_m[i]));
    row.torque[i] = cross(lever, row.force[i]);
  }
  return row;
}

Real rate_of(const Row& row, const MechanismStart& start) {
  Real rate = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    if (row.bodies[i] < 0) continue;
    const BodyMotion& m = start.bodies[static_cast<std::size_t>(row.bodies[i])];
    rate += dot(row.force[i], m.v_m_per_s) + dot(row.torque[i], rotate(m.q_wxyz, m.w_rad_per_s));
  }
  return rate;
}

}  // namespace atwood::loop_rows
