// Bodies that fixed joints weld together and that float: each assembly is one rigid body, whose mass, centre of mass
// and inertia follow from those of its parts (J. Steiner's theorem). In uniform gravity its centre falls on a parabola
// and it turns as a free top (see free-rigid-body); the joints' wrenches are what each part needs for its motion.
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

template <class S> std::array<S, 9> turned_to(const Quat<S>& q_AB, const Real33& inertia_B) {
  std::array<S, 9> made{};
  for (std::size_t k = 0; k < 3; ++k) {
    Vec<S> e{};
    e[k] = 1;
    const Vec<S> b = rotate(conjugate(q_AB), e);
    Vec<S> Ib{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) Ib[i] += S(inertia_B[3 * i + j]) * b[j];
    const Vec<S> column = rotate(q_AB, Ib);
    for (std::size_t i = 0; i < 3; ++i) made[3 * i + k] = column[i];
  }
  return made;
}

template <class S> struct Part {  // of an assembly, in the axes of its base
  int body = 0;
  Quat<S> q{1, 0, 0, 0};
  Vec<S> from_centre{};  // of the assembly
};
template <class S> struct Assembly {
  std::vector<Part<S>> parts;
  std::array<S, 9> inertia{};
  Vec<S> p0{}, v0{};  // of the centre of mass
  RotationAt<S> turn;
};

// The body at the root of the tree; -1: the world, or a fixed body.
int base_of(const Scene& scene, int body) {
  for (;;) {
    if (moving_body(scene, body) < 0) return -1;
    const Joint* placing = nullptr;
    for (const Joint& joint : scene.joints)
      if (joint.child == body) placing = &joint;
    if (placing == nullptr) return body;
    body = placing->parent;
  }
}

template <class S> Assembly<S> assemble(const Scene& scene, int base, const std::vector<BodyKinematics<S>>& start) {
  Assembly<S> made;
  const Pose<S>& at = start[static_cast<std::size_t>(base)].pose;
  S mass = 0;
  Vec<S> centre{};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (base_of(scene, static_cast<int>(i)) != base) continue;
    const Pose<S>& pose = start[i].pose;
    const S m = scene.bodies[i].mass_kg;
    Part<S>& part = made.parts.emplace_back();
    part.body = static_cast<int>(i);
    part.q = conjugate(at.q_WB) * pose.q_WB;
    part.from_centre = rotate(conjugate(at.q_WB), pose.p_WB - at.p_WB);
    mass += m;
    centre = centre + m * part.from_centre;
  }
  centre = (1 / mass) * centre;
  for (Part<S>& part : made.parts) {
    const Vec<S> d = part.from_centre = part.from_centre - centre;
    const Body& body = scene.bodies[static_cast<std::size_t>(part.body)];
    const std::array<S, 9> own = turned_to<S>(part.q, body.inertia_kg_m2);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        made.inertia[3 * i + j] += own[3 * i + j] + S(body.mass_kg) * ((i == j ? dot(d, d) : S(0)) - d[i] * d[j]);
  }
  made.p0 = at.p_WB + rotate(at.q_WB, centre);
  made.v0 = at.v_WB + rotate(at.q_WB, cross(at.w_WB_B, centre));
  made.turn = torque_free<S>(made.inertia, at.q_WB, at.w_WB_B);
  return made;
}

// w' = I^-1 ((I w) x w), by Cramer's rule.
template <class S> Vec<S> free_spin_rate(const std::array<S, 9>& I, const Vec<S>& w) {
  const Vec<S> column[3] = {{I[0], I[3], I[6]}, {I[1], I[4], I[7]}, {I[2], I[5], I[8]}};
  const Vec<S> L = w[0] * column[0] + w[1] * column[1] + w[2] * column[2], b = cross(L, w);
  const S determinant = dot(column[0], cross(column[1], column[2]));
  return {dot(b, cross(column[1], column[2])) / determinant, dot(column[0], cross(b, column[2])) / determinant,
          dot(column[0], cross(column[1], b)) / determinant};
}

template <class S>
void place(const Assembly<S>& assembly, const Vec<S>& gravity, S t, std::vector<BodyKinematics<S>>& bodies) {
  const Rotation<S> now = assembly.turn(t);
  const Vec<S> p = assembly.p0 + t * assembly.v0 + (t * t / 2) * gravity, v = assembly.v0 + t * gravity;
  const Vec<S> w = rotate(now.q, now.w), alpha = rotate(now.q, free_spin_rate(assembly.inertia, now.w));
  for (const Part<S>& part : assembly.parts) {
    const Vec<S> r = rotate(now.q, part.from_centre);
    BodyKinematics<S>& body = bodies[static_cast<std::size_t>(part.body)];
    body.pose.q_WB = now.q * part.q;
    body.pose.p_WB = p + r;
    body.pose.v_WB = v + cross(w, r);
    body.pose.w_WB_B = rotate(conjugate(body.pose.q_WB), w);
    body.w_W = w;
    body.alpha_W = alpha;
    body.a_W = gravity + cross(alpha, r) + cross(w, cross(w, r));
  }
}

std::string uncovered(const Scene& scene) {
  if (scene.joints.empty()) return "expected bodies that fixed joints weld together; found no joint";
  std::vector<int> placed(scene.bodies.size(), 0);
  for (const Joint& joint : scene.joints) ++placed[static_cast<std::size_t>(joint.child)];
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (placed[i] > 1) return "`" + body.name + "` is placed by " + std::to_string(placed[i]) + " joints";
    if (body.fixed) continue;
    if (base_of(scene, static_cast<int>(i)) < 0) return "`" + body.name + "` is welded to what does not move";
    if (!rotates(body)) return "`" + body.name + "` is a point mass";
  }
  return possible_contact(scene);
}

template <class S> Motion<S> solve_welded_bodies(const Scenario& scenario, const std::vector<S>& t_s) {
  Motion<S> motion;
  const Scene& scene = scenario.scene;
  motion.refusal = uncovered(scene);
  if (!motion.refusal.empty()) return motion;
  std::vector<JointState<S>> start;
  for (const Joint& joint : scene.joints) start.push_back(initial_joint<S>(joint));
  std::vector<BodyKinematics<S>> bodies = place_bodies(scene, start);
  std::vector<Assembly<S>> assemblies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (const int body = static_cast<int>(i); base_of(scene, body) == body)
      assemblies.push_back(assemble(scene, body, bodies));
  const Vec<S> gravity = vec<S>(scene.gravity_m_per_s2);
  for (const S& t : t_s) {
    for (const Assembly<S>& assembly : assemblies) place(assembly, gravity, t, bodies);
    std::vector<JointState<S>> joints = start;
    if (!(solve_reactions(scene, bodies, t, joints) <= S(kMaxResidual)))
      motion.refusal = "the scene has forces with which it does not solve the equations of motion";
    if (!motion.refusal.empty()) break;
    auto& poses = motion.poses.emplace_back();
    for (const BodyKinematics<S>& body : bodies) poses.push_back(body.pose);
    motion.joints.push_back(std::move(joints));
  }
  return motion;
}

}  // namespace

Solution welded_bodies() {
  return {
      "welded-bodies",
      "bodies welded by fixed joints move as one rigid body: Steiner's theorem and the free asymmetric top, van Zon and "
      "Schofield, J. Comput. Phys. 225 (2007) 145",
      feature::uniform_gravity | feature::spin | feature::fixed_joint, solve_welded_bodies<Narrow>,
      solve_welded_bodies<Wide>};
}

}  // namespace atwood::closed_form
