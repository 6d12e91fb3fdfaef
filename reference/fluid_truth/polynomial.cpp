// The equations of `+polynomial` (docs/fluids.md), written from that page: derivatives by moving least squares.
// P. Lancaster and K. Salkauskas, Math. Comp. 37 (1981) 141; T. Liszka and J. Orkisz, Comput. Struct. 11 (1980) 83.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "fluid_truth/polynomial_walls.hpp"
#include "fluid_truth/solution.hpp"
#include "scene/fluid_surface.hpp"

namespace atwood::fluid_truth {

namespace {

constexpr double kMinPivot = 1e-10;  // the page ends a run long before, at 0.004

template <class S> struct Derivatives {  // of one field at one particle
  Vec<S> grad{};
  S laplacian{}, filter{};
};

template <class S> class Polynomial final : public FluidSystem<S> {
 public:
  Polynomial(const Scene& scene, const Response& response);
  void rate(S t, const S* y, S* dydt) override;
  std::vector<S> densities(const S* y) override {
    const S* from = y + this->data.layout.density;
    return {from, from + this->data.layout.count};
  }

 private:
  Vec<S> transport(const std::vector<Neighbour<S>>& near) const;

  Kernel<S> weight_, crowding_;
  std::vector<Monomial> basis_;
  NodeFit<S> of_wall_, of_surface_;
  PolynomialWalls<S> walls_;
  int first_[3] = {-1, -1, -1}, second_[3] = {-1, -1, -1};  // monomials z_a and z_a^2
  S shift_{}, shift_speed_{}, filter_{};
};

// A setting of 0 stands for the default.
double given(const Response& response, const char* name, double otherwise) {
  const double value = number(response, name, 0);
  return value > 0 ? value : otherwise;
}

template <class S> Polynomial<S>::Polynomial(const Scene& scene, const Response& response) {
  for (const auto& [name, value] : response.settings) {
    const char* known[] = {"degree", "kernel",  "smoothing", "shift", "shift_speed",
                           "filter", "threads", "lanes",     "skin"};
    require(std::find(std::begin(known), std::end(known), name) != std::end(known),
            "the setting `" + name + "` of +polynomial is not covered");
  }
  const double degree = number(response, "degree", 4);
  require(degree == 2 || degree == 4, "expected degree=2 or 4");
  const bool high = degree == 4;
  this->data = particle_data<S>(scene, true);
  const int d = this->data.layout.d;
  try {
    this->data.layout.node_count = static_cast<int>(surface_points(scene).size());
  } catch (const std::invalid_argument& error) {
    require(false, error.what());
  }
  this->data.layout.nodes = this->data.layout.size;
  this->data.layout.size += d * this->data.layout.node_count;
  const bool surface = this->data.layout.node_count > 0;
  require(!surface || !high, "a free surface needs degree=2");
  const KernelKind kind = kernel_named(word(response, "kernel", "wendland-c2"));
  const S D = this->data.spacing, R = S(given(response, "smoothing",
                                              surface ? 1.75
                                              : high  ? 1.55
                                                      : 1.5)) *
                                      D * S(support_of(kind));
  weight_ = kernel_of<S>(kind, d, R);
  crowding_ = kernel_of<S>(KernelKind::wendland_c2, d, 2 * D);
  walls_ = polynomial_walls<S>(scene, this->data.spacing, R);
  of_wall_ = node_fit(weight_, d, high ? 3 : 2, high ? 4 : 2, this->data.layout.count);
  of_surface_ = node_fit(weight_, d, 2, 2, this->data.layout.count);
  const double shift = number(response, "shift", -1);
  shift_ = shift >= 0 ? shift : surface ? 0 : 1;
  const double filter = number(response, "filter", -1);
  filter_ = filter >= 0 ? filter : surface ? 1 : !high ? 0.005 : walls_.planes.empty() ? 0.1 : 0.3;
  const double speed = number(response, "shift_speed", 0);
  shift_speed_ = speed > 0                      ? S(speed)
                 : this->data.largest_speed > 0 ? S(this->data.largest_speed)
                                                : S(this->data.largest_sound_speed) / 20;
  basis_ = monomials(d, static_cast<int>(degree), 1);
  for (int k = 0; k < static_cast<int>(basis_.size()); ++k)
    for (int a = 0; a < d; ++a) {
      const auto& power = basis_[k].power;
      if (power[0] + power[1] + power[2] == power[a] && power[a] == 1) first_[a] = k;
      if (power[0] + power[1] + power[2] == power[a] && power[a] == 2) second_[a] = k;
    }
}

// u_i = 3 A U R_s sum_j D^d (-F_ij) x_ij over particles and dummies, times the product of 1 - (1 - (r / (2 D))^2)^3
// over nodes
template <class S> Vec<S> Polynomial<S>::transport(const std::vector<Neighbour<S>>& near) const {
  const S D = this->data.spacing;
  S volume = D * D, open = 1;
  if (this->data.layout.d == 3) volume *= D;
  Vec<S> sum{};
  for (const Neighbour<S>& each : near) {
    if (!(each.r < crowding_.R)) continue;
    const int behind = each.other - this->data.layout.count;  // the nodes of walls, dummies, the nodes of the surface
    const int nodes = static_cast<int>(walls_.nodes.size()), dummies = static_cast<int>(walls_.dummies.size());
    if (behind >= 0 && behind < nodes) continue;
    if (behind < nodes + dummies) sum = sum - (volume * crowding_.slope_over_r(each.r)) * each.x;
    else open *= 1 - raised(1 - each.r * each.r / (4 * D * D), 3);
  }
  return (3 * shift_ * shift_speed_ * crowding_.R * open) * sum;
}

template <class S> void Polynomial<S>::rate(S t, const S* y, S* dydt) {
  const auto& of = this->data;
  const auto& layout = of.layout;
  const int d = layout.d, n = static_cast<int>(basis_.size()), fields = d + 1 + (layout.temperature >= 0 ? 1 : 0);
  std::vector<Vec<S>> x;
  for (int i = 0; i < layout.count; ++i) x.push_back(of.read(y, i));
  const int wall_nodes = static_cast<int>(walls_.nodes.size());
  for (const auto& node : walls_.nodes) x.push_back(node.x);
  x.insert(x.end(), walls_.dummies.begin(), walls_.dummies.end());
  const int surface = static_cast<int>(x.size());
  for (int k = 0; k < layout.node_count; ++k) x.push_back(of.read(y + layout.nodes, k));
  const bool particles_alone = static_cast<int>(x.size()) == layout.count;
  const auto near = neighbours_of(of, x, larger(particles_alone ? weight_.R : of_wall_.support, crowding_.R));
  // Velocity components, density, temperature of particles and nodes.
  std::vector<std::vector<S>> values(fields, std::vector<S>(x.size()));
  std::vector<bool> counts(x.size(), true);  // in the fits
  for (int i = 0; i < layout.count; ++i)
    for (int f = 0; f < fields; ++f)
      values[f][i] = f < d ? y[layout.velocity + d * i + f] : y[(f == d ? layout.density : layout.temperature) + i];
  for (int j = layout.count; j < surface; ++j) {
    counts[j] = false;
    if (j >= layout.count + wall_nodes) continue;
    const auto found = walls_.fields_at(j - layout.count, of_wall_, near[j], values);
    if (!found) continue;
    counts[j] = true;
    for (int f = 0; f < fields; ++f) values[f][j] = (*found)[f];
  }
  for (int k = 0; k < layout.node_count; ++k)
    for (int f = 0; f < fields; ++f) {
      const auto free = of_surface_.at_node(near[surface + k], -1, [&](int j, const Vec<S>&) { return values[f][j]; });
      const S found = free ? *free : S(std::numeric_limits<double>::quiet_NaN());
      values[f][surface + k] = f == d ? of.laws.front().rho0 : found;
      if (f < d) dydt[layout.nodes + d * k + f] = found;
    }
  const auto value = [&](int field, int i) { return values[field][i]; };
  for (int i = 0; i < layout.count; ++i) {
    std::vector<S> M(static_cast<std::size_t>(n) * n, S(0)), m(n, S(0)), p(n);
    std::vector<std::vector<S>> B(fields, std::vector<S>(n, S(0)));
    std::vector<S> differences(fields, S(0));
    S weights = 0;
    const S R = walls_.support_at(x[i], weight_.R), H = R / 2;
    for (const Neighbour<S>& each : near[i]) {
      if (!(each.r < R) || !counts[each.other]) continue;
      const S w = weight_.shape(each.r / R);
      weights += w;
      for (int k = 0; k < n; ++k) {
        p[k] = 1;
        for (int a = 0; a < d; ++a) p[k] *= raised(-each.x[a] / H, basis_[k].power[a]);
      }
      for (int k = 0; k < n; ++k) {
        m[k] += w * p[k];
        for (int l = 0; l <= k; ++l) M[k * n + l] += w * p[k] * p[l];
      }
      for (int f = 0; f < fields; ++f) {
        const S difference = value(f, each.other) - value(f, i);
        differences[f] += w * difference;
        for (int k = 0; k < n; ++k) B[f][k] += w * p[k] * difference;
      }
    }
    const Fit<S> fit(M, n, kMinPivot);
    if (!fit.regular()) {
      const S none = std::numeric_limits<double>::quiet_NaN();
      for (int a = 0; a < d; ++a) dydt[d * i + a] = dydt[layout.velocity + d * i + a] = none;
      for (const int from : {layout.density, layout.temperature})
        if (from >= 0) dydt[from + i] = none;
      continue;
    }
    const std::vector<S> of_m = fit.solve(m);
    S own = 1 + weights;
    for (int k = 0; k < n; ++k) own -= m[k] * of_m[k];
    std::vector<Derivatives<S>> at(fields);
    for (int f = 0; f < fields; ++f) {
      const std::vector<S> c = fit.solve(B[f]);
      S rest = differences[f];
      for (int k = 0; k < n; ++k) rest -= m[k] * c[k];
      at[f].filter = rest / own;
      for (int a = 0; a < d; ++a) {
        at[f].grad[a] = c[first_[a]] / H;
        at[f].laplacian += 2 * c[second_[a]] / (H * H);
      }
    }
    const FluidLaw<S>& law = of.laws[of.fluid[i]];
    const Vec<S> u = transport(near[i]);
    const S rho = value(d, i), T = layout.temperature >= 0 ? value(d + 1, i) : law.T0;
    const S mu = law.dynamic_viscosity(T), damping = filter_ * law.c / S(of.spacing);
    const Vec<S> grad_T = layout.temperature >= 0 ? at[d + 1].grad : Vec<S>{};
    const Vec<S> source = of.source[of.fluid[i]] ? of.source[of.fluid[i]](t, x[i]) : Vec<S>{};
    S divergence = 0, dissipation = 0;
    for (int a = 0; a < d; ++a) {
      divergence += at[a].grad[a];
      dissipation += dot(at[a].grad, at[a].grad);
      dydt[d * i + a] = value(a, i) + u[a];
      dydt[layout.velocity + d * i + a] = -law.pressure_slope(rho) / rho * at[d].grad[a] +
                                          mu / rho * (at[a].laplacian - law.decay * dot(grad_T, at[a].grad)) +
                                          dot(u, at[a].grad) + damping * at[a].filter +
                                          (1 - law.expansion * (T - law.T0)) * of.gravity[a] + source[a];
    }
    dydt[layout.density + i] = -rho * divergence + dot(u, at[d].grad) + damping * at[d].filter;
    if (layout.temperature < 0) continue;
    const S power = law.conductivity * at[d + 1].laplacian + (law.viscous_heat ? mu * dissipation : S(0));
    dydt[layout.temperature + i] =
        law.heat_capacity > 0 ? power / (rho * law.heat_capacity) + dot(u, grad_T) + damping * at[d + 1].filter : S(0);
  }
}

}  // namespace

template <class S> std::unique_ptr<FluidSystem<S>> polynomial_system(const Scene& scene, const Response& response) {
  return std::make_unique<Polynomial<S>>(scene, response);
}

template std::unique_ptr<FluidSystem<double>> polynomial_system(const Scene&, const Response&);
template std::unique_ptr<FluidSystem<Narrow>> polynomial_system(const Scene&, const Response&);
template std::unique_ptr<FluidSystem<Wide>> polynomial_system(const Scene&, const Response&);

}  // namespace atwood::fluid_truth
