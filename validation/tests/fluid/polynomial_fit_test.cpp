// Fits by moving least squares: exact for polynomials, of their order for smooth fields, the same bits in lanes.
#include "fluid/polynomial_fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "scene/split_mix.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

using Field = std::function<double(const double* x)>;

struct Cloud {
  int dimensions, count;
  double spacing;
  std::vector<double> x;
};
// n^d points around the origin, each moved by up to a fifth of the spacing.
Cloud disturbed_points(int dimensions, int n, double spacing) {
  SplitMix64 random{11};
  Cloud cloud{dimensions, 1, spacing, {}};
  for (int c = 0; c < dimensions; ++c) cloud.count *= n;
  for (int i = 0; i < cloud.count; ++i)
    for (int c = 0, left = i; c < dimensions; ++c, left /= n)
      cloud.x.push_back((left % n - 0.5 * (n - 1) + 0.2 * random.next_unit()) * spacing);
  return cloud;
}

struct Fitted {
  std::vector<Fit<double>> fits;  // by point
  std::vector<bool> inside;       // the whole support is
};
// All fields are the same one.
Fitted fit_field(const Cloud& cloud, int degree, double smoothing, const Field& field, bool lane_by_lane = false) {
  const int d = cloud.dimensions;
  const double support = 2 * smoothing * cloud.spacing;
  Domain domain;
  domain.dimensions = d;
  Neighbours<double> lists(domain, support, 0.1 * support);
  REQUIRE(lists.update(cloud.x.data(), cloud.count, nullptr));
  const std::size_t slots = std::size_t(lists.blocks()) * kLaneCount;
  std::vector<double> records(slots * kFitRecord), supports(slots, support);
  double most = 0;
  for (const double x : cloud.x) most = std::max(most, std::abs(x));
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const int i = lists.order()[std::min<std::size_t>(slot, cloud.count - 1)];
    const double* const x = &cloud.x[std::size_t(i) * d];
    for (int c = 0; c < d; ++c) records[slot * kFitRecord + c] = x[c];
    for (int f = 0; f <= d; ++f) records[slot * kFitRecord + d + f] = field(x);
  }
  PolynomialFits<double> fits;
  fits.dimensions = d;
  fits.degree = degree;
  fits.fields = d + 1;
  fits.spacing = cloud.spacing;
  fits.lane_by_lane = lane_by_lane;
  LaneArray<double> scratch;
  std::vector<Fit<double>> by_slot(slots);
  fits.fit(lists, records.data(), supports.data(), nullptr, 0, lists.blocks(), scratch, by_slot.data());
  Fitted fitted;
  for (int i = 0; i < cloud.count; ++i) {
    fitted.fits.push_back(by_slot[lists.slot_of()[i]]);
    bool inside = true;
    for (int c = 0; c < d; ++c) inside = inside && std::abs(cloud.x[std::size_t(i) * d + c]) < most - support;
    fitted.inside.push_back(inside);
  }
  return fitted;
}

// A polynomial with all monomials of degree up to p in x, y (and z), with its derivatives.
double powers(const double* x, int d, int p, int along, int times) {
  double sum = 0;
  for (int a = 0; a <= p; ++a)
    for (int b = 0; a + b <= p; ++b)
      for (int e = 0; e <= (d == 3 ? p - a - b : 0); ++e) {
        const int exponent[3] = {a, b, e};
        double term = 1 + 0.3 * a - 0.2 * b + 0.7 * e;
        for (int c = 0; c < d; ++c) {
          int n = exponent[c];
          for (int k = 0; k < (c == along ? times : 0); ++k) term *= n--;
          term *= n >= 0 ? std::pow(x[c], n) : 0;
        }
        sum += term;
      }
  return sum;
}

// The worst errors of gradient and Laplacian at points whose whole support is inside, and how many these are.
struct Errors {
  double gradient = 0, laplacian = 0, change = 0;
  int points = 0;
};
Errors errors_of(const Cloud& cloud, const Fitted& fitted,
                 const std::function<double(const double*, int, int)>& exact) {
  Errors errors;
  for (int i = 0; i < cloud.count; ++i) {
    if (!fitted.inside[i]) continue;
    ++errors.points;
    const double* const x = &cloud.x[std::size_t(i) * cloud.dimensions];
    double laplacian = 0;
    for (int c = 0; c < cloud.dimensions; ++c) {
      errors.gradient = std::max(errors.gradient, std::abs(fitted.fits[i].gradient[0][c] - exact(x, c, 1)));
      laplacian += exact(x, c, 2);
    }
    errors.laplacian = std::max(errors.laplacian, std::abs(fitted.fits[i].laplacian[0] - laplacian));
    errors.change = std::max(errors.change, std::abs(fitted.fits[i].change[0]));
  }
  return errors;
}

}  // namespace

