#include "fluid/polynomial_nodes.hpp"

#include <algorithm>
#include <numeric>

#include "fluid/polynomial_basis.hpp"
#include "fluid/polynomial_fit.hpp"

namespace atwood::fluid {
namespace {

constexpr double kDryPivot = 1e-4;  // of a node whose neighbours do not determine its fit

// Monomials of degree 0 .. q in z, by ascending degree; the linear ones come first after 1.
template <class S> int monomials(int d, int q, const S* z, S* out) {
  int count = 0;
  for (int degree = 0; degree <= q; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= (d == 2 ? degree - a : 0); --b) {
        S value = S(1);
        for (int k = 0; k < a; ++k) value *= z[0];
        for (int k = 0; k < b; ++k) value *= z[1];
        for (int k = 0; k < degree - a - b; ++k) value *= z[2];
        out[count++] = value;
      }
  return count;
}

constexpr int kMaxMonomials = 35;

// Indices into monomials(): all of degree 0 .. q.
std::vector<int> all_monomials(int d, int q) {
  std::vector<int> found(monomial_count(d, q));
  std::iota(found.begin(), found.end(), 0);
  return found;
}

// Those of a polynomial whose slope along z_axis vanishes in the plane z_axis = 0: no monomial has z_axis once. Of
// degree 2 z_axis alone is left out.
std::vector<int> with_given_slope(int d, int q, int axis) {
  std::vector<int> found;
  int index = 0;
  for (int degree = 0; degree <= q; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= (d == 2 ? degree - a : 0); --b, ++index) {
        const int power[3] = {a, b, degree - a - b};
        if (power[axis] != 1 || (q == 2 && degree > 1)) found.push_back(index);
      }
  return found;
}

// a with M a = e_0, M n by n, row-major, overwritten; false: singular.
template <class S> bool solve_first_unit(int n, S* M, S* a) {
  for (int i = 0; i < n; ++i) {
    const S diagonal = M[i * n + i];
    S pivot = diagonal;
    for (int k = 0; k < i; ++k) pivot -= M[i * n + k] * M[i * n + k];
    if (!(pivot > S(kDryPivot) * diagonal)) return false;
    M[i * n + i] = real::sqrt(pivot);
    for (int j = i + 1; j < n; ++j) {
      S sum = M[j * n + i];
      for (int k = 0; k < i; ++k) sum -= M[j * n + k] * M[i * n + k];
      M[j * n + i] = sum / M[i * n + i];
    }
  }
  for (int i = 0; i < n; ++i) {
    S sum = i == 0 ? S(1) : S(0);
    for (int k = 0; k < i; ++k) sum -= M[i * n + k] * a[k];
    a[i] = sum / M[i * n + i];
  }
  for (int i = n - 1; i >= 0; --i) {
    S sum = a[i];
    for (int k = i + 1; k < n; ++k) sum -= M[k * n + i] * a[k];
    a[i] = sum / M[i * n + i];
  }
  return true;
}

}  // namespace

template <class S>
bool NodeFits<S>::around(const Neighbours<S>& lists, const S* records, int slot, int axis, S sign,
                         NodeWeights<S>& weights) const {
  const int d = dimensions, lane = slot % kLaneCount;
  const int highest = axis < 0 ? degree : std::max(degree, slope_degree), count = monomial_count(d, highest);
  const NeighbourBlock block = lists.block(slot / kLaneCount);
  S M[kMaxMonomials * kMaxMonomials]{}, a[kMaxMonomials], p[kMaxMonomials];
  weights.slots.clear();
  weights.distance.clear();
  weights.given_slope.clear();
  std::vector<S> basis, w;  // `count` values and one value a neighbour
  for (int n = 0; n < block.counts[lane]; ++n) {
    const int other = block.entries[n * kLaneCount + lane];
    if (lists.order()[other] >= particles) continue;
    S z[3]{}, r2{};
    for (int c = 0; c < d; ++c) {
      z[c] = records[std::ptrdiff_t(other) * kFitRecord + c] - records[std::ptrdiff_t(slot) * kFitRecord + c];
      if (lists.period(c) > S(0)) z[c] = nearest_image(z[c], lists.period(c));
      r2 += z[c] * z[c];
    }
    const S s = real::sqrt(r2) / support;
    if (!(s < S(1))) continue;
    weights.slots.push_back(other);
    weights.distance.push_back(axis < 0 ? S(0) : sign * z[axis]);
    for (int c = 0; c < d; ++c) z[c] = z[c] / (S(0.5) * support);
    monomials(d, highest, z, p);
    basis.insert(basis.end(), p, p + count);
    w.push_back(kernel_value<S>(shape, s));
    for (int i = 0; i < count; ++i)
      for (int j = 0; j <= i; ++j) M[i * count + j] += w.back() * p[i] * p[j];
  }
  const int found = static_cast<int>(w.size());
  // The value at the node of the polynomial with some of the monomials.
  const auto value = [&](const std::vector<int>& used, std::vector<S>& by) {
    S some[kMaxMonomials * kMaxMonomials];
    const int some_count = static_cast<int>(used.size());
    if (found < some_count) return false;
    for (int k = 0; k < some_count; ++k)
      for (int l = 0; l <= k; ++l) some[k * some_count + l] = M[used[k] * count + used[l]];
    if (!solve_first_unit(some_count, some, a)) return false;
    by.assign(found, S(0));
    for (int n = 0; n < found; ++n) {
      for (int k = 0; k < some_count; ++k) by[n] += a[k] * basis[n * count + used[k]];
      by[n] = w[n] * by[n];
    }
    return true;
  };
  if (!value(all_monomials(d, degree), weights.unconstrained)) return false;
  return axis < 0 || value(with_given_slope(d, slope_degree, axis), weights.given_slope) ||
         (slope_degree > degree && value(with_given_slope(d, degree, axis), weights.given_slope));
}

template struct NodeFits<float>;
template struct NodeFits<double>;
template struct NodeFits<long double>;
template struct NodeFits<Quad>;

}  // namespace atwood::fluid
