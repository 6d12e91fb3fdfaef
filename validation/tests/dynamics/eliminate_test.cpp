// Elimination in each scalar, against an answer that is known exactly, and what it refuses.
#include <catch2/catch.hpp>
#include <limits>

#include "dynamics/complementarity.hpp"
#include "protocol/sample.hpp"

namespace atwood::test {
namespace {

template <class S> using Rows = std::vector<std::vector<S>>;
template <class S> S size_of(S x) { return x < 0 ? -x : x; }

// The matrix of a chain of n masses, 2 on the diagonal and -1 beside it; b is such that x_i = (i + 1) / 3.
template <class S> void solves_a_chain(std::size_t n, S round_off) {
  Rows<S> A(n, std::vector<S>(n, S(0)));
  std::vector<S> b(n, S(0)), x;
  for (std::size_t i = 0; i < n; ++i) {
    A[i][i] = 2;
    if (i > 0) A[i][i - 1] = A[i - 1][i] = -1;
  }
  b[n - 1] = S(n + 1) / 3;
  REQUIRE(dynamics::eliminate(A, b, S(1e-12), x));
  REQUIRE(x.size() == n);
  for (std::size_t i = 0; i < n; ++i) CHECK(size_of(x[i] - S(i + 1) / 3) <= S(8 * n) * round_off);
}

}  // namespace

TEST_CASE("elimination solves a chain of 1 to 12 contacts to round-off") {
  for (std::size_t n = 1; n <= dynamics::kMaxSimultaneous; ++n) {
    solves_a_chain<double>(n, 0x1p-53);
    solves_a_chain<long double>(n, 0x1p-64L);
    solves_a_chain<Wide>(n, Wide(0x1p-113L));
  }
}

TEST_CASE("elimination exchanges rows, and refuses what is singular or no number") {
  std::vector<double> x;
  REQUIRE(dynamics::eliminate<double>({{1e-3, 1}, {1, 1}}, {1, 2}, 1e-9, x));
  CHECK(x[0] == Approx(1 / 0.999).epsilon(1e-14));
  CHECK(x[1] == Approx(2 - 1 / 0.999).epsilon(1e-14));
  CHECK_FALSE(dynamics::eliminate<double>({{1, 2}, {2, 4}}, {1, 2}, 1e-12, x));
  CHECK_FALSE(dynamics::eliminate<double>({{1, 1}, {1, 1 + 1e-13}}, {1, 2}, 1e-12, x));
  CHECK(dynamics::eliminate<double>({{1, 1}, {1, 1 + 1e-11}}, {1, 2}, 1e-12, x));
  CHECK_FALSE(dynamics::eliminate<double>({{0, 0}, {0, 0}}, {0, 0}, 1e-12, x));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(dynamics::eliminate<double>({{nan, 1}, {1, 2}}, {1, 2}, 1e-12, x));
  CHECK_FALSE(dynamics::eliminate<double>({{2, 1}, {1, nan}}, {1, 2}, 1e-12, x));
  CHECK(dynamics::eliminate<double>({}, {}, 1e-12, x));
  CHECK(x.empty());
  std::vector<Wide> wide;
  CHECK_FALSE(dynamics::eliminate<Wide>({{1, 3}, {3, 9}}, {1, 2}, Wide(1e-25), wide));
}

}  // namespace atwood::test
