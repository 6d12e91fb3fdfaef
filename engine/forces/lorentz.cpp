#include "forces/lanes.hpp"

namespace atwood {
namespace {

// F = q (E + v x B).
template <class S> struct LorentzTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  std::vector<S> charge;
  Vec3<S> electric, magnetic;

  bool velocity_dependent() const override { return dot(magnetic, magnetic) != S(0); }
  bool add_magnetic(Vec3<S>* charge_field_W) const override {
    for (std::size_t k = 0; k < bodies.size(); ++k) charge_field_W[bodies[k]] += charge[k] * magnetic;
    return true;
  }
  static constexpr Items items = Items::bodies;
  template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
    return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), charge = charge[item],
            electric = electric, magnetic = magnetic](auto k)
               ATWOOD_INLINED { load.force_W(k) += charge * (electric + cross(body.v_WB(k), magnetic)); };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const Lorentz& force, const Scene& scene) {
  auto term = std::make_unique<LorentzTerm<S>>();
  term->bodies = force.bodies;
  for (const int i : force.bodies) term->charge.push_back(S(scene.bodies[i].charge_C));
  term->electric = narrow3<S>(force.electric_V_per_m);
  term->magnetic = narrow3<S>(force.magnetic_T);
  return term;
}

template TermPointer<float> make_term<float>(const Lorentz&, const Scene&);
template TermPointer<double> make_term<double>(const Lorentz&, const Scene&);
template TermPointer<long double> make_term<long double>(const Lorentz&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Lorentz&, const Scene&);

}  // namespace atwood
