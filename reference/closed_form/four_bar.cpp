// N four-bars in a row: N + 1 parallel bars of one length on hinges to the world, whose tips N coupling bars join, on
// the branch on which the bars stay parallel and the coupling bars do not turn. It has one degree of freedom: with J
// the moments of inertia of the parallel bars about their hinges and m l^2 of the couplings, and D the first moments m
// d of the parallel bars and m l of the couplings,
//   J theta'' = n . (D x g):   a pendulum
// (uniform rods of mass m and length l: theta'' = (g / l) ((N + 1)/2 + N) / ((N + 1)/3 + N) sin theta from the upward
// vertical). When all bars lie in one line the mechanism has another branch; the motion goes on along this one, which
// is its continuous limit from both sides. M. Gonzalez, D. Dopico, U. Lugris and J. Cuadrado, Multibody Syst. Dyn. 16
// (2006) 179, problem A02 of the IFToMM benchmark.
#include "closed_form/mechanism.hpp"
#include "closed_form/pendulum.hpp"

namespace atwood::closed_form {

namespace {

// Reactions of more unknowns than these are not reported: the elimination is cubic in them.
constexpr std::size_t kMaxJoints = 12;

struct Bars {
  std::vector<std::size_t> ground;  // joints of the parallel bars to the world
  std::vector<int> bar_of;          // of each body: 1 a parallel bar, 2 a coupling, 0 fixed
};

std::string find_bars(const Scene& scene, Bars& bars) {
  bars.bar_of.assign(scene.bodies.size(), 0);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (!is_grounded(scene, joint)) continue;
    int& of = bars.bar_of[static_cast<std::size_t>(joint.child)];
    if (of == 1)
      return "`" + scene.bodies[static_cast<std::size_t>(joint.child)].name + "` has two hinges to the world";
    of = 1;
    bars.ground.push_back(j);
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed && bars.bar_of[i] == 0) bars.bar_of[i] = 2;
  if (bars.ground.size() < 2) return "expected two or more parallel bars on hinges to the world";
  std::vector<int> ends(scene.bodies.size(), 0);
  for (const Joint& joint : scene.joints) {
    if (is_grounded(scene, joint)) continue;
    const auto parent = static_cast<std::size_t>(joint.parent), child = static_cast<std::size_t>(joint.child);
    if (bars.bar_of[parent] + bars.bar_of[child] != 3)
      return "the hinge `" + joint.name + "` does not join a parallel bar and a coupling bar";
    ++ends[bars.bar_of[parent] == 2 ? parent : child];
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (bars.bar_of[i] == 2 && ends[i] != 2) return "`" + scene.bodies[i].name + "` does not join two parallel bars";
  return "";
}

// The bars of each body that couplings tie together, as sets: all parallel bars turn together only if they are one set.
bool is_connected(const Scene& scene) {
  std::vector<std::size_t> set(scene.bodies.size());
  for (std::size_t i = 0; i < set.size(); ++i) set[i] = i;
  const auto root = [&](std::size_t i) {
    while (set[i] != i) i = set[i];
    return i;
  };
  for (const Joint& joint : scene.joints)
    if (!is_grounded(scene, joint))
      set[root(static_cast<std::size_t>(joint.parent))] = root(static_cast<std::size_t>(joint.child));
  std::size_t sets = 0;
  for (std::size_t i = 0; i < set.size(); ++i)
    if (!scene.bodies[i].fixed && root(i) == i) ++sets;
  return sets == 1;
}

template <class S> struct FourBar {
  Pendulum<S> swing;
  std::vector<JointState<S>> start;
  std::vector<S> turns;  // of each hinge's coordinate with the bars' angle

  std::vector<JointState<S>> at(S t) const {
    const JointState<S> now = swing.at(t);
    std::vector<JointState<S>> made(start.size());
    for (std::size_t j = 0; j < made.size(); ++j) {
      made[j].q[0] = start[j].q[0] + turns[j] * now.q[0];
      made[j].u[0] = turns[j] * now.u[0];
      made[j].du[0] = turns[j] * now.du[0];
    }
    return made;
  }
};

template <class S> S moment_about(const Body& body, const Vec<S>& axis_B) {
  S sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) sum += axis_B[i] * S(body.inertia_kg_m2[3 * i + j]) * axis_B[j];
  return sum;
}

template <class S> std::string build(const Scene& scene, FourBar<S>& made) {
  Bars bars;
  if (std::string why = find_bars(scene, bars); !why.empty()) return why;
  if (!is_connected(scene)) return "the bars are not one mechanism";
  if (std::string why = start_joints(scene, made.start); !why.empty()) return why;
  const std::vector<BodyKinematics<S>> bodies = place_bodies(scene, made.start);
  const Joint& first = scene.joints[bars.ground.front()];
  const Vec<S> n = rotate(bodies[static_cast<std::size_t>(first.child)].pose.q_WB, unit<S>(first.axis_body));
  // The bar from the hinge to the tip: the same vector for all, to the round-off of the scene's doubles.
  Vec<S> bar{};
  std::vector<Vec<S>> foot(scene.bodies.size());
  S size = 0, rate = 0;
  for (const std::size_t j : bars.ground) {
    foot[static_cast<std::size_t>(scene.joints[j].child)] = anchor_at(scene.joints[j], 1, bodies);
    size = larger(size, norm(anchor_at(scene.joints[j], 0, bodies)));
  }
  const auto across = [&](const Vec<S>& v) { return v - dot(v, n) * n; };
  bool found = false;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const S sign = sign_along(joint, bodies, n);
    if (sign == 0) return "the axis of the hinge `" + joint.name + "` is not parallel to that of `" + first.name + "`";
    const bool grounded = is_grounded(scene, joint);
    if (j == bars.ground.front()) rate = sign * made.start[j].u[0];
    const bool child_turns = bars.bar_of[static_cast<std::size_t>(joint.child)] == 1;
    made.turns.push_back(child_turns ? sign : -sign);
    if (grounded) continue;
    const int upright = child_turns ? joint.child : joint.parent;
    const Vec<S> here = across(anchor_at(joint, child_turns ? 1 : 0, bodies) - foot[static_cast<std::size_t>(upright)]);
    if (!found) bar = here;
    found = true;
    size = larger(size, norm(here));
    if (norm(here - bar) > S(1e-12) * size) return "the bars on hinges to the world are not parallel and of one length";
  }
  S inertia = 0;
  Vec<S> first_moment{};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    const S mass = body.mass_kg;
    const Vec<S> arm = bars.bar_of[i] == 2 ? bar : across(bodies[i].pose.p_WB - foot[i]);
    inertia += mass * dot(arm, arm);
    if (bars.bar_of[i] == 1) inertia += moment_about(body, rotate(conjugate(bodies[i].pose.q_WB), n));
    first_moment = first_moment + mass * arm;
  }
  const Vec<S> g = across(vec<S>(scene.gravity_m_per_s2));
  if (!(norm(first_moment) * norm(g) > 0)) return "gravity has no moment about the hinges";
  made.swing = swing<S>(inertia, first_moment, n, g, S(0), rate);
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (magnitude(made.start[j].u[0] - made.turns[j] * rate) > S(1e-12) * magnitude(rate))
      return "the bars do not turn together at the start";
  return "";
}

