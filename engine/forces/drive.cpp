#include "forces/force.hpp"

namespace atwood {
namespace {

// F = force cos(omega t + phase).
template <class S> struct DriveTerm final : ForceTerm<S> {
  std::vector<int> bodies;
  Vec3<S> force;
  S angular_frequency, phase;

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    const Vec3<S> now = real::cos(angular_frequency * motion.t_s + phase) * force;
    for (const int i : bodies) loads[i].force_W += now;
  }
};

}  // namespace

template <class S> TermPointer<S> make_term(const Drive& force, const Scene&) {
  auto term = std::make_unique<DriveTerm<S>>();
  term->bodies = force.bodies;
  term->force = narrow3<S>(force.force_N);
  term->angular_frequency = S(force.angular_frequency_rad_per_s);
  term->phase = S(force.phase_rad);
  return term;
}

template TermPointer<float> make_term<float>(const Drive&, const Scene&);
template TermPointer<double> make_term<double>(const Drive&, const Scene&);
template TermPointer<long double> make_term<long double>(const Drive&, const Scene&);
template TermPointer<Quad> make_term<Quad>(const Drive&, const Scene&);

}  // namespace atwood
