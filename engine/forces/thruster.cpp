#include "forces/force.hpp"

namespace atwood {
namespace {

// A force fixed in the body: R thrust at R point; its torque in body axes is constant.
template <class S> struct ThrusterTerm final : ForceTerm<S> {
  int body;
  Vec3<S> force_B, torque_B;

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    loads[body].force_W += rotate(motion.q_WB(body), force_B);
    loads[body].torque_B += torque_B;
  }
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
