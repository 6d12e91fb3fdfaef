// Richardson extrapolation and the grid convergence index from three steps, for runs without a truth.
//
// Roache, J. Fluids Eng. 116 (1994) 405; unequal refinement as Celik et al., J. Fluids Eng. 130 (2008)
// 078001, eq. 5: with e21 = f2 - f1, e32 = f3 - f2 (1 the finest) and s the sign of e32 / e21,
//
//     |e32 / e21| = r21^p (r32^p - s) / (r21^p - s),    f* = f1 - e21 / (r21^p - 1),    GCI = 1.25 |e21| / (r21^p - 1).
//
// The right side rises with p, which is found by bisection: the fixed point that they iterate need not be attracting.
//
// Here f may be a vector (a body's position): |e| is its norm, and e32 . e21 < 0 is oscillation. The order
// keeps its sign: where differences grow as h decreases it is negative, and there is no index.
#include <cmath>

#include "validation/metrics/bisection.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

constexpr double kMaxOrder = 64;

// |e32| / |e21| of an error C h^p (s = 1), or of one whose sign alternates (s = -1): rises with p.
double ratio_of_differences(double p, double s, double r21, double r32) {
  const double x21 = p * std::log(r21), x32 = p * std::log(r32);
  if (s < 0) return std::exp(x21) * (std::exp(x32) + 1) / (std::exp(x21) + 1);
  return p == 0 ? std::log(r32) / std::log(r21) : std::exp(x21) * std::expm1(x32) / std::expm1(x21);
}

}  // namespace

GridConvergence grid_convergence(const GridLevel& fine, const GridLevel& medium, const GridLevel& coarse) {
  constexpr double safety = 1.25;
  GridConvergence g;
  const std::size_t n = fine.value.size();
  double e21 = 0, e32 = 0, dot = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double d21 = medium.value[i] - fine.value[i], d32 = coarse.value[i] - medium.value[i];
    e21 += d21 * d21;
    e32 += d32 * d32;
    dot += d21 * d32;
  }
  e21 = std::sqrt(e21);
  e32 = std::sqrt(e32);
  g.difference = e21;
  const double r21 = medium.h_s / fine.h_s, r32 = coarse.h_s / medium.h_s;
  if (!std::isfinite(e21) || !std::isfinite(e32) || !(r21 > 1) || !(r32 > 1)) return g;
  if (e21 == 0 || e32 == 0) {
    g.kind = GridConvergence::Kind::none;
    return g;
  }
  const double s = dot < 0 ? -1 : 1;
  double p = std::log(e32 / e21) / std::log(r21);
  if (r21 != r32) {
    const auto excess = [&](double order) { return e32 / e21 - ratio_of_differences(order, s, r21, r32); };
    if (!(excess(-kMaxOrder) > 0) || excess(kMaxOrder) > 0) {
      g.kind = GridConvergence::Kind::not_found;
      g.order = std::nan("");
      return g;
    }
    p = metrics::bisect(excess, -kMaxOrder, kMaxOrder, 80).low;
  }
  g.order = p;
  if (!(p > 0) || !std::isfinite(p)) {
    g.kind = GridConvergence::Kind::divergent;
    return g;
  }
  g.kind = s < 0 ? GridConvergence::Kind::oscillatory : GridConvergence::Kind::monotone;
  const double fine_gain = std::pow(r21, p) - 1, coarse_gain = std::pow(r32, p) - 1;
  g.index = safety * e21 / fine_gain;
  g.index_coarse = safety * e32 / coarse_gain;
  for (std::size_t i = 0; i < n; ++i)
    g.extrapolated.push_back(fine.value[i] - (medium.value[i] - fine.value[i]) / fine_gain);
  return g;
}

AsymptoticRange asymptotic_range(double finer_order, double coarser_order, double formal_order) {
  constexpr double max_difference = 0.1;
  if (!std::isfinite(finer_order) || !std::isfinite(coarser_order)) return AsymptoticRange::not_tested;
  const bool agree = std::fabs(finer_order - coarser_order) <= max_difference &&
                     (!(formal_order > 0) || std::fabs(finer_order - formal_order) <= max_difference);
  return agree ? AsymptoticRange::agrees : AsymptoticRange::disagrees;
}

std::string to_string(GridConvergence::Kind kind) {
  switch (kind) {
    case GridConvergence::Kind::monotone: return "monotone";
    case GridConvergence::Kind::oscillatory: return "oscillatory";
    case GridConvergence::Kind::divergent: return "divergent";
    case GridConvergence::Kind::none: return "no difference";
    case GridConvergence::Kind::not_found: return "no order below 64";
  }
  return "";
}

}  // namespace atwood
