#include "fluid/polynomial_walls.hpp"

#include <cmath>
#include <stdexcept>

#include "fluid/polynomial_basis.hpp"
#include "scene/fluid_walls.hpp"

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

constexpr int kMostMonomials = 35;

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

// Neighbours of a node among the particles, with their weights in the value there.
template <class S> struct PolynomialWalls<S>::Weights {
  std::vector<int> slots;
  std::vector<S> distance, free, sloped;  // distance along the normal; free: no condition; sloped: normal slope given
};

template <class S>
PolynomialWalls<S>::PolynomialWalls(const Scene& scene, const ParticleSet<S>& set, KernelShape shape, int degree,
                                    S support)
    : scene_(scene), set_(set), shape_(shape), dimensions_(scene.domain.dimensions), degree_(degree),
      support_(support) {
  spacing_ = S(scene.fluids.front().spacing_m);
  const Fluid& fluid = scene.fluids.front();
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[boundary.body];
    const auto* plane = std::get_if<Plane>(&body.shape);
    if (plane == nullptr || !body.fixed) {
      unsupported_ = "+polynomial has walls along fixed planes only; the boundary `" + body.name + "` is another";
      return;
    }
    Wall wall{};
    wall.body = boundary.body;
    wall.axis = -1;
    for (int c = 0; c < dimensions_; ++c)
      if (std::abs(plane->normal[c]) == 1) wall.axis = c;
    if (wall.axis < 0) {
      unsupported_ = "the plane of the boundary `" + body.name + "` is across no axis";
      return;
    }
    wall.sign = S(plane->normal[wall.axis]);
    wall.offset = S(plane->offset_m);
    for (int c = 0; c < dimensions_; ++c) wall.velocity[c] = S(body.velocity_m_per_s[c]);
    wall.no_slip = boundary.slip == Slip::no_slip;
    wall.has_temperature = boundary.temperature_K.has_value();
    wall.temperature = S(boundary.temperature_K.value_or(0));
    if (boundary.heat_flux_W_per_m2.has_value() && fluid.conductivity_W_per_m_K > 0)
      wall.slope = -S(*boundary.heat_flux_W_per_m2) / S(fluid.conductivity_W_per_m_K);
    walls_.push_back(wall);
  }
  // The first layer of the walls' points, moved to the surface, carries the nodes.
  try {
    const double spacing = fluid.spacing_m;
    std::vector<S> dummies;
    for (const WallPoint& point : wall_points(scene, static_cast<double>(support))) {
      const Wall& wall = walls_[point.boundary];
      const Body& own = scene.bodies[wall.body];
      Real3 at = point.at_m;
      const double depth = depth_in_body_m(own, dimensions_, at);
      for (int c = 0; c < dimensions_; ++c) dummies.push_back(S(at[c]));
      if (depth > spacing) continue;
      at[wall.axis] = static_cast<double>(wall.sign * wall.offset);
      bool behind = false;
      for (const Wall& other : walls_)
        behind =
            behind || (&other != &wall && depth_in_body_m(scene.bodies[other.body], dimensions_, at) > -1e-9 * spacing);
      if (behind) continue;
      for (int c = 0; c < dimensions_; ++c) positions_.push_back(S(at[c]));
      wall_of_.push_back(point.boundary);
    }
    nodes_ = static_cast<int>(wall_of_.size());
    positions_.insert(positions_.end(), dummies.begin(), dummies.end());
  } catch (const std::invalid_argument& error) {
    unsupported_ = error.what();
  }
}

template <class S> S PolynomialWalls<S>::widest_support() const { return (S(1) + S(kWidening)) * support_; }

template <class S> S PolynomialWalls<S>::support_at(const S* x) const {
  S near{};
  for (const Wall& wall : walls_) {
    const S s = real::abs(wall.sign * x[wall.axis] - wall.offset) / support_;
    if (s < S(1)) near = real::max(near, (S(1) - s) * (S(1) - s) * (S(1) + S(2) * s));
  }
  return (S(1) + S(kWidening) * near) * support_;
}