template <class S> Motion<S> solve_four_bar(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  FourBar<S> path;
  motion.refusal = not_a_tree(scene);
  if (motion.refusal.empty()) motion.refusal = build(scene, path);
  if (!motion.refusal.empty()) return motion;
  if (scene.joints.size() <= kMaxJoints) return move_mechanism<S>(scenario, t_s, [&](S t) { return path.at(t); });
  for (const S& t : t_s) {
    std::vector<JointState<S>> joints = path.at(t);
    auto& poses = motion.poses.emplace_back();
    for (const BodyKinematics<S>& body : place_bodies(scene, joints)) poses.push_back(body.pose);
    for (JointState<S>& joint : joints) {
      joint.force_N.fill(std::numeric_limits<double>::quiet_NaN());
      joint.torque_N_m.fill(std::numeric_limits<double>::quiet_NaN());
    }
    motion.joints.push_back(std::move(joints));
  }
  return motion;
}

}  // namespace

Solution four_bar() {
  return {
      "four-bar",
      "parallel bars and couplings, one degree of freedom: the pendulum's elliptic functions; problem A02 of Gonzalez, "
      "Dopico, Lugris and Cuadrado, Multibody Syst. Dyn. 16 (2006) 179",
      feature::uniform_gravity | feature::spin | feature::hinge | feature::loop, solve_four_bar<Narrow>,
      solve_four_bar<Wide>};
}

}  // namespace atwood::closed_form
