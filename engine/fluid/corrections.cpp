#include "fluid/corrections.hpp"

namespace atwood::fluid {
namespace {

// each(j, V_j F_ij, x_ij) for the neighbours of a slot.
template <class S, class Each> void for_neighbours(const CorrectionData<S>& data, int slot, const Each& each) {
  const NeighbourBlock block = data.lists.block(slot / kLaneCount);
  for (int n = 0; n < block.longest; ++n) {
    const int j = block.entries[n];
    if (j == slot) continue;
    S x[3]{}, r2{};
    for (int c = 0; c < data.dimensions; ++c) {
      x[c] = data.records[std::ptrdiff_t(slot) * kRecordSize + c] - data.records[std::ptrdiff_t(j) * kRecordSize + c];
      if (data.lists.period(c) > S(0)) x[c] = nearest_image(x[c], data.lists.period(c));
      r2 += x[c] * x[c];
    }
    if (beyond_support(data.kernel, r2)) continue;
    const S F = data.kernel.slope_over_distance(real::sqrt(r2));
    if (F != S(0)) each(j, data.masses[j] / data.densities[j] * F, x);
  }
}

template <class S> S velocity(const CorrectionData<S>& data, int slot, int c) {
  return data.records[std::ptrdiff_t(slot) * kRecordSize + data.dimensions + c];
}

// The inverse of a symmetric matrix of d rows; the identity where its determinant is below 0.01.
template <class S> void invert(int d, const S (&m)[3][3], S (&inverse)[3][3]) {
  S full[3][3];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) full[a][b] = a < d && b < d ? m[a][b] : S(a == b ? 1 : 0);
  S cofactor[3][3];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      cofactor[a][b] = full[a1][b1] * full[a2][b2] - full[a1][b2] * full[a2][b1];
    }
  const S determinant = full[0][0] * cofactor[0][0] + full[0][1] * cofactor[0][1] + full[0][2] * cofactor[0][2];
  const bool singular = !(determinant >= S(0.01));
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) inverse[a][b] = singular ? S(a == b ? 1 : 0) : cofactor[b][a] / determinant;
}

}  // namespace

template <class S> void add_corrected_gradients(const CorrectionData<S>& data, int first, int last, S* sums) {
  const int d = data.dimensions;
  for (int i = first; i < last; ++i) {
    S moment[3][3]{}, inverse[3][3], pressed[3]{}, stretched[3][3]{};
    for_neighbours(data, i, [&](int j, S weight, const S* x) {
      for (int a = 0; a < d; ++a) {
        pressed[a] += weight * (data.pressures[i] - data.pressures[j]) * x[a];
        for (int b = 0; b < d; ++b) {
          moment[a][b] -= weight * x[a] * x[b];
          stretched[a][b] += weight * (velocity(data, i, a) - velocity(data, j, a)) * x[b];
        }
      }
    });
    invert(d, moment, inverse);
    S* const out = sums + std::ptrdiff_t(i) * SumRecord::size;
    S divergence{};
    for (int a = 0; a < d; ++a)
      for (int b = 0; b < d; ++b) {
        out[SumRecord::acceleration + a] += inverse[a][b] * pressed[b] / data.densities[i];
        divergence += inverse[a][b] * stretched[a][b];
      }
    out[SumRecord::density] += data.densities[i] * divergence;
  }
}

template void add_corrected_gradients<float>(const CorrectionData<float>&, int, int, float*);
template void add_corrected_gradients<double>(const CorrectionData<double>&, int, int, double*);
template void add_corrected_gradients<long double>(const CorrectionData<long double>&, int, int, long double*);
template void add_corrected_gradients<Quad>(const CorrectionData<Quad>&, int, int, Quad*);

}  // namespace atwood::fluid
