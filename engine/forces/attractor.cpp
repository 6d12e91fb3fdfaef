#include "forces/force.hpp"

namespace atwood {
namespace {

// a = -mu r / |r|^3, r from the centre.
template <class S> struct AttractorTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  Vec3<S> center;
  S mu;

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    for (const int i : bodies) {
      const Vec3<S> r = motion.p_WB(i) - center;
      const S r2 = dot(r, r);
      loads[i].acceleration_W -= (mu / (r2 * real::sqrt(r2))) * r;
    }
  }
};

}  // namespace

template <class S> TermPointer<S> make_term(const Attractor& force, const Scene&) {
  auto term = std::make_unique<AttractorTerm<S>>();
  term->bodies = force.bodies;
  term->center = narrow3<S>(force.center_m);
  term->mu = S(force.mu_m3_per_s2);
  return term;
}

template TermPointer<float> make_term<float>(const Attractor&, const Scene&);
template TermPointer<double> make_term<double>(const Attractor&, const Scene&);
template TermPointer<long double> make_term<long double>(const Attractor&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Attractor&, const Scene&);

}  // namespace atwood
