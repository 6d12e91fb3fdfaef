#include "dynamics/joint_poses.hpp"

#include <cmath>
#include <limits>

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {
namespace {

using Wide3 = Triple<Wide>;
using Wide4 = std::array<Wide, 4>;

const Wide kPi = acosq(-1);
const BodySample kWorld;

const BodySample& body_of(const SampleView& sample, int body) {
  return body < 0 ? kWorld : sample.bodies[static_cast<std::size_t>(body)];
}

Wide4 conjugate(const Wide4& q) { return {q[0], -q[1], -q[2], -q[3]}; }

Wide4 product(const Wide4& a, const Wide4& b) {
  const auto& [aw, ax, ay, az] = a;
  const auto& [bw, bx, by, bz] = b;
  return {aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
          aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw};
}

Wide4 unit(const Wide4& q) {
  const Wide length = sqrtq(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

Wide4 positive(const Wide4& q) { return q[0] < 0 ? Wide4{-q[0], -q[1], -q[2], -q[3]} : q; }

// An angle modulo 2 pi in (-pi, pi].
Wide principal(Wide angle) {
  const Wide turn = 2 * kPi;
  const Wide rest = angle - turn * floorq(angle / turn);
  return rest > kPi ? rest - turn : rest;
}

Wide3 to_world(const BodySample& body, const std::array<double, 3>& v_body) {
  return rotate(unit(body.q_wxyz), widen<Wide>(v_body));
}

Wide3 point_velocity(const BodySample& body, const Wide3& arm_W) {
  return body.v_m_per_s + cross(rotate(unit(body.q_wxyz), body.w_rad_per_s), arm_W);
}

// Angle of v from u about the unit vector a, of the parts of u and v across a.
Wide angle_about(const Wide3& a, const Wide3& u, const Wide3& v) {
  return atan2q(dot(a, cross(u, v)), dot(u, v) - dot(u, a) * dot(v, a));
}

// Angle of two unit vectors, without cancellation at 0 and pi.
Wide angle_between(const Wide3& a, const Wide3& b) { return atan2q(norm(cross(a, b)), dot(a, b)); }

// S = F^T R_rel = exp(axis q) in the joint's own constraint: its twist about the axis is the coordinate, its swing the
// tilt.
void read_hinge(const Wide4& S, const Wide3& axis, JointPose& out) {
  const Wide3 v{S[1], S[2], S[3]};
  const Wide along = dot(v, axis);
  out.q[0] = principal(2 * atan2q(along, S[0]));
  out.tilt_rad = 2 * atan2q(norm(v - along * axis), sqrtq(S[0] * S[0] + along * along));
}

// R_rel = exp(a1 q0) F exp(a2 q1): R_rel a2 is F a2 turned about a1, and R_rel^T a1 is F^T a1 turned back about a2.
void read_universal(const Joint& joint, const Wide4& F, const Wide4& R_rel, const Wide3& w_rel_P, JointPose& out) {
  const Wide3 a1 = widen<Wide>(joint.axes_body[0]), a2 = widen<Wide>(joint.axes_body[1]);
  const Wide3 a2_start = rotate(F, a2), a2_now = rotate(R_rel, a2);
  out.q[0] = angle_about(a1, a2_start, a2_now);
  out.q[1] = angle_about(a2, rotate(conjugate(R_rel), a1), rotate(conjugate(F), a1));
  out.tilt_rad = magnitude(angle_between(a1, a2_now) - angle_between(a1, a2_start));
  // w_rel = a1 q0' + (R_rel a2) q1', least squares.
  const Wide c = dot(a1, a2_now), x = dot(a1, w_rel_P), y = dot(a2_now, w_rel_P);
  out.u[0] = (x - c * y) / (1 - c * c);
  out.u[1] = (y - c * x) / (1 - c * c);
}

}  // namespace

bool is_angle(JointKind kind, int coordinate) {
  return kind != JointKind::slider && !(kind == JointKind::cylindrical && coordinate == 1);
}

JointPose joint_pose(const Scene& scene, int index, const SampleView& sample) {
  const Joint& joint = scene.joints[static_cast<std::size_t>(index)];
  const BodySample &parent = body_of(sample, joint.parent), &child = body_of(sample, joint.child);
  const Wide4 qp = unit(parent.q_wxyz), qc = unit(child.q_wxyz);
  const Wide4 F = unit({joint.frame_wxyz[0], joint.frame_wxyz[1], joint.frame_wxyz[2], joint.frame_wxyz[3]});
  const Wide4 R_rel = product(conjugate(qp), qc), S = product(conjugate(F), R_rel);
  const Wide3 arm_p = to_world(parent, joint.anchors_body_m[0]), arm_c = to_world(child, joint.anchors_body_m[1]);
  const Wide3 apart = child.p_m + arm_c - (parent.p_m + arm_p);
  const Wide3 w_p = rotate(qp, parent.w_rad_per_s), w_c = rotate(qc, child.w_rad_per_s);

  JointPose out;
  out.gap_m = norm(apart);
  const bool turns = joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical;
  const bool slides = joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical;
  const Wide3 axis = widen<Wide>(joint.axis_body), axis_W = rotate(qc, axis);
  if (turns) {
    read_hinge(S, axis, out);
    out.u[0] = dot(axis_W, w_c - w_p);
  }
  if (slides) {
    const int i = turns ? 1 : 0;
    out.q[i] = dot(axis_W, apart);
    out.u[i] =
        dot(axis_W, point_velocity(child, arm_c) - point_velocity(parent, arm_p)) + dot(cross(w_c, axis_W), apart);
    out.gap_m = norm(apart - out.q[i] * axis_W);
  }
  if (joint.kind == JointKind::slider || joint.kind == JointKind::fixed)
    out.tilt_rad = 2 * atan2q(norm(Wide3{S[1], S[2], S[3]}), magnitude(S[0]));
  if (joint.kind == JointKind::universal) read_universal(joint, F, R_rel, rotate_back(qp, w_c - w_p), out);
  if (joint.kind == JointKind::ball) {
    out.q = positive(S);
    out.u = rotate_back(qc, w_c - w_p);
  }
  return out;
}

std::vector<JointSample> joints_at_start(const Scene& scene) {
  std::vector<JointSample> joints(scene.joints.size());
  const Wide unknown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (int i = 0; i < 4; ++i) joints[j].q[i] = scene.joints[j].coordinates[i];
    for (int i = 0; i < 3; ++i) joints[j].u[i] = scene.joints[j].rates[i];
    joints[j].force_N = joints[j].torque_N_m = {unknown, unknown, unknown};
  }
  return joints;
}

std::vector<JointSample> joints_of(const Scene& scene, const SampleView& sample,
                                   const std::vector<JointSample>& before) {
  if (sample.joints.size() == scene.joints.size()) return {sample.joints.begin(), sample.joints.end()};
  std::vector<JointSample> joints = joints_at_start(scene);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const JointPose pose = joint_pose(scene, static_cast<int>(j), sample);
    const JointKind kind = scene.joints[j].kind;
    const Wide4 last = j < before.size() ? before[j].q : joints[j].q;
    joints[j].q = pose.q;
    joints[j].u = pose.u;
    if (kind == JointKind::ball) {
      Wide same = 0;
      for (int i = 0; i < 4; ++i) same += pose.q[i] * last[i];
      if (same < 0)
        for (Wide& c : joints[j].q) c = -c;
      continue;
    }
    for (int i = 0; i < coordinate_count(kind); ++i)
      if (is_angle(kind, i)) joints[j].q[i] = last[i] + principal(pose.q[i] - last[i]);
  }
  return joints;
}

// ---- ropes --------------------------------------------------------------------------------------------------------
namespace {

struct Tangent {
  Wide3 point;   // where the straight part touches the pulley
  Wide3 normal;  // from the axle to that point, unit; any for radius 0
  Wide3 along;   // unit, the rope's direction from the first body to the last
  Wide length = 0;
};

// The straight part between the point P and a pulley at C with the axis a. With n the unit vector from the axle to the
// tangent point, the rope's direction there is e = a x n: P = C + r n - L e towards the pulley and P = C + r n + L e
// away from it. With d = P - C and L^2 = d^2 - r^2 both give d^2 n = r d + s L a x d, s = 1 towards and -1 away.
Tangent tangent(const Wide3& P, const Pulley& pulley, int towards) {
  const Wide3 C = widen<Wide>(pulley.axle_m), a = widen<Wide>(pulley.axis), d = P - C;
  const Wide r = pulley.radius_m, square = dot(d, d);
  Tangent t;
  t.length = sqrtq(square - r * r);
  if (r == 0) {
    t.point = C;
    t.along = Wide(-towards / t.length) * d;
    return t;
  }
  t.normal = (1 / square) * (r * d + Wide(towards * t.length) * cross(a, d));
  t.along = cross(a, t.normal);
  t.point = C + r * t.normal;
  return t;
}

// The straight part from one pulley to the next: e = a1 x n1 = a2 x n2 and C2 + r2 n2 - C1 - r1 n1 = L e. With parallel
// axes, a2 = s a1 (s = 1 or -1), n2 = s n1, so that with n = n1: C2 - C1 = L e + (r1 - s r2) n.
std::array<Tangent, 2> tangents(const Pulley& first, const Pulley& second) {
  const Wide3 C1 = widen<Wide>(first.axle_m), C2 = widen<Wide>(second.axle_m), D = C2 - C1;
  std::array<Tangent, 2> ends;
  const Wide3 a = widen<Wide>(first.radius_m > 0 ? first.axis : second.axis);
  const Wide s = dot(widen<Wide>(first.axis), widen<Wide>(second.axis)) < 0 ? -1 : 1;
  const Wide r1 = first.radius_m, r2 = second.radius_m;
  // In the sense of a: rho1 n and rho2 n are the vectors from the axles to the tangent points.
  const Wide rho1 = first.radius_m > 0 ? r1 : 0, rho2 = first.radius_m > 0 ? s * r2 : r2;
  const Wide rho = rho1 - rho2, square = dot(D, D), length = sqrtq(square - rho * rho);
  // D = L (a x n) + rho n, a x D = -L n + rho (a x n): n = (rho D - L a x D) / D^2.
  const Wide3 n = (1 / square) * (rho * D - length * cross(a, D));
  const Wide3 along = r1 == 0 && r2 == 0 ? (1 / length) * D : cross(a, n);
  const Wide sign2 = first.radius_m > 0 ? s : 1;
  ends[0] = {C1 + rho1 * n, n, along, length};
  ends[1] = {C2 + rho2 * n, sign2 * n, along, length};
  return ends;
}

Wide3 end_point(const Rope& rope, const SampleView& sample, int end) {
  const BodySample& body = body_of(sample, rope.bodies[static_cast<std::size_t>(end)]);
  return body.p_m + to_world(body, rope.points_body_m[static_cast<std::size_t>(end)]);
}

// Arc of the rope on a pulley, from where it arrives to where it leaves, in the sense of the axis: [0, 2 pi).
Wide arc_rad(const Pulley& pulley, const Tangent& arrives, const Tangent& leaves) {
  if (pulley.radius_m == 0) return 0;
  const Wide angle = angle_about(widen<Wide>(pulley.axis), arrives.normal, leaves.normal);
  return angle < 0 ? angle + 2 * kPi : angle;
}

}  // namespace

Wide rope_length_m(const Scene&, const Rope& rope, const SampleView& sample) {
  const Wide3 A = end_point(rope, sample, 0), B = end_point(rope, sample, 1);
  if (rope.over.empty()) return norm(B - A);
  Tangent arrives = tangent(A, rope.over.front(), 1);
  Wide length = arrives.length;
  for (std::size_t i = 0; i < rope.over.size(); ++i) {
    const bool last = i + 1 == rope.over.size();
    std::array<Tangent, 2> between;
    if (!last) between = tangents(rope.over[i], rope.over[i + 1]);
    const Tangent leaves = last ? tangent(B, rope.over[i], -1) : between[0];
    length += Wide(rope.over[i].radius_m) * arc_rad(rope.over[i], arrives, leaves) + leaves.length;
    if (!last) arrives = between[1];
  }
  return length;
}

// A point of the rope at its end moves along the straight part with the body's point there, and a turn of the straight
// part winds as much rope onto the pulley as its tangent point moves: the speed of the rope is v . e (the involute of a
// circle).
Wide rope_speed_m_per_s(const Scene&, const Rope& rope, const SampleView& sample) {
  const BodySample& body = body_of(sample, rope.bodies[0]);
  const Wide3 arm = to_world(body, rope.points_body_m[0]), v = point_velocity(body, arm);
  const Wide3 A = body.p_m + arm;
  if (rope.over.empty()) {
    const Wide3 D = end_point(rope, sample, 1) - A;
    return dot(v, D) / norm(D);
  }
  return dot(v, tangent(A, rope.over.front(), 1).along);
}

}  // namespace atwood::dynamics
