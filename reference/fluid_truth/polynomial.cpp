// The equations of `+polynomial` (docs/fluids.md) without walls, written from that page: derivatives by moving least squares.
// P. Lancaster and K. Salkauskas, Math. Comp. 37 (1981) 141; T. Liszka and J. Orkisz, Comput. Struct. 11 (1980) 83.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "fluid_truth/particles.hpp"
#include "fluid_truth/solution.hpp"
#include "scene/fluid_surface.hpp"

namespace atwood::fluid_truth {

namespace {

constexpr double kLeastPivot = 1e-10;  // the page ends a run long before, at 0.004

struct Monomial {
  int power[3] = {0, 0, 0};
};

// All monomials of degree `least` ... P in d variables, by descending degree.
std::vector<Monomial> monomials(int d, int P, int least) {
  std::vector<Monomial> made;
  for (int degree = P; degree >= least; --degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) {
        const int e = degree - a - b;
        if (d == 3 || e == 0) made.push_back({{a, b, e}});
      }
  return made;
}

template <class S> S raised(S x, int n) {
  S made = 1;
  for (int k = 0; k < n; ++k) made *= x;
  return made;
}

// Cholesky's factor of a symmetric positive matrix scaled to a unit diagonal, and solutions by it.
template <class S> class Fit {
 public:
  Fit(const std::vector<S>& M, int n) : n_(n), scale_(n), L_(M) {
    for (int k = 0; k < n; ++k) {
      if (!(M[k * n + k] > 0)) return;
      scale_[k] = 1 / sqrt(M[k * n + k]);
    }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j) {
        S sum = M[i * n + j] * scale_[i] * scale_[j];
        for (int k = 0; k < j; ++k) sum -= L_[i * n + k] * L_[j * n + k];
        if (i == j) {
          if (!(sum >= S(kLeastPivot))) return;
          L_[i * n + i] = sqrt(sum);
        } else {
          L_[i * n + j] = sum / L_[j * n + j];
        }
      }
    regular_ = true;
  }
  bool regular() const { return regular_; }
  std::vector<S> solve(const std::vector<S>& b) const {
    std::vector<S> x(n_);
    for (int i = 0; i < n_; ++i) {
      S sum = b[i] * scale_[i];
      for (int k = 0; k < i; ++k) sum -= L_[i * n_ + k] * x[k];
      x[i] = sum / L_[i * n_ + i];
    }
    for (int i = n_ - 1; i >= 0; --i) {
      S sum = x[i];
      for (int k = i + 1; k < n_; ++k) sum -= L_[k * n_ + i] * x[k];
      x[i] = sum / L_[i * n_ + i];
    }
    for (int i = 0; i < n_; ++i) x[i] *= scale_[i];
    return x;
  }

 private:
  int n_;
  std::vector<S> scale_, L_;
  bool regular_ = false;
};

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
  std::vector<S> at_node(const std::vector<Neighbour<S>>& near, const std::vector<std::vector<S>>& values) const;

