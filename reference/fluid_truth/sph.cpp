// The equations of `+sph` (docs/fluids.md), written from that page: for each particle the sums over its neighbours.
// J. J. Monaghan, Rep. Prog. Phys. 68 (2005) 1703; S. Adami, X. Y. Hu, N. A. Adams, J. Comput. Phys. 231 (2012) 7057.
#include <algorithm>
#include <cmath>

#include "fluid_truth/particles.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

enum class Viscosity { none, morris, central };

template <class S> struct Pair {
  int other = 0;
  Vec<S> x{};  // x_i - x_other
  S W{}, F{};  // kernel, slope over r
  S r2{};
};

template <class S> S power(S x, int n) {
  S made = 1;
  for (int k = 0; k < n; ++k) made *= x;
  return made;
}

template <class S> class Sph final : public FluidSystem<S> {
 public:
  Sph(const Scene& scene, const Response& response);
  void rate(S t, const S* y, S* dydt) override;
  std::vector<S> densities(const S* y) override;

 private:
  // What one evaluation computes of the particles and of the walls' points.
  struct Now {
    std::vector<Vec<S>> x, v, u;  // u: transport velocity of `shift`
    std::vector<S> rho, p, V, T;
    std::vector<std::vector<Pair<S>>> fluid, walls;  // of each particle
    std::vector<S> wall_p, wall_rho, wall_T;
    std::vector<S> wall_q;  // of a flux: heat for each particle, over its W / rho
    std::vector<Vec<S>> wall_v;
    std::vector<bool> wall_acts;
  };
  Now evaluate(const S* y);
  void find_pairs(Now& now);
  void find_densities(const S* y, Now& now);
  void find_walls(Now& now);
  void find_fluxes(Now& now);
  void find_transport(Now& now);
  Vec<S> viscous(const Now& now, int i, const Pair<S>& pair, S mu_other, S rho_other, const Vec<S>& v_ij) const;
  void density_rate(const Now& now, int i, S& drho) const;
  void momentum_rate(const Now& now, int i, S t, Vec<S>& dv, S& heat) const;
  void corrected_rate(const Now& now, int i, Vec<S>& dv, S& drho) const;
  void temperature_rate(const Now& now, int i, S& power) const;
  void transport_rate(const Now& now, int i, Vec<S>& dv, S& drho, S& dT) const;

  Kernel<S> kernel_;
  bool summation_ = false, corrected_ = false;
  Viscosity viscosity_ = Viscosity::morris;
  S diffusion_{}, shift_{}, wall_volume_{};
  S beside_{};  // sum of V W of a wall's point beside a lattice that fills the other side
};

// Where `shift` below 0 stands for 1: particles that move fill a periodic domain, and no marker follows them.
bool shifted_unless_told(const Scene& scene, bool excluded, double largest_speed) {
  for (const FluidProbe& probe : scene.probes) excluded = excluded || probe.kind == ProbeKind::marker;
  const auto& period = scene.domain.periodic_m;
  const bool periodic = period[0] > 0 && period[1] > 0 && (scene.domain.dimensions == 2 || period[2] > 0);
  return !excluded && periodic && scene.fluid_boundaries.empty() && largest_speed > 0;
}

