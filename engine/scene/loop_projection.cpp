#include "scene/loop_projection.hpp"

#include <algorithm>

#include "scene/least_change.hpp"
#include "scene/loop_rows.hpp"

namespace atwood {

using namespace quad;
using namespace loop_rows;

namespace {

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
