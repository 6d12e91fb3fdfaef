// Mechanisms of a run: which bodies joints connect, their rows of constraints, and the factors of these.
#include "contact/stepping/mechanisms.hpp"

#include <algorithm>

#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/impact_prediction.hpp"
#include "math/so3.hpp"
#include "scene/mechanism.hpp"
#include "scene/union_find.hpp"

namespace atwood::stepping {
namespace {

constexpr int kUnknowns = 6;  // of a body

// I^-1 = C C^T with C lower triangular: (xx, yx, zx, yy, zy, zz), world axes.
template <class S> struct InertiaRoot { S xx{}, yx{}, zx{}, yy{}, zy{}, zz{}; };
template <class S> InertiaRoot<S> inertia_root(const Row<S>& inertia) {
  const S* I = inertia.at;
  InertiaRoot<S> c;
  const auto root = [](S square) { return square > S(0) ? real::sqrt(square) : S(0); };
  const auto over = [](S a, S b) { return b > S(0) ? a / b : S(0); };
  c.xx = root(I[0]);
  c.yx = over(I[1], c.xx);
  c.zx = over(I[2], c.xx);
  c.yy = root(I[3] - c.yx * c.yx);
  c.zy = over(I[4] - c.yx * c.zx, c.yy);
  c.zz = root(I[5] - c.zx * c.zx - c.zy * c.zy);
  return c;
}

// Adds M^-1/2 (force, torque) to six unknowns.
template <class S> void add_scaled(const Row<S>& inertia, const Vec3<S>& force, const Vec3<S>& torque, S* z) {
  const InertiaRoot<S> c = inertia_root(inertia);
  const S root = real::sqrt(inertia.at[6]);
  store3(load3(z) + root * force, z);
  const Vec3<S> turned{c.xx * torque.x + c.yx * torque.y + c.zx * torque.z, c.yy * torque.y + c.zy * torque.z,
                       c.zz * torque.z};
  store3(load3(z + 3) + turned, z + 3);
}

// The rate u_k of a joint as a row; also the wrench pair of a force along it.
template <class S>
void set_coordinate_row(const Joint& joint, int k, const TiedBody<S>& parent, const TiedBody<S>& child,
                        TiedRow<S>& row) {
  row.body[0] = joint.parent;
  row.body[1] = joint.child;
  row.on[0] = row.on[1] = {};
  if (joint.kind == JointKind::ball || joint.kind == JointKind::universal) {
    Vec3<S> along;
    if (joint.kind == JointKind::ball) {
      along = rotate(child.q_WB, Vec3<S>{S(k == 0), S(k == 1), S(k == 2)});
    } else {  // w_rel = a1 u0 + a2 u1
      const Vec3<S> a1 = rotate(parent.q_WB, narrow3<S>(joint.axes_body[0])),
                    a2 = rotate(child.q_WB, narrow3<S>(joint.axes_body[1]));
      const S c = dot(a1, a2);
      along = (S(1) / (S(1) - c * c)) * (k == 0 ? a1 - c * a2 : a2 - c * a1);
    }
    row.on[0].torque = -along;
    row.on[1].torque = along;
    return;
  }
  const Vec3<S> axis = narrow3<S>(joint.axis_body), a = rotate(child.q_WB, (S(1) / norm(axis)) * axis);
  const bool slides = joint.kind == JointKind::slider || (joint.kind == JointKind::cylindrical && k == 1);
  if (!slides) {
    row.on[0].torque = -a;
    row.on[1].torque = a;
    return;
  }
  const Vec3<S> r_p = rotate(parent.q_WB, narrow3<S>(joint.anchors_body_m[0])),
                r_c = rotate(child.q_WB, narrow3<S>(joint.anchors_body_m[1]));
  const Vec3<S> d = (child.p_WB - parent.p_WB) + (r_c - r_p);
  row.on[0] = {-a, -cross(r_p, a)};
  row.on[1] = {a, cross(r_c - d, a)};
}

// The row of a condition at time t, its torques such that both impulses act at one point of the world.
template <class S>
void set_condition_row(const TiedJoint<S>& joint, int i, const TiedBody<S>& parent, const TiedBody<S>& child, S t_s,
                       S size_m, TiedRow<S>& row) {
  JointRow<S> c;
  constraint_row(joint.constraint, i, parent, child, t_s, c);
  row.body[0] = joint.constraint.parent;
  row.body[1] = joint.constraint.child;
  row.value = c.value;
  row.rate = c.rate;
  for (int k = 0; k < 2; ++k) row.on[k] = c.on[k];
  const ConditionKind kind = joint.constraint.conditions[static_cast<std::size_t>(i)].kind;
  const bool length = kind == ConditionKind::point || kind == ConditionKind::slide;
  const S far = real::max(norm(child.p_WB), norm(parent.p_WB)) + size_m;
  const S angle = kind == ConditionKind::turn ? real::max(S(1), real::abs(c.rate * t_s)) : S(1);
  row.tolerance = S(32) * real::epsilon<S>() * (length ? far : angle);
  if (kind != ConditionKind::point) return;
  const Vec3<S> x_p = parent.p_WB + rotate(parent.q_WB, joint.constraint.anchor[0]),
                x_c = child.p_WB + rotate(child.q_WB, joint.constraint.anchor[1]), x = S(0.5) * (x_p + x_c);
  const Vec3<S>& n = row.on[1].force;
  row.on[0].torque = -cross(x - parent.p_WB, n);
  row.on[1].torque = cross(x - child.p_WB, n);
}

}  // namespace

template <class S> TiedBody<S> tied_body(const World<S>& world, int body, S after_s) {
  if (body < 0) return {};
  const BodyRows<S>& bodies = world.bodies;
  const TiedBodies<S>& tied = *world.tied;
  const auto i = static_cast<std::size_t>(body);
  const S* v = bodies.velocity[i].at;
  TiedBody<S> out{load3(bodies.pose[i].at), bodies.q_WB[i], load3(v), load3(v + 3)};
  if (tied.mechanism_of[i] < 0) return out;
  out.q_WB = tied.q_begin[i];
  if (after_s == S(0)) return out;
  const S* shift = bodies.impact_shift[i].at;
  out.p_WB += load3(shift) + after_s * out.v_WB;
  out.q_WB = normalised(so3_exp(load3(shift + 3) + after_s * out.w_WB) * out.q_WB);
  return out;
}

namespace {

// Where impulses act after_s into the substep: a body that had impacts moves as if it had started from its shifted
// place.
template <class S> TiedBody<S> shifted_body(const World<S>& world, int body, S after_s) {
  TiedBody<S> out = tied_body(world, body, after_s);
  if (after_s > S(0) || body < 0 || !is_tied(world, body)) return out;
  const S* shift = world.bodies.impact_shift[static_cast<std::size_t>(body)].at;
  const Vec3<S> by = load3(shift), turned = load3(shift + 3);
  out.p_WB += by;
  if (dot(turned, turned) > S(0)) out.q_WB = normalised(so3_exp(turned) * out.q_WB);
  return out;
}

}  // namespace

template <class S> S rate_of(const World<S>& world, const TiedRow<S>& row) {
  S rate{};
  for (int k = 0; k < 2; ++k) {
    if (row.body[k] < 0) continue;
    const S* v = world.bodies.velocity[static_cast<std::size_t>(row.body[k])].at;
    rate += dot(row.on[k].force, load3(v)) + dot(row.on[k].torque, load3(v + 3));
  }
  return rate;
}

template <class S> void apply_row(World<S>& world, const TiedRow<S>& row, S impulse) {
  for (int k = 0; k < 2; ++k) {
    if (row.body[k] < 0 || !world.bodies.moves[static_cast<std::size_t>(row.body[k])]) continue;
    S* v = world.bodies.velocity[static_cast<std::size_t>(row.body[k])].at;
    const Row<S>& inertia = world.bodies.inertia[static_cast<std::size_t>(row.body[k])];
    store3(load3(v) + (impulse * inertia.at[6]) * row.on[k].force, v);
    store3(load3(v + 3) + apply_inverse_inertia(inertia, impulse * row.on[k].torque), v + 3);
  }
}

template <class S>
void add_to_response(const World<S>& world, int body, const Vec3<S>& force, const Vec3<S>& torque,
                     TiedResponse<S>& to) {
  const auto i = static_cast<std::size_t>(body);
  add_scaled(world.bodies.inertia[i], force, torque, to.z.data() + world.tied->first_unknown[i]);
}

template <class S> void project_response(World<S>& world, TiedResponse<S>& response) {
  if (response.mechanism < 0) return;
  Mechanism<S>& mechanism = world.tied->mechanisms[static_cast<std::size_t>(response.mechanism)];
  const std::size_t size = response.z.size();
  for (std::size_t j = 0; j < mechanism.rows.size(); ++j) {
    mechanism.b[j] = S(0);
    for (std::size_t i = 0; i < size; ++i) mechanism.b[j] += mechanism.columns[j * size + i] * response.z[i];
  }
  mechanism.qr.solve(mechanism.b.data(), mechanism.z.data());
  for (std::size_t i = 0; i < size; ++i) response.z[i] -= mechanism.z[i];
}

template <class S> void factor_rows(World<S>& world, Mechanism<S>& mechanism, S after_s, bool dampers) {
  TiedBodies<S>& tied = *world.tied;
  auto& rows = mechanism.rows;
  rows.clear();
  int compliant_unknown = 0;
  for (const int j : mechanism.joints) {
    const TiedJoint<S>& joint = tied.joints[static_cast<std::size_t>(j)];
    const Joint& of = world.scene->joints[static_cast<std::size_t>(j)];
    const TiedBody<S> parent = shifted_body(world, of.parent, after_s), child = shifted_body(world, of.child, after_s);
    for (int i = 0; i < static_cast<int>(joint.constraint.conditions.size()); ++i) {
      rows.push_back({});
      rows.back().joint = j;
      set_condition_row(joint, i, parent, child, world.t_s, tied.size_m, rows.back());
      rows.back().target_rate = rows.back().rate;
    }
    for (int k = 0; dampers && k < rate_count(of.kind); ++k) {
      if (!(joint.damping[k] > S(0))) continue;
      rows.push_back({});
      TiedRow<S>& row = rows.back();
      set_coordinate_row(of, k, parent, child, row);
      row.joint = j;
      row.coordinate = k;
      row.compliant_unknown = compliant_unknown++;
      row.compliance = S(1) / real::sqrt(world.sub_s * joint.damping[k]);
    }
  }
  const int bodies = kUnknowns * static_cast<int>(mechanism.bodies.size()), size = bodies + compliant_unknown;
  const int count = static_cast<int>(rows.size());
  mechanism.compliant_velocity.assign(static_cast<std::size_t>(compliant_unknown), S(0));
  mechanism.b.resize(rows.size());
  mechanism.x.resize(rows.size());
  mechanism.z.resize(static_cast<std::size_t>(size));
  mechanism.qr.resize(size, count);
  mechanism.columns.clear();
  for (int j = 0; j < count; ++j) {
    TiedRow<S>& row = rows[static_cast<std::size_t>(j)];
    S* column = mechanism.qr.column(j);
    std::fill(column, column + size, S(0));
    for (int k = 0; k < 2; ++k) {
      if (row.body[k] < 0 || tied.mechanism_of[static_cast<std::size_t>(row.body[k])] < 0) continue;
      const auto i = static_cast<std::size_t>(row.body[k]);
      add_scaled(world.bodies.inertia[i], row.on[k].force, row.on[k].torque, column + tied.first_unknown[i]);
    }
    if (row.compliant_unknown >= 0) column[bodies + row.compliant_unknown] = row.compliance;
    S square{};
    for (int i = 0; i < size; ++i) square += column[i] * column[i];
    row.scale = square > S(0) ? S(1) / real::sqrt(square) : S(0);
    for (int i = 0; i < size; ++i) column[i] *= row.scale;
  }
  mechanism.columns.assign(mechanism.qr.column(0), mechanism.qr.column(0) + static_cast<std::ptrdiff_t>(size) * count);
  mechanism.qr.factor(S(1024) * real::epsilon<S>());
}

template <class S> void satisfy_joints(World<S>& world, Mechanism<S>& mechanism) {
  auto& rows = mechanism.rows;
  const auto soft_of = [&](const TiedRow<S>& row) -> S& {
    return mechanism.compliant_velocity[static_cast<std::size_t>(row.compliant_unknown)];
  };
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const TiedRow<S>& row = rows[j];
    const S compliant_unknown = row.compliant_unknown >= 0 ? row.compliance * soft_of(row) : S(0);
    mechanism.b[j] = row.scale * (row.target_rate - (rate_of(world, row) + compliant_unknown));
  }
  mechanism.qr.solve(mechanism.b.data(), mechanism.z.data());
  mechanism.qr.multipliers(mechanism.x.data());
  for (std::size_t j = 0; j < rows.size(); ++j) {
    TiedRow<S>& row = rows[j];
    const S impulse = row.scale * mechanism.x[j];
    if (impulse == S(0)) continue;
    apply_row(world, row, impulse);
    row.impulse += impulse;
    if (row.compliant_unknown >= 0) soft_of(row) += row.compliance * impulse;
  }
}

