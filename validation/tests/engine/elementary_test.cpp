// Elementary functions by IEEE operations alone, beside quadruple precision.
#include "math/elementary.hpp"

#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "math/scalar.hpp"

using namespace atwood;

namespace {

// |found - exact| in units in the last place of `found`.
double ulps(double found, Quad exact) {
  int exponent = 0;
  std::frexp(found, &exponent);
  return std::fabs(static_cast<double>((Quad(found) - exact) / Quad(std::ldexp(1.0, exponent - 53))));
}

struct Uniform {
  std::mt19937_64 random{7};
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
  }
};

}  // namespace

TEST_CASE("elementary functions: within .51 units in the last place") {
  Uniform between;
  double log = 0, exp = 0, power = 0, angle = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = i % 2 ? between(0.7, 1.5) : std::ldexp(between(1, 2), static_cast<int>(between(-1000, 1000)));
    log = std::fmax(log, ulps(real::log(x), logq(x)));
    const double z = i % 2 ? between(-1, 1) : between(-700, 700);
    exp = std::fmax(exp, ulps(real::exp(z), expq(z)));
    const double base = between(0.1, 10), y = between(-3, 3);
    power = std::fmax(power, ulps(real::power(base, y), powq(base, y)));
    const double a = std::ldexp(between(-1, 1), i % 3 ? 0 : -40), b = std::ldexp(between(-1, 1), i % 5 ? 0 : -40);
    angle = std::fmax(angle, ulps(real::atan2(a, b), atan2q(a, b)));
  }
  CHECK(log < 0.51);
  CHECK(exp < 0.51);
  CHECK(power < 0.51);
  CHECK(angle < 0.51);
}

TEST_CASE(
    "elementary functions: sine and cosine of doubles within .8 units in the last place, floats rounded correctly") {
  Uniform between;
  double worst = 0;
  int floats_off = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = i % 2 ? between(-4, 4) : between(-1e6, 1e6);  // 2^19 lies within
    if (std::fabs(std::sin(x)) > 1e-3) worst = std::fmax(worst, ulps(real::sin(x), sinq(x)));
    if (std::fabs(std::cos(x)) > 1e-3) worst = std::fmax(worst, ulps(real::cos(x), cosq(x)));
    const float f = static_cast<float>(x);
    floats_off += real::sin(f) != static_cast<float>(sinq(f)) || real::cos(f) != static_cast<float>(cosq(f));
  }
  CHECK(worst < 0.8);
  CHECK(floats_off == 0);
}

TEST_CASE("elementary functions: the factor of a step size") {
  Uniform between;
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = std::ldexp(between(1, 2), static_cast<int>(between(-200, 200))), y = between(-1, 1);
    const double exact = std::pow(x, y);
    worst = std::fmax(worst, std::fabs(real::step_power(x, y) - exact) / exact);
  }
  CHECK(worst < 1e-6);
  CHECK(real::step_power(0, 0.5) == 0);
  CHECK(std::isinf(real::step_power(0, -0.5)));
  CHECK(real::step_power(1, 0.3) == Approx(1).margin(1e-15));
  CHECK(std::isnan(real::step_power(std::nan(""), 0.5)));
}

TEST_CASE("elementary functions: zeros, infinities and what is not a number") {
  const double infinity = std::numeric_limits<double>::infinity(), none = std::nan("");
  CHECK(real::log(1) == 0);
  CHECK(real::log(0) == -infinity);
  CHECK(real::log(infinity) == infinity);
  CHECK(std::isnan(real::log(-1)));
  CHECK(real::exp(0) == 1);
  CHECK(real::exp(-infinity) == 0);
  CHECK(real::exp(infinity) == infinity);
  CHECK(std::isnan(real::exp(none)));
  CHECK(real::exp(-745) == std::numeric_limits<double>::denorm_min());
  CHECK(real::power(0, 0.5) == 0);
  CHECK(real::power(0, -0.5) == infinity);
  CHECK(real::power(3, 0) == 1);
  CHECK(std::isnan(real::power(-2, 0.5)));
  CHECK(std::isnan(real::power(none, 0.5)));
  CHECK(real::atan2(0.0, -1.0) == std::atan2(0.0, -1.0));
  CHECK(real::atan2(-0.0, -1.0) == std::atan2(-0.0, -1.0));
  CHECK(real::atan2(1.0, 0.0) == std::atan2(1.0, 0.0));
  CHECK(real::atan2(infinity, -infinity) == std::atan2(infinity, -infinity));
  CHECK(std::isnan(real::atan2(none, 1.0)));
  CHECK(std::isnan(real::sin(infinity)));
}