template <class S> Sph<S>::Sph(const Scene& scene, const Response& response) {
  for (const auto& [name, value] : response.settings) {
    const char* known[] = {"kernel", "smoothing", "density", "viscosity", "density_diffusion", "corrected",
                           "shift",  "threads",   "lanes",   "skin",      "reversible"};
    require(std::find(std::begin(known), std::end(known), name) != std::end(known),
            "the setting `" + name + "` of +sph is not covered");
    require(name != "reversible" || value == "false",
            "the integer lattice of `reversible` is not a differential equation");
  }
  const std::string density = word(response, "density", "continuity");
  require(density == "continuity" || density == "summation", "expected density=continuity or summation");
  summation_ = density == "summation";
  this->data = particle_data<S>(scene, !summation_);
  const KernelKind kind = kernel_named(word(response, "kernel", ""));
  const double smoothing = number(response, "smoothing", 0);
  require(smoothing > 0, "expected the setting `smoothing`");
  const double support = smoothing * this->data.spacing * support_of(kind);
  kernel_ = kernel_of<S>(kind, this->data.layout.d, S(smoothing) * S(this->data.spacing) * S(support_of(kind)));
  const std::string viscosity = word(response, "viscosity", "morris");
  require(viscosity == "morris" || viscosity == "central" || viscosity == "none",
          "expected viscosity=morris, central or none");
  viscosity_ = viscosity == "none" ? Viscosity::none : viscosity == "morris" ? Viscosity::morris : Viscosity::central;
  corrected_ = flag(response, "corrected", false);
  const double shift = number(response, "shift", 0), diffusion = number(response, "density_diffusion", 0);
  shift_ =
      S(shift < 0 ? double(shifted_unless_told(scene, summation_ || corrected_, this->data.largest_speed)) : shift);
  diffusion_ = S(diffusion < 0 ? (shift_ > 0 ? 0.1 : 0) : diffusion);
  this->data.points = fixed_points<S>(scene, support);
  require(!(corrected_ && summation_), "corrected=true needs density=continuity");
  require(this->data.points.empty() || (!corrected_ && shift_ == 0),
          "walls with `corrected` or `shift` are not covered");
  require(this->data.points.empty() || scene.fluids.size() == 1, "walls with several fluids are not covered");
  wall_volume_ = S(this->data.spacing) * S(this->data.spacing);
  if (this->data.layout.d == 3) wall_volume_ *= S(this->data.spacing);
  const int n = static_cast<int>(std::ceil(support / this->data.spacing));
  for (int a = 1; a <= n; ++a)
    for (int b = -n; b <= n; ++b)
      for (int c = -n; c <= n; ++c) {
        if (this->data.layout.d == 2 && c != 0) continue;
        const Vec<S> place = S(this->data.spacing) * Vec<S>{S(a), S(b), S(c)};
        const S r = sqrt(dot(place, place));
        if (r < kernel_.R) beside_ += wall_volume_ * kernel_.value(r);
      }
}

template <class S> void Sph<S>::find_pairs(Now& now) {
  const auto count = static_cast<std::size_t>(this->data.layout.count);
  std::vector<Vec<S>> all = now.x;
  for (const FixedPoint<S>& point : this->data.points) all.push_back(point.x);
  const auto near = neighbours_of(this->data, all, kernel_.R);
  now.fluid.assign(count, {});
  now.walls.assign(count, {});
  for (std::size_t i = 0; i < count; ++i)
    for (const Neighbour<S>& each : near[i]) {
      const bool wall = each.other >= static_cast<int>(count);
      Pair<S> pair{wall ? each.other - static_cast<int>(count) : each.other, each.x, kernel_.value(each.r),
                   kernel_.slope_over_r(each.r), dot(each.x, each.x)};
      (wall ? now.walls : now.fluid)[i].push_back(pair);
    }
}

// rho_i = m_i W(0) + sum_j m_j W_ij, walls of mass rho0 D^d included; or the state's.
template <class S> void Sph<S>::find_densities(const S* y, Now& now) {
  const auto& of = this->data;
  for (int i = 0; i < of.layout.count; ++i) {
    const FluidLaw<S>& law = of.laws[of.fluid[i]];
    S rho = 0;
    if (summation_) {
      rho = of.mass[i] * kernel_.value(S(0));
      for (const Pair<S>& pair : now.fluid[i]) rho += of.mass[pair.other] * pair.W;
      for (const Pair<S>& pair : now.walls[i]) rho += law.rho0 * wall_volume_ * pair.W;
    } else {
      rho = y[of.layout.density + i];
    }
    now.rho.push_back(rho);
    now.p.push_back(law.pressure(rho));
    now.V.push_back(of.mass[i] / rho);
  }
}

