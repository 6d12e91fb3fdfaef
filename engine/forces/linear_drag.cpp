#include "forces/lanes.hpp"

namespace atwood {
namespace {

// F = -c (v - wind), torque = -c_w w in body axes.
template <class S> struct LinearDragTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  S coefficient, angular_coefficient;
  Vec3<S> wind;

  bool velocity_dependent() const override { return true; }
  static constexpr Items items = Items::bodies;
  template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
    return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), coefficient = coefficient,
            angular = angular_coefficient, wind = wind](auto k) ATWOOD_INLINED {
      load.force_W(k) -= coefficient * (body.v_WB(k) - wind);
      load.torque_B(k) -= angular * body.w_WB_B(k);
    };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const LinearDrag& force, const Scene&) {
  auto term = std::make_unique<LinearDragTerm<S>>();
  term->bodies = force.bodies;
  term->coefficient = S(force.coefficient_kg_per_s);
  term->angular_coefficient = S(force.angular_coefficient_N_m_s);
  term->wind = narrow3<S>(force.wind_m_per_s);
  return term;
}

template TermPointer<float> make_term<float>(const LinearDrag&, const Scene&);
template TermPointer<double> make_term<double>(const LinearDrag&, const Scene&);
template TermPointer<long double> make_term<long double>(const LinearDrag&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const LinearDrag&, const Scene&);

}  // namespace atwood
