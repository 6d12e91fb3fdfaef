#include "forces/lanes.hpp"

namespace atwood {
namespace {

// a = -mu r / |r|^3, r from the centre.
template <class S> struct AttractorTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  Vec3<S> center;
  S mu;

  static constexpr Items items = Items::bodies;
  template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
    return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), center = center, mu = mu](auto k)
               ATWOOD_INLINED {
                 const auto r = body.p_WB(k) - center;
                 const auto r2 = dot(r, r);
                 load.acceleration_W(k) -= (mu / (r2 * root(k, r2))) * r;
               };
  }
  ATWOOD_ONE_LAW
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