template <class S> void Sph<S>::find_walls(Now& now) {
  const std::size_t count = this->data.points.size();
  std::vector<S> sum(count, S(0));
  now.wall_p.assign(count, S(0));
  now.wall_T.assign(count, S(0));
  now.wall_rho.assign(count, S(0));
  now.wall_v.assign(count, {});
  now.wall_acts.assign(count, false);
  for (std::size_t i = 0; i < now.walls.size(); ++i)
    for (const Pair<S>& pair : now.walls[i]) {
      const auto w = static_cast<std::size_t>(pair.other);
      sum[w] += pair.W;
      now.wall_v[w] = now.wall_v[w] + pair.W * now.v[i];
      now.wall_T[w] += pair.W * now.T[i];
      // x_w - x_i is minus the pair's difference
      now.wall_p[w] += pair.W * (now.p[i] - now.rho[i] * dot(this->data.gravity, pair.x));
    }
  for (std::size_t w = 0; w < count; ++w) {
    if (!(sum[w] > 0)) continue;
    now.wall_acts[w] = true;
    now.wall_v[w] = (1 / sum[w]) * now.wall_v[w];
    now.wall_T[w] /= sum[w];
    now.wall_p[w] /= sum[w];
    now.wall_rho[w] = this->data.laws.front().density_at(now.wall_p[w]);
  }
}

// q a H(3 s / s0) / s of each point with a flux q and an area a, s = sum_f V_f W_wf
template <class S> void Sph<S>::find_fluxes(Now& now) {
  now.wall_q.assign(this->data.points.size(), S(0));
  std::vector<S> s(this->data.points.size(), S(0));
  for (std::size_t i = 0; i < now.walls.size(); ++i)
    for (const Pair<S>& pair : now.walls[i]) s[pair.other] += now.V[i] * pair.W;
  for (std::size_t w = 0; w < this->data.points.size(); ++w) {
    if (!this->data.points[w].heat_flux || !(s[w] > 0)) continue;
    const S z = 3 * s[w] / beside_;
    const S wet = z < 1 ? 6 * power(z, 5) - 15 * power(z, 4) + 10 * power(z, 3) : S(1);
    now.wall_q[w] = *this->data.points[w].heat_flux * this->data.points[w].area * wet / s[w];
  }
}

// u_i = -shift U R sum_j V_j F_ij x_ij
template <class S> void Sph<S>::find_transport(Now& now) {
  now.u.assign(now.x.size(), {});
  if (shift_ == 0) return;
  for (std::size_t i = 0; i < now.x.size(); ++i) {
    Vec<S> sum{};
    for (const Pair<S>& pair : now.fluid[i]) sum = sum + (now.V[pair.other] * pair.F) * pair.x;
    now.u[i] = (-shift_ * S(this->data.largest_speed) * kernel_.R) * sum;
  }
}

template <class S> typename Sph<S>::Now Sph<S>::evaluate(const S* y) {
  const auto& layout = this->data.layout;
  Now now;
  for (int i = 0; i < layout.count; ++i) {
    now.x.push_back(this->data.read(y, i));
    now.v.push_back(this->data.read(y + layout.velocity, i));
    now.T.push_back(layout.temperature >= 0 ? y[layout.temperature + i] : S(this->data.fixed_temperature[i]));
  }
  find_pairs(now);
  find_densities(y, now);
  find_walls(now);
  find_fluxes(now);
  find_transport(now);
  return now;
}

template <class S> std::vector<S> Sph<S>::densities(const S* y) { return evaluate(y).rho; }

// A_ij of a pair whose other side has the viscosity mu_other and the density rho_other.
template <class S>
Vec<S> Sph<S>::viscous(const Now& now, int i, const Pair<S>& pair, S mu_other, S rho_other, const Vec<S>& v_ij) const {
  if (viscosity_ == Viscosity::none) return {};
  const S mu = this->data.laws[this->data.fluid[i]].dynamic_viscosity(now.T[i]);
  const S factor = (mu + mu_other) / (now.rho[i] * rho_other) * pair.F;
  if (viscosity_ == Viscosity::morris) return factor * v_ij;
  if (!(pair.r2 > 0)) return {};
  return (S(this->data.layout.d + 2) * factor * dot(v_ij, pair.x) / pair.r2) * pair.x;
}