  Kernel<S> weight_, crowding_;
  std::vector<Monomial> basis_, of_node_;
  int first_[3] = {-1, -1, -1}, second_[3] = {-1, -1, -1};  // monomials z_a and z_a^2
  S H_{}, shift_{}, shift_speed_{}, filter_{};
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
  require(scene.fluid_boundaries.empty(), "boundaries are not covered with +polynomial");
  const double degree = number(response, "degree", 4);
  require(degree == 2 || degree == 4, "expected degree=2 or 4");
  const bool high = degree == 4;
  this->data = particle_data<S>(scene, true);
  const int d = this->data.layout.d;
  of_node_ = monomials(d, 2, 0);
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
  H_ = R / 2;
  const double shift = number(response, "shift", -1);
  shift_ = shift >= 0 ? shift : surface ? 0 : 1;
  const double filter = number(response, "filter", -1);
  filter_ = filter >= 0 ? filter : surface ? 1 : high ? 0.1 : 0.005;
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

// u_i = 3 A U R_s sum_j D^d (-F_ij) x_ij over particles, times the product of 1 - (1 - (r / (2 D))^2)^3 over nodes
template <class S> Vec<S> Polynomial<S>::transport(const std::vector<Neighbour<S>>& near) const {
  const S D = this->data.spacing;
  S volume = D * D, open = 1;
  if (this->data.layout.d == 3) volume *= D;
  Vec<S> sum{};
  for (const Neighbour<S>& each : near) {
    if (!(each.r < crowding_.R)) continue;
    if (each.other < this->data.layout.count) sum = sum - (volume * crowding_.slope_over_r(each.r)) * each.x;
    else open *= 1 - raised(1 - each.r * each.r / (4 * D * D), 3);
  }
  return (3 * shift_ * shift_speed_ * crowding_.R * open) * sum;
}

// All fields' free values at a node, from particles within 1.4 R of it: the constants of polynomials of degree 2.
template <class S>
std::vector<S> Polynomial<S>::at_node(const std::vector<Neighbour<S>>& near,
                                      const std::vector<std::vector<S>>& values) const {
  const int n = static_cast<int>(of_node_.size()), d = this->data.layout.d;
  const S reach = S(14) / 10 * weight_.R;
  std::vector<S> M(static_cast<std::size_t>(n) * n, S(0)), p(n), made(values.size());
  std::vector<std::vector<S>> B(values.size(), std::vector<S>(n, S(0)));
  for (const Neighbour<S>& each : near) {
    if (!(each.r < reach) || each.other >= this->data.layout.count) continue;
    const S w = weight_.shape(each.r / reach);
    for (int k = 0; k < n; ++k) {
      p[k] = 1;
      for (int a = 0; a < d; ++a) p[k] *= raised(-2 * each.x[a] / reach, of_node_[k].power[a]);
    }
    for (int k = 0; k < n; ++k) {
      for (int l = 0; l <= k; ++l) M[k * n + l] += w * p[k] * p[l];
      for (std::size_t f = 0; f < values.size(); ++f) B[f][k] += w * p[k] * values[f][each.other];
    }
  }
  const Fit<S> fit(M, n);
  for (std::size_t f = 0; f < values.size(); ++f)
    made[f] = fit.regular() ? fit.solve(B[f])[n - 1] : S(std::numeric_limits<double>::quiet_NaN());
  return made;
}

template <class S> void Polynomial<S>::rate(S t, const S* y, S* dydt) {
  const auto& of = this->data;
  const auto& layout = of.layout;
  const int d = layout.d, n = static_cast<int>(basis_.size()), fields = d + 1 + (layout.temperature >= 0 ? 1 : 0);
  std::vector<Vec<S>> x;
  for (int i = 0; i < layout.count; ++i) x.push_back(of.read(y, i));
  for (int k = 0; k < layout.node_count; ++k) x.push_back(of.read(y + layout.nodes, k));
  const auto near =
      neighbours_of(of, x, larger(layout.node_count > 0 ? S(14) / 10 * weight_.R : weight_.R, crowding_.R));
  // Velocity components, density, temperature of particles and nodes.
  std::vector<std::vector<S>> values(fields, std::vector<S>(x.size()));
  for (int i = 0; i < layout.count; ++i)
    for (int f = 0; f < fields; ++f)
      values[f][i] = f < d ? y[layout.velocity + d * i + f] : y[(f == d ? layout.density : layout.temperature) + i];
  for (int k = 0; k < layout.node_count; ++k) {
    const std::vector<S> free = at_node(near[layout.count + k], values);
    for (int f = 0; f < fields; ++f) values[f][layout.count + k] = f == d ? of.laws.front().rho0 : free[f];
    for (int a = 0; a < d; ++a) dydt[layout.nodes + d * k + a] = free[a];
  }
  const auto value = [&](int field, int i) { return values[field][i]; };
  for (int i = 0; i < layout.count; ++i) {
    std::vector<S> M(static_cast<std::size_t>(n) * n, S(0)), m(n, S(0)), p(n);
    std::vector<std::vector<S>> B(fields, std::vector<S>(n, S(0)));
    std::vector<S> differences(fields, S(0));
    S weights = 0;
    for (const Neighbour<S>& each : near[i]) {
      if (!(each.r < weight_.R)) continue;
      const S w = weight_.shape(each.r / weight_.R);
      weights += w;
      for (int k = 0; k < n; ++k) {
        p[k] = 1;
        for (int a = 0; a < d; ++a) p[k] *= raised(-each.x[a] / H_, basis_[k].power[a]);
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
    const Fit<S> fit(M, n);
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
        at[f].grad[a] = c[first_[a]] / H_;
        at[f].laplacian += 2 * c[second_[a]] / (H_ * H_);
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
