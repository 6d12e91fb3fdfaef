#include "forces/lanes.hpp"

namespace atwood {
namespace {

// F = -1/2 rho C_d A |u| u, u = v - wind; torque = -c_w w in body axes.
template <class S> struct QuadraticDragTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  S half_rho_cd_area, angular_coefficient;
  Vec3<S> wind;

  bool velocity_dependent() const override { return true; }
  static constexpr Items items = Items::bodies;
  template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
    return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), coefficient = half_rho_cd_area,
            angular = angular_coefficient, wind = wind](auto k) ATWOOD_INLINED {
      const auto u = body.v_WB(k) - wind;
      load.force_W(k) -= (coefficient * root(k, dot(u, u))) * u;
      load.torque_B(k) -= angular * body.w_WB_B(k);
    };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const QuadraticDrag& force, const Scene&) {
  auto term = std::make_unique<QuadraticDragTerm<S>>();
  term->bodies = force.bodies;
  term->half_rho_cd_area = S(0.5) * S(force.density_kg_per_m3) * S(force.drag_coefficient) * S(force.area_m2);
  term->angular_coefficient = S(force.angular_coefficient_N_m_s);
  term->wind = narrow3<S>(force.wind_m_per_s);
  return term;
}

template TermPointer<float> make_term<float>(const QuadraticDrag&, const Scene&);
template TermPointer<double> make_term<double>(const QuadraticDrag&, const Scene&);
template TermPointer<long double> make_term<long double>(const QuadraticDrag&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const QuadraticDrag&, const Scene&);

}  // namespace atwood
