// Reactions of joints from the motion of all bodies. Unknown is the wrench of each joint within the directions in which
// it constrains; the Newton-Euler equations of the bodies are linear in it. Gauss-Jordan elimination with complete
// pivoting meets redundant constraints: a component of a wrench is determined if it vanishes on the null space.
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

constexpr double kRankTolerance = 0x1p-40;  // of the largest pivot

// Unit wrench of one unknown: force on the child at its anchor, torque about it.
template <class S> struct Direction {
  std::size_t joint = 0;
  Vec<S> force{}, torque{};
};

template <class S> struct Equations {  // row-major, the right-hand side in the last column
  std::size_t rows = 0, unknowns = 0;
  std::vector<S> entries;
  S& at(std::size_t row, std::size_t column) { return entries[row * (unknowns + 1) + column]; }
};

template <class S> Vec<S> coordinate_axis(int i) {
  Vec<S> e{};
  e[static_cast<std::size_t>(i)] = 1;
  return e;
}

// Two unit vectors orthogonal to the unit vector n and to each other.
template <class S> std::array<Vec<S>, 2> orthogonal(const Vec<S>& n) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (magnitude(n[static_cast<std::size_t>(i)]) < magnitude(n[static_cast<std::size_t>(least)])) least = i;
  Vec<S> a = cross(n, coordinate_axis<S>(least));
  a = (1 / norm(a)) * a;
  return {a, cross(n, a)};
}

template <class S> struct Placed {  // a joint in the world
  Vec<S> anchor{}, n1{}, n2{};
};

template <class S> Placed<S> placed(const Joint& joint, const std::vector<BodyKinematics<S>>& bodies) {
  Placed<S> made;
  const Pose<S>& child = bodies[static_cast<std::size_t>(joint.child)].pose;
  made.anchor = child.p_WB + rotate(child.q_WB, vec<S>(joint.anchors_body_m[1]));
  if (joint.kind == JointKind::universal) {
    made.n1 = unit<S>(joint.axes_body[0]);
    if (joint.parent >= 0) made.n1 = rotate(bodies[static_cast<std::size_t>(joint.parent)].pose.q_WB, made.n1);
    made.n2 = rotate(child.q_WB, unit<S>(joint.axes_body[1]));
  } else if (joint.kind != JointKind::fixed && joint.kind != JointKind::ball) {
    made.n1 = rotate(child.q_WB, unit<S>(joint.axis_body));
  }
  return made;
}

template <class S>
void add_directions(std::size_t index, const Joint& joint, bool held, const Placed<S>& at,
                    std::vector<Direction<S>>& made) {
  const bool free_slide = joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical,
             free_turn = joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical;
  if (free_slide && !held)
    for (const Vec<S>& e : orthogonal(at.n1)) made.push_back({index, e, {}});
  else
    for (int i = 0; i < 3; ++i) made.push_back({index, coordinate_axis<S>(i), {}});
  if (joint.kind == JointKind::ball) return;
  if (joint.kind == JointKind::universal) {
    const Vec<S> across = cross(at.n1, at.n2);
    made.push_back({index, {}, (1 / norm(across)) * across});
  } else if (free_turn && !held) {
    for (const Vec<S>& e : orthogonal(at.n1)) made.push_back({index, {}, e});
  } else {
    for (int i = 0; i < 3; ++i) made.push_back({index, {}, coordinate_axis<S>(i)});
  }
}

template <class S> Vec<S> turned_inertia(const Body& body, const Pose<S>& pose, const Vec<S>& w_W) {
  const Vec<S> w = rotate(conjugate(pose.q_WB), w_W);
  const Real33& I = body.inertia_kg_m2;
  return rotate(pose.q_WB, Vec<S>{S(I[0]) * w[0] + S(I[1]) * w[1] + S(I[2]) * w[2],
                                  S(I[3]) * w[0] + S(I[4]) * w[1] + S(I[5]) * w[2],
                                  S(I[6]) * w[0] + S(I[7]) * w[1] + S(I[8]) * w[2]});
}

