#include "fluid/polynomial_surface.hpp"

#include <stdexcept>

#include "scene/fluid_surface.hpp"

namespace atwood::fluid {
namespace {

template <class S> S distance2(const S* a, const S* b, int d) {
  S sum{};
  for (int c = 0; c < d; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

}  // namespace

template <class S>
PolynomialSurface<S>::PolynomialSurface(const Scene& scene, const ParticleSet<S>& set, KernelShape shape, S support)
    : set_(set), dimensions_(scene.domain.dimensions),
      spacing_(S(scene.fluids.front().spacing_m)), fits_{shape, dimensions_,          2,
                                                         2,     set.layout.particles, (S(1) + S(kWidening)) * support} {
  try {
    for (const Real3& x : surface_points(scene))
      for (int c = 0; c < dimensions_; ++c) start_.push_back(S(x[c]));
  } catch (const std::invalid_argument& error) {
    unsupported_ = error.what();
    return;
  }
  const S near = S(kMaxSpacingsOfNeighbours) * spacing_;
  for (int a = 0; a < count(); ++a)
    for (int b = 0; b < a; ++b)
      if (distance2(&start_[a * dimensions_], &start_[b * dimensions_], dimensions_) < near * near)
        near_.push_back({a, b});
}

template <class S>
bool PolynomialSurface<S>::fill(const Neighbours<S>& lists, int first, S* records, SlotWeight<S>* weights, S* rates) {
  const int d = dimensions_;
  alone_ = false;
  for (int n = 0; n < count(); ++n) {
    const int slot = lists.slot_of()[first + n];
    if (!fits_.around(lists, records, slot, -1, S(1), around_)) {
      alone_ = true;
      for (int c = 0; c < d; ++c) alone_at_[c] = records[std::ptrdiff_t(slot) * kFitRecord + c];
      return false;
    }
    weights[slot] = {S(1), S(0), S(1)};
    S* const own = records + std::ptrdiff_t(slot) * kFitRecord;
    const auto value = [&](int field) {
      S sum{};
      for (std::size_t k = 0; k < around_.slots.size(); ++k)
        sum += around_.unconstrained[k] * records[std::ptrdiff_t(around_.slots[k]) * kFitRecord + field];
      return sum;
    };
    for (int c = 0; c < d; ++c) rates[n * d + c] = own[d + c] = value(d + c);
    own[2 * d] = set_.laws.front().density0;
    if (set_.layout.temperature) own[2 * d + 1] = value(2 * d + 1);
  }
  return true;
}

template <class S> std::string PolynomialSurface<S>::fault(const S* x) const {
  if (alone_)
    return "too few particles are near the free surface at " + position_text(alone_at_, dimensions_) +
           " to determine its velocity; +polynomial has no breaking surfaces";
  const S torn = S(kMaxSpacingsStretched) * spacing_;
  for (const auto& [a, b] : near_)
    if (distance2(x + a * dimensions_, x + b * dimensions_, dimensions_) > torn * torn)
      return "the free surface at " + position_text(x + a * dimensions_, dimensions_) +
             " is stretched: two of its nodes that began beside each other are more than " +
             format_double(kMaxSpacingsStretched) + " spacings apart; +polynomial has no breaking surfaces";
  return "";
}

template class PolynomialSurface<float>;
template class PolynomialSurface<double>;
template class PolynomialSurface<long double>;
template class PolynomialSurface<Quad>;

}  // namespace atwood::fluid
