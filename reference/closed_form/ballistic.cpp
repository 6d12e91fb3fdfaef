// Free flight under uniform gravity: p = p0 + v0 t + g t^2 / 2. Galilei, Discorsi (1638), fourth day.
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

template <class S> Translation<S> ballistic_translation(const Scene& scene, int body) {
  for (const Force& force : scene.forces)
    if (acts_on(force, body)) return {force_on_body(scene, force, body) + " is not covered", {}};
  const Vec<S> p = vec<S>(scene.bodies[body].position_m), v = vec<S>(scene.bodies[body].velocity_m_per_s);
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2);
  return {"", [=](S t) { return CenterMotion<S>{p + t * (v + (t / 2) * g), v + t * g}; }};
}

template <class S> Motion<S> solve_ballistic(const Scenario& scenario, const std::vector<S>& t_s) {
  return solve_each_body<S>(scenario, t_s, ballistic_translation<S>);
}

}  // namespace

Solution ballistic() {
  return {"ballistic",           "free flight under uniform gravity, p = p0 + v0 t + g t^2/2",
          feature::kFreeMotion,  solve_ballistic<Narrow>,
          solve_ballistic<Wide>, true};
}

// A free body under uniform gravity: the same path of the centre, with the attitude from free_rotation().
Solution free_rigid_body() {
  return {"free-rigid-body",
          "free asymmetric top by Jacobi elliptic functions with attitude, van Zon and Schofield, J. Comput. Phys. 225 "
          "(2007) 145; Carlson's symmetric integrals; uniform gravity",
          feature::kFreeMotion,
          solve_ballistic<Narrow>,
          solve_ballistic<Wide>,
          true};
}

}  // namespace atwood::closed_form