template <class S> void Sph<S>::density_rate(const Now& now, int i, S& drho) const {
  const auto& of = this->data;
  const FluidLaw<S>& law = of.laws[of.fluid[i]];
  S plain = 0, diffused = 0;
  for (const Pair<S>& pair : now.fluid[i]) {
    const int j = pair.other;
    plain += of.mass[j] * pair.F * dot(now.v[i] - now.v[j], pair.x);
    if (of.fluid[j] == of.fluid[i]) diffused += now.V[j] * (now.rho[i] - now.rho[j]) * pair.F;
  }
  for (const Pair<S>& pair : now.walls[i])
    if (now.wall_acts[pair.other])
      plain += law.rho0 * wall_volume_ * pair.F * dot(now.v[i] - this->data.points[pair.other].velocity, pair.x);
  if (!corrected_) drho += plain;
  drho += 2 * diffusion_ * kernel_.R / S(support_of(kernel_.kind)) * law.c * diffused;
}

// Pressure, viscosity, gravity, source; `heat`: -1/2 sum m_j A_ij . v_ij, of a wall the whole.
template <class S> void Sph<S>::momentum_rate(const Now& now, int i, S t, Vec<S>& dv, S& heat) const {
  const auto& of = this->data;
  const FluidLaw<S>& law = of.laws[of.fluid[i]];
  const S own = now.p[i] / (now.rho[i] * now.rho[i]);
  for (const Pair<S>& pair : now.fluid[i]) {
    const int j = pair.other;
    const Vec<S> v_ij = now.v[i] - now.v[j];
    const Vec<S> A = viscous(now, i, pair, of.laws[of.fluid[j]].dynamic_viscosity(now.T[j]), now.rho[j], v_ij);
    if (!corrected_) dv = dv - (of.mass[j] * (own + now.p[j] / (now.rho[j] * now.rho[j])) * pair.F) * pair.x;
    dv = dv + of.mass[j] * A;
    heat -= of.mass[j] * dot(A, v_ij) / 2;
  }
  for (const Pair<S>& pair : now.walls[i]) {
    const int w = pair.other;
    if (!now.wall_acts[w]) continue;
    const S m = law.rho0 * wall_volume_;
    dv = dv - (m * (own + now.wall_p[w] / (now.wall_rho[w] * now.wall_rho[w])) * pair.F) * pair.x;
    if (!this->data.points[w].no_slip) continue;
    const Vec<S> mirrored = S(2) * this->data.points[w].velocity - now.wall_v[w];
    const Vec<S> A = viscous(now, i, pair, law.dynamic_viscosity(now.T[i]), now.wall_rho[w], now.v[i] - mirrored);
    dv = dv + m * A;
    heat -= m * dot(A, now.v[i] - this->data.points[w].velocity);
  }
  dv = dv + (1 - law.expansion * (now.T[i] - law.T0)) * of.gravity;
  if (of.source[of.fluid[i]]) dv = dv + of.source[of.fluid[i]](t, now.x[i]);
}

// The inverse of a symmetric d x d matrix times a vector, by cofactors; `determinant` as well.
template <class S> S determinant(const S (&m)[3][3], int d) {
  if (d == 2) return m[0][0] * m[1][1] - m[0][1] * m[1][0];
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}
template <class S> Vec<S> solved(const S (&m)[3][3], int d, const Vec<S>& b) {  // Cramer's rule
  const S whole = determinant(m, d);
  Vec<S> made{};
  for (int k = 0; k < d; ++k) {
    S changed[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) changed[i][j] = j == k ? b[i] : m[i][j];
    made[k] = determinant(changed, d) / whole;
  }
  return made;
}

template <class S> void Sph<S>::corrected_rate(const Now& now, int i, Vec<S>& dv, S& drho) const {
  const int d = this->data.layout.d;
  S M[3][3] = {};
  for (const Pair<S>& pair : now.fluid[i])
    for (int a = 0; a < d; ++a)
      for (int b = 0; b < d; ++b) M[a][b] -= now.V[pair.other] * pair.F * pair.x[a] * pair.x[b];
  if (determinant(M, d) < S(0.01))
    for (int a = 0; a < d; ++a)
      for (int b = 0; b < d; ++b) M[a][b] = a == b ? 1 : 0;
  for (const Pair<S>& pair : now.fluid[i]) {
    const int j = pair.other;
    const Vec<S> g = solved(M, d, pair.F * pair.x);
    drho += now.rho[i] * now.V[j] * dot(now.v[i] - now.v[j], g);
    dv = dv + (now.V[j] * (now.p[i] - now.p[j]) / now.rho[i]) * g;
  }
}

