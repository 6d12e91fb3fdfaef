// Packs of eight numbers at every vector width that this machine has: each lane has the bits of the scalar operation.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>

#include "contact/stepping/rows.hpp"
#include "integrators/radau15_kernels.hpp"
#include "math/sin_cos.hpp"

namespace atwood::testing {
namespace {

template <class S> struct Numbers { S a[kLaneCount], b[kLaneCount], out[10][kLaneCount]; };

// What the kernel makes of a and b, row by row; the scalar's results beside it.
template <class S> void check_operations(VectorWidth width, Numbers<S>& n) {
  in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
    constexpr VectorWidth at = decltype(w)::value;
    using P = PackAt<S, at>;
    const P a = load_at<at>(n.a), b = load_at<at>(n.b);
    store<S>(a + b, n.out[0]);
    store<S>(a - b * S(3), n.out[1]);
    store<S>(S(2) / b - a, n.out[2]);
    store<S>(-a, n.out[3]);
    store<S>(root(WholePack<at>{}, a * a), n.out[4]);
    store<S>(where_above(a, b, a, -b), n.out[5]);
    store<S>(broadcast_at<at>(S(-0.0)), n.out[6]);
    for (int k = 0; k < kLaneCount; ++k) n.out[7][k] = a[k];
    P sine, cosine;
    real::same_sin_cos(a, sine, cosine);
    store<S>(sine, n.out[8]);
    store<S>(cosine, n.out[9]);
  });
  for (int k = 0; k < kLaneCount; ++k) {
    const S a = n.a[k], b = n.b[k];
    S sine, cosine;
    real::same_sin_cos(a, sine, cosine);
    const S expected[] = {a + b, a - b * S(3), S(2) / b - a, -a, std::sqrt(a * a), a > b ? a : -b, S(-0.0),
                          a,     sine,         cosine};
    for (int row = 0; row < 10; ++row) {
      INFO("row " << row << ", lane " << k << ", width " << static_cast<int>(width));
      if (std::isnan(expected[row])) CHECK(std::isnan(n.out[row][k]));
      else CHECK(std::memcmp(&expected[row], &n.out[row][k], sizeof(S)) == 0);
    }
  }
}

std::vector<VectorWidth> widths() {
  std::vector<VectorWidth> all{VectorWidth::narrow};
  for (const VectorWidth width : {VectorWidth::v3, VectorWidth::v4})
    if (width <= widest_vectors()) all.push_back(width);
  return all;
}

TEMPLATE_TEST_CASE("each lane of a pack has the bits of the scalar operation", "", float, double) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> size(-1e3, 1e3);
  for (const VectorWidth width : widths()) {
    Numbers<TestType> n{};
    for (int draw = 0; draw < 20; ++draw) {
      for (int k = 0; k < kLaneCount; ++k) n.a[k] = TestType(size(random)), n.b[k] = TestType(size(random));
      if (draw == 1) n.a[6] = TestType(-0.0), n.b[1] = n.a[1];
      if (draw == 2) n.a[5] = TestType(1e9);  // beyond the range of the reduction by pi / 2
      if (draw == 3) n.b[2] = std::numeric_limits<TestType>::quiet_NaN();
      check_operations(width, n);
    }
  }
}

TEMPLATE_TEST_CASE("eight rows are transposed into eight packs", "", float, double) {
  for (const VectorWidth width : widths()) {
    stepping::Row<TestType> rows[kLaneCount], back[kLaneCount] = {};
    for (int i = 0; i < kLaneCount; ++i)
      for (int k = 0; k < kLaneCount; ++k) rows[i].at[k] = TestType(10 * i + k);
    const std::int32_t index[kLaneCount] = {7, 2, 0, 5, 1, 6, 3, 4};
    TestType columns[kLaneCount][kLaneCount];
    in_lanes<TestType>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      PackAt<TestType, at> packs[kLaneCount];
      stepping::gather<TestType, at>(rows, index, packs);
      for (int c = 0; c < kLaneCount; ++c) store<TestType>(packs[c], columns[c]);
      stepping::scatter<TestType, at>(packs, index, 6, back);
    });
    for (int c = 0; c < kLaneCount; ++c)
      for (int k = 0; k < kLaneCount; ++k) {
        CHECK(columns[c][k] == rows[index[k]].at[c]);
        CHECK(back[index[k]].at[c] == (k < 6 ? rows[index[k]].at[c] : TestType(0)));
      }
  }
}

TEMPLATE_TEST_CASE("the largest size and any lane above zero are found in every lane", "", float, double) {
  using S = TestType;
  for (const VectorWidth width : widths())
    for (int lane = 0; lane < kLaneCount; ++lane)
      for (const S value : {S(-3), std::numeric_limits<S>::quiet_NaN()}) {
        S numbers[kLaneCount] = {S(1), S(-2), S(0.5), S(0), S(-0.0), S(2), S(1), S(-1)}, zeros[kLaneCount] = {};
        numbers[lane] = value;
        zeros[lane] = S(1e-30);
        S largest{};
        bool found = false, none = true;
        in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
          constexpr VectorWidth at = decltype(w)::value;
          radau::LargestSize<PackAt<S, at>> most;
          most.add(load_at<at>(numbers));
          most.add(broadcast_at<at>(S(0.25)));
          largest = most.value();
          found = stepping::any_above_zero<S, at>(load_at<at>(zeros));
          none = stepping::any_above_zero<S, at>(-load_at<at>(zeros));
        });
        INFO("lane " << lane << ", width " << static_cast<int>(width));
        if (std::isnan(value)) CHECK(std::isnan(largest));
        else CHECK(largest == S(3));
        CHECK(found);
        CHECK_FALSE(none);
      }
}

TEST_CASE("the largest size of a scalar without vectors keeps a NaN of every lane") {
  for (int lane = 0; lane < kLaneCount; ++lane) {
    long double numbers[kLaneCount] = {1, -2, 0.5L, 0, -0.0L, 2, 1, -1};
    numbers[lane] = std::numeric_limits<long double>::quiet_NaN();
    radau::LargestSize<Pack<long double>> most;
    most.add(load(numbers));
    most.add(broadcast(0.25L));
    INFO("lane " << lane);
    CHECK(std::isnan(most.value()));
  }
}

}  // namespace
}  // namespace atwood::testing
