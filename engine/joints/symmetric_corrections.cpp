// What symmetric projections ask of the constraints: displacements by given multipliers, and the multipliers of a gap.
#include <algorithm>

#include "joints/constraints.hpp"
#include "joints/planar_loops.hpp"

namespace atwood {

// W^T (W G^T x) = M^-1 G^T x.
template <class S> void Constraints<S>::displace(const S* at, const Multipliers& by, S* y) {
  refactor(at);
  const auto displacement = [&](const Group& group, const std::vector<S>& multipliers) {
    std::fill(change_.begin(), change_.end(), S(0));
    std::fill(z_.begin(), z_.end(), S(0));
    std::vector<S>& column = b_;
    for (const int r : group.rows) {
      if (multipliers[r] == S(0)) continue;
      whiten(rows_[r], column.data());
      for (int i = 0; i < group.size(); ++i) z_[i] += multipliers[r] * column[i];
    }
    unwhiten(group, z_.data(), change_.data());
  };
  for (const Group& group : groups_) {
    displacement(group, by.position);
    apply_change(group, change_.data(), y);
    displacement(group, by.rate);
    for (std::size_t k = 0; k < change_.size(); ++k)
      if (change_[k] != S(0)) y[tree_.state_of_rate(static_cast<int>(k))] += change_[k];
  }
}

// Twice the kinetic energy is the square of the length of a whitened vector of rates.
template <class S> S Constraints<S>::speed_scale() const {
  S square = S(0);
  for (std::size_t i = 0; i < tree_.links().size(); ++i) {
    const Link<S>& link = tree_.links()[i];
    const LinkMotion<S>& m = tree_.motion(static_cast<int>(i));
    const Vec3<S> v = m.v + cross(m.w, m.r);
    square += link.mass_kg * dot(v, v) + (link.J_B.xx + link.J_B.yy + link.J_B.zz) * dot(m.w, m.w);
  }
  return real::sqrt(square);
}

template <class S> S Constraints<S>::add_half_correction(const S* y, Multipliers& by, S speed) {
  refactor(y);
  const S round_off = S(16) * real::epsilon<S>();
  speed = real::max(speed, speed_scale());
  S worst = worst_value(true);
  for (std::size_t k = 0; k < scratch_.size(); ++k) scratch_[k] = y[tree_.state_of_rate(static_cast<int>(k))];
  const auto add = [&](Group& group, std::vector<S>& to) {
    group.qr.solve(b_.data(), z_.data());
    group.qr.multipliers(x_.data());
    for (std::size_t j = 0; j < group.used.size(); ++j) to[group.used[j]] += x_[j] * rows_[group.used[j]].scale / S(2);
  };
  for (Group& group : groups_) {
    factor(group, false, S(1024) * real::epsilon<S>());
    if (group.used.empty()) continue;
    for (std::size_t j = 0; j < group.used.size(); ++j) {
      const Row& row = rows_[group.used[j]];
      b_[j] = row.rate >= 0 ? S(0) : -row.scale * row.row.value;
    }
    add(group, by.position);
    missing_rates(group);
    add(group, by.rate);
    S square = S(0);
    for (int i = 0; i < group.size(); ++i) square += z_[i] * z_[i];
    if (square > S(0)) worst = real::max(worst, real::sqrt(square) / (round_off * speed));
  }
  return worst;
}

#define ATWOOD_SYMMETRIC(S)                                                 \
  template void Constraints<S>::displace(const S*, const Multipliers&, S*); \
  template S Constraints<S>::speed_scale() const;                           \
  template S Constraints<S>::add_half_correction(const S*, Multipliers&, S);
ATWOOD_SYMMETRIC(float)
ATWOOD_SYMMETRIC(double)
ATWOOD_SYMMETRIC(long double)
ATWOOD_SYMMETRIC(Quad)
#undef ATWOOD_SYMMETRIC

}  // namespace atwood