// div(rho u) - rho div u, and (1 / rho) sum V_j F x . (rho_i u_i + rho_j u_j) (v_j - v_i) / 2, of the temperature
// likewise
template <class S> void Sph<S>::transport_rate(const Now& now, int i, Vec<S>& dv, S& drho, S& dT) const {
  for (const Pair<S>& pair : now.fluid[i]) {
    const int j = pair.other;
    const S flux = now.V[j] * pair.F * dot(pair.x, now.rho[i] * now.u[i] + now.rho[j] * now.u[j]);
    drho += flux - now.rho[i] * now.V[j] * pair.F * dot(pair.x, now.u[j] - now.u[i]);
    dv = dv + (flux / (2 * now.rho[i])) * (now.v[j] - now.v[i]);
    dT += flux / (2 * now.rho[i]) * (now.T[j] - now.T[i]);
  }
}

// Cleary and Monaghan, J. Comput. Phys. 148 (1999) 227, eq. 28.
template <class S> void Sph<S>::temperature_rate(const Now& now, int i, S& power) const {
  const auto& of = this->data;
  const S k = of.laws[of.fluid[i]].conductivity;
  for (const Pair<S>& pair : now.fluid[i]) {
    const int j = pair.other;
    const S other = of.laws[of.fluid[j]].conductivity;
    if (!(k + other > 0)) continue;
    power += of.mass[j] * 4 * k * other / (k + other) * (now.T[i] - now.T[j]) * pair.F / (now.rho[i] * now.rho[j]);
  }
  for (const Pair<S>& pair : now.walls[i]) {
    const FixedPoint<S>& point = this->data.points[pair.other];
    if (!now.wall_acts[pair.other]) continue;
    if (point.temperature) {
      const S T = 2 * *point.temperature - now.wall_T[pair.other];
      power += of.laws.front().rho0 * wall_volume_ * 2 * k * (now.T[i] - T) * pair.F /
               (now.rho[i] * now.wall_rho[pair.other]);
    }
    power += now.wall_q[pair.other] * pair.W / now.rho[i];
  }
}

template <class S> void Sph<S>::rate(S t, const S* y, S* dydt) {
  const auto& of = this->data;
  const auto& layout = of.layout;
  const Now now = evaluate(y);
  for (int i = 0; i < layout.count; ++i) {
    Vec<S> dv{};
    S drho = 0, heat = 0, power = 0, carried = 0;
    momentum_rate(now, i, t, dv, heat);
    if (layout.density >= 0) density_rate(now, i, drho);
    if (corrected_) corrected_rate(now, i, dv, drho);
    if (shift_ != 0) transport_rate(now, i, dv, drho, carried);
    for (int a = 0; a < layout.d; ++a) {
      dydt[layout.d * i + a] = now.v[i][a] + now.u[i][a];
      dydt[layout.velocity + layout.d * i + a] = dv[a];
    }
    if (layout.density >= 0) dydt[layout.density + i] = drho;
    if (layout.temperature < 0) continue;
    const FluidLaw<S>& law = of.laws[of.fluid[i]];
    temperature_rate(now, i, power);
    if (law.viscous_heat) power += heat;
    dydt[layout.temperature + i] = law.heat_capacity > 0 ? power / law.heat_capacity + carried : S(0);
  }
}

}  // namespace

template <class S> std::unique_ptr<FluidSystem<S>> sph_system(const Scene& scene, const Response& response) {
  return std::make_unique<Sph<S>>(scene, response);
}

template std::unique_ptr<FluidSystem<double>> sph_system(const Scene&, const Response&);
template std::unique_ptr<FluidSystem<Narrow>> sph_system(const Scene&, const Response&);
template std::unique_ptr<FluidSystem<Wide>> sph_system(const Scene&, const Response&);

}  // namespace atwood::fluid_truth
