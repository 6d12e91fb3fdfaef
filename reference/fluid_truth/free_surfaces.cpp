// Fluids with a free surface: a column in equilibrium, a rotating square, a dam on a dry bed.
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

// ---- a column at rest ---------------------------------------------------------------------------------------------
// Pressure is the weight above: dp = -g dm per area. With the equation of state, the depth y below the surface and
// dp = rho g dy:
//   Tait      g y = c^2 / (gamma - 1) ((1 + gamma p / (rho0 c^2))^((gamma - 1) / gamma) - 1)
//   linear    g y = c^2 log(1 + p / (rho0 c^2))                   (also Tait with gamma = 1)
// A column of height H that begins at the uniform density rho0 settles: the pressure at the bottom stays rho0 g H (mass
// coordinates), and the surface sinks to the depth y at which p = rho0 g H. (Monaghan 1994, section 4.)
template <class S> struct Column {
  S rho0{}, c{}, gamma{};  // gamma = 1: linear
  S depth(S gravity, S p) const {
    const S q = log1p(gamma * p / (rho0 * c * c));
    return gamma == 1 ? c * c * q / gravity : c * c * expm1((gamma - 1) / gamma * q) / ((gamma - 1) * gravity);
  }
  S pressure(S gravity, S depth) const {
    const S head = gravity * depth / (c * c);
    if (gamma == 1) return rho0 * c * c * expm1(head);
    return rho0 * c * c / gamma * expm1(gamma / (gamma - 1) * log1p((gamma - 1) * head));
  }
};

template <class S> Field<S> solve_column(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  const Upwards up = upwards_of(scene);
  const auto* box = std::get_if<BoxRegion>(&fluid.region);
  require(box != nullptr, "expected the region of a box");
  require(fluid.expansion_per_K == 0 && fluid.source.name.empty(), "expected no expansion and no source");
  require(fluid.initial.name.empty() || fluid.initial.name == "hydrostatic",
          "expected a uniform density or the initial field `hydrostatic`");
  const bool tait = fluid.equation_of_state == EquationOfState::tait;
  const Column<S> column{fluid.density_kg_per_m3, fluid.sound_speed_m_per_s, tait ? S(fluid.tait_exponent) : S(1)};
  const S g = up.g, sign = up.sign;
  const S floor = sign * S(up.sign > 0 ? box->min_m[up.axis] : box->max_m[up.axis]),  // heights along minus gravity
      top = sign * S(up.sign > 0 ? box->max_m[up.axis] : box->min_m[up.axis]);
  S surface = floor + column.depth(g, column.rho0 * g * (top - floor));
  if (fluid.initial.name == "hydrostatic") {
    surface = parameter(fluid.initial, "surface_m", static_cast<double>(top));
    require(parameter(fluid.initial, "knock_m_per_s", 0) == 0 || fluid.viscosity_m2_per_s > 0,
            "the vortices of a fluid without viscosity do not come to rest");
  }
  Field<S> made;
  made.note = "the settled state: waves that remain are the method's, or have not decayed yet";
  made.at = [=](S) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const S depth = surface - sign * x[up.axis];
      at.p = depth > 0 ? column.pressure(g, depth) : S(0);
      at.density = column.rho0 * exp(log1p(column.gamma * at.p / (column.rho0 * column.c * column.c)) / column.gamma);
      return at;
    };
  };
  made.probe = [=](S, const FluidProbe& probe) -> std::optional<ProbeAt<S>> {
    if (probe.kind != ProbeKind::column_height) return {};
    return ProbeAt<S>{surface - floor, S(0)};
  };
  return made;
}

// ---- a rotating square ----------------------------------------------------------------------------------------------
// u = w y, v = -w x about the centre at t = 0. Incompressible: lap p = -rho0 d_i u_j d_j u_i = 2 rho0 w^2 with p = 0 on
// the surface (A. Colagrossi, thesis, Rome 2005; Le Touze, Colagrossi, Colicchio, Greco, Int. J. Numer. Meth. Fluids 73
// (2013) 660, a double series). Summed over one index, with X, Y from a corner of the square of side L:
//   p = -rho0 w^2 (X (L - X) - 8 L^2 / pi^3 S)
//   S = sum_{n odd} sin(n pi X / L) cosh(n pi (Y - L/2) / L) / (n^3 cosh(n pi / 2))
// The terms after n = N are at most exp(-n pi d / L) / n^3 with d the distance of Y from the nearer side; X and Y are
// exchanged where that is better, and the rest is bounded by the sum of 1 / n^3 at a corner.
constexpr int kTerms = 400;

template <class S> struct SquarePressure { S value{}, neglected{}; };

template <class S> SquarePressure<S> square_pressure(S X, S Y, S L) {  // of rho0 w^2 = 1
  S dx = larger(S(0), X < L - X ? X : L - X), dy = larger(S(0), Y < L - Y ? Y : L - Y);
  if (dy < dx) {
    std::swap(X, Y);
    std::swap(dx, dy);
  }
  const S turn = pi<S>() / L;
  S sum = 0, last = 0;
  int n = 1;
  for (; n < 2 * kTerms; n += 2) {
    // cosh(n pi (Y - L/2) / L) / cosh(n pi / 2), without overflow
    const S m = n, ratio = (exp(-m * turn * dy) + exp(-m * turn * (L - dy))) / (1 + exp(-m * pi<S>()));
    last = ratio / (m * m * m);
    sum += sin(m * turn * X) * last;
    if (last < unit_round_off<S>() * S(1e-3)) break;
  }
  // Terms of step 2 in n: the rest is at most the last term times n / 4 (from 1 / n^3), or a geometric series of ratio
  // exp(-2 pi dy / L).
  const S decay = -expm1(-2 * turn * dy), rest = decay > 4 / S(n) ? last / decay : last * S(n) / 4;
  const S scale = 8 * L * L / (pi<S>() * pi<S>() * pi<S>());
  return {-(X * (L - X) - scale * sum), scale * rest};
}