template <class S> void add_reactions(World<S>& world, Mechanism<S>& mechanism, S after_s) {
  TiedBodies<S>& tied = *world.tied;
  for (TiedRow<S>& row : mechanism.rows) {
    TiedJoint<S>& joint = tied.joints[static_cast<std::size_t>(row.joint)];
    if (row.compliant_unknown >= 0) {
      joint.applied[row.coordinate] += row.impulse;
    } else {
      const TiedBody<S> child = tied_body(world, row.body[1], after_s);
      const Vec3<S> arm = rotate(child.q_WB, joint.constraint.anchor[1]);
      joint.force += row.impulse * row.on[1].force;
      joint.torque += row.impulse * (row.on[1].torque - cross(arm, row.on[1].force));
    }
    row.impulse = S(0);
  }
}

template <class S> bool are_joined(const World<S>& world, int a, int b) {
  if (world.tied == nullptr) return false;
  return std::binary_search(world.tied->joined.begin(), world.tied->joined.end(),
                            std::pair<int, int>(std::minmax(a, b)));
}

namespace {

template <class S> TiedJoint<S> make_tied_joint(const Scene& scene, const Joint& joint) {
  TiedJoint<S> tied;
  Quat<S> attitude{};
  if (joint.parent >= 0) {
    const auto& q = scene.bodies[static_cast<std::size_t>(joint.parent)].orientation_wxyz;
    attitude = normalised(Quat<S>{S(q[0]), S(q[1]), S(q[2]), S(q[3])});
  }
  tied.constraint = joint_constraint<S>(joint, attitude);
  return tied;
}

template <class S> void add_stops(const Joint& joint, int index, TiedBodies<S>& to, Mechanism<S>& mechanism) {
  for (const bool lower : {true, false}) {
    StopConstraint<S> stop;
    stop.joint = index;
    stop.side = lower ? S(1) : S(-1);
    stop.limit = S(lower ? joint.limits->lower : joint.limits->upper);
    stop.restitution = S(joint.limits->restitution);
    stop.round_off = S(64) * real::epsilon<S>() * real::max(S(1), real::abs(stop.limit));
    to.has_stop_restitution = to.has_stop_restitution || stop.restitution > S(0);
    mechanism.stops.push_back(static_cast<int>(to.stops.size()));
    to.stops.push_back(stop);
  }
}

// Sets `mechanism_of`, `local` and the mechanisms' bodies; `parent`: the union-find over bodies.
template <class S> void list_bodies(const Scene& scene, std::vector<int>& parent, TiedBodies<S>& to) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) continue;
    const int index = to.mechanism_of[static_cast<std::size_t>(find_root(parent, static_cast<int>(i)))];
    if (index < 0) continue;
    Mechanism<S>& mechanism = to.mechanisms[static_cast<std::size_t>(index)];
    to.mechanism_of[i] = index;
    to.first_unknown[i] = kUnknowns * static_cast<int>(mechanism.bodies.size());
    mechanism.bodies.push_back(static_cast<int>(i));
  }
}

