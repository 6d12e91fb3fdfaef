#include "forces/lanes.hpp"

namespace atwood {
namespace {

// A force fixed in the world at a point fixed in the body.
template <class S> struct PointForceTerm final : ForceTerm<S> {
  int body;
  Vec3<S> point_B, force_W;

  static constexpr Items items = Items::the_force;
  template <class M, class L> ATWOOD_INLINE auto law(const M& motion, const L& loads) const {
    return [at = motion.body(body), load = loads.body(body), point_B = point_B, force_W = force_W](int k)
               ATWOOD_INLINED { add_force_at(load, k, at.q_WB(k), point_B, force_W); };
  }
  ATWOOD_ONE_LAW
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
