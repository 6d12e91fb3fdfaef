#include "forces/force.hpp"

namespace atwood {
namespace {

// A force fixed in the world at a point fixed in the body.
template <class S> struct PointForceTerm final : ForceTerm<S> {
  int body;
  Vec3<S> point_B, force_W;

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    add_force_at(loads[body], motion.q_WB(body), point_B, force_W);
  }
};

}  // namespace

template <class S> TermPointer<S> make_term(const PointForce& force, const Scene&) {
  auto term = std::make_unique<PointForceTerm<S>>();
  term->body = force.body;
  term->point_B = narrow3<S>(force.point_body_m);
  term->force_W = narrow3<S>(force.force_N);
  term->on_s = force.on_s;
  return term;
}

template TermPointer<float> make_term<float>(const PointForce&, const Scene&);
template TermPointer<double> make_term<double>(const PointForce&, const Scene&);
template TermPointer<long double> make_term<long double>(const PointForce&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const PointForce&, const Scene&);

}  // namespace atwood