template <class S>
bool PolynomialWalls<S>::extrapolate(const Neighbours<S>& lists, const S* records, int slot, const Wall& wall,
                                     Weights& weights) const {
  const int d = dimensions_, record = 8, particles = set_.layout.particles, lane = slot % kLaneCount;
  const NeighbourBlock block = lists.block(slot / kLaneCount);
  const S reach = widest_support();
  S M[2][kMostMonomials * kMostMonomials]{}, a[2][kMostMonomials], p[kMostMonomials];
  const int count = monomial_count(d, degree_ < 3 ? 2 : kWallDegree);
  const int q = degree_ < 3 ? 2 : kWallDegree, normal = 1 + wall.axis;
  weights.slots.clear();
  weights.distance.clear();
  weights.free.clear();
  weights.sloped.clear();
  std::vector<S>& basis = weights.free;  // count values a neighbour, until the end
  std::vector<S> w;
  for (int n = 0; n < block.counts[lane]; ++n) {
    const int other = block.entries[n * kLaneCount + lane];
    if (lists.order()[other] >= particles) continue;
    S z[3]{}, r2{};
    for (int c = 0; c < d; ++c) {
      S x = records[std::ptrdiff_t(other) * record + c] - records[std::ptrdiff_t(slot) * record + c];
      if (lists.period(c) > S(0)) x = nearest_image(x, lists.period(c));
      r2 += x * x;
      z[c] = x;
    }
    const S s = real::sqrt(r2) / reach;
    if (!(s < S(1))) continue;
    weights.slots.push_back(other);
    weights.distance.push_back(wall.sign * z[wall.axis]);
    for (int c = 0; c < d; ++c) z[c] = z[c] / (S(0.5) * reach);
    monomials(d, q, z, p);
    basis.insert(basis.end(), p, p + count);
    w.push_back(kernel_value<S>(shape_, s));
    for (int i = 0; i < count; ++i)
      for (int j = 0; j <= i; ++j) M[0][i * count + j] += w.back() * p[i] * p[j];
  }
  const int found = static_cast<int>(w.size());
  if (found < count) return false;
  // The same without the monomial along the normal, whose coefficient is given.
  const int fewer = count - 1;
  for (int i = 0, k = 0; i < count; ++i) {
    if (i == normal) continue;
    for (int j = 0, l = 0; j <= i; ++j) {
      if (j == normal) continue;
      M[1][k * fewer + l++] = M[0][i * count + j];
    }
    ++k;
  }
  if (!solve_first_unit(count, M[0], a[0]) || !solve_first_unit(fewer, M[1], a[1])) return false;
  weights.sloped.resize(found);
  std::vector<S> free(found);
  for (int n = 0; n < found; ++n) {
    S one{}, two{};
    for (int i = 0, k = 0; i < count; ++i) {
      one += a[0][i] * basis[n * count + i];
      if (i != normal) two += a[1][k++] * basis[n * count + i];
    }
    free[n] = w[n] * one;
    weights.sloped[n] = w[n] * two;
  }
  weights.free = free;
  return true;
}

template <class S> void PolynomialWalls<S>::fill(const Neighbours<S>& lists, S* records, SlotWeight<S>* weights) const {
  const int d = dimensions_, record = 8, particles = set_.layout.particles;
  Weights around;
  for (int w = 0; w < count(); ++w) {
    const int slot = lists.slot_of()[particles + w];
    weights[slot] = {S(0), w < nodes_ ? S(0) : S(1)};
    if (w >= nodes_) continue;
    const Wall& wall = walls_[wall_of_[w]];
    if (!extrapolate(lists, records, slot, wall, around)) continue;  // dry
    weights[slot].fit = S(1);
    S* const own = records + std::ptrdiff_t(slot) * record;
    const auto value = [&](const std::vector<S>& by, int field, S slope) {
      S sum{};
      for (std::size_t n = 0; n < around.slots.size(); ++n)
        sum += by[n] * (records[std::ptrdiff_t(around.slots[n]) * record + field] - slope * around.distance[n]);
      return sum;
    };
    for (int c = 0; c < d; ++c)
      own[d + c] = wall.no_slip || c == wall.axis ? wall.velocity[c] : value(around.sloped, d + c, S(0));
    own[2 * d] = value(around.free, 2 * d, S(0));
    if (set_.layout.temperature)
      own[2 * d + 1] = wall.has_temperature ? wall.temperature : value(around.sloped, 2 * d + 1, wall.slope);
  }
}

template <class S> std::string PolynomialWalls<S>::crossed(const S* x) const {
  for (const Wall& wall : walls_)
    if (wall.sign * x[wall.axis] - wall.offset < -S(0.5) * spacing_) return scene_.bodies[wall.body].name;
  return "";
}

template class PolynomialWalls<float>;
template class PolynomialWalls<double>;
template class PolynomialWalls<long double>;
template class PolynomialWalls<Quad>;

}  // namespace atwood::fluid
