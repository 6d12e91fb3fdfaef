#include "forces/force.hpp"

namespace atwood {
namespace {

// F = -c (v - wind), torque = -c_w w in body axes.
template <class S> struct LinearDragTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  S coefficient, angular_coefficient;
  Vec3<S> wind;

  bool velocity_dependent() const override { return true; }
  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    for (const int i : bodies) {
      loads[i].force_W -= coefficient * (motion.v_WB(i) - wind);
      loads[i].torque_B -= angular_coefficient * motion.w_WB_B(i);
    }
  }
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
