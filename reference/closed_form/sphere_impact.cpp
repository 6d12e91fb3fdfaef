// Two spheres in free flight, Newton's law of impact: E. J. Routh, Dynamics of a System of Rigid Bodies, art. 169. Both
// have the same acceleration, so that their relative motion d = d0 + u t is uniform; they touch at |d| = R, the sum of
// the radii:
//   u^2 t^2 + 2 b t + c = 0,  b = d0 . u < 0,  c = d0^2 - R^2;   t = c / (-b + sqrt(u^2 R^2 - |d0 x u|^2))
// the smaller root, without cancellation. J = -(1 + e) vn / (1/m_a + 1/m_b) along the line of centres.
//
// With friction, the slip velocity is s = (u - (r_a W_a + r_b W_b) x n) without its component along n (W: angular
// velocities, world axes). Coulomb's impulse opposes s and keeps its direction: it is the lesser of mu J (slip until
// the end) and the impulse that stops the slip (stick), |s| / (1/m_a + 1/m_b + r_a^2/I_a + r_b^2/I_b): art. 180.
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

struct Two {
  int a = -1, b = -1;
};

std::string find_two(const Scene& scene, Two& two) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const int at = static_cast<int>(i);
    if (body.fixed && body.shape.index() == 0) continue;
    if (!std::holds_alternative<Sphere>(body.shape) || two.b >= 0)
      return "`" + body.name + "` is one body too many or of another shape: expected two spheres";
    (two.a < 0 ? two.a : two.b) = at;
    if (body.release_s > 0) return "`" + body.name + "` has a later release, which is not covered";
    if (body.fixed && scene.gravity_m_per_s2 != Real3{})
      return "`" + body.name + "` is fixed and gravity acts on the other sphere, which is not covered";
    for (const Force& force : scene.forces)
      if (acts_on(force, at)) return force_on_body(scene, force, at) + " is not covered";
  }
  if (two.b < 0) return "expected two spheres";
  return scene.bodies[two.a].fixed && scene.bodies[two.b].fixed ? "both spheres are fixed" : "";
}

template <class S> struct Meeting {
  bool happens = false;
  S t{}, impulse{}, before{}, after{};
  Vec<S> normal{};
};

template <class S> Meeting<S> meet(const Vec<S>& d0, const Vec<S>& u, S radii, S e, S inverse_mass) {
  Meeting<S> made;
  const S b = dot(d0, u), c = (norm(d0) - radii) * (norm(d0) + radii);
  const Vec<S> aside = cross(d0, u);
  const S inside = dot(u, u) * radii * radii - dot(aside, aside);
  if (!(b < 0) || !(inside > 0)) return made;
  made.happens = true;
  made.t = larger(S(0), c / (sqrt(inside) - b));
  const Vec<S> d = d0 + made.t * u;  // of length R, but for spheres that touch at the start to the round-off of doubles
  made.normal = (1 / norm(d)) * d;
  made.before = c > 0 ? -sqrt(inside) / radii : b / norm(d);  // u . n at contact: (b + u^2 t) / R
  made.after = -e * made.before;
  made.impulse = -(1 + e) * made.before / inverse_mass;
  return made;
}

// Effect of friction at the impact, for spheres with equal principal moments of inertia.
template <class S> struct Friction {
  Vec<S> impulse_on_b{};  // on a: its opposite
  S size{};
  std::array<Rotation<S>, 2> spin{};  // after the impact, at its instant
};

template <class S>
Friction<S> rub(const Scene& scene, const Two& two, const Meeting<S>& hit, const Vec<S>& u, S mu,
                const std::array<RotationSolution<S>, 2>& turns) {
  Friction<S> made;
  Vec<S> sliding = u - dot(u, hit.normal) * hit.normal;
  S yielding = 0;
  S lever[2];
  for (int k = 0; k < 2; ++k) {
    const Body& body = scene.bodies[k == 0 ? two.a : two.b];
    lever[k] = 0;
    if (body.fixed) continue;
    made.spin[k] = turns[k].at(hit.t);
    const S radius = S(std::get<Sphere>(body.shape).radius_m);
    sliding = sliding - radius * cross(rotate(made.spin[k].q, made.spin[k].w), hit.normal);
    yielding = yielding + 1 / S(body.mass_kg);
    if (!rotates(body)) continue;
    lever[k] = radius / S(body.inertia_kg_m2[0]);
    yielding = yielding + radius * lever[k];
  }
  const S speed = norm(sliding);
  if (!(speed > 64 * unit_round_off<S>() * norm(u))) return made;
  const Vec<S> along = (1 / speed) * sliding;
  const S most = mu * hit.impulse, sticks = speed / yielding;
  made.size = most < sticks ? most : sticks;
  made.impulse_on_b = (-made.size) * along;
  const Vec<S> about = cross(hit.normal, along);  // r x impulse has this direction for both
  for (int k = 0; k < 2; ++k)
    made.spin[k].w = made.spin[k].w + (made.size * lever[k]) * rotate(conjugate(made.spin[k].q), about);
  return made;
}