template <class S> struct Eliminated {
  std::vector<S> solution;           // free unknowns 0; NaN where the system has no solution at all
  std::vector<std::vector<S>> null;  // basis of the null space
  S residual{};                      // largest right-hand side left in a row without a pivot
};

template <class S> Eliminated<S> eliminate(Equations<S> m) {
  const std::size_t n = m.unknowns;
  std::vector<std::size_t> pivot_row(n, m.rows);
  std::vector<bool> used(m.rows, false);
  S largest = 0;
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t row = m.rows, column = n;
    S most = 0;
    for (std::size_t i = 0; i < m.rows; ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (!used[i] && pivot_row[j] == m.rows && magnitude(m.at(i, j)) > most)
          most = magnitude(m.at(row = i, column = j));
    largest = larger(largest, most);
    if (!(most > S(kRankTolerance) * largest)) break;
    used[row] = true;
    pivot_row[column] = row;
    const S pivot = m.at(row, column);
    for (std::size_t j = 0; j <= n; ++j) m.at(row, j) /= pivot;
    for (std::size_t i = 0; i < m.rows; ++i) {
      const S factor = m.at(i, column);
      if (i == row || factor == 0) continue;
      for (std::size_t j = 0; j <= n; ++j) m.at(i, j) -= factor * m.at(row, j);
    }
  }
  Eliminated<S> made;
  made.solution.assign(n, S(0));
  for (std::size_t j = 0; j < n; ++j) {
    if (pivot_row[j] < m.rows) {
      made.solution[j] = m.at(pivot_row[j], n);
      continue;
    }
    auto& along = made.null.emplace_back(n, S(0));
    along[j] = 1;
    for (std::size_t k = 0; k < n; ++k)
      if (pivot_row[k] < m.rows) along[k] = -m.at(pivot_row[k], j);
  }
  for (std::size_t i = 0; i < m.rows; ++i)
    if (!used[i]) made.residual = larger(made.residual, magnitude(m.at(i, n)));
  return made;
}

template <class S> struct Balance {  // of one body: force and torque about its centre that its motion takes
  Vec<S> force{}, torque{};
};

template <class S>
std::vector<Balance<S>> needed(const Scene& scene, const std::vector<BodyKinematics<S>>& bodies, S& scale) {
  std::vector<Balance<S>> made(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    const BodyKinematics<S>& at = bodies[i];
    const S mass = body.mass_kg;
    const Vec<S> momentum = turned_inertia(body, at.pose, at.w_W), change = turned_inertia(body, at.pose, at.alpha_W);
    made[i].force = mass * (at.a_W - vec<S>(scene.gravity_m_per_s2));
    made[i].torque = change + cross(at.w_W, momentum);
    for (const Vec<S>& term : {mass * at.a_W, mass * vec<S>(scene.gravity_m_per_s2), change, cross(at.w_W, momentum)})
      scale = larger(scale, norm(term));
  }
  return made;
}

// A wrench on the child at `anchor`, and its opposite on the parent there.
template <class S, class Add>
void apply(const Joint& joint, const Vec<S>& anchor, const Vec<S>& force, const Vec<S>& torque,
           const std::vector<BodyKinematics<S>>& bodies, const Add& add) {
  const auto to = [&](int body, S sign) {
    if (body < 0) return;
    const Vec<S> arm = anchor - bodies[static_cast<std::size_t>(body)].pose.p_WB;
    add(static_cast<std::size_t>(body), sign * force, sign * (torque + cross(arm, force)));
  };
  to(joint.child, 1);
  to(joint.parent, -1);
}

}  // namespace

