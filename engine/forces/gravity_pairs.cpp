#include "forces/gravity_pairs.hpp"

#include <algorithm>
#include <cmath>

namespace atwood {
namespace {

template <class S> struct Lanes { S x[kGravityBlock], y[kGravityBlock], z[kGravityBlock]; };

template <class S, class Arrays> ATWOOD_INLINE void load(const Arrays& from, int first, Lanes<S>& to) {
  for (int l = 0; l < kGravityBlock; ++l) to.x[l] = from.x[first + l];
  for (int l = 0; l < kGravityBlock; ++l) to.y[l] = from.y[first + l];
  for (int l = 0; l < kGravityBlock; ++l) to.z[l] = from.z[first + l];
}

// Adds the accelerations of the block by bodies [from, to). `meets_itself`: the sources include the block's own bodies;
// a lane whose body is the source uses a distance of 1, so its term is 0.
template <bool meets_itself, class S>
ATWOOD_INLINE void pull(const PointMasses<S>& bodies, int from, int to, S softening2_m2, int first, const Lanes<S>& at,
                        Lanes<S>& sum) {
  for (int j = from; j < to; ++j) {
    const S x = bodies.x_m[j], y = bodies.y_m[j], z = bodies.z_m[j], Gm = bodies.Gm_m3_per_s2[j];
    for (int l = 0; l < kGravityBlock; ++l) {
      const S rx = x - at.x[l], ry = y - at.y[l], rz = z - at.z[l];
      S r2 = rx * rx + ry * ry + rz * rz + softening2_m2;
      if constexpr (meets_itself) r2 = first + l == j ? S(1) : r2;
      const S inverse_cube = S(1) / (r2 * std::sqrt(r2));
      const S strength = Gm * inverse_cube;
      sum.x[l] += strength * rx;
      sum.y[l] += strength * ry;
      sum.z[l] += strength * rz;
    }
  }
}

// In index order: the sources before the block, those of the block itself, those behind it.
template <class S>
ATWOOD_INLINE void pull_block(const PointMasses<S>& bodies, int from, int to, S softening2_m2, int first,
                              const Accelerations<S>& sums) {
  Lanes<S> at, sum;
  struct {
    const S *x, *y, *z;
  } positions{bodies.x_m, bodies.y_m, bodies.z_m};
  load(positions, first, at);
  load(sums, first, sum);
  const int block_from = std::clamp(first, from, to), block_to = std::clamp(first + kGravityBlock, from, to);
  pull<false>(bodies, from, block_from, softening2_m2, first, at, sum);
  pull<true>(bodies, block_from, block_to, softening2_m2, first, at, sum);
  pull<false>(bodies, block_to, to, softening2_m2, first, at, sum);
  for (int l = 0; l < kGravityBlock; ++l) sums.x[first + l] = sum.x[l];
  for (int l = 0; l < kGravityBlock; ++l) sums.y[first + l] = sum.y[l];
  for (int l = 0; l < kGravityBlock; ++l) sums.z[first + l] = sum.z[l];
}

}  // namespace

template <class S>
void add_gravity(VectorWidth width, const PointMasses<S>& bodies, int from, int to, S softening2_m2, int first_block,
                 int last_block, const Accelerations<S>& sums) {
  at_width(
      width, [=]() __attribute__((always_inline)) {
        for (int block = first_block; block < last_block; ++block)
          pull_block(bodies, from, to, softening2_m2, block * kGravityBlock, sums);
      });
}

template void add_gravity(VectorWidth, const PointMasses<float>&, int, int, float, int, int,
                          const Accelerations<float>&);
template void add_gravity(VectorWidth, const PointMasses<double>&, int, int, double, int, int,
                          const Accelerations<double>&);

}  // namespace atwood
