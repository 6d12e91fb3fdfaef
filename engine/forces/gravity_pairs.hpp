// Mutual gravity by direct sums over structures of arrays: lanes run over the attracted bodies, the loop over the
// attracting ones, in index order.
//
//   a_i += sum_j Gm_j r_ij / (|r_ij|^2 + eps^2)^(3/2),   r_ij = r_j - r_i,  j = from .. to - 1 without i
//
// Each term is computed as the loop over pairs of mutual_gravity.cpp computes it (IEEE square root and division, each
// rounded once), and each body's sum runs in the same order, so the bits are that loop's, at every vector width and
// however the bodies are shared out among threads. A pair is computed twice, once for each of its bodies: N (N - 1)
// interactions.
#pragma once

#include "math/vector_width.hpp"

namespace atwood {

// Attracted bodies per block; arrays of targets and sums are padded to whole blocks.
inline constexpr int kGravityBlock = 16;
constexpr int whole_blocks(int bodies) { return (bodies + kGravityBlock - 1) / kGravityBlock; }

template <class S> struct PointMasses {
  const S *x_m, *y_m, *z_m;  // whole blocks; the padding must be finite
  const S* Gm_m3_per_s2;
};
template <class S> struct Accelerations { S *x, *y, *z; };  // [m/s^2], whole blocks; added to

// The acceleration by bodies [from, to) of each body of blocks [first_block, last_block). In float and double.
template <class S>
void add_gravity(VectorWidth width, const PointMasses<S>& bodies, int from, int to, S softening2_m2, int first_block,
                 int last_block, const Accelerations<S>& sums);

}  // namespace atwood
