#include "forces/gravity_many.hpp"
#include "forces/lanes.hpp"

namespace atwood {
namespace {

// a_i = G sum_j m_j r_ij / (|r_ij|^2 + eps^2)^(3/2), r_ij from i to j (Plummer's softening). A fixed body attracts with
// the mass it states.
template <class S> struct GravityTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  std::vector<S> Gm;
  S softening2;

  static constexpr Items items = Items::pairs;
  template <class M, class L> ATWOOD_INLINE auto law(int a, int b, const M& motion, const L& loads) const {
    return [body_a = motion.body(bodies[a]), body_b = motion.body(bodies[b]), load_a = loads.body(bodies[a]),
            load_b = loads.body(bodies[b]), softening2 = softening2, Gm_a = Gm[a], Gm_b = Gm[b]](auto k)
               ATWOOD_INLINED {
                 const auto r = body_b.p_WB(k) - body_a.p_WB(k);
                 const auto r2 = dot(r, r) + softening2;
                 const auto inverse_cube = S(1) / (r2 * root(k, r2));
                 load_a.acceleration_W(k) += (Gm_b * inverse_cube) * r;
                 load_b.acceleration_W(k) -= (Gm_a * inverse_cube) * r;
               };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S>
TermPointer<S> make_term(const MutualGravity& force, const Scene& scene, const GravityOptions& options) {
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
