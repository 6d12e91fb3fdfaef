// The two methods by themselves: coefficients, observed order, exactness.
#include <quadmath.h>

#include <catch2/catch.hpp>

#include "dynamics/arithmetic.hpp"
#include "extended/collocation.hpp"
#include "extended/extrapolation.hpp"

using namespace atwood;
using namespace atwood::extended;

namespace {

double size(Wide x) { return static_cast<double>(fabsq(x)); }

// y' = 24 t^23 as a system of y alone with t as its clock.
const Rate<Wide> power = [](Wide t, const Wide*, Wide* dydt) {
  Wide value = 24;
  for (int k = 0; k < 23; ++k) value *= t;
  dydt[0] = value;
};

}  // namespace

TEST_CASE("Gauss nodes satisfy the simplifying conditions B(20) and C(10)") {
  const GaussTableau& tableau = gauss_tableau();
  for (int k = 1; k <= 20; ++k) {
    Wide sum = 0;
    for (int j = 0; j < kStages; ++j) sum += tableau.b[j] * powq(tableau.c[j], k - 1);
    CHECK(size(sum - Wide(1) / k) < 1e-33);
  }
  Wide beyond = 0;
  for (int j = 0; j < kStages; ++j) beyond += tableau.b[j] * powq(tableau.c[j], 20);
  CHECK(size(beyond - Wide(1) / 21) > 1e-14);  // order 20, not more
  for (int i = 0; i < kStages; ++i)
    for (int k = 1; k <= 10; ++k) {
      Wide sum = 0;
      for (int j = 0; j < kStages; ++j) sum += tableau.A[i][j] * powq(tableau.c[j], k - 1);
      CHECK(size(sum - powq(tableau.c[i], k) / k) < 1e-33);
    }
}

TEST_CASE("collocation is exact on polynomials of degree 20, and has order 20") {
  const Problem problem = problem_of(1, [](auto t, const auto*, auto* dydt) {
    auto value = 20 * t;
    for (int k = 0; k < 18; ++k) value *= t;
    dydt[0] = value;
  });
  Collocation stepper(problem, 1);  // tolerance 1: never rejects
  Wide y[1] = {0};
  Wide t = 0;
  while (t < 1) t += stepper.step(t, y, 1 - t);
  CHECK(size(y[0] - 1) < 1e-31);

  // A full swing and more: halving h divides the error by 2^20 (within the constants' own change).
  const auto error = [](int steps) {
    const Problem swing = problem_of(2, [](auto, const auto* z, auto* dydt) {
      dydt[0] = z[1];
      dydt[1] = -z[0];
    });
    Wide z[2] = {1, 0};
    const Wide h = Wide(16) / steps;
    Collocation stepper_at_ease(swing, 1e2);
    for (Wide taken = 0; taken < 2;) {  // elsewhere, until it would take 2 at once
      Wide elsewhere[2] = {1, 0};
      taken = stepper_at_ease.step(0, elsewhere, 1000);
    }
    for (int k = 0; k < steps; ++k) REQUIRE(stepper_at_ease.step(k * h, z, h) == h);
    return size(z[0] - cosq(16));
  };
  const double order = std::log2(error(8) / error(16));
  CHECK(order > 19.5);
  CHECK(order < 20.5);
}

TEST_CASE("extrapolation is exact on t^24 once it has twelve columns") {
  Extrapolation<Wide> stepper(1, {}, power, 1e-28);
  Wide y[1] = {0};
  REQUIRE(advance<Wide>(stepper, 0, y, 1));
  CHECK(size(y[0] - 1) < 1e-30);
}

TEST_CASE("both methods end at the requested time, within their tolerance") {
  const Problem swing = problem_of(2, [](auto, const auto* y, auto* dydt) {
    dydt[0] = y[1];
    dydt[1] = -y[0];
  });
  for (const double tolerance : {1e-12, 1e-20, 1e-28}) {
    Extrapolation<Wide> explicit_one(2, {}, swing.rate, tolerance);
    Collocation implicit_one(swing, tolerance);
    for (Stepper<Wide>* stepper :
         {static_cast<Stepper<Wide>*>(&explicit_one), static_cast<Stepper<Wide>*>(&implicit_one)}) {
      Wide y[2] = {1, 0};
      REQUIRE(advance<Wide>(*stepper, 0, y, Wide(7) / 3));
      REQUIRE(advance<Wide>(*stepper, Wide(7) / 3, y, 10 - Wide(7) / 3));
      CHECK(size(y[0] - cosq(10)) < 100 * tolerance);
    }
  }
}

// y' = sqrt(y) from 1, and from below zero: no rate there is a number.
TEST_CASE("collocation takes no step where the rates are not numbers") {
  const Problem root = problem_of(1, [](auto, const auto* y, auto* dydt) { dydt[0] = dynamics::sqrt(y[0]); });
  for (const double from : {1.0, -1.0}) {
    Collocation collocation(root, 1e-20);
    Wide y = from;
    const Wide taken = collocation.step(0, &y, 0.01);
    CHECK((taken > 0) == (from > 0));
    CHECK((y == from) == (from < 0));
  }
}

TEST_CASE("a collision of point masses is refused as singular") {
  const Rate<Wide> fall = [](Wide, const Wide* y, Wide* dydt) {
    dydt[0] = y[1];
    dydt[1] = -1 / (y[0] * y[0]);
  };
  Extrapolation<Wide> stepper(2, {}, fall, 1e-20);
  Wide y[2] = {1, 0};  // reaches the centre at t = pi / sqrt(8)
  CHECK_FALSE(advance<Wide>(stepper, 0, y, 2));
}
