// Candidate pairs of the broad phase. Every body's bounding volume is enlarged by a margin, and the pairs stay valid
// until a body has moved by its margin. The contacts of spheres are laid out here as well.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "contact/stepping/batch_layout.hpp"
#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"

namespace atwood::stepping {
namespace {

constexpr int kMinPairsForTeam = 2000;

// The margin of a body is kMarginAtRest of its size, plus its motion bound of the coming step, plus that of
// kMarginSteps more; the last is at most kMaxMarginAhead of its size: in a falling crowd, pairs that are far apart
// would cost more than a new broad phase.
constexpr double kMarginAtRest = 0.08;
constexpr double kMarginSteps = 2;
constexpr double kMaxMarginAhead = 0.25;

template <class S> bool is_sphere(const World<S>& world, int i) { return world.geometry[i].kind == ShapeKind::sphere; }

template <class S> S size_of(const World<S>& world, int i) { return world.geometry[i].bounding_radius; }

// Sets the motion bounds of the coming step. True: the pairs at hand are valid until its end, because no body can leave
// its margin. Displacements are measured from the position at detection, so that a body that rests or oscillates keeps
// its pairs; rotations are summed.
template <class S> bool candidates_remain_valid(World<S>& world, S h_s) {
  BodyRows<S>& bodies = world.bodies;
  const S dv_m_per_s = norm(world.gravity_W) * h_s;
  std::atomic<bool> valid = world.candidates.valid;
  for_bodies(world, [&](int first, int last) {
    bool within = true;
    for (int i = first; i < last; ++i) {
      if (!bodies.moves[i]) continue;
      const S* v = bodies.velocity[i].at;
      const S rotation = is_sphere(world, i) ? S(0) : h_s * norm(load3(v + 3)) * size_of(world, i);
      bodies.motion_bound[i] = h_s * (norm(load3(v)) + dv_m_per_s) + rotation;
      const S moved = norm(load3(bodies.pose[i].at) - world.candidates.position_at_detection[i]) +
                      world.candidates.rotation_path[i];
      within = within && moved + bodies.motion_bound[i] <= world.candidates.margin[i];
      world.candidates.rotation_path[i] += rotation;
    }
    if (!within) valid.store(false, std::memory_order_relaxed);
  });
  return valid;
}

// Sets World::items, margins and the reference of candidates_remain_valid(). Planes are handled apart.
template <class S> void build_broad_phase_items(World<S>& world, S h_s) {
  world.candidates.items.clear();
  world.candidates.item_body.clear();
  const BodyRows<S>& bodies = world.bodies;
  for (int i = 0; i < bodies.count; ++i) {
    const ShapeKind kind = world.geometry[i].kind;
    if (kind == ShapeKind::none || kind == ShapeKind::plane) continue;
    BroadItem<S> item;
    const S size = size_of(world, i),
            ahead = real::min(S(kMarginSteps) * bodies.motion_bound[i], S(kMaxMarginAhead) * size);
    const S margin = world.candidates.margin[i] =
        bodies.moves[i] ? S(kMarginAtRest) * size + bodies.motion_bound[i] + ahead : S(0);
    item.center = world.candidates.position_at_detection[i] = load3(bodies.pose[i].at);
    world.candidates.rotation_path[i] =
        is_sphere(world, i) ? S(0) : h_s * norm(load3(bodies.velocity[i].at + 3)) * size;
    item.radius = size + margin;
    item.moves = bodies.moves[i] != 0;
    if (kind == ShapeKind::sphere) {
      const Vec3<S> out{item.radius, item.radius, item.radius};
      item.box = {item.center - out, item.center + out};
    } else {
      const Vec3<S> out{margin, margin, margin};
      const Aabb<S> tight = bounds(world.geometry[i], transform(item.center, bodies.q_WB[i]));
      item.box = {tight.low - out, tight.high + out};
    }
    world.candidates.items.push_back(item);
    world.candidates.item_body.push_back(i);
  }
}

// ---- contacts of spheres
template <class S> SphereBatch<S> empty_batch(const World<S>& world) {
  SphereBatch<S> batch;
  std::fill(std::begin(batch.a), std::end(batch.a), world.bodies.count);
  std::fill(std::begin(batch.b), std::end(batch.b), world.bodies.count);
  const auto set_all = [](Lanes<S>& lanes, S value) { std::fill(lanes.lane, lanes.lane + kLaneCount, value); };
  for (Lanes<S>* lanes :
       {&batch.slop, &batch.normal[0], &batch.normal[1], &batch.radius_a, &batch.radius_b, &batch.friction,
        &batch.restitution, &batch.gap, &batch.bias, &batch.arm_a, &batch.arm_b, &batch.mass_n, &batch.mass_t,
        &batch.impulse_n, &batch.impulse_t[0], &batch.impulse_t[1], &batch.impulse_t[2]})
    set_all(*lanes, S(0));
  set_all(batch.normal[2], S(1));
  return batch;
}

// Sets lane `lane` to a new contact of the pair. Its normal is +z until the centres are apart.
template <class S>
void init_sphere_contact(World<S>& world, SphereBatch<S>& batch, int lane, const CandidatePair& pair) {
  const BodyRows<S>& bodies = world.bodies;
  batch.a[lane] = pair.a;
  batch.b[lane] = pair.b;
  batch.radius_a.lane[lane] = world.geometry[pair.a].radius;
  const Geometry<S>& other = world.geometry[pair.b];
  const PairCoefficients& coefficients = world.coefficients(pair.a, pair.b);
  batch.friction.lane[lane] = S(coefficients.friction);
  batch.restitution.lane[lane] = S(coefficients.restitution);
  batch.gap.lane[lane] = S(kNoValue);
  batch.slop.lane[lane] =
      S(kSlopPerSize) * (other.kind == ShapeKind::plane ? world.geometry[pair.a].radius
                                                        : real::min(world.geometry[pair.a].radius, other.radius));
  const S mobility = bodies.velocity[pair.a].at[6] + bodies.velocity[pair.b].at[6];
  batch.mass_n.lane[lane] = mobility > S(0) ? S(1) / mobility : S(0);
  if (other.kind == ShapeKind::plane) {
    const Vec3<S> n = -other.normal_W;
    batch.normal[0].lane[lane] = n.x;
    batch.normal[1].lane[lane] = n.y;
    batch.normal[2].lane[lane] = n.z;
    // gap = N . p - offset - radius = -n . p - (radius_a + radius_b) with radius_b = offset
    batch.radius_b.lane[lane] = other.offset;
  } else {
    batch.radius_b.lane[lane] = other.radius;
  }
}

// Sets `stored` to the impulses and normals of the pairs that carry an impulse, in the order of the pairs.
template <class S>
void store_impulses(const World<S>& world, const std::vector<CandidatePair>& pairs,
                    std::vector<StoredImpulse<S>>& stored) {
  stored.clear();
  for (const CandidatePair& pair : pairs) {
    const SphereBatch<S>& batch = world.sphere_contacts.batches[static_cast<std::size_t>(pair.slot / kLaneCount)];
    const int k = pair.slot % kLaneCount;
    if (!(batch.impulse_n.lane[k] > S(0))) continue;
    StoredImpulse<S> one{pair.a, pair.b, batch.impulse_n.lane[k], {}, {}};
    for (int c = 0; c < 3; ++c) {
      one.impulse_t[c] = batch.impulse_t[c].lane[k];
      one.normal[c] = batch.normal[c].lane[k];
    }
    stored.push_back(one);
  }
}

bool ordered_before(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) { return a != c ? a < c : b < d; }

// Gives the stored impulses to the pairs' new contacts. Both lists are sorted by a and then b; those of contacts with
// planes by b and then a (`by_b`).
template <class S>
void restore_impulses(World<S>& world, const std::vector<CandidatePair>& pairs,
                      const std::vector<StoredImpulse<S>>& stored, bool by_b) {
  const auto earlier = [&](const StoredImpulse<S>& k, const CandidatePair& pair) {
    return by_b ? ordered_before(k.b, k.a, pair.b, pair.a) : ordered_before(k.a, k.b, pair.a, pair.b);
  };
  std::size_t at = 0;
  for (const CandidatePair& pair : pairs) {
    while (at < stored.size() && earlier(stored[at], pair)) ++at;
    if (at == stored.size()) return;
    if (stored[at].a != pair.a || stored[at].b != pair.b) continue;
    SphereBatch<S>& batch = world.sphere_contacts.batches[static_cast<std::size_t>(pair.slot / kLaneCount)];
    const int k = pair.slot % kLaneCount;
    batch.impulse_n.lane[k] = stored[at].impulse_n;
    for (int c = 0; c < 3; ++c) {
      batch.impulse_t[c].lane[k] = stored[at].impulse_t[c];
      batch.normal[c].lane[k] = stored[at].normal[c];
    }
  }
}

// Appends the batches of the pairs, colour by colour, and their contacts. `colour[i]` is that of pair i; -1: the pair
// has no contact of this kind. Sets the pairs' slots.
template <class S>
void build_batches(World<S>& world, std::vector<CandidatePair>& pairs, const std::vector<int>& colour, int colours,
                   SpherePartner partner) {
  std::vector<int>&count = world.scratch.count, &next_slot = world.scratch.next_slot;
  auto& batches = world.sphere_contacts.batches;
  append_batches(world.sphere_contacts, colour, colours, partner, empty_batch(world), count, next_slot);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (colour[i] < 0) continue;
    const int slot = pairs[i].slot = next_slot[colour[i]]++;
    batches[static_cast<std::size_t>(slot / kLaneCount)].count = slot % kLaneCount + 1;
  }
  const auto init = [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const CandidatePair& pair = pairs[static_cast<std::size_t>(i)];
      if (colour[static_cast<std::size_t>(i)] < 0) continue;
      init_sphere_contact(world, batches[static_cast<std::size_t>(pair.slot / kLaneCount)], pair.slot % kLaneCount,
                          pair);
    }
  };
  const int count_of_pairs = static_cast<int>(pairs.size());
  if (world.team == nullptr || count_of_pairs < kMinPairsForTeam) return init(0, count_of_pairs);
  world.team->run(true, [&](int part) {
    const Share own = share(count_of_pairs, part, world.team->size());
    init(own.first, own.last);
  });
}

