#include "scene/loop_projection.hpp"

#include <algorithm>
#include <numeric>

#include "scene/least_change.hpp"
#include "scene/rope_path.hpp"
#include "scene/union_find.hpp"

namespace atwood {

using namespace quad;

namespace {

// One unknown: a rate of a placing joint, or of a free body that no joint places (0 to 2: velocity, 3 to 5: turning
// about its own axes). It moves the bodies as a screw does: along `axis`, or by turning about it through `point`
// (world).
struct Freedom {
  int body = -1;   // a root, or the child of `joint`
  int joint = -1;  // -1: of a root
  std::size_t component = 0;
  bool slides = false;
  Vector axis{}, point{};
};

// A linear form on the motions of two bodies: force . v + torque . w, w in world axes, v of the centre of mass.
struct Row {
  std::array<int, 2> bodies{-1, -1};
  std::array<Vector, 2> force{}, torque{};
  Real residual = 0;      // of the positions
  Real target = 0;        // the rate that it should have
  bool is_length = true;  // else an angle
};

struct Loops {
  const Scene& scene;
  std::vector<int> order;      // placing joints from the root
  std::vector<int> placing;    // of each body
  std::vector<bool> involved;  // bodies of mechanisms with loops or ropes
  std::vector<Freedom> freedoms;
  std::vector<std::vector<int>> movers;  // of each body the freedoms that move it
  Real size = 1;                         // [m]
};

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

// Joints whose coordinates the projection leaves as they are.
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

Vector world_point(const MechanismStart& start, int body, const std::array<double, 3>& point_body) {
  const BodyMotion world = world_motion();
  const BodyMotion& m = motion_of(start.bodies, body, world);
  return m.p_m + rotate(m.q_wxyz, wide(point_body));
}
Vector point_velocity(const MechanismStart& start, int body, const std::array<double, 3>& point_body) {
  const BodyMotion world = world_motion();
  const BodyMotion& m = motion_of(start.bodies, body, world);
  return m.v_m_per_s + rotate(m.q_wxyz, cross(m.w_rad_per_s, wide(point_body)));
}

// Calls f(body, point) for all anchors of joints, ends of ropes and centres of mass of mechanisms with loops or ropes.
template <class F> void each_point(const Scene& scene, const std::vector<bool>& involved, F f) {
  const auto take = [&](int body, const Real3& point, int other) {
    const auto in = [&](int b) { return b >= 0 && involved[static_cast<std::size_t>(b)]; };
    if (in(body) || in(other)) f(body, point);
  };
  for (const Joint& joint : scene.joints) {
    take(joint.parent, joint.anchors_body_m[0], joint.child);
    take(joint.child, joint.anchors_body_m[1], joint.parent);
  }
  for (const Rope& rope : scene.ropes)
    for (std::size_t i = 0; i < 2; ++i) take(rope.bodies[i], rope.points_body_m[i], rope.bodies[1 - i]);
  for (std::size_t b = 0; b < involved.size(); ++b)
    if (involved[b]) f(static_cast<int>(b), Real3{});
}

// The diagonal of the box around anchors, ends of ropes and centres of mass.
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

// The screws of all freedoms in the present configuration.
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

// ---- the linear problem -------------------------------------------------------------------------------------------
struct Twist {
  Vector v, w;  // of the centre of mass; world axes
};
Twist twist_of(const Freedom& freedom, const MechanismStart& start, int body) {
  if (freedom.slides) return {freedom.axis, {}};
  return {cross(freedom.axis, start.bodies[static_cast<std::size_t>(body)].p_m - freedom.point), freedom.axis};
}

// The row over all freedoms.
std::vector<Real> over_freedoms(const Loops& loops, const MechanismStart& start, const Row& row) {
  std::vector<Real> out(loops.freedoms.size());
  for (std::size_t i = 0; i < 2; ++i) {
    if (row.bodies[i] < 0) continue;
    for (const int f : loops.movers[static_cast<std::size_t>(row.bodies[i])]) {
      const Twist t = twist_of(loops.freedoms[static_cast<std::size_t>(f)], start, row.bodies[i]);
      out[static_cast<std::size_t>(f)] += dot(row.force[i], t.v) + dot(row.torque[i], t.w);
    }
  }
  return out;
}

Vector inertia_times(const Body& body, const Quaternion& q, const Vector& w) {
  const Vector own = rotate_back(q, w);
  Vector out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out[i] += body.inertia_kg_m2[3 * i + j] * own[j];
  return rotate(q, out);
}

SymmetricMatrix mass_matrix(const Loops& loops, const MechanismStart& start) {
  SymmetricMatrix mass(loops.freedoms.size());
  for (std::size_t b = 0; b < loops.scene.bodies.size(); ++b) {
    const Body& body = loops.scene.bodies[b];
    for (const int f : loops.movers[b]) {
      const Twist t = twist_of(loops.freedoms[static_cast<std::size_t>(f)], start, static_cast<int>(b));
      const Vector momentum = Real(body.mass_kg) * t.v;
      const Vector spin = inertia_times(body, start.bodies[b].q_wxyz, t.w);
      for (const int g : loops.movers[b]) {
        if (g > f) continue;
        const Twist other = twist_of(loops.freedoms[static_cast<std::size_t>(g)], start, static_cast<int>(b));
        mass.at(static_cast<std::size_t>(f), static_cast<std::size_t>(g)) +=
            dot(momentum, other.v) + dot(spin, other.w);
      }
    }
  }
  // Pulleys turn with the rope's speed, that of its first end along the first straight part.
  for (std::size_t i = 0; i < loops.scene.ropes.size(); ++i) {
    const RopePath path = path_of(loops.scene, start, i);
    Row speed = rope_row(loops.scene, start, i, path);
    speed.bodies[1] = -1;
    Real weight = 0;
    for (const Pulley& pulley : loops.scene.ropes[i].over)
      if (pulley.radius_m > 0) weight += Real(pulley.inertia_kg_m2) / (Real(pulley.radius_m) * pulley.radius_m);
    if (weight == 0) continue;
    const std::vector<Real> row = over_freedoms(loops, start, speed);
    for (std::size_t f = 0; f < row.size(); ++f)
      for (std::size_t g = 0; g <= f; ++g) mass.at(f, g) += weight * row[f] * row[g];
  }
  return mass;
}

std::vector<Row> all_rows(const Loops& loops, const MechanismStart& start, bool with_ropes) {
  std::vector<Row> rows;
  for (const Joint& joint : loops.scene.joints)
    if (joint.closes_loop)
      for (const Row& row : joint_rows(joint, start)) rows.push_back(row);
  if (with_ropes)
    for (std::size_t i = 0; i < loops.scene.ropes.size(); ++i)
      rows.push_back(rope_row(loops.scene, start, i, path_of(loops.scene, start, i)));
  return rows;
}

LeastChange factorised(const Loops& loops, const MechanismStart& start, bool with_ropes, double rank_tolerance) {
  std::vector<std::vector<Real>> rows;
  for (const Row& row : all_rows(loops, start, with_ropes)) {
    rows.push_back(over_freedoms(loops, start, row));
    if (row.is_length)
      for (Real& x : rows.back()) x /= loops.size;
  }
  return LeastChange(mass_matrix(loops, start), rows, rank_tolerance);
}

// ---- moving -------------------------------------------------------------------------------------------------------
void place_bodies(const Loops& loops, MechanismStart& start) {
  const BodyMotion world = world_motion();
  for (const int j : loops.order) {
    const Joint& joint = loops.scene.joints[static_cast<std::size_t>(j)];
    if (loops.involved[static_cast<std::size_t>(joint.child)])
      start.bodies[static_cast<std::size_t>(joint.child)] =
          placed_child(joint, start.joints[static_cast<std::size_t>(j)], motion_of(start.bodies, joint.parent, world));
  }
}

// Adds a displacement to the coordinates; those of a rotation group by the exponential of the body's turn.
void displace(const Loops& loops, const std::vector<Real>& step, MechanismStart& start) {
  for (std::size_t f = 0; f < loops.freedoms.size(); ++f) {
    const Freedom& freedom = loops.freedoms[f];
    BodyMotion& body = start.bodies[static_cast<std::size_t>(freedom.body)];
    const bool ball =
        freedom.joint >= 0 && loops.scene.joints[static_cast<std::size_t>(freedom.joint)].kind == JointKind::ball;
    const bool turns = ball ? freedom.component == 0 : freedom.joint < 0 && freedom.component == 3;
    if (turns) {
      Quaternion& q = ball ? start.joints[static_cast<std::size_t>(freedom.joint)].q : body.q_wxyz;
      q = normalised(product(q, exponential({step[f], step[f + 1], step[f + 2]})));
    } else if (freedom.joint < 0 && freedom.component < 3) {
      body.p_m[freedom.component] += step[f];
    } else if (freedom.joint >= 0 && !ball) {
      start.joints[static_cast<std::size_t>(freedom.joint)].q[freedom.component] += step[f];
    }
  }
  place_bodies(loops, start);
}

void accelerate(const Loops& loops, const std::vector<Real>& change, MechanismStart& start) {
  for (std::size_t f = 0; f < loops.freedoms.size(); ++f) {
    const Freedom& freedom = loops.freedoms[f];
    BodyMotion& body = start.bodies[static_cast<std::size_t>(freedom.body)];
    if (freedom.joint >= 0) start.joints[static_cast<std::size_t>(freedom.joint)].u[freedom.component] += change[f];
    else if (freedom.component < 3) body.v_m_per_s[freedom.component] += change[f];
    else body.w_rad_per_s[freedom.component - 3] += change[f];
  }
  place_bodies(loops, start);
}

Real largest_of(const std::vector<Real>& values) {
  Real out = 0;
  for (const Real x : values) out = isnanq(x) ? x : fmaxq(out, fabsq(x));
  return out;
}

std::vector<Real> residuals(const Loops& loops, const MechanismStart& start) {
  std::vector<Real> out;
  for (const Row& row : all_rows(loops, start, false))
    out.push_back(row.is_length ? row.residual / loops.size : row.residual);
  return out;
}
std::vector<Real> rate_residuals(const Loops& loops, const MechanismStart& start) {
  std::vector<Real> out;
  for (const Row& row : all_rows(loops, start, true)) {
    const Real off = rate_of(row, start) - row.target;
    out.push_back(row.is_length ? off / loops.size : off);
  }
  return out;
}

// The rows of a hinge vanish for opposite axes as well.
bool axes_agree(const Scene& scene, const MechanismStart& start) {
  const BodyMotion world = world_motion();
  for (const Joint& joint : scene.joints) {
    if (!joint.closes_loop || (joint.kind != JointKind::hinge && joint.kind != JointKind::cylindrical)) continue;
    const Quaternion on_parent =
        product(motion_of(start.bodies, joint.parent, world).q_wxyz, normalised(wide(joint.frame_wxyz)));
    const Vector axis = wide(joint.axis_body);
    if (dot(rotate(on_parent, axis), rotate(motion_of(start.bodies, joint.child, world).q_wxyz, axis)) < 0)
      return false;
  }
  return true;
}

constexpr double kConverged = 1e-30;  // of the residuals: lengths over the size, angles in radians
constexpr double kRoundOff = 1e-33;   // of the same

// Newton's method; whether it converged. A step turns nothing by more than half a radian and moves nothing by more than
// half the size, and neither by more than ten times the root of the residual: near a singular configuration a gap of g
// closes by a displacement of the order of sqrt(g), where Newton's step may be of any size. A decomposition is used
// again after steps so small that it would be the same to ten digits.
bool close_loops(Loops& loops, MechanismStart& start, double rank_tolerance) {
  std::optional<LeastChange> solve;
  Real before = 0;
  bool converged = false;
  for (int iteration = 0; iteration < 200; ++iteration) {
    const std::vector<Real> off = residuals(loops, start);
    const Real worst = largest_of(off);
    // A step more takes a residual below the tolerance to round-off; a start that is at it stays to the bit.
    if (converged || (iteration == 0 && worst <= kRoundOff)) return axes_agree(loops.scene, start);
    converged = worst <= kConverged;
    if (isnanq(worst) || (iteration > 20 && worst > Real(0.5) * before && worst < Real(1e-20))) return false;
    before = worst;
    if (!solve) {
      set_screws(loops, start);
      solve.emplace(factorised(loops, start, false, rank_tolerance));
    }
    std::vector<Real> step = solve->change(off);
    Real fraction = 1;
    for (std::size_t f = 0; f < step.size(); ++f) {
      const Real most = fminq(Real(0.5), 10 * sqrtq(worst)) * (loops.freedoms[f].slides ? loops.size : Real(1));
      if (fabsq(step[f]) > most) fraction = fminq(fraction, most / fabsq(step[f]));
    }
    for (Real& x : step) x *= fraction;
    displace(loops, step, start);
    if (largest_of(step) > Real(1e-10)) solve.reset();
  }
  return false;
}

bool match_rates(Loops& loops, MechanismStart& start, double rank_tolerance) {
  Real speed = 1;
  for (const BodyMotion& body : start.bodies)
    speed = fmaxq(speed, fmaxq(norm(body.v_m_per_s) / loops.size, norm(body.w_rad_per_s)));
  const Real tolerance = kConverged * speed;
  if (largest_of(rate_residuals(loops, start)) <= kRoundOff * speed) return true;
  set_screws(loops, start);
  const LeastChange solve = factorised(loops, start, true, rank_tolerance);
  bool matched = false;
  for (int refinement = 0; refinement < 4 && !matched; ++refinement) {
    matched = refinement > 0 && largest_of(rate_residuals(loops, start)) <= tolerance;  // then one more, as above
    accelerate(loops, solve.change(rate_residuals(loops, start)), start);
  }
  return largest_of(rate_residuals(loops, start)) <= tolerance;
}

// The closing joint with the largest residual.
int worst_joint(const Loops& loops, const MechanismStart& start) {
  int worst = -1;
  Real most = -1;
  for (std::size_t j = 0; j < loops.scene.joints.size(); ++j) {
    if (!loops.scene.joints[j].closes_loop) continue;
    for (const Row& row : joint_rows(loops.scene.joints[j], start)) {
      const Real off = fabsq(row.is_length ? row.residual / loops.size : row.residual);
      if (off > most || isnanq(off)) most = off, worst = static_cast<int>(j);
    }
  }
  return worst;
}

// Of the joints that move bodies of loops, those whose coordinates stay as given: "`a`, `b`".
std::string names_of_kept_joints(const Loops& loops) {
  const Scene& scene = loops.scene;
  const std::vector<bool> held = held_joints(scene);
  std::string names;
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (held[j] && loops.involved[static_cast<std::size_t>(scene.joints[j].child)])
      names += (names.empty() ? "`" : ", `") + scene.joints[j].name + "`";
  return names;
}

// Whether the loops close where no coordinate is driven or held.
bool closes_when_released(const Scene& scene, MechanismStart start) {
  Scene released = scene;
  for (Joint& joint : released.joints) {
    joint.driven_rate.reset();
    joint.hold.clear();
  }
  Loops loops{released, joints_from_root(released), placing_joints(released), involved_bodies(released), {}, {}, 1};
  add_freedoms(loops);
  loops.size = mechanism_size(released, loops.involved, start);
  return close_loops(loops, start, 1e-8);
}

}  // namespace

void project_start(const Scene& scene, MechanismStart& start) {
  bool closes = false;
  for (const Joint& joint : scene.joints) closes = closes || joint.closes_loop;
  if (!closes && scene.ropes.empty()) return;
  Loops loops{scene, joints_from_root(scene), placing_joints(scene), involved_bodies(scene), {}, {}, 1};
  add_freedoms(loops);
  loops.size = mechanism_size(scene, loops.involved, start);

  // Directions whose effect on the constraints is below the tolerance (of the largest) are left alone: at a singular
  // configuration the round-off of doubles would otherwise move the start far along them. Where the loop does not close
  // without them, they are used.
  const MechanismStart given = start;
  for (const double rank_tolerance : {1e-8, 1e-14, 1e-24}) {
    start = given;
    if (close_loops(loops, start, rank_tolerance) && match_rates(loops, start, rank_tolerance)) return;
  }
  start = given;
  const bool closed = close_loops(loops, start, 1e-8) || (start = given, close_loops(loops, start, 1e-24));
  const int joint = worst_joint(loops, start);
  const std::string name =
      joint < 0 ? "the ropes" : "joint `" + scene.joints[static_cast<std::size_t>(joint)].name + "`";
  const std::string kept = names_of_kept_joints(loops);
  if (!closed && !kept.empty() && closes_when_released(scene, given))
    throw MechanismError("the loop that " + name + " closes does not close while the coordinates of " + kept +
                             ", which are driven or held, stay as they are: they leave the other joints too few "
                             "freedoms, or one of them is out of reach; expected fewer driven or held joints, or other "
                             "coordinates of theirs",
                         joint);
  if (!closed)
    throw MechanismError(
        "the loop that " + name +
            " closes has no configuration near the given one that satisfies its joints; expected lengths "
            "and coordinates with which it closes",
        joint);
  throw MechanismError(
      "no rates satisfy the constraints of " + name +
          (kept.empty() ? std::string("; expected others")
                        : " with those of " + kept + ", which are driven or held; expected others, or fewer of them"),
      joint);
}

LoopGap joint_gap(const Scene& scene, const MechanismStart& start, int joint) {
  const std::vector<bool> involved = involved_bodies(scene);
  const Real size = mechanism_size(scene, involved, start);
  Real speed = size, turning = 1;
  each_point(scene, involved,
             [&](int body, const Real3& point) { speed = fmaxq(speed, norm(point_velocity(start, body, point))); });
  for (std::size_t b = 0; b < involved.size(); ++b)
    if (involved[b]) turning = fmaxq(turning, norm(start.bodies[b].w_rad_per_s));
  LoopGap out;
  for (const Row& row : joint_rows(scene.joints[static_cast<std::size_t>(joint)], start)) {
    const Real gap = fabsq(row.is_length ? row.residual / size : row.residual);
    const Real rate = fabsq(rate_of(row, start) - row.target) / (row.is_length ? speed : turning);
    out.gap = std::max(out.gap, static_cast<double>(gap));
    out.rate = std::max(out.rate, static_cast<double>(rate));
  }
  return out;
}

LoopGap rope_gap(const Scene& scene, const MechanismStart& start, int rope) {
  const std::vector<bool> involved = involved_bodies(scene);
  Real speed = mechanism_size(scene, involved, start);
  each_point(scene, involved,
             [&](int body, const Real3& point) { speed = fmaxq(speed, norm(point_velocity(start, body, point))); });
  const auto index = static_cast<std::size_t>(rope);
  const Row row = rope_row(scene, start, index, path_of(scene, start, index));
  return {0, static_cast<double>(fabsq(rate_of(row, start)) / speed)};
}

void require_bends(const Scene& scene, const MechanismStart& start) {
  constexpr double round_off_rad = 1e-12, least_rad = -0.25 * 3.14159265358979323846;
  for (std::size_t i = 0; i < scene.ropes.size(); ++i) {
    const Rope& rope = scene.ropes[i];
    const RopePath path = path_of(scene, start, i);
    for (std::size_t k = 0; k < rope.over.size(); ++k) {
      if (rope.over[k].radius_m == 0) continue;
      const Vector &in = path.directions[k], &out = path.directions[k + 1];
      const Real bend = atan2q(dot(unit(wide(rope.over[k].axis)), cross(in, out)), dot(in, out));
      if (bend < -round_off_rad && bend > least_rad)
        throw MechanismError("rope `" + rope.name + "` leaves pulley " + std::to_string(k) +
                                 ", or bends around it by more than 315 degrees; expected a bend of 0 to 315 degrees "
                                 "in the sense of the pulley's `axis`",
                             -1, static_cast<int>(i));
    }
  }
}

}  // namespace atwood
