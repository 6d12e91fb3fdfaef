// Recurrences of power series: products, powers and sums (Hairer, Norsett, Wanner, Solving ODEs I, I.8).
#pragma once

#include "integrators/taylor.hpp"

namespace atwood::series {

// (x y)_k = sum_j x_j y_(k-j), coefficients `stride` apart (Cauchy).
template <class S> S product(const S* x, const S* y, std::ptrdiff_t stride, int k) {
  S sum = S(0);
  for (int j = 0; j <= k; ++j) sum += x[j * stride] * y[(k - j) * stride];
  return sum;
}

// Coefficient k of u = r.r + s^2, of w = u^(-3/2) and of r w, for W adjacent pairs. w' u = -3/2 u' w gives
//   k u_0 w_k = -sum_(j<k) (3 k - j) / 2  u_(k-j) w_j
template <int W, class S> ATWOOD_INLINE void inverse_cube_series(PairSeries<S>& pairs, const S* half, int k) {
  const std::ptrdiff_t lanes = pairs.lanes, stride = 5 * lanes;
  for (std::ptrdiff_t first = 0; first < lanes; first += W) {
    S *x = pairs.rows.data() + first, *y = x + lanes, *z = y + lanes, *u = z + lanes, *w = u + lanes;
    S sum[W]{}, ax[W]{}, ay[W]{}, az[W]{};
    for (int j = 0; 2 * j < k; ++j) {
      const std::ptrdiff_t a = j * stride, b = (k - j) * stride;
      for (int l = 0; l < W; ++l) sum[l] += x[a + l] * x[b + l] + y[a + l] * y[b + l] + z[a + l] * z[b + l];
    }
    for (int l = 0; l < W; ++l) sum[l] += sum[l];
    if (k % 2 == 0) {
      const std::ptrdiff_t a = k / 2 * stride;
      for (int l = 0; l < W; ++l) sum[l] += x[a + l] * x[a + l] + y[a + l] * y[a + l] + z[a + l] * z[a + l];
    }
    if (k == 0)
      for (int l = 0; l < W; ++l) sum[l] += pairs.softening2[first + l];
    for (int l = 0; l < W; ++l) u[k * stride + l] = sum[l];
    if (k == 0) {
      for (int l = 0; l < W; ++l) {
        pairs.inverse_u[first + l] = S(1) / sum[l];
        w[l] = S(1) / (sum[l] * real::sqrt(sum[l]));
      }
    } else {
      S power[W]{};
      for (int j = 0; j < k; ++j) {
        const std::ptrdiff_t a = j * stride, b = (k - j) * stride;
        for (int l = 0; l < W; ++l) power[l] += half[3 * k - j] * (u[b + l] * w[a + l]);
      }
      for (int l = 0; l < W; ++l) w[k * stride + l] = -power[l] * pairs.inverse_u[first + l] / S(k);
    }
    for (int j = 0; j <= k; ++j) {
      const std::ptrdiff_t a = j * stride, b = (k - j) * stride;
      for (int l = 0; l < W; ++l) {
        ax[l] += w[a + l] * x[b + l];
        ay[l] += w[a + l] * y[b + l];
        az[l] += w[a + l] * z[b + l];
      }
    }
    S* out = pairs.acceleration.data() + first;
    for (int l = 0; l < W; ++l) out[l] = ax[l];
    for (int l = 0; l < W; ++l) out[lanes + l] = ay[l];
    for (int l = 0; l < W; ++l) out[2 * lanes + l] = az[l];
  }
}

// Coefficients of a top: three permuted copies of q, (y z x) and (z x y) of w, w itself; four numbers each. Then
//   q' = 1/2 q (0, w):  2 q'_k = sum_j w_x,j qx_(k-j) + w_y,j qy_(k-j) + w_z,j qz_(k-j)
//   the products of w for Euler's equations in principal axes:  (w_y w_z, w_z w_x, w_x w_y)_k = sum_j yzx_j zxy_(k-j)
inline constexpr int kTopScalars = 24;

template <class S> ATWOOD_INLINE void store_rotation_rows(const S* q, const S* w, S* row) {
  const S all[kTopScalars] = {-q[1], q[0], q[3], -q[2], -q[2], -q[3], q[0], q[1], -q[3], q[2], -q[1], q[0],
                              w[1],  w[2], w[0], S(0),  w[2],  w[0],  w[1], S(0), w[0],  w[1], w[2],  S(0)};
  for (int i = 0; i < kTopScalars; ++i) row[i] = all[i];
}

// Four adjacent numbers: one vector register where the scalar has them.
template <class S, bool vectors = has_vector_lanes<S>> struct Four {
  S at[4];
  ATWOOD_INLINE void add(S factor, const S* b) {
    for (int l = 0; l < 4; ++l) at[l] += factor * b[l];
  }
  ATWOOD_INLINE void add(const S* a, const S* b) {
    for (int l = 0; l < 4; ++l) at[l] += a[l] * b[l];
  }
};
template <class S> struct Four<S, true> {
  typedef S V __attribute__((vector_size(4 * sizeof(S))));
  V at;
  ATWOOD_INLINE static V load(const S* from) {
    V v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
  }
  ATWOOD_INLINE void add(S factor, const S* b) { at += factor * load(b); }
  ATWOOD_INLINE void add(const S* a, const S* b) { at += load(a) * load(b); }
};

template <class S>
ATWOOD_INLINE void rotation_products(const S* rows, std::ptrdiff_t stride, int k, S* twice_turn, S* products) {
  Four<S> x{}, y{}, z{}, w{};
  for (int j = 0; j <= k; ++j) {
    const S *a = rows + j * stride, *b = rows + (k - j) * stride;
    x.add(a[20], b);
    y.add(a[21], b + 4);
    z.add(a[22], b + 8);
    w.add(a + 12, b + 16);
  }
  for (int l = 0; l < 4; ++l) twice_turn[l] = (x.at[l] + y.at[l]) + z.at[l];
  for (int l = 0; l < 3; ++l) products[l] = w.at[l];
}

// sum over k = 1 .. order of c_k theta^k, of every component.
template <class S> ATWOOD_INLINE void horner(const S* series, int size, int order, S theta, S* out) {
  const S* top = series + static_cast<std::ptrdiff_t>(order) * size;
  for (int i = 0; i < size; ++i) out[i] = theta * top[i];
  for (int k = order - 1; k > 0; --k) {
    const S* c = series + static_cast<std::ptrdiff_t>(k) * size;
    for (int i = 0; i < size; ++i) out[i] = theta * (out[i] + c[i]);
  }
}

}  // namespace atwood::series