template <class S>
S solve_reactions(const Scene& scene, const std::vector<BodyKinematics<S>>& bodies, S t_s,
                  std::vector<JointState<S>>& joints) {
  S scale = 0;
  std::vector<Balance<S>> left = needed(scene, bodies, scale);
  std::vector<Direction<S>> directions;
  std::vector<Placed<S>> places;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const Placed<S> at = places.emplace_back(placed(joint, bodies));
    add_directions(j, joint, joint.driven_rate.has_value() || joints[j].locked, at, directions);
    Vec<S> force{}, torque{};
    for (int k = 0; k < rate_count(joint.kind); ++k) {
      const S along = joints[j].applied[static_cast<std::size_t>(k)] =
          applied_at(scene, static_cast<int>(j), k, joints[j].q[static_cast<std::size_t>(k)],
                     joints[j].u[static_cast<std::size_t>(k)], t_s);
      const bool pushes = joint.kind == JointKind::slider || (joint.kind == JointKind::cylindrical && k == 1);
      const Vec<S> way = along * (joint.kind == JointKind::universal && k == 1 ? at.n2 : at.n1);
      scale = larger(scale, magnitude(along));
      (pushes ? force : torque) = (pushes ? force : torque) + way;
    }
    apply<S>(joint, at.anchor, force, torque, bodies, [&](std::size_t i, const Vec<S>& f, const Vec<S>& m) {
      left[i].force = left[i].force - f;
      left[i].torque = left[i].torque - m;
    });
  }
  Equations<S> equations;
  equations.rows = 6 * bodies.size();
  equations.unknowns = directions.size();
  equations.entries.assign(equations.rows * (equations.unknowns + 1), S(0));
  const auto fill = [&](std::size_t column) {
    return [&equations, &scene, column](std::size_t i, const Vec<S>& f, const Vec<S>& m) {
      if (scene.bodies[i].fixed) return;
      for (std::size_t k = 0; k < 3; ++k) {
        equations.at(6 * i + k, column) += f[k];
        equations.at(6 * i + 3 + k, column) += m[k];
      }
    };
  };
  for (std::size_t c = 0; c < directions.size(); ++c) {
    const Direction<S>& d = directions[c];
    apply<S>(scene.joints[d.joint], places[d.joint].anchor, d.force, d.torque, bodies, fill(c));
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) fill(directions.size())(i, left[i].force, left[i].torque);
  const Eliminated<S> solved = eliminate(std::move(equations));
  std::vector<std::array<S, 6>> open(joints.size(), std::array<S, 6>{});
  for (std::size_t c = 0; c < directions.size(); ++c) {
    const Direction<S>& d = directions[c];
    joints[d.joint].force_N = joints[d.joint].force_N + solved.solution[c] * d.force;
    joints[d.joint].torque_N_m = joints[d.joint].torque_N_m + solved.solution[c] * d.torque;
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!joints[j].locked) continue;
    Vec<S>& of = scene.joints[j].kind == JointKind::slider ? joints[j].force_N : joints[j].torque_N_m;
    joints[j].stop = dot(of, places[j].n1);
    of = of - joints[j].stop * places[j].n1;
  }
  for (const std::vector<S>& along : solved.null) {
    std::vector<std::array<S, 6>> moved(joints.size(), std::array<S, 6>{});
    for (std::size_t c = 0; c < directions.size(); ++c)
      for (std::size_t k = 0; k < 3; ++k) {
        moved[directions[c].joint][k] += along[c] * directions[c].force[k];
        moved[directions[c].joint][3 + k] += along[c] * directions[c].torque[k];
      }
    for (std::size_t j = 0; j < joints.size(); ++j)
      for (std::size_t k = 0; k < 6; ++k) open[j][k] = larger(open[j][k], magnitude(moved[j][k]));
  }
  for (std::size_t j = 0; j < joints.size(); ++j)
    for (std::size_t k = 0; k < 6; ++k)
      if (open[j][k] > S(kRankTolerance)) {
        joints[j].not_unique |= 1u << k;
        (k < 3 ? joints[j].force_N[k] : joints[j].torque_N_m[k - 3]) = std::numeric_limits<double>::quiet_NaN();
      }
  return scale > 0 ? solved.residual / scale : solved.residual;
}

template Narrow solve_reactions(const Scene&, const std::vector<BodyKinematics<Narrow>>&, Narrow,
                                std::vector<JointState<Narrow>>&);
template Wide solve_reactions(const Scene&, const std::vector<BodyKinematics<Wide>>&, Wide,
                              std::vector<JointState<Wide>>&);

}  // namespace atwood::closed_form
