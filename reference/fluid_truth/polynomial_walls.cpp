#include "fluid_truth/polynomial_walls.hpp"

#include <algorithm>

#include "fluid_truth/solution.hpp"
#include "fluid_truth/walls.hpp"

namespace atwood::fluid_truth {

template <class S> NodeFit<S> node_fit(const Kernel<S>& weight, int d, int degree, int slope_degree, int particles) {
  std::vector<Monomial> basis = monomials(d, larger(degree, slope_degree), 0);
  std::stable_sort(basis.begin(), basis.end(),
                   [](const Monomial& a, const Monomial& b) { return a.degree() < b.degree(); });
  return {weight, basis, S(14) / 10 * weight.R, d, particles, degree, slope_degree};
}

template <class S> PolynomialWalls<S> polynomial_walls(const Scene& scene, double spacing, S R) {
  PolynomialWalls<S> made;
  const int d = scene.domain.dimensions;
  for (std::size_t b = 0; b < scene.fluid_boundaries.size(); ++b) {
    const Body& body = scene.bodies[static_cast<std::size_t>(scene.fluid_boundaries[b].body)];
    const auto* plane = std::get_if<atwood::Plane>(&body.shape);
    require(plane != nullptr && body.fixed, "+polynomial has walls along fixed planes only");
    typename PolynomialWalls<S>::Plane own;
    own.boundary = static_cast<int>(b);
    own.axis = -1;
    for (int a = 0; a < d; ++a)
      if (plane->normal[a] == 1 || plane->normal[a] == -1) own.axis = a;
    require(own.axis >= 0, "+polynomial has walls across an axis only");
    own.sign = S(plane->normal[own.axis]);
    own.offset = S(plane->offset_m);
    made.planes.push_back(own);
  }
  for (const FixedPoint<S>& point : fixed_points<S>(scene, static_cast<double>(R))) {
    const auto& plane = made.planes[point.boundary];
    made.dummies.push_back(point.x);
    if (!(-plane.height(point.x) < S(spacing))) continue;  // behind the first layer
    typename PolynomialWalls<S>::Node node{point.x,       point.velocity,    point.boundary,
                                           point.no_slip, point.temperature, {}};
    node.x[plane.axis] = plane.sign * plane.offset;
    bool behind = false;
    for (const auto& other : made.planes)
      behind = behind || (&other != &plane && -other.height(node.x) > S(-1e-9 * spacing));
    if (behind) continue;
    const double k = only_fluid(scene).conductivity_W_per_m_K;
    if (point.heat_flux && k > 0) node.slope = -*point.heat_flux / S(k);
    made.nodes.push_back(node);
  }
  return made;
}

template <class S> S PolynomialWalls<S>::support_at(const Vec<S>& x, S R) const {
  S q = 0;
  for (const Plane& plane : planes) {
    const S s = magnitude(plane.height(x)) / R;
    if (s < 1) q = larger(q, (1 - s) * (1 - s) * (1 + 2 * s));
  }
  return R * (1 + S(4) / 10 * q);
}

template <class S>
std::optional<std::vector<S>> PolynomialWalls<S>::fields_at(int k, const NodeFit<S>& fit,
                                                            const std::vector<Neighbour<S>>& near,
                                                            const std::vector<std::vector<S>>& values) const {
  const Node& node = nodes[k];
  const Plane& plane = planes[node.plane];
  const auto sloped = [&](int field, S slope) {
    return fit.at_node(near, plane.axis, [&](int j, const Vec<S>& away) {
      return values[field][j] - slope * plane.sign * away[plane.axis];
    });
  };
  const int d = fit.d;
  const auto density = fit.at_node(near, -1, [&](int j, const Vec<S>&) { return values[d][j]; });
  if (!density) return {};
  const bool warm = static_cast<int>(values.size()) > d + 1;
  if ((!node.no_slip || (warm && !node.temperature)) && !sloped(0, S(0))) return {};
  std::vector<S> made(values.size());
  for (int a = 0; a < d; ++a) made[a] = node.no_slip || a == plane.axis ? node.velocity[a] : *sloped(a, S(0));
  made[d] = *density;
  if (warm) made[d + 1] = node.temperature ? *node.temperature : *sloped(d + 1, node.slope);
  return made;
}

#define ATWOOD_POLYNOMIAL_WALLS(S)                                       \
  template NodeFit<S> node_fit(const Kernel<S>&, int, int, int, int);    \
  template PolynomialWalls<S> polynomial_walls(const Scene&, double, S); \
  template struct PolynomialWalls<S>;
ATWOOD_POLYNOMIAL_WALLS(double)
ATWOOD_POLYNOMIAL_WALLS(Narrow)
ATWOOD_POLYNOMIAL_WALLS(Wide)
#undef ATWOOD_POLYNOMIAL_WALLS

}  // namespace atwood::fluid_truth
