#include "fluid/walls.hpp"

#include <algorithm>
#include <stdexcept>

#include "collision/geometry.hpp"
#include "scene/fluid_walls.hpp"

namespace atwood::fluid {

template <class S> struct Walls<S>::FluidLoad final : ForceTerm<S> {
  const std::vector<Load<S>>& of;
  explicit FluidLoad(const std::vector<Load<S>>& loads) : of(loads) {}
  void add_loads(const Motion<S>&, Load<S>* loads) const override {
    for (std::size_t b = 0; b < of.size(); ++b) {
      loads[b].force_W += of[b].force_W;
      loads[b].torque_B += of[b].torque_B;
    }
  }
  bool velocity_dependent() const override { return true; }
};

// The terms of one wall point in the rates of one particle.
template <class S> struct Walls<S>::WallPairTerms {
  Vec3<S> acceleration;
  S density{}, heat{};
};

namespace {

// sum of D^d W over the points D (a, b, c), a = 1, 2, ..., b and c whole: a wall point beside a fluid on a lattice.
template <class S> S lattice_beside(const Kernel<S>& kernel, int d, S spacing, S volume) {
  const int reach = static_cast<int>(kernel.support / spacing) + 1, deep = d == 3 ? reach : 0;
  S sum{};
  for (int a = 1; a <= reach; ++a)
    for (int b = -reach; b <= reach; ++b)
      for (int c = -deep; c <= deep; ++c) sum += kernel.value(spacing * real::sqrt(S(a * a + b * b + c * c)));
  return volume * sum;
}

// 0 at 0, 1 from 1 on, with two continuous derivatives.
template <class S> S smooth_step(S z) { return z >= S(1) ? S(1) : z * z * z * (S(10) + z * (S(6) * z - S(15))); }

}  // namespace

template <class S>
Walls<S>::Walls(const Scene& scene, const ParticleSet<S>& set, const PairSums<S>& sums, RigidModel<S>* bodies)
    : scene_(scene), set_(set), sums_(sums), bodies_(bodies) {
  const int d = scene.domain.dimensions;
  const S spacing = S(scene.fluids.front().spacing_m);
  volume_ = d == 2 ? spacing * spacing : spacing * spacing * spacing;
  for (int c = 0; c < d; ++c) gravity_[c] = S(scene.gravity_m_per_s2[c]);
  try {
    for (const WallPoint& point : wall_points(scene, static_cast<double>(sums.kernel.support)))
      points_.push_back({point.boundary, scene.fluid_boundaries[point.boundary].body, narrow3<S>(point.at_m),
                         S(point.area_m2) * S(scene.fluid_boundaries[point.boundary].heat_flux_W_per_m2.value_or(0))});
  } catch (const std::invalid_argument& refused) {
    unsupported_ = "+sph: " + std::string(refused.what());
    return;
  }
  for (const FluidBoundary& boundary : scene.fluid_boundaries)
    if (scene.bodies[boundary.body].fixed) add_barrier(scene.bodies[boundary.body]);
  half_lattice_sum_ = lattice_beside(sums.kernel, d, spacing, volume_);
  const std::size_t count = points_.size();
  x_.resize(count * d);
  u_.resize(count * d);
  slip_.resize(count * d);
  weight_.resize(count);
  pressure_.resize(count);
  density_.resize(count);
  temperature_.resize(count);
  heating_.resize(count);
  loads_.resize(scene.bodies.size());
  if (bodies->state_size() > 0) bodies->add_term(std::make_unique<FluidLoad>(loads_), "the fluid");
}

template <class S> void Walls<S>::place(S t_s, const S* y_bodies) {
  const int d = scene_.domain.dimensions;
  const Motion<S> motion = bodies_->motion(t_s, y_bodies);
  for (int w = 0; w < count(); ++w) {
    const Point& point = points_[w];
    const Body& body = scene_.bodies[point.body];
    Vec3<S> x = point.at, u = narrow3<S>(body.velocity_m_per_s);
    if (!body.fixed) {
      const Quat<S> q = motion.q_WB(point.body);
      const Vec3<S> arm = rotate(q, point.at);
      x = motion.p_WB(point.body) + arm;
      u = motion.v_WB(point.body) + cross(rotate(q, motion.w_WB_B(point.body)), arm);
    }
    const S of_x[3] = {x.x, x.y, x.z}, of_u[3] = {u.x, u.y, u.z};
    for (int c = 0; c < d; ++c) x_[w * d + c] = of_x[c], u_[w * d + c] = of_u[c];
  }
}

namespace {

// x_i - x_j of two slots by the nearest image; returns r^2.
template <class S> S difference(const Neighbours<S>& lists, const S* records, int d, int i, int j, S* x) {
  S r2{};
  for (int c = 0; c < d; ++c) {
    x[c] = records[std::ptrdiff_t(i) * kRecordSize + c] - records[std::ptrdiff_t(j) * kRecordSize + c];
    if (lists.period(c) > S(0)) x[c] = nearest_image(x[c], lists.period(c));
    r2 += x[c] * x[c];
  }
  return r2;
}

}  // namespace

template <class S>
void Walls<S>::extrapolate(const Neighbours<S>& lists, const S* records, const S* densities, const S* y) {
  const Layout& at = set_.layout;
  const int d = at.dimensions;
  if (flagged_build_ != lists.builds()) {
    flagged_build_ = lists.builds();
    near_wall_.assign(lists.blocks(), 0);
    for (int slot = 0; slot < lists.count(); ++slot) {
      if (lists.order()[slot] < at.particles) continue;
      const NeighbourBlock block = lists.block(slot / kLaneCount);
      for (int n = 0; n < block.longest; ++n) near_wall_[block.entries[n] / kLaneCount] = 1;
    }
  }
  for (int w = 0; w < count(); ++w) {
    const int slot = lists.slot_of()[at.particles + w];
    const NeighbourBlock block = lists.block(slot / kLaneCount);
    S weight{}, filled{}, pressure{}, temperature{}, velocity[3]{};
    for (int n = 0; n < block.longest; ++n) {
      const int other = block.entries[n], f = lists.order()[other];
      if (f >= at.particles) continue;
      S x[3];
      const S r2 = difference(lists, records, d, slot, other, x);
      if (beyond_support(sums_.kernel, r2)) continue;
      const S W = sums_.kernel.value(real::sqrt(r2));
      if (W == S(0)) continue;
      S lift{};
      for (int c = 0; c < d; ++c) {
        lift += gravity_[c] * x[c];
        velocity[c] += W * y[at.velocities() + f * d + c];
      }
      weight += W;
      filled += set_.mass[f] / densities[other] * W;
      pressure += W * (law().pressure(densities[other]) + densities[other] * lift);
      if (at.temperature) temperature += W * y[at.temperatures() + f];
    }
    weight_[w] = weight;
    const S inverse = weight > S(0) ? S(1) / weight : S(0);
    for (int c = 0; c < d; ++c) slip_[w * d + c] = inverse * velocity[c];
    pressure_[w] = inverse * pressure;
    density_[w] = law().density(pressure_[w]);
    temperature_[w] = inverse * temperature;
    const S power = points_[w].power;
    heating_[w] =
        power != S(0) && filled > S(0) ? power * smooth_step(S(3) * filled / half_lattice_sum_) / filled : S(0);
  }
}

// The terms of docs/fluids.md, "Walls", of one particle and one point.
template <class S>
auto Walls<S>::wall_pair_terms(const Neighbours<S>& lists, const S* records, const S* densities, const S* y, int slot,
                               int wall_slot) const -> WallPairTerms {
  const Layout& at = set_.layout;
  const int d = at.dimensions, i = lists.order()[slot], w = lists.order()[wall_slot] - at.particles;
  WallPairTerms terms;
  if (weight_[w] == S(0)) return terms;
  S x[3]{}, v[3]{}, slip[3]{}, approach{}, drag_approach{}, r2 = difference(lists, records, d, slot, wall_slot, x);
  if (beyond_support(sums_.kernel, r2)) return terms;
  const S F = sums_.kernel.slope_over_distance(real::sqrt(r2));
  if (F == S(0)) return terms;
  for (int c = 0; c < d; ++c) {
    v[c] = y[at.velocities() + i * d + c] - u_[w * d + c];
    slip[c] = y[at.velocities() + i * d + c] - (S(2) * u_[w * d + c] - slip_[w * d + c]);
    approach += v[c] * x[c];
    drag_approach += slip[c] * x[c];
  }
  const FluidBoundary& boundary = scene_.fluid_boundaries[points_[w].boundary];
  const S* const record = records + std::ptrdiff_t(slot) * kRecordSize;
  const S push = -mass() * (record[2 * d] + pressure_[w] / (density_[w] * density_[w])) * F;
  const S per_volume = mass() * F / (densities[slot] * density_[w]);
  S a[3]{};
  for (int c = 0; c < d; ++c) a[c] = push * x[c];
  if (boundary.slip == Slip::no_slip && sums_.viscosity != Viscosity::none) {
    const S T_i = at.temperature ? y[at.temperatures() + i] : law().temperature0;
    const S viscosity = law().dynamic_viscosity(T_i);
    const S drag = S(2) * viscosity * per_volume;
    S power{};
    for (int c = 0; c < d; ++c) {
      const S A = sums_.viscosity == Viscosity::morris ? drag * slip[c]
                  : r2 > S(0)                          ? S(d + 2) * drag * drag_approach / r2 * x[c]
                                                       : S(0);
      a[c] += A;
      power += A * v[c];
    }
    if (sums_.viscous_heat) terms.heat -= power;
  }
  if (boundary.temperature_K && at.temperature) {
    const S other = S(2) * S(*boundary.temperature_K) - temperature_[w];
    terms.heat += per_volume * S(2) * law().conductivity * (y[at.temperatures() + i] - other);
  }
  terms.density = mass() * F * approach;
  if (heating_[w] != S(0)) terms.heat += heating_[w] * sums_.kernel.value(real::sqrt(r2)) / densities[slot];
  terms.acceleration = {a[0], a[1], a[2]};
  return terms;
}

template <class S>
void Walls<S>::add_forces(const Neighbours<S>& lists, const S* records, const S* densities, const S* y, int first,
                          int last, S* sums) const {
  const Layout& at = set_.layout;
  for (int b = first; b < last; ++b) {
    if (!near_wall_[b]) continue;
    const NeighbourBlock block = lists.block(b);
    for (int lane = 0; lane < kLaneCount; ++lane) {
      const int slot = b * kLaneCount + lane;
      if (slot >= lists.count() || lists.order()[slot] >= at.particles) continue;
      S* const out = sums + std::ptrdiff_t(slot) * SumRecord::size;
      for (int n = 0; n < block.longest; ++n) {
        const int other = block.entries[n];
        if (lists.order()[other] < at.particles) continue;
        const WallPairTerms t = wall_pair_terms(lists, records, densities, y, slot, other);
        out[SumRecord::acceleration] += t.acceleration.x;
        out[SumRecord::acceleration + 1] += t.acceleration.y;
        out[SumRecord::acceleration + 2] += t.acceleration.z;
        out[SumRecord::density] += t.density;
        out[SumRecord::heat] += t.heat;
      }
    }
  }
}

// From the points' side, in their order: the same whatever the threads.
template <class S>
void Walls<S>::load_bodies(const Neighbours<S>& lists, const S* records, const S* densities, const S* y) {
  const Layout& at = set_.layout;
  const Motion<S> motion = bodies_->motion(S(0), y + at.bodies());
  for (Load<S>& load : loads_) load = {};
  for (int w = 0; w < count(); ++w) {
    const Point& point = points_[w];
    if (scene_.bodies[point.body].fixed || weight_[w] == S(0)) continue;
    const int wall_slot = lists.slot_of()[at.particles + w];
    const NeighbourBlock block = lists.block(wall_slot / kLaneCount);
    Vec3<S> force;
    for (int n = 0; n < block.longest; ++n) {
      const int slot = block.entries[n], i = lists.order()[slot];
      if (i >= at.particles) continue;
      force -= set_.mass[i] * wall_pair_terms(lists, records, densities, y, slot, wall_slot).acceleration;
    }
    loads_[point.body].force_W += force;
    if (bodies_->rotates(point.body))
      loads_[point.body].torque_B += cross(point.at, rotate_back(motion.q_WB(point.body), force));
  }
}

template <class S> std::string Walls<S>::boundary_behind(const S* x) const {
  const int d = scene_.domain.dimensions;
  for (const FluidBoundary& boundary : scene_.fluid_boundaries) {
    const Body& body = scene_.bodies[boundary.body];
    if (!body.fixed) continue;
    Real3 at{};
    for (int c = 0; c < d; ++c) at[c] = static_cast<double>(x[c]);
    if (depth_in_body_m(body, d, at) > scene_.fluids.front().spacing_m) return body.name;
  }
  return "";
}

template <class S> void Walls<S>::add_barrier(const Body& body) {
  const Real4& q = body.orientation_wxyz;
  const Aabb<double> box = bounds(make_geometry<double>(body.shape),
                                  transform(narrow3<double>(body.position_m), Quat<double>{q[0], q[1], q[2], q[3]}));
  Barrier barrier{std::holds_alternative<Plane>(body.shape),
                  {S(box.low.x), S(box.low.y), S(box.low.z)},
                  {S(box.high.x), S(box.high.y), S(box.high.z)}};
  if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    const int axis = normal_axis(*plane, scene_.domain.dimensions);
    const double across = plane->normal[axis];
    (across > 0 ? barrier.high : barrier.low)[axis] = S((plane->offset_m - scene_.fluids.front().spacing_m) / across);
  }
  barriers_.push_back(barrier);
}