// Colours the pairs of spheres and of spheres with planes, and builds their batches. Pairs for which no colour is left
// get one of their own; a sphere has one contact with each plane, so each plane is a colour.
template <class S> void colour_sphere_pairs(World<S>& world) {
  const BodyRows<S>& bodies = world.bodies;
  world.sphere_contacts.clear();
  GraphColouring& colouring = world.scratch.colouring;
  colouring.used.assign(static_cast<std::size_t>(bodies.count), 0);
  std::vector<int>&moving = world.scratch.colour, &fixed = world.scratch.other_colour;
  moving.resize(world.candidates.sphere_pairs.size());
  fixed.resize(world.candidates.sphere_pairs.size());
  int moving_colours = kColourCount, fixed_colours = kColourCount;
  for (std::size_t i = 0; i < world.candidates.sphere_pairs.size(); ++i) {
    const CandidatePair& pair = world.candidates.sphere_pairs[i];
    const bool b_moves = bodies.moves[pair.b] != 0;
    const int colour = colouring.assign(pair.a, pair.b, b_moves);
    moving[i] = fixed[i] = -1;
    if (b_moves) moving[i] = colour < kColourCount ? colour : moving_colours++;
    else fixed[i] = colour < kColourCount ? colour : fixed_colours++;
  }
  build_batches(world, world.candidates.sphere_pairs, moving, moving_colours, SpherePartner::moving_sphere);
  build_batches(world, world.candidates.sphere_pairs, fixed, fixed_colours, SpherePartner::fixed_sphere);
  std::vector<int>& plane = world.scratch.colour;
  plane.resize(world.candidates.plane_pairs.size());
  int planes = 0;
  for (std::size_t i = 0; i < plane.size(); ++i) {  // the pairs are sorted by plane
    if (i > 0 && world.candidates.plane_pairs[i].b != world.candidates.plane_pairs[i - 1].b) ++planes;
    plane[i] = planes;
  }
  build_batches(world, world.candidates.plane_pairs, plane, planes + 1, SpherePartner::plane);
}