template <class S> void add_dampers(const Scene& scene, TiedBodies<S>& to) {
  for (const JointForce& force : scene.joint_forces) {
    const auto* spring = std::get_if<JointSpring>(&force);
    if (spring == nullptr) continue;
    TiedJoint<S>& joint = to.joints[static_cast<std::size_t>(spring->joint)];
    const bool ball = scene.joints[static_cast<std::size_t>(spring->joint)].kind == JointKind::ball;
    for (int k = 0; k < 3; ++k)
      if (ball || k == spring->coordinate) joint.damping[k] += S(spring->damping);
  }
}

}  // namespace

template <class S> std::unique_ptr<TiedBodies<S>> make_tied_bodies(const Scene& scene) {
  if (scene.joints.empty()) return nullptr;
  auto out = std::make_unique<TiedBodies<S>>();
  const std::size_t count = scene.bodies.size();
  out->mechanism_of.assign(count, -1);
  out->first_unknown.assign(count, -1);
  out->q_begin.resize(count);
  out->q_end.resize(count);
  out->p_end.resize(count);
  out->velocity_before_impact.resize(count);
  std::vector<int> parent(count);
  for (std::size_t i = 0; i < count; ++i) parent[i] = static_cast<int>(i);
  for (const Joint& joint : scene.joints) {
    const bool tied_to_body = joint.parent >= 0;
    if (tied_to_body && !scene.bodies[static_cast<std::size_t>(joint.parent)].fixed)
      unite(parent, joint.parent, joint.child);
    if (tied_to_body) out->joined.push_back(std::minmax(joint.parent, joint.child));
    for (const auto& anchor : joint.anchors_body_m)
      for (const double x : anchor) out->size_m = real::max(out->size_m, real::abs(S(x)));
    for (const double q : joint.coordinates)  // an offset
      if (joint.kind == JointKind::slider) out->size_m = real::max(out->size_m, real::abs(S(q)));
  }
  if (!(out->size_m > S(0))) out->size_m = S(1);  // all anchors are centres of mass
  std::sort(out->joined.begin(), out->joined.end());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    int& index = out->mechanism_of[static_cast<std::size_t>(find_root(parent, joint.child))];
    if (index < 0) {
      index = static_cast<int>(out->mechanisms.size());
      out->mechanisms.push_back({});
    }
    Mechanism<S>& mechanism = out->mechanisms[static_cast<std::size_t>(index)];
    mechanism.joints.push_back(static_cast<int>(j));
    out->joints.push_back(make_tied_joint<S>(scene, joint));
    if (joint.limits) add_stops(joint, static_cast<int>(j), *out, mechanism);
  }
  list_bodies(scene, parent, *out);
  add_dampers(scene, *out);
  return out;
}

