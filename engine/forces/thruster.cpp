#include "forces/lanes.hpp"

namespace atwood {
namespace {

// A force fixed in the body: R thrust at R point; its torque in body axes is constant.
template <class S> struct ThrusterTerm final : ForceTerm<S> {
  int body;
  Vec3<S> force_B, torque_B;

  static constexpr Items items = Items::the_force;
  template <class M, class L> ATWOOD_INLINE auto law(const M& motion, const L& loads) const {
    return [at = motion.body(body), load = loads.body(body), force_B = force_B, torque_B = torque_B](int k)
               ATWOOD_INLINED {
                 load.force_W(k) += rotate(at.q_WB(k), force_B);
                 load.torque_B(k) += torque_B;
               };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const Thruster& force, const Scene&) {
  auto term = std::make_unique<ThrusterTerm<S>>();
  term->body = force.body;
  term->force_B = S(force.thrust_N) * narrow3<S>(force.direction_body);
  term->torque_B = cross(narrow3<S>(force.point_body_m), term->force_B);
  term->on_s = force.on_s;
  return term;
}

template TermPointer<float> make_term<float>(const Thruster&, const Scene&);
template TermPointer<double> make_term<double>(const Thruster&, const Scene&);
template TermPointer<long double> make_term<long double>(const Thruster&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Thruster&, const Scene&);

}  // namespace atwood