template <class S> void add_pairs_with_planes(World<S>& world) {
  for (int p = 0; p < world.bodies.count; ++p) {
    const Geometry<S>& plane = world.geometry[p];
    if (plane.kind != ShapeKind::plane) continue;
    for (int i = 0; i < world.bodies.count; ++i) {
      const ShapeKind kind = world.geometry[i].kind;
      if (!world.bodies.moves[i] || kind == ShapeKind::none || are_joined(world, i, p)) continue;
      const S height = dot(plane.normal_W, load3(world.bodies.pose[i].at)) - plane.offset;
      if (!(height <= size_of(world, i) + world.candidates.margin[i])) continue;
      (kind == ShapeKind::sphere ? world.candidates.plane_pairs : world.candidates.manifold_pairs).push_back({i, p, 0});
    }
  }
}

}  // namespace

template <class S> void update_candidate_pairs(World<S>& world, S h_s) {
  if (candidates_remain_valid(world, h_s)) return;
  std::vector<StoredImpulse<S>>&sphere_impulses = world.scratch.sphere_impulses,
  &plane_impulses = world.scratch.plane_impulses;
  store_impulses(world, world.candidates.sphere_pairs, sphere_impulses);
  store_impulses(world, world.candidates.plane_pairs, plane_impulses);
  build_broad_phase_items(world, h_s);
  world.candidates.broad_phase->find(world.candidates.items, world.candidates.overlapping_pairs);
  world.candidates.sphere_pairs.clear();
  world.candidates.plane_pairs.clear();
  world.candidates.manifold_pairs.clear();
  world.candidates.has_fixed_pairs = false;
  for (const auto& [first, second] : world.candidates.overlapping_pairs) {
    std::int32_t a = world.candidates.item_body[first], b = world.candidates.item_body[second];
    if (!world.bodies.moves[a]) {  // body a of a pair moves
      std::swap(a, b);
      world.candidates.has_fixed_pairs = true;
    }
    if (are_joined(world, a, b)) continue;
    const bool spheres = is_sphere(world, a) && is_sphere(world, b);
    (spheres ? world.candidates.sphere_pairs : world.candidates.manifold_pairs).push_back({a, b, 0});
  }
  add_pairs_with_planes(world);
  const auto by_a = [](const CandidatePair& x, const CandidatePair& y) { return ordered_before(x.a, x.b, y.a, y.b); };
  // if nothing was swapped above, they are still sorted
  if (world.candidates.has_fixed_pairs)
    std::sort(world.candidates.sphere_pairs.begin(), world.candidates.sphere_pairs.end(), by_a);
  std::sort(world.candidates.manifold_pairs.begin(), world.candidates.manifold_pairs.end(), by_a);
  const auto by_plane = [](const CandidatePair& x, const CandidatePair& y) {
    return ordered_before(x.b, x.a, y.b, y.a);
  };
  std::sort(world.candidates.plane_pairs.begin(), world.candidates.plane_pairs.end(), by_plane);
  colour_sphere_pairs(world);
  restore_impulses(world, world.candidates.sphere_pairs, sphere_impulses, false);
  restore_impulses(world, world.candidates.plane_pairs, plane_impulses, true);
  world.candidates.valid = true;
}