template <class S> std::string set_mechanism_start(World<S>& world, S* y) {
  const Scene& scene = *world.scene;
  try {
    const MechanismStart start = mechanism_start(scene);
    const auto narrow = [](const quad::Vector& v) { return Vec3<S>{S(v[0]), S(v[1]), S(v[2])}; };
    for (int i = 0; i < world.bodies.count; ++i) {
      const BodyMotion& m = start.bodies[static_cast<std::size_t>(i)];
      const auto& q = m.q_wxyz;
      world.model->set_body(
          i, {narrow(m.p_m), narrow(m.v_m_per_s), {S(q[0]), S(q[1]), S(q[2]), S(q[3])}, narrow(m.w_rad_per_s)}, y);
    }
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      TiedJoint<S>& joint = world.tied->joints[j];
      for (int k = 0; k < coordinate_count(scene.joints[j].kind); ++k) joint.q[k] = S(start.joints[j].q[k]);
      for (int k = 0; k < rate_count(scene.joints[j].kind); ++k) joint.u[k] = S(start.joints[j].u[k]);
    }
  } catch (const MechanismError& error) {
    return error.what();
  }
  for (StopConstraint<S>& stop : world.tied->stops) {
    stop.impulse = S(0);
    const S gap = stop.side * (world.tied->joints[static_cast<std::size_t>(stop.joint)].q[0] - stop.limit);
    if (gap < -stop.round_off)
      return "joint `" + scene.joints[static_cast<std::size_t>(stop.joint)].name + "` starts beyond its limits";
  }
  return "";
}