template <class S> Motion<S> solve_sphere_impact(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  Two two;
  motion.refusal = find_two(scene, two);
  if (!motion.refusal.empty()) return motion;
  const Body* bodies[2] = {&scene.bodies[two.a], &scene.bodies[two.b]};
  const Pose<S> start[2] = {initial_pose<S>(*bodies[0]), initial_pose<S>(*bodies[1])};
  const std::array<RotationSolution<S>, 2> turns{free_rotation<S>(*bodies[0], S(0)),
                                                 free_rotation<S>(*bodies[1], S(0))};
  const S radius[2] = {S(std::get<Sphere>(bodies[0]->shape).radius_m), S(std::get<Sphere>(bodies[1]->shape).radius_m)};
  S inverse[2];
  for (int k = 0; k < 2; ++k) inverse[k] = bodies[k]->fixed ? S(0) : 1 / S(bodies[k]->mass_kg);
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2), d0 = start[1].p_WB - start[0].p_WB,
               u = start[1].v_WB - start[0].v_WB;
  const PairLaw& law = pair_law(scene, two.a, two.b);
  if (norm(d0) < (radius[0] + radius[1]) * (1 - 4 * unit_round_off<double>()))
    motion.refusal = "the spheres overlap at the start";
  // An overlap within the round-off of the doubles is a contact. The bars include it, and the neglected friction.
  const S overlap = larger(S(0), radius[0] + radius[1] - norm(d0)), t_end = scenario.t_end_s;
  const S left_out = law.friction != 0 ? 64 * unit_round_off<S>() * norm(u) : S(0);
  motion.input_round_off.v_m_per_s = 4 * (left_out + overlap / (radius[0] + radius[1]) * norm(u));
  motion.input_round_off.p_m = 4 * overlap + motion.input_round_off.v_m_per_s * t_end;
  motion.input_round_off.w_rad_per_s =
      motion.input_round_off.v_m_per_s / (radius[0] < radius[1] ? radius[0] : radius[1]);
  motion.input_round_off.q = motion.input_round_off.w_rad_per_s * t_end;
  Meeting<S> hit = meet(d0, u, radius[0] + radius[1], S(law.restitution), inverse[0] + inverse[1]);
  if (hit.t > S(scenario.t_end_s)) hit.happens = false;
  const bool rough = hit.happens && law.friction != 0;
  if (rough && !(has_spherical_inertia(*bodies[0]) && has_spherical_inertia(*bodies[1])))
    motion.refusal =
        "the contact has friction and a sphere with different principal moments of inertia, which is not covered";
  for (const RotationSolution<S>& turns_k : turns)
    if (motion.refusal.empty()) motion.refusal = turns_k.refusal;
  if (!motion.refusal.empty()) return motion;
  Friction<S> friction;
  if (rough) friction = rub(scene, two, hit, u, S(law.friction), turns);
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    for (int k = 0; k < 2; ++k) {
      if (bodies[k]->fixed || t == 0) continue;
      const Rotation<S> spin = turns[k].at(t);
      Pose<S>& now = poses[k == 0 ? two.a : two.b];
      now = {start[k].p_WB + t * (start[k].v_WB + (t / 2) * g), start[k].v_WB + t * g, spin.w, spin.q};
      if (!hit.happens || t < hit.t) continue;
      const Vec<S> kick = ((k == 0 ? -1 : 1) * inverse[k]) * (hit.impulse * hit.normal + friction.impulse_on_b);
      now.v_WB = now.v_WB + kick;
      now.p_WB = now.p_WB + (t - hit.t) * kick;
      if (!rough) continue;
      const Rotation<S>& spun = friction.spin[k];
      const S rate = norm(spun.w);
      now.w_WB_B = spun.w;
      now.q_WB = rate == 0 ? spun.q : spun.q * turn((1 / rate) * spun.w, rate * (t - hit.t));
    }
  }
  if (hit.happens) {
    ContactEvent<S> impact;
    impact.t_s = hit.t;
    impact.body_a = two.a;
    impact.body_b = two.b;
    const Vec<S> fall = bodies[0]->fixed ? Vec<S>{} : hit.t * (start[0].v_WB + (hit.t / 2) * g);
    impact.x_W = start[0].p_WB + fall + radius[0] * hit.normal;
    impact.normal_W = hit.normal;
    impact.impulse_n_N_s = hit.impulse;
    impact.impulse_t_N_s = friction.size;
    impact.vn_before_m_per_s = hit.before;
    impact.vn_after_m_per_s = hit.after;
    motion.events.push_back(impact);
  }
  return motion;
}

}  // namespace

Solution sphere_impact() {
  return {"sphere-impact",
          "two spheres, impact at the root of a quadratic, Newton's law and Coulomb's: Routh, art. 169, 180",
          feature::uniform_gravity | feature::spin | feature::kSimpleContact, solve_sphere_impact<Narrow>,
          solve_sphere_impact<Wide>};
}

}  // namespace atwood::closed_form
