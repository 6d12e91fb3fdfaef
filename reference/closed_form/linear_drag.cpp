// Drag linear in the speed relative to the wind, m v' = m g - c (v - u). Lamb, Dynamics (1914), art. 38.
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

// phi1(x) = (1 - exp(-x)) / x and phi2(x) = (exp(-x) - 1 + x) / x^2, without cancellation near 0:
//   phi2 = 1/2! - x/3! + x^2/4! - ...
template <class S> S phi1(S x) { return x == 0 ? S(1) : -expm1(-x) / x; }
template <class S> S phi2(S x) {
  if (x > 1) return (expm1(-x) + x) / (x * x);
  S term = S(1) / 2, sum = 0;
  for (int k = 3; magnitude(term) > unit_round_off<S>() / 8; ++k) {
    sum += term;
    term *= -x / k;
  }
  return sum;
}

// With k = c/m and u the wind:  v = u + (v0 - u) exp(-k t) + g t phi1(k t)
//                               p = p0 + u t + (v0 - u) t phi1(k t) + g t^2 phi2(k t)
template <class S> Translation<S> linear_drag_translation(const Scene& scene, int body) {
  S c = 0;
  Vec<S> carried{};
  for (const Force& force : scene.forces) {
    if (!acts_on(force, body)) continue;
    const auto* drag = std::get_if<LinearDrag>(&force);
    if (drag == nullptr) return {force_on_body(scene, force, body) + " is not covered", {}};
    c += S(drag->coefficient_kg_per_s);
    carried = carried + S(drag->coefficient_kg_per_s) * vec<S>(drag->wind_m_per_s);
  }
  const Vec<S> wind = c == 0 ? Vec<S>{} : (1 / c) * carried;
  const S k = c / S(scene.bodies[body].mass_kg);
  const Vec<S> p = vec<S>(scene.bodies[body].position_m), g = vec<S>(scene.gravity_m_per_s2);
  const Vec<S> u = vec<S>(scene.bodies[body].velocity_m_per_s) - wind;
  return {"", [=](S t) {
            const S x = k * t;
            return CenterMotion<S>{p + t * (wind + phi1(x) * u + (t * phi2(x)) * g),
                                   wind + exp(-x) * u + (t * phi1(x)) * g};
          }};
}

template <class S> Motion<S> solve_linear_drag(const Scenario& scenario, const std::vector<S>& t_s) {
  return solve_each_body<S>(scenario, t_s, linear_drag_translation<S>);
}

}  // namespace

Solution linear_drag() {
  return {"linear-drag",
          "drag linear in the air speed: exponential approach, Lamb, Dynamics (1914)",
          feature::kFreeMotion | feature::linear_drag_force | feature::angular_drag,
          solve_linear_drag<Narrow>,
          solve_linear_drag<Wide>,
          true};
}

}  // namespace atwood::closed_form