template <class S> bool Walls<S>::some_may_be_behind(const S* x) const {
  return scene_.domain.dimensions == 2 ? some_may_be_behind<2>(x) : some_may_be_behind<3>(x);
}

template <class S> template <int d> bool Walls<S>::some_may_be_behind(const S* x) const {
  // The extent of all particles, by several of each extreme, so that a comparison need not wait for the one before.
  constexpr int parts = 4 * d;
  const int size = d * set_.layout.particles, whole = size - size % parts;
  S low[parts], high[parts];
  for (int k = 0; k < parts; ++k) low[k] = high[k] = x[k % d];
  for (int i = 0; i < whole; i += parts)
    for (int k = 0; k < parts; ++k) {
      low[k] = x[i + k] < low[k] ? x[i + k] : low[k];
      high[k] = x[i + k] > high[k] ? x[i + k] : high[k];
    }
  for (int i = whole; i < size; ++i) {
    low[i % d] = std::min(low[i % d], x[i]);
    high[i % d] = std::max(high[i % d], x[i]);
  }
  for (int k = d; k < parts; ++k) {
    low[k % d] = std::min(low[k % d], low[k]);
    high[k % d] = std::max(high[k % d], high[k]);
  }
  for (const Barrier& barrier : barriers_) {
    bool meets = true;
    for (int c = 0; c < d; ++c) meets = meets && low[c] <= barrier.high[c] && high[c] >= barrier.low[c];
    if (!meets) continue;
    if (barrier.plane) return true;
    for (int i = 0; i < size; i += d) {
      bool inside = true;
      for (int c = 0; c < d; ++c) inside = inside & (x[i + c] <= barrier.high[c]) & (x[i + c] >= barrier.low[c]);
      if (inside) return true;
    }
  }
  return false;
}

template class Walls<float>;
template class Walls<double>;
template class Walls<long double>;
template class Walls<Quad>;

}  // namespace atwood::fluid