TEST_CASE("A fit reproduces polynomials of its degree to round-off, and no higher ones") {
  struct Case {
    int dimensions, degree, n;
    double smoothing;
  };
  for (const Case& it : {Case{2, 2, 16, 1.5}, {2, 4, 18, 1.55}, {3, 2, 10, 1.5}, {3, 4, 11, 1.55}}) {
    INFO("d = " << it.dimensions << ", degree " << it.degree);
    const Cloud cloud = disturbed_points(it.dimensions, it.n, 0.1);
    for (const int above : {0, 1}) {
      const int p = it.degree + above, d = it.dimensions;
      const Fitted fitted =
          fit_field(cloud, it.degree, it.smoothing, [&](const double* x) { return powers(x, d, p, 0, 0); });
      const Errors errors =
          errors_of(cloud, fitted, [&](const double* x, int c, int times) { return powers(x, d, p, c, times); });
      CHECK(errors.points > 5);
      if (above == 0) {
        CHECK(errors.gradient < 2e-11);
        CHECK(errors.laplacian < 2e-9);
        CHECK(errors.change < 2e-12);
      } else {
        CHECK(errors.gradient > 1e-6);
        CHECK(errors.change > 1e-8);
      }
    }
  }
}

TEST_CASE("First derivatives converge with the fit's degree, the Laplacian one order below") {
  const auto wave = [](const double* x, int c, int times) {  // sin(2 x + 1) cos(y)
    const double s = std::sin(2 * x[0] + 1), co = std::cos(2 * x[0] + 1), y = x[1];
    if (times == 0) return s * std::cos(y);
    if (times == 1) return c == 0 ? 2 * co * std::cos(y) : -s * std::sin(y);
    return c == 0 ? -4 * s * std::cos(y) : -s * std::cos(y);
  };
  for (const int degree : {2, 4}) {
    INFO("degree " << degree);
    Errors errors[2];
    for (const int fine : {0, 1}) {
      const Cloud cloud = disturbed_points(2, 24, fine == 0 ? 0.1 : 0.05);
      errors[fine] = errors_of(
          cloud, fit_field(cloud, degree, degree == 2 ? 1.5 : 1.55, [&](const double* x) { return wave(x, 0, 0); }),
          wave);
    }
    const double gradient = std::log2(errors[0].gradient / errors[1].gradient);
    const double laplacian = std::log2(errors[0].laplacian / errors[1].laplacian);
    CHECK(gradient == Approx(degree).margin(0.3));
    CHECK(laplacian > degree - 1.3);
    CHECK(std::log2(errors[0].change / errors[1].change) > degree + 0.7);
  }
}

TEST_CASE("Lanes and the scalar loop give the same bits") {
  for (const int dimensions : {2, 3}) {
    for (const int degree : {2, 4}) {
      const Cloud cloud = disturbed_points(dimensions, dimensions == 2 ? 13 : degree == 2 ? 7 : 9, 0.1);
      const auto field = [](const double* x) { return std::sin(3 * x[0]) + x[1] * x[1] * x[0]; };
      const Fitted lanes = fit_field(cloud, degree, 1.6, field), loop = fit_field(cloud, degree, 1.6, field, true);
      int compared = 0;
      for (int i = 0; i < cloud.count; ++i) {
        const Fit<double>&a = lanes.fits[i], &b = loop.fits[i];
        if (!(b.least_pivot > 1e-3)) continue;  // corners of the cloud: singular
        ++compared;
        CHECK(a.least_pivot == b.least_pivot);
        for (int f = 0; f <= dimensions; ++f) {
          CHECK(a.laplacian[f] == b.laplacian[f]);
          CHECK(a.change[f] == b.change[f]);
          for (int c = 0; c < dimensions; ++c) CHECK(a.gradient[f][c] == b.gradient[f][c]);
        }
        for (int c = 0; c < dimensions; ++c) CHECK(a.shift_sum[c] == b.shift_sum[c]);
      }
      CHECK(compared > cloud.count / 8);
    }
  }
}

TEST_CASE("A neighbourhood on two lines does not determine a polynomial of degree 4, and its pivot says so") {
  Cloud cloud{2, 0, 0.1, {}};
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 2; ++j) cloud.x.insert(cloud.x.end(), {0.1 * i, 0.1 * j});
  cloud.count = 80;
  const Fitted fitted = fit_field(cloud, 4, 1.55, [](const double* x) { return x[0]; });
  for (const Fit<double>& fit : fitted.fits) CHECK(!(fit.least_pivot > 1e-10));
}