template <class S> bool may_miss_a_pair(const World<S>& world, int body, S remaining_s) {
  const BodyRows<S>& bodies = world.bodies;
  const auto path = [&](int i, S size) {
    if (!bodies.moves[i]) return S(0);
    const S *v = bodies.velocity[i].at, *shift = bodies.impact_shift[i].at;
    const S along = norm(load3(shift)) + remaining_s * norm(load3(v));
    return is_sphere(world, i) ? along : along + size * (norm(load3(shift + 3)) + remaining_s * norm(load3(v + 3)));
  };
  const Vec3<S> p = load3(bodies.pose[body].at);
  const S size = size_of(world, body), own = path(body, size);
  if (norm(p - world.candidates.position_at_detection[body]) + world.candidates.rotation_path[body] + own <=
      world.candidates.margin[body])
    return false;
  const auto is_candidate = [&](int other) {
    const auto holds = [&](const CandidatePair& pair) {
      return (pair.a == body && pair.b == other) || (pair.a == other && pair.b == body);
    };
    const auto in = [&](const std::vector<CandidatePair>& pairs) {
      return std::any_of(pairs.begin(), pairs.end(), holds);
    };
    return in(world.candidates.sphere_pairs) || in(world.candidates.plane_pairs) || in(world.candidates.manifold_pairs);
  };
  for (int i = 0; i < bodies.count; ++i) {
    const Geometry<S>& other = world.geometry[i];
    if (i == body || other.kind == ShapeKind::none || are_joined(world, body, i)) continue;
    const S distance = other.kind == ShapeKind::plane
                           ? dot(other.normal_W, p) - other.offset
                           : norm(load3(bodies.pose[i].at) - p) - size_of(world, i) - path(i, size_of(world, i));
    if (distance <= size + own && !is_candidate(i)) return true;
  }
  return false;
}

template void update_candidate_pairs<float>(World<float>&, float);
template void update_candidate_pairs<double>(World<double>&, double);
template bool may_miss_a_pair<float>(const World<float>&, int, float);
template bool may_miss_a_pair<double>(const World<double>&, int, double);

}  // namespace atwood::stepping
