// Kepler's problem: bodies about a fixed attractor, or two bodies that attract (gravity) or repel (charges) each other,
// reduced to their centre of mass. Newton, Principia (1687), book I, propositions 11-13 and 57-63; evaluated as in
// inverse_square.cpp. The hyperbola of two like charges is Rutherford's (Phil. Mag. 21 (1911) 669) from a finite
// distance.
#include <algorithm>

#include "closed_form/inverse_square.hpp"

namespace atwood::closed_form {

namespace {

template <class S> Translation<S> about_attractor(const Scene& scene, int body) {
  const Attractor* center = nullptr;
  for (const Force& force : scene.forces) {
    if (!acts_on(force, body)) continue;
    if (!std::holds_alternative<Attractor>(force) || center != nullptr)
      return {force_on_body(scene, force, body) + " is not covered: expected exactly one attractor", {}};
    center = &std::get<Attractor>(force);
  }
  const Body& planet = scene.bodies[body];
  if (center == nullptr) return {"no attractor acts on `" + planet.name + "`", {}};
  if (scene.gravity_m_per_s2 != Real3{}) return {"uniform gravity together with an attractor is not covered", {}};
  const Vec<S> origin = vec<S>(center->center_m);
  const InverseSquare<S> orbit{S(center->mu_m3_per_s2), vec<S>(planet.position_m) - origin,
                               vec<S>(planet.velocity_m_per_s),
                               is_radial(center->center_m, planet.position_m, {}, planet.velocity_m_per_s)};
  if (const std::string why = orbit.refusal(); !why.empty()) return {"`" + planet.name + "` " + why, {}};
  return {"",
          [=](S t) {
            const CenterMotion<S> now = orbit.at(t);
            return CenterMotion<S>{origin + now.p, now.v, now.failure};
          },
          orbit.collision_s(), "`" + planet.name + "` reaches the centre of attraction"};
}

struct Couple {
  int a = -1, b = -1;
};

// The one pair of mobile bodies that forces act between, and the mu of its relative motion.
template <class S> std::string find_couple(const Scene& scene, Couple& couple, S& mu) {
  for (const Force& force : scene.forces) {
    const auto* gravity = std::get_if<MutualGravity>(&force);
    const auto* coulomb = std::get_if<Coulomb>(&force);
    if (!gravity && !coulomb) return "the force `" + force_name(force) + "` is not covered";
    const std::vector<int>& bodies = gravity ? gravity->bodies : coulomb->bodies;
    if (bodies.size() != 2)
      return "`" + force_name(force) + "` acts among " + std::to_string(bodies.size()) + " bodies: expected two";
    const int a = std::min(bodies[0], bodies[1]), b = std::max(bodies[0], bodies[1]);
    if (couple.a >= 0 && (couple.a != a || couple.b != b)) return "forces act between more than two bodies";
    couple = {a, b};
    if (gravity && gravity->softening_m != 0) return "softened gravity is not covered";
    for (const int i : {a, b})
      if (scene.bodies[i].fixed || scene.bodies[i].release_s > 0)
        return "`" + scene.bodies[i].name + "` is fixed or has a later release, which is not covered";
    const S first = scene.bodies[a].mass_kg, second = scene.bodies[b].mass_kg;
    if (gravity) mu += S(gravity->constant_m3_per_kg_s2) * (first + second);
    if (coulomb)
      mu -= S(coulomb->constant_N_m2_per_C2) * S(scene.bodies[a].charge_C) * S(scene.bodies[b].charge_C) *
            (1 / first + 1 / second);
  }
  return couple.a < 0 ? "expected a force between two bodies; found none" : "";
}

// c = (m_a p_a + m_b p_b) / M falls freely; r = p_b - p_a; p_a = c - (m_b / M) r, p_b = c + (m_a / M) r.
template <class S> Motion<S> two_bodies(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Couple couple;
  S mu = 0;
  Motion<S> failed;
  failed.refusal = find_couple(scene, couple, mu);
  if (!failed.refusal.empty()) return failed;
  const Body &a = scene.bodies[couple.a], &b = scene.bodies[couple.b];
  const S share_a = S(a.mass_kg) / (S(a.mass_kg) + S(b.mass_kg)),
          share_b = S(b.mass_kg) / (S(a.mass_kg) + S(b.mass_kg));
  const Vec<S> pa = vec<S>(a.position_m), pb = vec<S>(b.position_m);
  const Vec<S> va = vec<S>(a.velocity_m_per_s), vb = vec<S>(b.velocity_m_per_s);
  const Vec<S> c0 = share_a * pa + share_b * pb, u = share_a * va + share_b * vb, g = vec<S>(scene.gravity_m_per_s2);
  const InverseSquare<S> orbit{mu, pb - pa, vb - va,
                               is_radial(a.position_m, b.position_m, a.velocity_m_per_s, b.velocity_m_per_s)};
  if (const std::string why = orbit.refusal(); !why.empty()) {
    failed.refusal = "`" + b.name + "` about `" + a.name + "` " + why;
    return failed;
  }
  const S collision_s = orbit.collision_s();
  return solve_each_body<S>(scenario, t_s, [=](const Scene& all, int body) -> Translation<S> {
    const bool first = body == couple.a, second = body == couple.b;
    if (!first && !second) {
      const Vec<S> p = vec<S>(all.bodies[body].position_m), v = vec<S>(all.bodies[body].velocity_m_per_s);
      return {"", [=](S t) { return CenterMotion<S>{p + t * (v + (t / 2) * g), v + t * g}; }};
    }
    const S share = first ? -share_b : share_a;
    return {"",
            [=](S t) {
              const CenterMotion<S> r = orbit.at(t);
              return CenterMotion<S>{c0 + t * (u + (t / 2) * g) + share * r.p, u + t * g + share * r.v, r.failure};
            },
            collision_s, "`" + a.name + "` and `" + b.name + "` collide"};
  });
}

template <class S> Motion<S> solve_kepler(const Scenario& scenario, const std::vector<S>& t_s) {
  for (const Force& force : scenario.scene.forces)
    if (std::holds_alternative<Attractor>(force)) return solve_each_body<S>(scenario, t_s, about_attractor<S>);
  return two_bodies<S>(scenario, t_s);
}

}  // namespace

Solution kepler() {
  return {
      "kepler",
      "Kepler's equation in universal variables, Stiefel and Scheifele, Linear and Regular Celestial Mechanics (1971)",
      feature::kFreeMotion | feature::attractor | feature::mutual_gravity | feature::coulomb,
      solve_kepler<Narrow>,
      solve_kepler<Wide>,
      true};
}

Solution coulomb_two_body() {
  return {"coulomb-two-body",
          "conic of two charges about their centre of mass (Rutherford 1911), in universal variables, Stiefel and "
          "Scheifele (1971)",
          feature::kFreeMotion | feature::mutual_gravity | feature::coulomb,
          two_bodies<Narrow>,
          two_bodies<Wide>,
          true};
}

}  // namespace atwood::closed_form
