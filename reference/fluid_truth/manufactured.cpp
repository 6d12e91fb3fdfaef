#include "fluid_truth/manufactured.hpp"

#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

template <class S> Vec<S> Manufactured<S>::velocity(S t, const Vec<S>& x) const {
  const S amplitude = U * cos(w * t);
  const S sx = sin(k * x[0]), sy = sin(k * x[1]), sz = sin(k * x[2]);
  const S cx = cos(k * x[0]), cy = cos(k * x[1]), cz = cos(k * x[2]);
  if (dimensions == 2) return amplitude * Vec<S>{sx * cy, -cx * sy, S(0)};
  return amplitude * Vec<S>{sx * (cz * sy * sy - cy * sz * sz), sy * (cx * sz * sz - cz * sx * sx),
                            sz * (cy * sx * sx - cx * sy * sy)};
}

template <class S> S Manufactured<S>::density(const Vec<S>& x) const {
  return rho0 * (1 + a * sin(k * x[0]) * sin(k * x[1]) * (dimensions == 2 ? S(1) : sin(k * x[2])));
}

template <class S> Vec<S> Manufactured<S>::source(S t, const Vec<S>& x) const {
  const S W = cos(w * t), sx = sin(k * x[0]), sy = sin(k * x[1]), cx = cos(k * x[0]), cy = cos(k * x[1]);
  const S rho = density(x), viscosity = nu * rho0 / rho,
          slope = c * c * exp((gamma - 1) * log1p((rho - rho0) / rho0)) / rho;
  Vec<S> made{};
  if (dimensions == 2) {
    const Vec<S> u{sx * cy, -cx * sy, S(0)};          // of U W = 1
    const Vec<S> convection{sx * cx, sy * cy, S(0)};  // u.grad u / k
    const Vec<S> grad{cx * sy, sx * cy, S(0)};        // grad(sx sy) / k
    for (int i = 0; i < 2; ++i)
      made[i] = -U * w * sin(w * t) * u[i] + U * U * W * W * k * convection[i] + slope * rho0 * a * k * grad[i] +
                2 * viscosity * k * k * U * W * u[i];
    return made;
  }
  const S sz = sin(k * x[2]), cz = cos(k * x[2]);
  const S s[3] = {sx, sy, sz}, o[3] = {cx, cy, cz};
  Vec<S> u{}, laplacian{}, grad{};  // of U W = 1; lap u / k^2; grad(sx sy sz) / k
  S slopes[3][3];                   // d u_i / d x_j / k
  for (int i = 0; i < 3; ++i) {     // u_i = s_i (o_m s_l^2 - o_l s_m^2), l and m the next two axes
    const int l = (i + 1) % 3, m = (i + 2) % 3;
    const S bracket = o[m] * s[l] * s[l] - o[l] * s[m] * s[m];
    u[i] = s[i] * bracket;
    slopes[i][i] = o[i] * bracket;
    slopes[i][l] = s[i] * s[l] * (2 * o[m] * o[l] + s[m] * s[m]);
    slopes[i][m] = -s[i] * s[m] * (s[l] * s[l] + 2 * o[l] * o[m]);
    laplacian[i] = 2 * s[i] * (o[m] * (1 - 3 * s[l] * s[l]) - o[l] * (1 - 3 * s[m] * s[m]));
    grad[i] = o[i] * s[l] * s[m];
  }
  for (int i = 0; i < 3; ++i) {
    S convection = 0;
    for (int j = 0; j < 3; ++j) convection += u[j] * slopes[i][j];
    made[i] = -U * w * sin(w * t) * u[i] + U * U * W * W * k * convection + slope * rho0 * a * k * grad[i] -
              viscosity * k * k * U * W * laplacian[i];
  }
  return made;
}

template <class S> Manufactured<S> manufactured_of(const Scene& scene, const Fluid& fluid, const InitialField& field) {
  const bool plane = field.name == "mms-2d";
  require(plane || field.name == "mms-3d", "expected the field `mms-2d` or `mms-3d`; found `" + field.name + "`");
  require(scene.domain.dimensions == (plane ? 2 : 3), "`" + field.name + "` has another number of dimensions");
  Manufactured<S> made;
  made.dimensions = scene.domain.dimensions;
  made.k = wave_number<S>(scene, field, 0);
  made.U = parameter(field, "speed_m_per_s", 1);
  made.w = parameter(field, "angular_frequency_rad_per_s", 1);
  made.a = parameter(field, "density_amplitude", 0);
  made.rho0 = fluid.density_kg_per_m3;
  made.c = fluid.sound_speed_m_per_s;
  made.gamma = fluid.equation_of_state == EquationOfState::tait ? S(fluid.tait_exponent) : S(1);
  made.nu = fluid.viscosity_m2_per_s;
  return made;
}

namespace {

template <class S> Field<S> solve_manufactured(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require(!has_boundaries(scene) && scene.gravity_m_per_s2 == Real3{}, "expected no boundary and no gravity");
  require(fluid.initial.name == asked.scenario.truth.solution, "expected the initial field of the same name");
  require(fluid.source.name == fluid.initial.name && fluid.source.parameters == fluid.initial.parameters,
          "expected a source of the same name and parameters as the initial field");
  const auto field = manufactured_of<S>(scene, fluid, fluid.initial);
  for (int axis = 0; axis < field.dimensions; ++axis) require_period<S>(scene, field.k, axis);
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      at.v = field.velocity(t, x);
      at.density = field.density(x);
      const S excess = field.density(x) / field.rho0 - 1;
      at.p = field.rho0 * field.c * field.c / field.gamma * expm1(field.gamma * log1p(excess));
      return at;
    };
  };
  return made;
}

}  // namespace

Solution mms_2d() {
  return {"mms-2d",
          "manufactured solution in the plane: Roache, J. Fluids Eng. 124 (2002) 4",
          {true, true, true, false},
          solve_manufactured<Narrow>,
          solve_manufactured<Wide>};
}
Solution mms_3d() {
  return {"mms-3d",
          "manufactured solution in space: Roache, J. Fluids Eng. 124 (2002) 4",
          {true, true, true, false},
          solve_manufactured<Narrow>,
          solve_manufactured<Wide>};
}

template struct Manufactured<Narrow>;
template struct Manufactured<Wide>;
template struct Manufactured<double>;
template Manufactured<Narrow> manufactured_of(const Scene&, const Fluid&, const InitialField&);
template Manufactured<Wide> manufactured_of(const Scene&, const Fluid&, const InitialField&);
template <> Manufactured<double> manufactured_of(const Scene& scene, const Fluid& fluid, const InitialField& field) {
  const auto from = manufactured_of<Narrow>(scene, fluid, field);
  Manufactured<double> made;
  made.dimensions = from.dimensions;
  made.k = static_cast<double>(from.k), made.U = static_cast<double>(from.U), made.w = static_cast<double>(from.w);
  made.a = static_cast<double>(from.a), made.rho0 = static_cast<double>(from.rho0);
  made.c = static_cast<double>(from.c), made.gamma = static_cast<double>(from.gamma);
  made.nu = static_cast<double>(from.nu);
  return made;
}

}  // namespace atwood::fluid_truth
