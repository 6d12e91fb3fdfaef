#include "fluid/kernel.hpp"

#include <array>
#include <stdexcept>

namespace atwood::fluid {
namespace {

struct Named {
  const char* name;
  KernelShape shape;
  int ceiling;
  // N = normalisation_2 / pi in two dimensions, normalisation_3 / pi in three, as numerator and denominator.
  int over_pi_2[2], over_pi_3[2];
};
constexpr std::array<Named, 5> kKernels{{{"cubic", KernelShape::cubic, 3, {80, 7}, {16, 1}},
                                         {"quintic", KernelShape::quintic, 5, {15309, 478}, {2187, 40}},
                                         {"wendland-c2", KernelShape::wendland_c2, 4, {7, 1}, {21, 2}},
                                         {"wendland-c4", KernelShape::wendland_c4, 6, {9, 1}, {495, 32}},
                                         {"wendland-c6", KernelShape::wendland_c6, 8, {78, 7}, {1365, 64}}}};

const Named& named(KernelShape shape) {
  for (const Named& kernel : kKernels)
    if (kernel.shape == shape) return kernel;
  throw std::invalid_argument("no such kernel");
}

}  // namespace

KernelShape kernel_shape(const std::string& name) {
  for (const Named& kernel : kKernels)
    if (name == kernel.name) return kernel.shape;
  throw std::invalid_argument("there is no kernel `" + name + "`");
}

int time_order_ceiling(KernelShape shape) { return named(shape).ceiling; }

template <class S> Kernel<S> make_kernel(KernelShape shape, int dimensions, S h_m) {
  const int(&over_pi)[2] = dimensions == 2 ? named(shape).over_pi_2 : named(shape).over_pi_3;
  const S pi = real::atan2(S(0), S(-1));
  Kernel<S> kernel{shape, dimensions, S(support_ratio(shape)) * h_m, S(0), S(0), S(0)};
  kernel.inverse_support = S(1) / kernel.support;
  S volume = kernel.support * kernel.support;
  if (dimensions == 3) volume = volume * kernel.support;
  kernel.value_factor = S(over_pi[0]) / (S(over_pi[1]) * pi * volume);
  kernel.slope_factor = kernel.value_factor / (kernel.support * kernel.support);
  return kernel;
}

template <class S> S Kernel<S>::value(S r) const {
  return value_factor * kernel_value<S>(shape, S(r * inverse_support));
}
template <class S> S Kernel<S>::slope_over_distance(S r) const {
  return slope_factor * kernel_slope<S>(shape, S(r * inverse_support));
}

#define ATWOOD_KERNEL(S)     \
  template struct Kernel<S>; \
  template Kernel<S> make_kernel<S>(KernelShape, int, S);
ATWOOD_KERNEL(float)
ATWOOD_KERNEL(double)
ATWOOD_KERNEL(long double)
ATWOOD_KERNEL(Quad)
#undef ATWOOD_KERNEL

}  // namespace atwood::fluid
