#include "forces/lanes.hpp"

namespace atwood {
namespace {

// Henon and Heiles, Astron. J. 69 (1964) 73: V = (x^2 + y^2) / 2 + lambda (x^2 y - y^3 / 3), in joules; F = -grad V.
template <class S> struct HenonHeilesTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  S lambda;

  static constexpr Items items = Items::bodies;
  template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
    return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), lambda = lambda](auto k) ATWOOD_INLINED {
      const auto p = body.p_WB(k);
      load.force_W(k) -=
          Vec3<decltype(p.x * lambda)>{p.x + S(2) * lambda * p.x * p.y, p.y + lambda * (p.x * p.x - p.y * p.y), {}};
    };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const Potential& force, const Scene&) {
  if (force.name != "henon-heiles") throw Unsupported{"atwood has no potential `" + force.name + "`"};
  auto term = std::make_unique<HenonHeilesTerm<S>>();
  term->bodies = force.bodies;
  const auto lambda = force.parameters.find("lambda");
  term->lambda = lambda == force.parameters.end() ? S(1) : S(lambda->second);
  return term;
}

template TermPointer<float> make_term<float>(const Potential&, const Scene&);
template TermPointer<double> make_term<double>(const Potential&, const Scene&);
template TermPointer<long double> make_term<long double>(const Potential&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Potential&, const Scene&);

}  // namespace atwood
