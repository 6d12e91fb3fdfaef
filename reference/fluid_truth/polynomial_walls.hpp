// Walls of `+polynomial` (docs/fluids.md, "Walls" of that part): planes across an axis, with nodes on their surfaces
// and dummies behind them.
#pragma once

#include <optional>
#include <vector>

#include "fluid_truth/kernel.hpp"
#include "fluid_truth/least_squares.hpp"
#include "fluid_truth/particles.hpp"

namespace atwood::fluid_truth {

// Fits the values of particles around a node.
template <class S> struct NodeFit {
  Kernel<S> weight;
  std::vector<Monomial> basis;  // by ascending degree
  S support{};
  int d = 2, particles = 0;
  int degree = 2, slope_degree = 2;  // Q without a condition, and with a given slope
  // The value at the node of the polynomial that fits value(j, x_j - x_n) best over the particles within the reach.
  // With a slope of 0 along z_axis, unless axis < 0. Empty: the particles do not determine it.
  template <class Value>
  std::optional<S> at_node(const std::vector<Neighbour<S>>& near, int axis, const Value& value) const {
    if (axis < 0) return of_degree(degree, near, axis, value);
    const auto found = of_degree(slope_degree, near, axis, value);
    return found || slope_degree == degree ? found : of_degree(degree, near, axis, value);
  }

 private:
  template <class Value>
  std::optional<S> of_degree(int q, const std::vector<Neighbour<S>>& near, int axis, const Value& value) const;
};
template <class S> NodeFit<S> node_fit(const Kernel<S>& weight, int d, int degree, int slope_degree, int particles);

template <class S> struct PolynomialWalls {
  struct Plane {
    int axis = 1, boundary = 0;
    S sign{}, offset{};  // the fluid is where sign x_axis > offset
    S height(const Vec<S>& x) const { return sign * x[axis] - offset; }
  };
  struct Node {
    Vec<S> x{}, velocity{};
    int plane = 0;
    bool no_slip = true;
    std::optional<S> temperature;
    S slope{};  // of the temperature along the normal into the fluid, where it is not given
  };
  std::vector<Plane> planes;
  std::vector<Node> nodes;
  std::vector<Vec<S>> dummies;

  // R_i of docs/fluids.md.
  S support_at(const Vec<S>& x, S R) const;
  // The fields at node k: velocity components, density, temperature. Empty: the node is dry.
  std::optional<std::vector<S>> fields_at(int k, const NodeFit<S>& fit, const std::vector<Neighbour<S>>& near,
                                          const std::vector<std::vector<S>>& values) const;
};

// Nothing where the scene has no boundary. Throws Refused for what docs/fluids.md refuses.
template <class S> PolynomialWalls<S> polynomial_walls(const Scene& scene, double spacing, S R);

// ---- in line: called with closures -------------------------------------------------------------------------------
template <class S>
template <class Value>
std::optional<S> NodeFit<S>::of_degree(int q, const std::vector<Neighbour<S>>& near, int axis,
                                       const Value& value) const {
  constexpr double min_pivot = 1e-4;
  std::vector<Monomial> own;
  for (const Monomial& each : basis) {
    const bool sloped = axis >= 0 && each.power[axis] == 1 && (q > 2 || each.degree() == 1);
    if (each.degree() <= q && !sloped) own.push_back(each);
  }
  const int n = static_cast<int>(own.size());
  std::vector<S> M(static_cast<std::size_t>(n) * n, S(0)), B(n, S(0)), p(n);
  int found = 0;
  for (const Neighbour<S>& each : near) {
    if (!(each.r < support) || each.other >= particles) continue;
    ++found;
    const S w = weight.shape(each.r / support);
    for (int k = 0; k < n; ++k) {
      p[k] = 1;
      for (int a = 0; a < d; ++a) p[k] *= raised(-2 * each.x[a] / support, own[k].power[a]);
    }
    const S f = value(each.other, S(-1) * each.x);
    for (int k = 0; k < n; ++k) {
      for (int l = 0; l <= k; ++l) M[k * n + l] += w * p[k] * p[l];
      B[k] += w * p[k] * f;
    }
  }
  if (found < n) return {};
  const Fit<S> fit(M, n, min_pivot);
  if (!fit.regular()) return {};
  return fit.solve(B)[0];  // the constant is the first monomial
}

}  // namespace atwood::fluid_truth
