// The narrow phase of all pairs but those of spheres and of spheres with planes: detects the manifolds of the step,
// transfers to them the impulses of the last step, and lays them out by colour.
#include <algorithm>

#include "contact/stepping/batch_layout.hpp"
#include "contact/stepping/contact_points.hpp"
#include "math/so3.hpp"

namespace atwood::stepping {
namespace {

// Shares of the smaller body's size:
constexpr double kContactMargin = 0.01;        // gap within which contacts are detected, beyond the motion bounds
constexpr double kImpulseMatchDistance = 0.1;  // distance within which points with other ids may be the same point
constexpr double kStaleMotion = 0.01;          // relative motion beyond which a manifold is stale
constexpr int kMinPairsForTeam = 32;

template <class S> Vec3<S> impulse_of(const ManifoldBatch<S>& batch, int k, int i) {
  const Vec3<S> n = lane_vector(batch.normal, k), t = lane_vector(batch.tangent, k);
  const ManifoldPoint<S>& point = batch.point[i];
  return point.impulse_n.lane[k] * n + point.impulse_t[0].lane[k] * t + point.impulse_t[1].lane[k] * cross(n, t);
}

// Copies the impulses of all batches to World::manifolds.
template <class S> void store_impulses(World<S>& world) {
  for (const ManifoldBatch<S>& batch : world.manifold_contacts.batches)
    for (int k = 0; k < batch.count; ++k) {
      ContactManifold<S>& manifold = world.manifolds[static_cast<std::size_t>(batch.manifold[k])];
      for (int i = 0; i < manifold.geometry.count; ++i) manifold.impulse_W[i] = impulse_of(batch, k, i);
    }
}

// Rotation vector since the step began.
template <class S> Vec3<S> rotation_of(const World<S>& world, int body) {
  return load3(world.bodies.pose[body].at + 3);
}
// Centre of mass.
template <class S> Vec3<S> position_of(const World<S>& world, int body) { return load3(world.bodies.pose[body].at); }

// q_WB now; BodyRows::q_WB is that of the beginning of the step.
template <class S> Quat<S> orientation(const World<S>& world, int body) {
  const Vec3<S> s = rotation_of(world, body);
  const Quat<S>& q = world.bodies.q_WB[body];
  return s.x == S(0) && s.y == S(0) && s.z == S(0) ? q : normalised(so3_exp(s) * q);
}

template <class S> S smaller_size(const World<S>& world, int a, int b) {
  return real::min(world.geometry[a].bounding_radius, world.geometry[b].bounding_radius);
}

template <class S> void detect_pair(const World<S>& world, int a, int b, S margin, std::vector<Manifold<S>>& out) {
  out.clear();
  find_contacts(world.geometry[a], transform(position_of(world, a), orientation(world, a)), world.geometry[b],
                transform(position_of(world, b), orientation(world, b)), margin, out);
}

// Sets `out` to the manifolds of the pairs [first, last); pairs whose bounding spheres are too far apart have none.
template <class S>
void detect_share(const World<S>& world, int first, int last, std::vector<Manifold<S>>& pair_manifolds,
                  std::vector<ContactManifold<S>>& out) {
  out.clear();
  for (int i = first; i < last; ++i) {
    const CandidatePair& pair = world.candidates.manifold_pairs[static_cast<std::size_t>(i)];
    const S margin = world.bodies.motion_bound[pair.a] + world.bodies.motion_bound[pair.b] +
                     S(kContactMargin) * smaller_size(world, pair.a, pair.b);
    if (world.geometry[pair.b].kind != ShapeKind::plane) {
      const Vec3<S> offset = position_of(world, pair.b) - position_of(world, pair.a);
      const S limit = world.geometry[pair.a].bounding_radius + world.geometry[pair.b].bounding_radius + margin;
      if (dot(offset, offset) > limit * limit) continue;
    }
    detect_pair(world, pair.a, pair.b, margin, pair_manifolds);
    for (const Manifold<S>& geometry : pair_manifolds) out.push_back({pair.a, pair.b, geometry, {}, 0, {}});
  }
}

// ---- warm start: from the manifolds of the last step to those of this one
bool pair_before(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) { return a != c ? a < c : b < d; }

// Points of equal id take over the impulse. Of those that are left (the ids change when the reference face changes from
// one body to the other), each new point takes that of the nearest old one within `distance_m`; each impulse is given
// once. Changes now.impulse_W.
template <class S> void transfer_impulses(const ContactManifold<S>& old, S distance_m, ContactManifold<S>& now) {
  bool given[4] = {}, matched[4] = {};
  for (int i = 0; i < now.geometry.count; ++i)
    for (int k = 0; k < old.geometry.count; ++k)
      if (!given[k] && !matched[i] && now.geometry.points[i].id == old.geometry.points[k].id) {
        now.impulse_W[i] = old.impulse_W[k];
        given[k] = matched[i] = true;
      }
  for (int i = 0; i < now.geometry.count; ++i) {
    int nearest = -1;
    S least = distance_m * distance_m;
    for (int k = 0; k < old.geometry.count && !matched[i]; ++k) {
      const Vec3<S> d = old.geometry.points[k].x_W - now.geometry.points[i].x_W;
      if (given[k] || !(dot(d, d) < least)) continue;
      least = dot(d, d);
      nearest = k;
    }
    if (nearest < 0) continue;
    now.impulse_W[i] = old.impulse_W[nearest];
    given[nearest] = true;
  }
}

// Of all manifolds: those of the same pair, and of the same pieces of compounds and meshes. Both lists are sorted by
// pair.
template <class S> void transfer_impulses(World<S>& world) {
  const auto& old = world.manifolds_before;
  std::size_t at = 0;
  for (ContactManifold<S>& now : world.manifolds) {
    const S distance_m = S(kImpulseMatchDistance) * smaller_size(world, now.a, now.b);
    while (at < old.size() && pair_before(old[at].a, old[at].b, now.a, now.b)) ++at;
    for (std::size_t j = at; j < old.size() && old[j].a == now.a && old[j].b == now.b; ++j)
      if (old[j].geometry.part_a == now.geometry.part_a && old[j].geometry.part_b == now.geometry.part_b)
        transfer_impulses(old[j], distance_m, now);
  }
}

// ---- layout of the batches
template <class S> ManifoldBatch<S> empty_batch(const World<S>& world) {
  ManifoldBatch<S> batch{};
  std::fill(std::begin(batch.a), std::end(batch.a), world.bodies.count);
  std::fill(std::begin(batch.b), std::end(batch.b), world.bodies.count);
  std::fill(batch.normal[2].lane, batch.normal[2].lane + kLaneCount, S(1));
  std::fill(batch.tangent[0].lane, batch.tangent[0].lane + kLaneCount, S(1));
  for (ManifoldPoint<S>& point : batch.point)
    std::fill(point.gap_at_detection.lane, point.gap_at_detection.lane + kLaneCount, S(kNoValue));
  return batch;
}

template <class S> Rounding<S> rounding_of(const World<S>& world, int body) {
  const Geometry<S>& shape = world.geometry[body];
  if (shape.kind == ShapeKind::cylinder) return {rotate(orientation(world, body), Vec3<S>{S(0), S(0), S(1)}), S(0)};
  return {{}, shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule ? shape.radius : S(0)};
}

// Where the contact point of two shapes lies between the surface points (advance_point): of a sphere on a slab it is
// below the sphere, wherever the slab slides; of a box on a plane it moves with the box's corners.
template <class S> S witness_offset(ShapeKind a, ShapeKind b) {
  const auto is_rounded = [](ShapeKind kind) {
    return kind == ShapeKind::sphere || kind == ShapeKind::capsule || kind == ShapeKind::cylinder;
  };
  if (b == ShapeKind::plane || (is_rounded(a) && !is_rounded(b))) return S(-0.5);
  return is_rounded(b) && !is_rounded(a) ? S(0.5) : S(0);
}

// Sets point i of lane k; a point that the manifold lacks is marked so. The impulse is split along the batch's frame.
template <class S>
void set_point(const World<S>& world, const ContactManifold<S>& manifold, int i, ManifoldBatch<S>& batch, int k) {
  ManifoldPoint<S>& point = batch.point[i];
  if (i >= manifold.geometry.count) {
    point.gap_at_detection.lane[k] = S(kNoValue);
    point.impulse_n.lane[k] = point.impulse_t[0].lane[k] = point.impulse_t[1].lane[k] = S(0);
    return;
  }
  const Vec3<S> n = lane_vector(batch.normal, k), t = lane_vector(batch.tangent, k);
  const ContactPoint<S>& from = manifold.geometry.points[i];
  set_lane_vector(from.x_W - position_of(world, manifold.a), k, point.r_a);
  set_lane_vector(from.x_W - position_of(world, manifold.b), k, point.r_b);
  point.gap_at_detection.lane[k] = from.gap;
  point.impulse_n.lane[k] = real::max(S(0), dot(manifold.impulse_W[i], n));
  point.impulse_t[0].lane[k] = dot(manifold.impulse_W[i], t);
  point.impulse_t[1].lane[k] = dot(manifold.impulse_W[i], cross(n, t));
}

// Sets what lane k stores of the manifold's geometry and of the poses at detection, which are the present ones.
template <class S>
void set_geometry(const World<S>& world, ContactManifold<S>& manifold, ManifoldBatch<S>& batch, int k) {
  const Vec3<S> n = manifold.geometry.normal_W;
  batch.points = std::max(batch.points, manifold.geometry.count);
  set_lane_vector(n, k, batch.normal);
  set_lane_vector(unit_tangent(n), k, batch.tangent);
  const Rounding<S> a = rounding_of(world, manifold.a), b = rounding_of(world, manifold.b);
  set_lane_vector(a.axis, k, batch.rounding_axis_a);
  set_lane_vector(b.axis, k, batch.rounding_axis_b);
  batch.rounding_radius_a.lane[k] = a.radius_m;
  batch.rounding_radius_b.lane[k] = b.radius_m;
  set_lane_vector(rotation_of(world, manifold.a), k, batch.rotation_a);
  set_lane_vector(rotation_of(world, manifold.b), k, batch.rotation_b);
  for (int i = 0; i < 4; ++i) set_point(world, manifold, i, batch, k);
  manifold.offset_W = position_of(world, manifold.b) - position_of(world, manifold.a);
}

// Puts manifold `index` into the lane `slot`.
template <class S> void set_manifold_contact(World<S>& world, int index, int slot) {
  ContactManifold<S>& manifold = world.manifolds[static_cast<std::size_t>(index)];
  ManifoldBatch<S>& batch = world.manifold_contacts.batches[static_cast<std::size_t>(slot / kLaneCount)];
  const int k = slot % kLaneCount;
  const PairCoefficients& coefficients = world.coefficients(manifold.a, manifold.b);
  manifold.slot = slot;
  batch.a[k] = manifold.a;
  batch.b[k] = manifold.b;
  batch.manifold[k] = index;
  batch.count = k + 1;
  batch.friction.lane[k] = S(coefficients.friction);
  batch.restitution.lane[k] = S(coefficients.restitution);
  batch.slop.lane[k] = S(kSlopPerSize) * smaller_size(world, manifold.a, manifold.b);
  batch.witness_offset.lane[k] = witness_offset<S>(world.geometry[manifold.a].kind, world.geometry[manifold.b].kind);
  set_geometry(world, manifold, batch, k);
}

// Colours the manifolds and builds their batches. Within a colour, manifolds of one or two points are apart from those
// with more, so that a batch has few empty points. Contacts for which no colour is left get one of their own.
template <class S> void build_batches(World<S>& world) {
  const BodyRows<S>& bodies = world.bodies;
  GraphColouring& colouring = world.scratch.colouring;
  std::vector<int>&count = world.scratch.count, &next_slot = world.scratch.next_slot, &colour = world.scratch.colour;
  colouring.used.assign(static_cast<std::size_t>(bodies.count), 0);
  colour.clear();
  int colours = 2 * kColourCount;
  for (const ContactManifold<S>& manifold : world.manifolds) {
    const int assigned = colouring.assign(manifold.a, manifold.b, bodies.moves[manifold.b] != 0);
    colour.push_back(assigned < kColourCount ? 2 * assigned + (manifold.geometry.count > 2 ? 1 : 0) : colours++);
  }
  world.manifold_contacts.clear();
  append_batches(world.manifold_contacts, colour, colours, SpherePartner::moving_sphere, empty_batch(world), count,
                 next_slot);
  for (std::size_t i = 0; i < colour.size(); ++i)
    set_manifold_contact(world, static_cast<int>(i), next_slot[colour[i]]++);
}

// ---- stale manifolds
// Bound on how far points of the two surfaces have moved relative to each other since detection, m.
template <class S> S relative_motion(const World<S>& world, const ContactManifold<S>& manifold) {
  const ManifoldBatch<S>& batch = world.manifold_contacts.batches[static_cast<std::size_t>(manifold.slot / kLaneCount)];
  const int k = manifold.slot % kLaneCount;
  const auto by_rotation = [&](int body, const Vec3<S>& at_detection) {
    return world.bodies.moves[body]
               ? world.geometry[body].bounding_radius * norm(rotation_of(world, body) - at_detection)
               : S(0);
  };
  return norm(position_of(world, manifold.b) - position_of(world, manifold.a) - manifold.offset_W) +
         by_rotation(manifold.a, lane_vector(batch.rotation_a, k)) +
         by_rotation(manifold.b, lane_vector(batch.rotation_b, k));
}

// The same bound for the coming substep, from the present velocities.
template <class S> S predicted_motion(const World<S>& world, const ContactManifold<S>& manifold) {
  const S *a = world.bodies.velocity[manifold.a].at, *b = world.bodies.velocity[manifold.b].at;
  const auto by_rotation = [&](int body, const S* v) {
    return world.bodies.moves[body] ? world.geometry[body].bounding_radius * norm(load3(v + 3)) : S(0);
  };
  return world.sub_s * (norm(load3(b) - load3(a)) + by_rotation(manifold.a, a) + by_rotation(manifold.b, b));
}

template <class S> bool is_stale(const World<S>& world, const ContactManifold<S>& manifold) {
  const S moved = relative_motion(world, manifold);
  if (!(moved > S(kStaleMotion) * smaller_size(world, manifold.a, manifold.b))) return false;
  S gap = manifold.geometry.points[0].gap;
  for (int i = 1; i < manifold.geometry.count; ++i) gap = real::min(gap, manifold.geometry.points[i].gap);
  return gap <= moved + S(2) * predicted_motion(world, manifold);  // it may touch within the substep
}

template <class S> bool is_only_manifold_of_pair(const World<S>& world, std::size_t i) {
  const auto same_pair = [&](const ContactManifold<S>& x) {
    return x.a == world.manifolds[i].a && x.b == world.manifolds[i].b;
  };
  return !(i > 0 && same_pair(world.manifolds[i - 1])) &&
         !(i + 1 < world.manifolds.size() && same_pair(world.manifolds[i + 1]));
}

// Lists the manifolds that may become stale within the step.
template <class S> void list_fast_manifolds(World<S>& world) {
  world.fast_manifolds.clear();
  for (std::size_t i = 0; i < world.manifolds.size(); ++i) {
    const ContactManifold<S>& manifold = world.manifolds[i];
    const S bound = world.bodies.motion_bound[manifold.a] +
                    (world.bodies.moves[manifold.b] ? world.bodies.motion_bound[manifold.b] : S(0));
    if (bound > S(kStaleMotion) * smaller_size(world, manifold.a, manifold.b) && is_only_manifold_of_pair(world, i))
      world.fast_manifolds.push_back(static_cast<int>(i));
  }
}

// Of a rolling body the contact point moves along the surface, however little the bodies move relative to each other.
template <class S> void add_rolling_manifolds(const World<S>& world, std::vector<int>& stale) {
  if (world.rolling.manifolds.empty()) return;
  for (const int i : world.rolling.manifolds)
    if (is_only_manifold_of_pair(world, static_cast<std::size_t>(i))) stale.push_back(i);
  std::sort(stale.begin(), stale.end());
  stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
}

// Adds the impulse sums of points that the manifold no longer has to those of its first point.
template <class S> void merge_impulse_sums(World<S>& world, const ContactManifold<S>& manifold) {
  const std::size_t first =
      kLaneCount * world.sphere_contacts.batches.size() + 4 * static_cast<std::size_t>(manifold.slot);
  for (int i = manifold.geometry.count; i < 4; ++i) {
    ImpulseSum<S>&to = world.impulse_sums[first], &from = world.impulse_sums[first + static_cast<std::size_t>(i)];
    to.normal_N_s += from.normal_N_s;
    to.normal_W += from.normal_W;
    to.tangential_W += from.tangential_W;
    from = {};
  }
}

// Replaces a manifold by what was detected now, in the same lane, and transfers its impulses.
template <class S> void replace_manifold(World<S>& world, ContactManifold<S>& manifold, const Manifold<S>& geometry) {
  ManifoldBatch<S>& batch = world.manifold_contacts.batches[static_cast<std::size_t>(manifold.slot / kLaneCount)];
  const int k = manifold.slot % kLaneCount;
  for (int i = 0; i < manifold.geometry.count; ++i) manifold.impulse_W[i] = impulse_of(batch, k, i);
  ContactManifold<S> now{manifold.a, manifold.b, geometry, {}, manifold.slot, {}};
  if (world.options.warm_start)
    transfer_impulses(manifold, S(kImpulseMatchDistance) * smaller_size(world, manifold.a, manifold.b), now);
  manifold = now;
  set_geometry(world, manifold, batch, k);
  if (world.records_impulses) merge_impulse_sums(world, manifold);
}

}  // namespace

template <class S> void find_manifolds(World<S>& world) {
  if (world.candidates.manifold_pairs.empty() && world.manifolds.empty()) return;
  store_impulses(world);
  world.manifolds.swap(world.manifolds_before);
  world.manifolds.clear();
  const int count = static_cast<int>(world.candidates.manifold_pairs.size());
  const int parts = world.team != nullptr && count >= kMinPairsForTeam ? world.team->size() : 1;
  auto& detected = world.scratch.detected;
  auto& pair_manifolds = world.scratch.pair_manifolds;
  if (static_cast<int>(detected.size()) < parts) {
    detected.resize(static_cast<std::size_t>(parts));
    pair_manifolds.resize(static_cast<std::size_t>(parts));
  }
  const auto work = [&](int part) {
    const Share own = share(count, part, parts);
    detect_share(world, own.first, own.last, pair_manifolds[static_cast<std::size_t>(part)],
                 detected[static_cast<std::size_t>(part)]);
  };
  if (parts == 1) work(0);
  else world.team->run(true, work);
  for (int part = 0; part < parts; ++part) {
    const auto& own = detected[static_cast<std::size_t>(part)];
    world.manifolds.insert(world.manifolds.end(), own.begin(), own.end());
  }
  for (const ContactManifold<S>& made : world.manifolds)
    add_convex_solves(made.geometry.solve, world.model->system().solvers);
  if (world.options.warm_start) transfer_impulses(world);
  build_batches(world);
  update_effective_masses(world);
  list_fast_manifolds(world);
}

// A manifold holds the points that were closest at detection. Bodies that rotate or slide along each other bring
// other points close, and a corner that no point represents would penetrate until the next step.
template <class S> void update_stale_manifolds(World<S>& world) {
  std::vector<int>& stale = world.stale_manifolds;
  stale.clear();
  for (const int i : world.fast_manifolds)
    if (is_stale(world, world.manifolds[static_cast<std::size_t>(i)])) stale.push_back(i);
  add_rolling_manifolds(world, stale);
  if (stale.empty()) return;
  const int count = static_cast<int>(stale.size());
  auto& updated = world.scratch.manifolds_updated;
  if (updated.size() < stale.size()) updated.resize(stale.size());
  const int parts = world.team != nullptr && count >= kMinPairsForTeam ? 4 * world.team->size() : 1;
  const auto work = [&](int part) {
    const Share own = share(count, part, parts);
    for (int i = own.first; i < own.last; ++i) {
      const ContactManifold<S>& manifold =
          world.manifolds[static_cast<std::size_t>(stale[static_cast<std::size_t>(i)])];
      const S margin = world.bodies.motion_bound[manifold.a] + world.bodies.motion_bound[manifold.b] +
                       S(kContactMargin) * smaller_size(world, manifold.a, manifold.b);
      detect_pair(world, manifold.a, manifold.b, margin, updated[static_cast<std::size_t>(i)]);
    }
  };
  if (parts == 1) work(0);
  else world.team->run(parts, work);
  for (int i = 0; i < count; ++i) {
    if (updated[static_cast<std::size_t>(i)].size() != 1) continue;
    ContactManifold<S>& manifold = world.manifolds[static_cast<std::size_t>(stale[static_cast<std::size_t>(i)])];
    add_convex_solves(updated[static_cast<std::size_t>(i)].front().solve, world.model->system().solvers);
    replace_manifold(world, manifold, updated[static_cast<std::size_t>(i)].front());
    update_effective_masses_of(world,
                               world.manifold_contacts.batches[static_cast<std::size_t>(manifold.slot / kLaneCount)]);
  }
  list_contacts_with_restitution(world);
}

template void find_manifolds<float>(World<float>&);
template void find_manifolds<double>(World<double>&);
template void update_stale_manifolds<float>(World<float>&);
template void update_stale_manifolds<double>(World<double>&);

}  // namespace atwood::stepping
