#include "forces/force.hpp"

namespace atwood {
namespace {

// F_i = -k q_i q_j r_ij / |r_ij|^3, r_ij from i to j: like charges repel.
template <class S> struct CoulombTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  std::vector<S> charge;
  S constant;

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    for (std::size_t a = 0; a < bodies.size(); ++a)
      for (std::size_t b = a + 1; b < bodies.size(); ++b) {
        const Vec3<S> r = motion.p_WB(bodies[b]) - motion.p_WB(bodies[a]);
        const S r2 = dot(r, r);
        const Vec3<S> force = (constant * charge[a] * charge[b] / (r2 * real::sqrt(r2))) * r;
        loads[bodies[a]].force_W -= force;
        loads[bodies[b]].force_W += force;
      }
  }
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
