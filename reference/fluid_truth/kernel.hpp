// The reference's kernels of smoothed particles, from their formulas. H. Wendland, Adv. Comput. Math. 4 (1995) 389;
// W. Dehnen and H. Aly, Mon. Not. R. Astron. Soc. 425 (2012) 1068, table 1; J. J. Monaghan, Rep. Prog. Phys. 68 (2005)
// 1703.
#pragma once

#include <string>

#include "fluid_truth/number.hpp"

namespace atwood::fluid_truth {

enum class KernelKind { cubic, quintic, wendland_c2, wendland_c4, wendland_c6 };

// Refuses an unknown name.
KernelKind kernel_named(const std::string& name);
// Support over smoothing length: 3 of the quintic spline, 2 of the others.
int support_of(KernelKind kind);

// W(r) = N R^-d w(r / R) and F(r) = W'(r) / r = N R^-(d+2) w'(s) / s, in d dimensions with the support R.
template <class S> struct Kernel {
  KernelKind kind = KernelKind::wendland_c2;
  int dimensions = 2;
  S R{};
  S value_scale{}, slope_scale{};  // N R^-d, N R^-(d+2)

  S shape(S s) const;               // w
  S shape_slope_over_s(S s) const;  // w' / s
  S value(S r) const { return value_scale * shape(r / R); }
  S slope_over_r(S r) const { return slope_scale * shape_slope_over_s(r / R); }
};
template <class S> Kernel<S> kernel_of(KernelKind kind, int dimensions, S R);

}  // namespace atwood::fluid_truth
