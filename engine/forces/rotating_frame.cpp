#include "forces/lanes.hpp"

namespace atwood {
namespace {

// Coriolis and centrifugal terms: a = -2 W x v - W x (W x r).
template <class S> struct RotatingFrameTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  Vec3<S> rate;

  bool velocity_dependent() const override { return dot(rate, rate) != S(0); }
  static constexpr Items items = Items::bodies;
  template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
    return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), rate = rate](auto k) ATWOOD_INLINED {
      const auto v = body.v_WB(k);
      load.acceleration_W(k) -= cross(rate, v + v + cross(rate, body.p_WB(k)));
    };
  }
  ATWOOD_ONE_LAW
};

}  // namespace

template <class S> TermPointer<S> make_term(const RotatingFrame& force, const Scene& scene) {
  auto term = std::make_unique<RotatingFrameTerm<S>>();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    if (rotates(body)) throw Unsupported{"atwood's rotating-frame acts on point masses; `" + body.name + "` rotates"};
    term->bodies.push_back(static_cast<int>(i));
  }
  term->rate = narrow3<S>(force.angular_velocity_rad_per_s);
  return term;
}

template TermPointer<float> make_term<float>(const RotatingFrame&, const Scene&);
template TermPointer<double> make_term<double>(const RotatingFrame&, const Scene&);
template TermPointer<long double> make_term<long double>(const RotatingFrame&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const RotatingFrame&, const Scene&);

}  // namespace atwood