template <class S> Field<S> solve_square(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require(scene.domain.dimensions == 2 && !has_boundaries(scene) && scene.gravity_m_per_s2 == Real3{},
          "expected two dimensions, no boundary and no gravity");
  require(fluid.initial.name == "square-patch", "expected the initial field `square-patch`");
  const auto* box = std::get_if<BoxRegion>(&fluid.region);
  require(box != nullptr, "expected the region of a box");
  const Vec<S> low = vec<S>(box->min_m), high = vec<S>(box->max_m);
  const S L = high[0] - low[0], w = parameter(fluid.initial, "rate_per_s", 5), rho0 = fluid.density_kg_per_m3;
  require(magnitude(high[1] - low[1] - L) <= S(1e-12) * L, "expected a square");
  const Vec<S> centre = S(0.5) * (low + high);
  Field<S> made;
  made.note = "the field at t = 0; later the invariants judge";
  made.undefined = [](S t) -> std::string {
    return t > 0 ? "the rotating square has an exact field only at t = 0" : "";
  };
  made.at = [=](S) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const SquarePressure<S> p = square_pressure(x[0] - low[0], x[1] - low[1], L);
      at.v = {w * (x[1] - centre[1]), -w * (x[0] - centre[0]), S(0)};
      at.p = rho0 * w * w * p.value;
      at.neglected_p = rho0 * w * w * p.neglected;
      at.density = rho0;
      return at;
    };
  };
  return made;
}

// ---- a dam on a dry bed -------------------------------------------------------------------------------------------
// Shallow water: A. Ritter, Z. Ver. Deutsch. Ing. 36 (1892) 947. With c0 = sqrt(g h0) and xi = (x - x0) / t:
//   h = (2 c0 - xi)^2 / (9 g),   u = 2 (c0 + xi) / 3         -c0 <= xi <= 2 c0
// A comparison and no bound: near the dam and the front the vertical acceleration is not small.
template <class S> Field<S> solve_ritter(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  const Upwards up = upwards_of(scene);
  require(up.axis != 0, "expected gravity across x");
  const auto* box = std::get_if<BoxRegion>(&fluid.region);
  require(box != nullptr, "expected the region of a box");
  const bool at_rest = fluid.initial.name == "hydrostatic" ? parameter(fluid.initial, "knock_m_per_s", 0) == 0
                                                           : fluid.initial.name.empty();
  require(at_rest && fluid.initial.velocity_m_per_s == Real3{} &&
              fluid.initial.velocity_gradient_per_s == std::array<double, 9>{},
          "expected a fluid at rest at t = 0");
  const S g = up.g, sign = up.sign, dam = box->max_m[0], back = box->min_m[0], rho0 = fluid.density_kg_per_m3,
          bottom = sign * S(up.sign > 0 ? box->min_m[up.axis] : box->max_m[up.axis]),
          h0 = S(box->max_m[up.axis]) - S(box->min_m[up.axis]), c0 = sqrt(g * h0);
  const auto beyond = [=](S t) -> std::string {
    return c0 * t > dam - back ? "the wave has reached the back of the reservoir" : "";
  };
  Field<S> made;
  made.bounded = false;
  made.note = "shallow water: a comparison without a bound";
  made.undefined = beyond;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const S xi = t > 0 ? (x[0] - dam) / t : x[0] < dam ? -c0 : 2 * c0;
      const bool still = xi <= -c0, dry = xi >= 2 * c0;
      const S h = still ? h0 : dry ? S(0) : (2 * c0 - xi) * (2 * c0 - xi) / (9 * g);
      if (!still && !dry) at.v[0] = 2 * (c0 + xi) / 3;
      const S depth = bottom + h - sign * x[up.axis];
      at.p = depth > 0 ? rho0 * g * depth : S(0);
      at.density = rho0;
      return at;
    };
  };
  made.probe = [=](S t, const FluidProbe& probe) -> std::optional<ProbeAt<S>> {
    if (probe.kind == ProbeKind::front) return ProbeAt<S>{dam + 2 * c0 * t, S(0)};
    return {};
  };
  return made;
}

}  // namespace

Solution hydrostatic() {
  return {"hydrostatic",
          "a compressible column at rest, in mass coordinates: Monaghan, J. Comput. Phys. 110 (1994) 399",
          {true, true, true, false},
          solve_column<Narrow>,
          solve_column<Wide>};
}

Solution square_patch() {
  return {"square-patch",
          "a rotating square at t = 0: Colagrossi 2005; Le Touze et al., Int. J. Numer. Meth. Fluids 73 (2013)",
          {true, true, true, false},
          solve_square<Narrow>,
          solve_square<Wide>};
}

Solution ritter() {
  return {"ritter",
          "a dam on a dry bed, shallow water: Ritter, Z. Ver. Deutsch. Ing. 36 (1892) 947",
          {true, true, true, false},
          solve_ritter<Narrow>,
          solve_ritter<Wide>};
}

}  // namespace atwood::fluid_truth
