// The reference's kernels: unit integral, slope, support, smoothness; and the limits of the pair sums.
#include <catch2/catch.hpp>

#include "fluid_scenes.hpp"
#include "fluid_truth/kernel.hpp"
#include "fluid_truth/particles.hpp"

using namespace atwood;
using namespace atwood::fluid_truth;

namespace {

constexpr KernelKind kAll[] = {KernelKind::cubic, KernelKind::quintic, KernelKind::wendland_c2, KernelKind::wendland_c4,
                               KernelKind::wendland_c6};

double d(Wide x) { return static_cast<double>(x); }

}  // namespace

TEST_CASE("A kernel has the integral 1 and the slope that its formula has") {
  for (const KernelKind kind : kAll)
    for (const int dimensions : {2, 3}) {
      const Wide R = 1.7;
      const auto kernel = kernel_of<Wide>(kind, dimensions, R);
      // Simpson's rule over each piece of the splines (thirds and halves are multiples of 1/6).
      Wide sum = 0;
      const int n = 6 * 200;
      for (int k = 0; k <= n; ++k) {
        const Wide r = R * k / n, shell = dimensions == 2 ? 2 * pi<Wide>() * r : 4 * pi<Wide>() * r * r;
        sum += kernel.value(r) * shell * ((k == 0 || k == n) ? 1 : k % 2 == 1 ? 4 : 2);
      }
      CHECK(d(sum * R / (3 * n)) == Approx(1).epsilon(1e-9));
      const Differences by;
      for (const double s : {0.05, 0.3, 0.4, 0.6, 0.9}) {
        const Wide slope = by.first([&](Wide e) { return kernel.value(R * Wide(s) + e); });
        CHECK(d(kernel.slope_over_r(R * Wide(s))) == Approx(d(slope / (R * Wide(s)))).epsilon(1e-13));
      }
      CHECK(d(kernel.slope_over_r(0)) == Approx(d(kernel.slope_over_r(Wide(1e-12)))).epsilon(1e-9));
      CHECK(d(kernel.value(R)) == 0);
      CHECK(d(kernel.slope_over_r(R * Wide(1.1))) == 0);
    }
}

TEST_CASE("Sums over pairs tend to the viscous terms that the fields use, in two and three dimensions") {
  // integral of (v_ij . x_ij) / r^2 F x_ij over space for v = (x^2, 0, 0) / 2 and (y^2, 0, 0) / 2 and (0, x y, 0), each
  // times 2 (d + 2), against lap v + 2 grad div v: (1 + 2, 0), (1, 0), (2, 0).
  for (const int dimensions : {2, 3}) {
    const double R = 1, step = dimensions == 2 ? 1.0 / 400 : 1.0 / 60;
    const auto kernel = kernel_of<double>(KernelKind::wendland_c4, dimensions, R);
    double along = 0, across = 0, mixed = 0, plain = 0;
    const int n = static_cast<int>(1 / step), layers = dimensions == 2 ? 0 : n;
    for (int i = -n; i <= n; ++i)
      for (int j = -n; j <= n; ++j)
        for (int k = -layers; k <= layers; ++k) {
          const double x = i * step, y = j * step, z = k * step, r2 = x * x + y * y + z * z;
          if (r2 == 0 || r2 >= R * R) continue;
          const double F = kernel.slope_over_r(std::sqrt(r2)),
                       cell = dimensions == 2 ? step * step : step * step * step;
          // x_ij = -(x, y, z), v_ij = -v at (x, y, z)
          const double scale = 2 * (dimensions + 2) * F / r2 * cell;
          along -= scale * (x * x / 2 * x) * x;
          across -= scale * (y * y / 2 * x) * x;
          mixed -= scale * (x * y * y) * x;
          plain -= 2 * F * cell * x * x / 2;
        }
    CHECK(along == Approx(3).epsilon(1e-3));
    CHECK(across == Approx(1).epsilon(1e-3));
    CHECK(mixed == Approx(2).epsilon(1e-3));
    CHECK(plain == Approx(1).epsilon(1e-3));  // Morris's: lap v alone
  }
}
