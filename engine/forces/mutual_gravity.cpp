#include "forces/gravity_many.hpp"

namespace atwood {
namespace {

// a_i = G sum_j m_j r_ij / (|r_ij|^2 + eps^2)^(3/2), r_ij from i to j (Plummer's softening). A fixed body attracts with
// the mass it states.
template <class S> struct GravityTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  std::vector<S> Gm;
  S softening2;

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    for (std::size_t a = 0; a < bodies.size(); ++a)
      for (std::size_t b = a + 1; b < bodies.size(); ++b) {
        const Vec3<S> r = motion.p_WB(bodies[b]) - motion.p_WB(bodies[a]);
        const S r2 = dot(r, r) + softening2;
        const S inverse_cube = S(1) / (r2 * real::sqrt(r2));
        loads[bodies[a]].acceleration_W += (Gm[b] * inverse_cube) * r;
        loads[bodies[b]].acceleration_W -= (Gm[a] * inverse_cube) * r;
      }
  }
};

}  // namespace

template <class S> TermPointer<S> make_term(const MutualGravity& force, const Scene& scene, const GravityOptions& options) {
  if (auto many = make_many_body_gravity<S>(force, scene, options)) return many;
  auto term = std::make_unique<GravityTerm<S>>();
  term->bodies = force.bodies;
  for (const int i : force.bodies) term->Gm.push_back(S(force.constant_m3_per_kg_s2) * S(scene.bodies[i].mass_kg));
  term->softening2 = S(force.softening_m) * S(force.softening_m);
  return term;
}

template TermPointer<float> make_term<float>(const MutualGravity&, const Scene&, const GravityOptions&);
template TermPointer<double> make_term<double>(const MutualGravity&, const Scene&, const GravityOptions&);
template TermPointer<long double> make_term<long double>(const MutualGravity&, const Scene&, const GravityOptions&);
template TermPointer<Quad> make_term<Quad>(const MutualGravity&, const Scene&, const GravityOptions&);

}  // namespace atwood
