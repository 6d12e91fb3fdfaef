// Two smooth spheres in free flight, Newton's law of impact: E. J. Routh, Dynamics of a System of Rigid Bodies, art. 169.
// Both fall alike, so their distance d = d0 + u t is uniform; they touch when |d| = R = r_a + r_b:
//   u^2 t^2 + 2 b t + c = 0,  b = d0 . u < 0,  c = d0^2 - R^2;   t = c / (-b + sqrt(u^2 R^2 - |d0 x u|^2))
// the smaller root, without cancellation. J = -(1 + e) vn / (1/m_a + 1/m_b) along the line of centres.
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

struct Two { int a = -1, b = -1; };

std::string find_two(const Scene& scene, Two& two) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const int at = static_cast<int>(i);
    if (body.fixed && body.shape.index() == 0) continue;
    if (!std::holds_alternative<Sphere>(body.shape) || two.b >= 0)
      return "`" + body.name + "` is there beside two spheres";
    (two.a < 0 ? two.a : two.b) = at;
    if (body.release_s > 0) return "`" + body.name + "` is released late";
    if (body.fixed && scene.gravity_m_per_s2 != Real3{}) return "`" + body.name + "` is fixed and the other falls";
    for (const Force& force : scene.forces)
      if (acts_on(force, at)) return named(scene, force, at) + " is not covered";
  }
  if (two.b < 0) return "two spheres are needed";
  return scene.bodies[two.a].fixed && scene.bodies[two.b].fixed ? "both spheres are fixed" : "";
}

template <class S>
struct Meeting {
  bool happens = false;
  S t{}, impulse{}, before{}, after{};
  Vec<S> normal{};
};

template <class S>
Meeting<S> meet(const Vec<S>& d0, const Vec<S>& u, S reach, S e, S inverse_mass) {
  Meeting<S> made;
  const S b = dot(d0, u), c = (norm(d0) - reach) * (norm(d0) + reach);
  const Vec<S> aside = cross(d0, u);
  const S inside = dot(u, u) * reach * reach - dot(aside, aside);
  if (!(b < 0) || !(inside > 0)) return made;
  made.happens = true;
  made.t = larger(S(0), c / (root(inside) - b));
  made.normal = (1 / reach) * (d0 + made.t * u);
  made.before = -root(inside) / reach;  // u . n at contact: (b + u^2 t) / R
  made.after = -e * made.before;
  made.impulse = -(1 + e) * made.before / inverse_mass;
  return made;
}

// Sliding of one surface over the other at the impact: friction would then act.
template <class S>
bool rubs(const Scene& scene, const Two& two, const Meeting<S>& hit, const Vec<S>& u,
          const std::array<Turning<S>, 2>& turns) {
  Vec<S> sliding = u - dot(u, hit.normal) * hit.normal;
  for (int k = 0; k < 2; ++k) {
    const Body& body = scene.bodies[k == 0 ? two.a : two.b];
    if (body.fixed) continue;
    const Spin<S> spin = turns[k].at(hit.t);
    sliding = sliding - S(std::get<Sphere>(body.shape).radius_m) * cross(rotate(spin.q, spin.w), hit.normal);
  }
  return norm(sliding) > 64 * unit_round_off<S>() * norm(u);
}

template <class S>
Motion<S> solve(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  Two two;
  motion.misfit = find_two(scene, two);
  if (!motion.misfit.empty()) return motion;
  const Body* bodies[2] = {&scene.bodies[two.a], &scene.bodies[two.b]};
  const Pose<S> start[2] = {initial_pose<S>(*bodies[0]), initial_pose<S>(*bodies[1])};
  const std::array<Turning<S>, 2> turns{turning<S>(*bodies[0], S(0)), turning<S>(*bodies[1], S(0))};
  const S radius[2] = {S(std::get<Sphere>(bodies[0]->shape).radius_m), S(std::get<Sphere>(bodies[1]->shape).radius_m)};
  S inverse[2];
  for (int k = 0; k < 2; ++k) inverse[k] = bodies[k]->fixed ? S(0) : 1 / S(bodies[k]->mass_kg);
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2), d0 = start[1].p_WB - start[0].p_WB, u = start[1].v_WB - start[0].v_WB;
  const PairLaw& law = pair_law(scene, two.a, two.b);
  if (norm(d0) < (radius[0] + radius[1]) * (1 - 4 * unit_round_off<double>())) motion.misfit = "the spheres overlap at the start";
  Meeting<S> hit = meet(d0, u, radius[0] + radius[1], S(law.restitution), inverse[0] + inverse[1]);
  if (hit.t > S(scenario.t_end_s)) hit.happens = false;
  if (hit.happens && law.friction != 0 && rubs(scene, two, hit, u, turns))
    motion.misfit = "the contact has friction and one surface slides over the other";
  for (const Turning<S>& turns_k : turns)
    if (motion.misfit.empty()) motion.misfit = turns_k.misfit;
  if (!motion.misfit.empty()) return motion;
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    for (int k = 0; k < 2; ++k) {
      if (bodies[k]->fixed || t == 0) continue;
      const Spin<S> spin = turns[k].at(t);
      Pose<S>& now = poses[k == 0 ? two.a : two.b];
      now = {start[k].p_WB + t * (start[k].v_WB + (t / 2) * g), start[k].v_WB + t * g, spin.w, spin.q};
      if (!hit.happens || t < hit.t) continue;
      const Vec<S> kick = ((k == 0 ? -1 : 1) * hit.impulse * inverse[k]) * hit.normal;
      now.v_WB = now.v_WB + kick;
      now.p_WB = now.p_WB + (t - hit.t) * kick;
    }
  }
  if (hit.happens) {
    Happening<S> impact;
    impact.t_s = hit.t;
    impact.body_a = two.a;
    impact.body_b = two.b;
    const Vec<S> fall = bodies[0]->fixed ? Vec<S>{} : hit.t * (start[0].v_WB + (hit.t / 2) * g);
    impact.x_W = start[0].p_WB + fall + radius[0] * hit.normal;
    impact.normal_W = hit.normal;
    impact.impulse_n_N_s = hit.impulse;
    impact.vn_before_m_per_s = hit.before;
    impact.vn_after_m_per_s = hit.after;
    motion.happenings.push_back(impact);
  }
  return motion;
}

}  // namespace

Solution sphere_impact() {
  return {"sphere-impact", "two smooth spheres, impact at the root of a quadratic, Newton's law: Routh, art. 169",
          solve<Narrow>, solve<Wide>};
}

}  // namespace atwood::closed_form
