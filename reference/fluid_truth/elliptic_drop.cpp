// A drop that a linear velocity field stretches into an ellipse, incompressible, without viscosity or surface tension.
// J. J. Monaghan, J. Comput. Phys. 110 (1994) 399, section 5. With u = -A x, v = A y and the semi-axes a, b:
//   A' = A^2 (a^2 - b^2) / (a^2 + b^2),   a' = -A a,   b' = A b
// The acceleration (A^2 - A') x, (A^2 + A') y is that of p = rho0 A^2 a^2 b^2 / (a^2 + b^2) (1 - x^2/a^2 - y^2/b^2),
// which is 0 on the surface. a b and A^2 (a^2 + b^2) are constant (area and energy).
#include <vector>

#include "fluid_truth/elliptic_drop.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

constexpr int kColumns = 12;

template <class S> Vec<S> rate(const Vec<S>& y) {  // of (a, b, A)
  const S a = y[0], b = y[1], A = y[2];
  return {-A * a, A * b, A * A * ((a - b) * (a + b)) / (a * a + b * b)};
}

// One step of Gragg's midpoint rule with 2, 4, ... 24 substeps, extrapolated in the square of the substep (Hairer,
// Norsett, Wanner, Solving Ordinary Differential Equations I, II.9): order 24.
template <class S> Vec<S> extrapolated_step(const Vec<S>& y, S H) {
  std::vector<Vec<S>> row(kColumns + 1);
  for (int k = 1; k <= kColumns; ++k) {
    const S h = H / S(2 * k);
    Vec<S> before = y, now = y + h * rate(y);
    for (int m = 1; m < 2 * k; ++m) {
      const Vec<S> after = before + 2 * h * rate(now);
      before = now;
      now = after;
    }
    row[k] = now;
    for (int j = k - 1; j >= 1; --j) {
      const S ratio = S(k) / S(j);
      row[j] = row[j + 1] + (1 / (ratio * ratio - 1)) * (row[j + 1] - row[j]);
    }
  }
  return row[1];
}

template <class S> Vec<S> integrate(const Vec<S>& y, S t, int steps) {
  Vec<S> now = y;
  for (int n = 0; n < steps; ++n) now = extrapolated_step(now, t / S(steps));
  return now;
}

}  // namespace

// Two numbers of steps; the difference bounds the error of the larger number, which is 2^24 times smaller.
template <class S> Drop<S> drop_at(const Drop<S>& start, S t) {
  const int steps = 1 + static_cast<int>(magnitude(start.A) * t * 16);
  const Vec<S> y{start.a, start.b, start.A}, coarse = integrate(y, t, steps), fine = integrate(y, t, 2 * steps);
  S error = 0;
  for (int i = 0; i < 3; ++i) error = larger(error, magnitude(fine[i] - coarse[i]) / magnitude(fine[i]));
  return {fine[0], fine[1], fine[2], error};
}

namespace {

template <class S> Field<S> solve_elliptic_drop(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require(scene.domain.dimensions == 2 && !has_boundaries(scene) && scene.gravity_m_per_s2 == Real3{} &&
              fluid.source.name.empty(),
          "expected two dimensions, no boundary, no gravity and no source");
  require(fluid.viscosity_m2_per_s == 0, "expected a fluid without viscosity");
  require(fluid.initial.name == "elliptic-drop", "expected the initial field `elliptic-drop`");
  Drop<S> start;
  Vec<S> centre{};
  if (const auto* ball = std::get_if<BallRegion>(&fluid.region)) {
    start.a = start.b = ball->radius_m;
    centre = vec<S>(ball->center_m);
  } else {
    const auto* ellipse = std::get_if<EllipsoidRegion>(&fluid.region);
    require(ellipse != nullptr, "expected a circle or an ellipse");
    start.a = ellipse->semi_axes_m[0], start.b = ellipse->semi_axes_m[1];
    centre = vec<S>(ellipse->center_m);
  }
  start.A = parameter(fluid.initial, "rate_per_s", 100);
  const S rho0 = fluid.density_kg_per_m3;
  Field<S> made;
  made.note = "incompressible";
  made.at = [=](S t) -> FieldAt<S> {
    const Drop<S> now = drop_at(start, t);
    const S aa = now.a * now.a, bb = now.b * now.b, middle = rho0 * now.A * now.A * aa * bb / (aa + bb);
    return [=](const Vec<S>& x) {
      Point<S> at;
      const S dx = x[0] - centre[0], dy = x[1] - centre[1];
      at.v = {-now.A * dx, now.A * dy, S(0)};
      at.p = middle * (1 - dx * dx / aa - dy * dy / bb);
      at.density = rho0;
      at.neglected_v = now.error * magnitude(now.A) * (magnitude(dx) + magnitude(dy));
      at.neglected_p = 8 * now.error * middle * (1 + dx * dx / aa + dy * dy / bb);
      return at;
    };
  };
  made.probe = [=](S t, const FluidProbe& probe) -> std::optional<ProbeAt<S>> {
    const Drop<S> now = drop_at(start, t);
    if (probe.kind == ProbeKind::front) return ProbeAt<S>{centre[0] + now.a, now.error * now.a};
    if (probe.kind != ProbeKind::marker) return {};
    // The flow is linear: the map of material points stretches by a / a0 and b / b0.
    const Vec<S> from = vec<S>(probe.position_m) - centre,
                 x = centre + Vec<S>{now.a / start.a * from[0], now.b / start.b * from[1], S(0)};
    return ProbeAt<S>{sqrt(dot(x, x)), now.error * (magnitude(x[0]) + magnitude(x[1]))};
  };
  return made;
}

}  // namespace

Solution elliptic_drop() {
  return {"elliptic-drop",
          "a drop stretched into an ellipse: Monaghan, J. Comput. Phys. 110 (1994) 399, section 5",
          {true, true, true, false},
          solve_elliptic_drop<Narrow>,
          solve_elliptic_drop<Wide>};
}

template Drop<Narrow> drop_at(const Drop<Narrow>&, Narrow);
template Drop<Wide> drop_at(const Drop<Wide>&, Wide);

}  // namespace atwood::fluid_truth
