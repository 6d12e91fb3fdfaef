#include "math/elementary.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace atwood::real {
namespace {

// log 2 in two parts: the first has 32 bits, so that its products with exponents are exact.
constexpr long double kLog2High = 0x1.62e42fefp-1L, kLog2Low = 0x1.473de6af278ece6p-34L;
constexpr std::uint64_t kFraction = (std::uint64_t{1} << 52) - 1;
constexpr long double kPi = 3.14159265358979323846264338327950288L;

template <int terms> constexpr std::array<long double, terms> odd_reciprocals() {  // 1, 1/3, 1/5, ...
  std::array<long double, terms> c{};
  for (int n = 0; n < terms; ++n) c[n] = 1.0L / (2 * n + 1);
  return c;
}

template <int terms> constexpr std::array<long double, terms> factorial_reciprocals() {  // 1, 1, 1/2, 1/6, ...
  std::array<long double, terms> c{1};
  long double factorial = 1;
  for (int n = 1; n < terms; ++n) c[n] = 1 / (factorial *= n);
  return c;
}

// x = 2^k m, m in [sqrt(1/2), sqrt 2). With s = (m - 1) / (m + 1), |s| < 0.172:
//   log m = 2 (s + s^3 / 3 + s^5 / 5 + ...)
long double log_of(double x) {
  int k = 0;
  double m = std::frexp(x, &k);
  if (m < 0x1.6a09e667f3bcdp-1) {
    m *= 2;
    --k;
  }
  const long double s = (m - 1.0L) / (m + 1.0L), square = s * s;
  constexpr int terms = 13;
  constexpr std::array<long double, terms> c = odd_reciprocals<terms>();
  long double sum = c[terms - 1];
  for (int n = terms - 2; n >= 0; --n) sum = sum * square + c[n];
  return k * kLog2High + (2 * s * sum + k * kLog2Low);
}

// x = k log 2 + r, |r| < 0.347, and Taylor's series of e^r.
double exp_of(long double x) {
  const int k = static_cast<int>(x / kLog2High + (x < 0 ? -0.5L : 0.5L));
  const long double r = (x - k * kLog2High) - k * kLog2Low;
  constexpr int terms = 18;
  constexpr std::array<long double, terms> c = factorial_reciprocals<terms>();
  long double sum = c[terms - 1];
  for (int n = terms - 2; n >= 0; --n) sum = sum * r + c[n];
  return static_cast<double>(std::ldexp(sum, k));
}

// The angle of t in [0, 1]. Halved twice, tan(a / 2) = t / (1 + sqrt(1 + t^2)), it is below 0.199.
long double arc_of(long double t) {
  for (int halving = 0; halving < 2; ++halving) t = t / (1 + std::sqrt(1 + t * t));
  constexpr int terms = 15;
  const long double square = t * t;
  constexpr std::array<long double, terms> c = odd_reciprocals<terms>();
  long double sum = c[terms - 1];
  for (int n = terms - 2; n >= 0; --n) sum = c[n] - sum * square;
  return 4 * t * sum;
}

}  // namespace

double log(double x) {
  if (!(x > 0)) return x == 0 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(x)) return x;
  return static_cast<double>(log_of(x));
}

double exp(double x) {
  if (x != x) return x;
  if (x > 709.8) return std::numeric_limits<double>::infinity();
  if (x < -745.2) return 0;
  return exp_of(x);
}

double power(double x, double y) {
  if (y == 0) return 1;
  if (x == 0) return y > 0 ? 0 : std::numeric_limits<double>::infinity();
  if (!(x > 0) || std::isinf(x) || !std::isfinite(y)) return std::pow(x, y);  // exact values and NaN
  const long double exponent = y * log_of(x);
  if (exponent > 709.8L) return std::numeric_limits<double>::infinity();
  if (exponent < -745.2L) return 0;
  return exp_of(exponent);
}

// The same series with fewer terms, in double; exponents are taken from and put into the bits.
double step_power(double x, double y) {
  if (!(x >= std::numeric_limits<double>::min()) || std::isinf(x)) return std::pow(x, y);
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x), half = std::uint64_t{0x6a09e667f3bcd};  // of sqrt 2
  const bool high = (bits & kFraction) > half;
  const int k = static_cast<int>(bits >> 52) - 1023 + high;
  const double m = std::bit_cast<double>((bits & kFraction) | std::uint64_t(high ? 1022 : 1023) << 52);
  const double s = (m - 1) / (m + 1), z = s * s;
  const double series = 2 * s * ((1 + z * (1.0 / 3)) + z * z * (1.0 / 5 + z * (1.0 / 7)));
  const double exponent = y * (k + series * 0x1.71547652b82fep0);  // of 2
  if (!(exponent > -1000 && exponent < 1000)) return exponent > 0 ? std::numeric_limits<double>::infinity() : 0;
  const double whole = (exponent + 0x1.8p52) - 0x1.8p52, r = (exponent - whole) * 0x1.62e42fefa39efp-1, rr = r * r;
  const double even = 1 + rr * (0.5 + rr * (1.0 / 24 + rr * (1.0 / 720)));
  const double odd = r * (1 + rr * (1.0 / 6 + rr * (1.0 / 120)));
  return (even + odd) * std::bit_cast<double>(std::uint64_t(1023 + static_cast<int>(whole)) << 52);
}

double atan2(double y, double x) {
  if (x == 0 || y == 0 || !std::isfinite(x) || !std::isfinite(y)) return std::atan2(y, x);  // exact values and NaN
  const long double across = std::fabs(y), along = std::fabs(x);
  long double angle = across <= along ? arc_of(across / along) : kPi / 2 - arc_of(along / across);
  if (x < 0) angle = kPi - angle;
  return static_cast<double>(y < 0 ? -angle : angle);
}

}  // namespace atwood::real
