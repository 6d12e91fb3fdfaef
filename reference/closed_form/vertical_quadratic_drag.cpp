// Drag quadratic in the air speed along one line, u' = g - kappa |u| u. Lamb, Dynamics (1914), art. 39.
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct AirMotion { S u{}, path{}; };  // air speed downwards, way through the air downwards

// Down, u >= 0, with the terminal speed V = sqrt(g / kappa), tau = g t / V, r = u0 / V:
//   u = V (r + tanh tau) / (1 + r tanh tau),      path = (V^2 / g) log(cosh tau + r sinh tau)
template <class S> AirMotion<S> down(S u0, S V, S g, S t) {
  const S tau = g * t / V, r = u0 / V, th = tanh(tau);
  const S half = sinh(tau < 1 ? tau / 2 : S(0));
  const S log_part = tau < 1 ? log1p(2 * half * half + r * sinh(tau)) : tau + log1p((r - 1) * (-expm1(-2 * tau)) / 2);
  return {V * (r + th) / (1 + r * th), V * V / g * log_part};
}

// Up, u < 0: u = V tan(tau - theta0), theta0 = atan(-u0 / V), until tau = theta0; from there it falls from rest.
//   path = (V^2 / g) log(cos theta0 / cos(tau - theta0))
// cos a / cos b - 1 = 2 sin((a + b) / 2) sin((b - a) / 2) / cos b, here a = theta0, b = tau - theta0.
template <class S> AirMotion<S> fall(S u0, S V, S g, S t) {
  if (u0 >= 0) return down(u0, V, g, t);
  const S theta0 = atan(-u0 / V), tau = g * t / V;
  const S b = tau < theta0 ? tau - theta0 : S(0);
  const S up = V * V / g * log1p(2 * sin((theta0 + b) / 2) * sin((b - theta0) / 2) / cos(b));
  if (tau < theta0) return {V * tan(b), up};
  const AirMotion<S> after = down(S(0), V, g, t - theta0 * V / g);
  return {after.u, up + after.path};
}

template <class S> Translation<S> vertical_quadratic_drag_translation(const Scene& scene, int body) {
  const Body& ball = scene.bodies[body];
  const QuadraticDrag* drag = nullptr;
  for (const Force& force : scene.forces) {
    if (!acts_on(force, body)) continue;
    if (!std::holds_alternative<QuadraticDrag>(force) || drag != nullptr)
      return {force_on_body(scene, force, body) + " is not covered: expected exactly one quadratic drag", {}};
    drag = &std::get<QuadraticDrag>(force);
  }
  if (drag == nullptr) return {"expected a quadratic drag on `" + ball.name + "`; found none", {}};
  const S kappa = S(drag->density_kg_per_m3) * S(drag->drag_coefficient) * S(drag->area_m2) / (2 * S(ball.mass_kg));
  const Vec<S> p = vec<S>(ball.position_m), wind = vec<S>(drag->wind_m_per_s), g = vec<S>(scene.gravity_m_per_s2);
  const Vec<S> u = vec<S>(ball.velocity_m_per_s) - wind;
  if (!(kappa > 0)) return {"the drag on `" + ball.name + "` is zero", {}};
  if (is_zero(g)) {  // u = u0 / (1 + kappa |u0| t) along itself
    const S speed = norm(u);
    return {"", [=](S t) {
              const S x = kappa * speed * t;
              const S way = speed == 0 ? S(0) : log1p(x) / (kappa * speed);
              return CenterMotion<S>{p + t * wind + way * u, wind + (1 / (1 + x)) * u};
            }};
  }
  if (!is_zero(cross(u, g))) return {"`" + ball.name + "` has an air velocity that is not parallel to gravity", {}};
  const S pull = norm(g);
  const Vec<S> along = (1 / pull) * g;
  const S u0 = dot(u, along), V = sqrt(pull / kappa);
  return {"", [=](S t) {
            const AirMotion<S> now = fall(u0, V, pull, t);
            return CenterMotion<S>{p + t * wind + now.path * along, wind + now.u * along};
          }};
}

template <class S> Motion<S> solve_vertical_quadratic_drag(const Scenario& scenario, const std::vector<S>& t_s) {
  return solve_each_body<S>(scenario, t_s, vertical_quadratic_drag_translation<S>);
}

}  // namespace

Solution vertical_quadratic_drag() {
  return {"vertical-quadratic-drag",
          "drag quadratic in the air speed along gravity: tanh and log cosh, Lamb, Dynamics (1914)",
          feature::kFreeMotion | feature::quadratic_drag_force | feature::angular_drag,
          solve_vertical_quadratic_drag<Narrow>,
          solve_vertical_quadratic_drag<Wide>,
          true};
}

}  // namespace atwood::closed_form
