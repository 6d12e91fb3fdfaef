#include "fluid/polynomial_nodes.hpp"

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
  const int d = dimensions, lane = slot % kLaneCount, count = monomial_count(d, degree);
  const NeighbourBlock block = lists.block(slot / kLaneCount);
  S M[kMaxMonomials * kMaxMonomials]{}, a[kMaxMonomials], p[kMaxMonomials];
  weights.slots.clear();
  weights.distance.clear();
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
    monomials(d, degree, z, p);
    basis.insert(basis.end(), p, p + count);
    w.push_back(kernel_value<S>(shape, s));
    for (int i = 0; i < count; ++i)
      for (int j = 0; j <= i; ++j) M[i * count + j] += w.back() * p[i] * p[j];
  }
  const int found = static_cast<int>(w.size());
  if (found < count) return false;
  // The value at the node of the polynomial with the monomials that `left_out` leaves.
  const auto value = [&](int left_out, std::vector<S>& by) {
    S some[kMaxMonomials * kMaxMonomials];
    const int fewer = left_out < 0 ? count : count - 1;
    const auto monomial = [&](int k) { return left_out < 0 || k < left_out ? k : k + 1; };
    for (int k = 0; k < fewer; ++k)
      for (int l = 0; l <= k; ++l) some[k * fewer + l] = M[monomial(k) * count + monomial(l)];
    if (!solve_first_unit(fewer, some, a)) return false;
    by.assign(found, S(0));
    for (int n = 0; n < found; ++n) {
      for (int k = 0; k < fewer; ++k) by[n] += a[k] * basis[n * count + monomial(k)];
      by[n] = w[n] * by[n];
    }
    return true;
  };
  return value(-1, weights.unconstrained) && (axis < 0 || value(1 + axis, weights.given_slope));
}

template struct NodeFits<float>;
template struct NodeFits<double>;
template struct NodeFits<long double>;
template struct NodeFits<Quad>;

}  // namespace atwood::fluid