template <class S> void coordinate_row(const World<S>& world, int joint, int k, S after_s, TiedRow<S>& row) {
  const Joint& of = world.scene->joints[static_cast<std::size_t>(joint)];
  row.joint = joint;
  set_coordinate_row(of, k, shifted_body(world, of.parent, after_s), shifted_body(world, of.child, after_s), row);
}

#define ATWOOD_MECHANISMS(S)                                                                                \
  template TiedBody<S> tied_body<S>(const World<S>&, int, S);                                               \
  template S rate_of<S>(const World<S>&, const TiedRow<S>&);                                                \
  template void apply_row<S>(World<S>&, const TiedRow<S>&, S);                                              \
  template void add_to_response<S>(const World<S>&, int, const Vec3<S>&, const Vec3<S>&, TiedResponse<S>&); \
  template void project_response<S>(World<S>&, TiedResponse<S>&);                                           \
  template void factor_rows<S>(World<S>&, Mechanism<S>&, S, bool);                                          \
  template void satisfy_joints<S>(World<S>&, Mechanism<S>&);                                                \
  template void add_reactions<S>(World<S>&, Mechanism<S>&, S);                                              \
  template bool are_joined<S>(const World<S>&, int, int);                                                   \
  template std::unique_ptr<TiedBodies<S>> make_tied_bodies<S>(const Scene&);                                \
  template std::string set_mechanism_start<S>(World<S>&, S*);                                               \
  template void coordinate_row<S>(const World<S>&, int, int, S, TiedRow<S>&);
ATWOOD_MECHANISMS(float)
ATWOOD_MECHANISMS(double)
#undef ATWOOD_MECHANISMS

}  // namespace atwood::stepping
