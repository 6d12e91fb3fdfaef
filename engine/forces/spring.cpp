#include "forces/lanes.hpp"

namespace atwood {
namespace {

// A spring with a dashpot along it, from end a to end b:
//   r = x_b - x_a,  n = r / |r|,  F on b = -(k (|r| - L) + c (x_b' - x_a') . n) n
// With L = 0 the spring's part is -k r, smooth through r = 0; the dashpot's limit for ends that pass straight through
// each other is -c (x_b' - x_a').
template <class S> struct SpringTerm final : ForceTerm<S> {
  int a = -1, b = 0;  // a = -1: the anchor
  Vec3<S> anchor, point_a, point_b;
  S stiffness, damping, rest_length;

  bool velocity_dependent() const override { return damping != S(0); }
  static constexpr Items items = Items::the_force;
  template <class M, class L> ATWOOD_INLINE auto law(const M& motion, const L& loads) const {
    const auto body_a = motion.body(a < 0 ? b : a), body_b = motion.body(b);  // an anchored end a: never read
    const auto load_a = loads.body(a < 0 ? b : a), load_b = loads.body(b);
    return [=, *this](int k) ATWOOD_INLINED {
      const Quat<S> q_a = a < 0 ? Quat<S>{} : body_a.q_WB(k), q_b = body_b.q_WB(k);
      const Vec3<S> x_a = a < 0 ? anchor : body_a.p_WB(k) + rotate(q_a, point_a);
      const Vec3<S> r = body_b.p_WB(k) + rotate(q_b, point_b) - x_a;
      const S length = norm(r);
      Vec3<S> on_b = -(rest_length == S(0) ? stiffness : stiffness * (S(1) - rest_length / length)) * r;
      if (damping != S(0)) {
        Vec3<S> u = body_b.v_WB(k) + rotate(q_b, cross(body_b.w_WB_B(k), point_b));
        if (a >= 0) u -= body_a.v_WB(k) + rotate(q_a, cross(body_a.w_WB_B(k), point_a));
        on_b -= damping * (length == S(0) ? u : (dot(u, r) / (length * length)) * r);
      }
      add_force_at(load_b, k, q_b, point_b, on_b);
      if (a >= 0) add_force_at(load_a, k, q_a, point_a, -on_b);
    };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const Spring& force, const Scene&) {
  auto term = std::make_unique<SpringTerm<S>>();
  const bool anchored = force.bodies.size() == 1;
  const auto point = [&](std::size_t k) {
    return k < force.points_body_m.size() ? narrow3<S>(force.points_body_m[k]) : Vec3<S>{};
  };
  term->a = anchored ? -1 : force.bodies[0];
  term->b = anchored ? force.bodies[0] : force.bodies[1];
  term->anchor = narrow3<S>(force.anchor_m);
  term->point_a = anchored ? Vec3<S>{} : point(0);
  term->point_b = anchored ? point(0) : point(1);
  term->stiffness = S(force.stiffness_N_per_m);
  term->damping = S(force.damping_N_s_per_m);
  term->rest_length = S(force.rest_length_m);
  return term;
}

template TermPointer<float> make_term<float>(const Spring&, const Scene&);
template TermPointer<double> make_term<double>(const Spring&, const Scene&);
template TermPointer<long double> make_term<long double>(const Spring&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Spring&, const Scene&);

}  // namespace atwood
