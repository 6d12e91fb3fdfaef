// Smoothing kernels: unit integral by quadrature, derivative by central differences, smoothness as claimed.
#include "fluid/kernel.hpp"

#include <catch2/catch.hpp>

using namespace atwood;
using namespace atwood::fluid;

namespace {

constexpr const char* kNames[] = {"cubic", "quintic", "wendland-c2", "wendland-c4", "wendland-c6"};

// Gauss-Legendre of 5 points, exact for polynomials of degree 9, on panels that end at the splines' knots and are short
// enough for degree 13 to round-off.
double integral(const Kernel<double>& kernel) {
  const double node[5] = {0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640, -0.9061798459386640};
  const double weight[5] = {0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                            0.2369268850561891};
  const double pi = 3.141592653589793;
  const int panels = 96;
  double sum = 0;
  for (int panel = 0; panel < panels; ++panel)
    for (int k = 0; k < 5; ++k) {
      const double half = kernel.support / (2 * panels), r = half * (2 * panel + 1 + node[k]);
      sum += half * weight[k] * kernel.value(r) * (kernel.dimensions == 2 ? 2 * pi * r : 4 * pi * r * r);
    }
  return sum;
}

}  // namespace

TEST_CASE("kernels have unit integral in two and three dimensions, at any smoothing length") {
  for (const char* name : kNames)
    for (const int dimensions : {2, 3})
      for (const double h : {1.0, 0.013}) {
        INFO(name << " d = " << dimensions);
        CHECK(integral(make_kernel(kernel_shape(name), dimensions, h)) == Approx(1).epsilon(1e-13));
      }
}

TEST_CASE("the slope is the derivative of the kernel") {
  for (const char* name : kNames)
    for (const int dimensions : {2, 3}) {
      INFO(name << " d = " << dimensions);
      const auto kernel = make_kernel<Quad>(kernel_shape(name), dimensions, Quad(0.7));
      for (double at = 0.013; at < 1; at += 0.0217) {
        const Quad r = Quad(at) * kernel.support, step = Quad(1e-9);
        const Quad difference = (kernel.value(r + step) - kernel.value(r - step)) / (Quad(2) * step);
        const double slope = static_cast<double>(kernel.slope_over_distance(r) * r);
        const double scale = static_cast<double>(kernel.value(Quad(0)));
        CHECK(slope < 0);
        CHECK(static_cast<double>(difference) == Approx(slope).epsilon(1e-12).margin(1e-14 * scale));
      }
    }
}

TEST_CASE("the kernel and its slope end at the support, and the slope over the distance is finite at 0") {
  for (const char* name : kNames) {
    const auto kernel = make_kernel<double>(kernel_shape(name), 3, 1.0);
    CHECK(kernel.support == support_ratio(kernel.shape));
    CHECK(kernel.value(kernel.support) == 0);
    CHECK(kernel.slope_over_distance(kernel.support * 1.5) == 0);
    const double at_0 = kernel.slope_over_distance(0);
    CHECK(at_0 < 0);
    CHECK(kernel.slope_over_distance(1e-9) == Approx(at_0).epsilon(1e-7));
  }
}

TEST_CASE("a kernel without a name is refused") { CHECK_THROWS_WITH(kernel_shape("gauss"), Catch::Contains("gauss")); }
