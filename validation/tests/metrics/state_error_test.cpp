// State errors against hand-known cases.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

BodySample turned(Wide angle_rad, Wide x, Wide y, Wide z) {
  BodySample b;
  const Wide s = sinq(angle_rad / 2);
  b.q_wxyz = {cosq(angle_rad / 2), s * x, s * y, s * z};
  return b;
}

}  // namespace

TEST_CASE("attitude error: the angle itself, down to 1e-18 rad, the same for q and -q") {
  const BodySample truth = turned(Wide(0.7), 0.6, 0.0, 0.8);
  for (const double angle : {3.0, 1.0, 1e-3, 1e-8, 1e-12, 1e-18}) {
    BodySample a = turned(Wide(0.7) + Wide(angle), 0.6, 0.0, 0.8);
    CHECK(attitude_error_rad(a, truth) == Approx(angle).epsilon(1e-12));
    for (Wide& c : a.q_wxyz) c = -c;
    CHECK(attitude_error_rad(a, truth) == Approx(angle).epsilon(1e-12));
    for (Wide& c : a.q_wxyz) c *= 3;
    CHECK(attitude_error_rad(a, truth) == Approx(angle).epsilon(1e-12));
  }
  CHECK(attitude_error_rad(truth, truth) == 0);
}

TEST_CASE("attitude error: rotations about different axes compose as on the sphere") {
  const double half_pi = std::acos(0.0);
  // A quarter turn about x against one about y: cos(angle/2) = cos^2(45 deg) = 1/2.
  CHECK(attitude_error_rad(turned(half_pi, 1, 0, 0), turned(half_pi, 0, 1, 0)) == Approx(2 * std::acos(0.5)));
  CHECK(attitude_error_rad(turned(half_pi, 1, 0, 0), turned(-half_pi, 1, 0, 0)) == Approx(2 * half_pi));
}

TEST_CASE("position error: subtracted wide, so no bit is lost far from the origin") {
  BodySample a, b;
  a.p_m = {Wide(1e8) + Wide(3e-12), 0, Wide(4e-12)};
  b.p_m = {Wide(1e8), 0, 0};
  CHECK(position_error_m(a, b) == Approx(5e-12).epsilon(1e-9));
}

TEST_CASE("a value under three bars prints as an upper limit") {
  CHECK(format_measure(1e-9, 1e-9) == "<= 2e-09");
  CHECK(format_measure(2.9e-9, 1e-9) == "<= 3.9e-09");
  CHECK(format_measure(3.1e-9, 1e-9) == "3.1e-09");
  CHECK(format_measure(0.125, 0) == "0.125");
  CHECK(format_measure(0, 1e-30) == "<= 1e-30");
}
