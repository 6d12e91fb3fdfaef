// A charge in uniform fields: gyration, drift E x B / B^2, acceleration along B. Jackson, Classical Electrodynamics,
// ch. 12.
//   v' = a + W x v,  a = g + q E / m,  W = -q B / m.
// exp(s W^) = 1 + G1 W^ + G2 W^ W^ with G_k(W^2, s) of stumpff.hpp, and each integral in s raises every index by one:
//   v = exp(t W^) v0 + (t + G2 W^ + G3 W^ W^) a,    p = p0 + (t + G2 W^ + G3 W^ W^) v0 + (t^2/2 + G3 W^ + G4 W^ W^) a
#include "closed_form/solution.hpp"
#include "closed_form/stumpff.hpp"

namespace atwood::closed_form {

namespace {

template <class S> Translation<S> lorentz_translation(const Scene& scene, int body) {
  const Body& particle = scene.bodies[body];
  Vec<S> E{}, B{};
  for (const Force& force : scene.forces) {
    if (!acts_on(force, body)) continue;
    const auto* field = std::get_if<Lorentz>(&force);
    if (field == nullptr) return {force_on_body(scene, force, body) + " is not covered", {}};
    E = E + vec<S>(field->electric_V_per_m);
    B = B + vec<S>(field->magnetic_T);
  }
  const S specific = S(particle.charge_C) / S(particle.mass_kg);
  const Vec<S> a = vec<S>(scene.gravity_m_per_s2) + specific * E, W = -specific * B;
  const Vec<S> p0 = vec<S>(particle.position_m), v0 = vec<S>(particle.velocity_m_per_s);
  return {"", [=](S t) {
            const auto G = stumpff(dot(W, W), t);
            const auto apply = [&](S zeroth, S first, S second, const Vec<S>& u) {
              const Vec<S> Wu = cross(W, u);
              return zeroth * u + first * Wu + second * cross(W, Wu);
            };
            return CenterMotion<S>{p0 + apply(t, G[2], G[3], v0) + apply(t * t / 2, G[3], G[4], a),
                                   apply(S(1), G[1], G[2], v0) + apply(t, G[2], G[3], a)};
          }};
}

template <class S> Motion<S> solve_lorentz(const Scenario& scenario, const std::vector<S>& t_s) {
  return solve_each_body<S>(scenario, t_s, lorentz_translation<S>);
}

}  // namespace

Solution lorentz() {
  return {"lorentz",
          "charge in uniform E and B: gyration, E x B drift, acceleration along B, Jackson, ch. 12",
          feature::kFreeMotion | feature::lorentz_force,
          solve_lorentz<Narrow>,
          solve_lorentz<Wide>,
          true};
}

}  // namespace atwood::closed_form
