// Bisection and false position in each scalar, at jumps and borders, and what they say when they end early.
#include "math/bracketed_root.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "math/scalar.hpp"

namespace atwood {
namespace {

// x^3 = 2, simple; evaluated as Illinois and bisection see it.
template <class S> S cube(S x) { return x * x * x - S(2); }

template <class S> void finds_the_cube_root_of_2() {
  const auto all = bisect([](S x) { return cube(x) < S(0); }, S(1), S(2), S(0), 200);
  REQUIRE(all.converged);
  CHECK(cube(all.low) < S(0));
  CHECK(cube(all.high) >= S(0));
  CHECK(all.high - all.low <= real::epsilon<S>());
  const auto quick = false_position(cube<S>, S(1), cube(S(1)), S(2), cube(S(2)), S(4) * real::epsilon<S>(), 100);
  REQUIRE(quick.converged);
  CHECK(quick.low <= all.high);
  CHECK(quick.high >= all.low);
  CHECK(quick.evaluations <= 20);  // order 1.44: bisection takes 24 to 113
  CHECK(quick.evaluations < all.evaluations);
}

}  // namespace

TEST_CASE("bracketed roots: every digit in every scalar") {
  finds_the_cube_root_of_2<float>();
  finds_the_cube_root_of_2<double>();
  finds_the_cube_root_of_2<long double>();
  finds_the_cube_root_of_2<Quad>();
}

TEST_CASE("bisection: a jump, a root at an end, a tolerance, too few evaluations") {
  const auto jump = bisect([](double x) { return x < 0.3; }, 0.0, 1.0, 0.0, 200);
  CHECK(jump.converged);
  CHECK(jump.high == 0.3);
  CHECK(jump.low == std::nextafter(0.3, 0.0));
  const auto at_high = bisect([](double) { return true; }, 1.0, 2.0, 0.0, 200);
  CHECK(at_high.converged);
  CHECK(at_high.high == 2);
  CHECK(at_high.low == std::nextafter(2.0, 0.0));
  const auto rough = bisect([](double x) { return x < 0.3; }, 0.0, 1.0, 1e-3, 200);
  CHECK(rough.converged);
  CHECK(rough.high - rough.low <= 1e-3 * rough.high);
  CHECK(rough.evaluations == 12);
  const auto cut = bisect([](double x) { return x < 0.3; }, 0.0, 1.0, 1e-3, 11);
  CHECK_FALSE(cut.converged);
  CHECK(cut.evaluations == 11);
  CHECK(cut.low < 0.3);
  CHECK(cut.high >= 0.3);
  CHECK(bisect([](double) { return true; }, 1.0, 1.0, 0.0, 10).converged);
}

TEST_CASE("false position: exact at once on a line, through a kink, and says what it could not do") {
  const auto line = false_position([](double x) { return x - 0.25; }, 0.0, -0.25, 1.0, 0.75, 0.0, 100);
  CHECK(line.converged);
  CHECK(line.high == 0.25);
  CHECK(line.low == line.high);
  CHECK(line.evaluations == 1);
  const auto kinked = [](double x) { return x < 0.7 ? 0.1 * (x - 0.7) : 100 * (x - 0.7); };
  const auto kink = false_position(kinked, 0.0, kinked(0), 1.0, kinked(1), 1e-15, 100);
  CHECK(kink.converged);
  CHECK(kink.high == Approx(0.7).epsilon(1e-14));
  CHECK_FALSE(false_position(kinked, 0.0, kinked(0), 1.0, kinked(1), 1e-15, 3).converged);
  const auto lost = false_position([](double) { return std::nan(""); }, 0.0, -1.0, 1.0, 1.0, 1e-15, 100);
  CHECK_FALSE(lost.converged);
  CHECK(lost.evaluations == 1);
  const auto none = false_position([](double x) { return x + 1; }, 0.0, 1.0, 1.0, 2.0, 1e-15, 100);
  CHECK_FALSE(none.converged);
  CHECK(none.evaluations == 0);
}

}  // namespace atwood
