#include "forces/lanes.hpp"

namespace atwood {
namespace {

// F_i = -k q_i q_j r_ij / |r_ij|^3, r_ij from i to j: like charges repel.
template <class S> struct CoulombTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  std::vector<S> charge;
  S constant;

  static constexpr Items items = Items::pairs;
  template <class M, class L> ATWOOD_INLINE auto law(int a, int b, const M& motion, const L& loads) const {
    return [body_a = motion.body(bodies[a]), body_b = motion.body(bodies[b]), load_a = loads.body(bodies[a]),
            load_b = loads.body(bodies[b]), product = constant * charge[a] * charge[b]](auto k) ATWOOD_INLINED {
      const auto r = body_b.p_WB(k) - body_a.p_WB(k);
      const auto r2 = dot(r, r);
      const auto force = (product / (r2 * root(k, r2))) * r;
      load_a.force_W(k) -= force;
      load_b.force_W(k) += force;
    };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const Coulomb& force, const Scene& scene) {
  auto term = std::make_unique<CoulombTerm<S>>();
  term->bodies = force.bodies;
  for (const int i : force.bodies) term->charge.push_back(S(scene.bodies[i].charge_C));
  term->constant = S(force.constant_N_m2_per_C2);
  return term;
}

template TermPointer<float> make_term<float>(const Coulomb&, const Scene&);
template TermPointer<double> make_term<double>(const Coulomb&, const Scene&);
template TermPointer<long double> make_term<long double>(const Coulomb&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Coulomb&, const Scene&);

}  // namespace atwood
