// The narrow phase of all pairs but balls with balls and planes: manifolds of the step, with the impulses that their
// points carried in the last one, laid out by colours.
#include <algorithm>

#include "contact/stepping/points.hpp"
#include "math/so3.hpp"

namespace atwood::stepping {
namespace {

constexpr double kNear = 0.01;  // of the smaller body's size: contacts within this gap are watched, moving or not
constexpr double kHandedOnWithin = 0.1;
constexpr int kPairsWorthATeam = 32;
// of the smaller body's size: a manifold serves until its bodies have moved so far apart or along
constexpr double kStaleShare = 0.01;

template <class S> Vec3<S> impulse_of(const ManifoldBatch<S>& batch, int k, int i) {
  const Vec3<S> n = lane_of(batch.normal, k), t = lane_of(batch.tangent, k);
  const ManifoldPoint<S>& point = batch.point[i];
  return point.impulse_n.lane[k] * n + point.impulse_t[0].lane[k] * t + point.impulse_t[1].lane[k] * cross(n, t);
}

template <class S> void keep_impulses(World<S>& world) {
  for (const ManifoldBatch<S>& batch : world.manifold_batches.batches)
    for (int k = 0; k < batch.count; ++k) {
      FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(batch.manifold[k])];
      for (int i = 0; i < found.shape.count; ++i) found.impulse_W[i] = impulse_of(batch, k, i);
    }
}

template <class S> Vec3<S> turned_by(const World<S>& world, int body) { return load3(world.bodies.place[body].at + 3); }
template <class S> Vec3<S> center(const World<S>& world, int body) { return load3(world.bodies.place[body].at); }

// Now: q_WB is that of the step's start.
template <class S> Quat<S> attitude(const World<S>& world, int body) {
  const Vec3<S> s = turned_by(world, body);
  const Quat<S>& q = world.bodies.q_WB[body];
  return s.x == S(0) && s.y == S(0) && s.z == S(0) ? q : normalised(so3_exp(s) * q);
}

template <class S> void find_pair(const World<S>& world, int a, int b, S margin, std::vector<Manifold<S>>& shapes) {
  shapes.clear();
  find_contacts(world.geometry[a], placement(center(world, a), attitude(world, a)), world.geometry[b],
                placement(center(world, b), attitude(world, b)), margin, shapes);
}

template <class S> void report(World<S>& world, const Manifold<S>& shape) {
  if (shape.solve.iterations > 0) world.model->system().solvers.add(IterativeSolver::expanding_polytope, shape.solve);
}

template <class S> S smaller_size(const World<S>& world, int a, int b) {
  return real::min(world.geometry[a].bounding_radius, world.geometry[b].bounding_radius);
}

// Pairs [first, last) of other_pairs, in their order.
template <class S>
void find_share(const World<S>& world, int first, int last, std::vector<Manifold<S>>& shapes,
                std::vector<FoundManifold<S>>& out) {
  const Bodies<S>& bodies = world.bodies;
  out.clear();
  for (int i = first; i < last; ++i) {
    const Candidate& pair = world.other_pairs[static_cast<std::size_t>(i)];
    const S margin = bodies.reach[pair.a] + bodies.reach[pair.b] + S(kNear) * smaller_size(world, pair.a, pair.b);
    if (world.geometry[pair.b].kind != ShapeKind::plane) {
      const Vec3<S> between = center(world, pair.b) - center(world, pair.a);
      const S most = world.geometry[pair.a].bounding_radius + world.geometry[pair.b].bounding_radius + margin;
      if (dot(between, between) > most * most) continue;
    }
    find_pair(world, pair.a, pair.b, margin, shapes);
    for (const Manifold<S>& shape : shapes) out.push_back({pair.a, pair.b, shape, {}, 0, {}});
  }
}

bool pair_before(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) { return a != c ? a < c : b < d; }

// Points of the same name go on with their impulse. What is left on both sides (the face that names them may change
// from one body's to the other's) goes to the nearest that is near, each once.
template <class S> void hand_on(const FoundManifold<S>& old, S near_m, FoundManifold<S>& now) {
  bool given[4] = {}, served[4] = {};
  for (int i = 0; i < now.shape.count; ++i)
    for (int k = 0; k < old.shape.count; ++k)
      if (!given[k] && !served[i] && now.shape.points[i].id == old.shape.points[k].id) {
        now.impulse_W[i] = old.impulse_W[k];
        given[k] = served[i] = true;
      }
  for (int i = 0; i < now.shape.count; ++i) {
    int nearest = -1;
    S least = near_m * near_m;
    for (int k = 0; k < old.shape.count && !served[i]; ++k) {
      const Vec3<S> d = old.shape.points[k].x_W - now.shape.points[i].x_W;
      if (given[k] || !(dot(d, d) < least)) continue;
      least = dot(d, d);
      nearest = k;
    }
    if (nearest < 0) continue;
    now.impulse_W[i] = old.impulse_W[nearest];
    given[nearest] = true;
  }
}

template <class S> void hand_on(World<S>& world) {
  const auto& old = world.manifolds_before;
  std::size_t at = 0;
  for (FoundManifold<S>& now : world.manifolds) {
    const S near_m = S(kHandedOnWithin) * smaller_size(world, now.a, now.b);
    while (at < old.size() && pair_before(old[at].a, old[at].b, now.a, now.b)) ++at;
    for (std::size_t j = at; j < old.size() && old[j].a == now.a && old[j].b == now.b; ++j)
      if (old[j].shape.piece_a == now.shape.piece_a && old[j].shape.piece_b == now.shape.piece_b)
        hand_on(old[j], near_m, now);
  }
}

template <class S> ManifoldBatch<S> blank(const World<S>& world) {
  ManifoldBatch<S> batch{};
  std::fill(std::begin(batch.a), std::end(batch.a), world.bodies.count);
  std::fill(std::begin(batch.b), std::end(batch.b), world.bodies.count);
  std::fill(batch.normal[2].lane, batch.normal[2].lane + kLaneCount, S(1));
  std::fill(batch.tangent[0].lane, batch.tangent[0].lane + kLaneCount, S(1));
  for (ManifoldPoint<S>& point : batch.point)
    std::fill(point.gap_found.lane, point.gap_found.lane + kLaneCount, S(1e30));
  return batch;
}

template <class S> Outline<S> outline(const World<S>& world, int body) {
  const Geometry<S>& shape = world.geometry[body];
  if (shape.kind == ShapeKind::cylinder) return {rotate(attitude(world, body), Vec3<S>{S(0), S(0), S(1)}), S(0)};
  return {{}, shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule ? shape.radius : S(0)};
}

// Of a ball on a slab what touches is under the ball, wherever the slab slides to; a box on a plane takes its corners
// along.
template <class S> S lean(ShapeKind a, ShapeKind b) {
  const auto is_round = [](ShapeKind kind) {
    return kind == ShapeKind::sphere || kind == ShapeKind::capsule || kind == ShapeKind::cylinder;
  };
  if (b == ShapeKind::plane || (is_round(a) && !is_round(b))) return S(-0.5);
  return is_round(b) && !is_round(a) ? S(0.5) : S(0);
}

template <class S>
void put_point(const World<S>& world, const FoundManifold<S>& found, int i, ManifoldBatch<S>& batch, int k) {
  ManifoldPoint<S>& point = batch.point[i];
  if (i >= found.shape.count) {
    point.gap_found.lane[k] = S(1e30);
    point.impulse_n.lane[k] = point.impulse_t[0].lane[k] = point.impulse_t[1].lane[k] = S(0);
    return;
  }
  const Vec3<S> n = lane_of(batch.normal, k), t = lane_of(batch.tangent, k);
  const ContactPoint<S>& from = found.shape.points[i];
  put_lane(from.x_W - center(world, found.a), k, point.r_a);
  put_lane(from.x_W - center(world, found.b), k, point.r_b);
  point.gap_found.lane[k] = from.gap;
  point.impulse_n.lane[k] = real::max(S(0), dot(found.impulse_W[i], n));
  point.impulse_t[0].lane[k] = dot(found.impulse_W[i], t);
  point.impulse_t[1].lane[k] = dot(found.impulse_W[i], cross(n, t));
}

// What a pair's shapes have to say, wherever its lane is; the bodies stand as they do now.
template <class S> void put_shape(const World<S>& world, FoundManifold<S>& found, ManifoldBatch<S>& batch, int k) {
  const Vec3<S> n = found.shape.normal_W;
  batch.points = std::max(batch.points, found.shape.count);
  put_lane(n, k, batch.normal);
  put_lane(tangent_of(n), k, batch.tangent);
  const Outline<S> a = outline(world, found.a), b = outline(world, found.b);
  put_lane(a.axis, k, batch.axis_a);
  put_lane(b.axis, k, batch.axis_b);
  batch.round_a.lane[k] = a.round_m;
  batch.round_b.lane[k] = b.round_m;
  put_lane(turned_by(world, found.a), k, batch.turned_a);
  put_lane(turned_by(world, found.b), k, batch.turned_b);
  for (int i = 0; i < 4; ++i) put_point(world, found, i, batch, k);
  found.between_W = center(world, found.b) - center(world, found.a);
}

template <class S> void put_manifold(World<S>& world, int index, int slot) {
  FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(index)];
  ManifoldBatch<S>& batch = world.manifold_batches.batches[static_cast<std::size_t>(slot / kLaneCount)];
  const int k = slot % kLaneCount;
  const Law& law = world.law(found.a, found.b);
  found.slot = slot;
  batch.a[k] = found.a;
  batch.b[k] = found.b;
  batch.manifold[k] = index;
  batch.count = k + 1;
  batch.friction.lane[k] = S(law.friction);
  batch.restitution.lane[k] = S(law.restitution);
  batch.slop.lane[k] = S(kSlopShare) * smaller_size(world, found.a, found.b);
  batch.lean.lane[k] = lean<S>(world.geometry[found.a].kind, world.geometry[found.b].kind);
  put_shape(world, found, batch, k);
}

// A colour's manifolds with few points stand apart from those with many.
template <class S> void lay_out(World<S>& world) {
  const Bodies<S>& bodies = world.bodies;
  auto& [palette, count, at, colour, other, balls, planes, found, shapes, renewed] = world.scratch;
  palette.used.assign(static_cast<std::size_t>(bodies.count), 0);
  colour.clear();
  int own = 2 * kColourCount;  // beyond the palette: a colour each
  for (const FoundManifold<S>& manifold : world.manifolds) {
    const int taken = palette.take(manifold.a, manifold.b, bodies.moves[manifold.b] != 0);
    colour.push_back(taken < kColourCount ? 2 * taken + (manifold.shape.count > 2 ? 1 : 0) : own++);
  }
  count.assign(static_cast<std::size_t>(own), 0);
  at.assign(static_cast<std::size_t>(own), 0);
  for (const int c : colour) ++count[c];
  auto& batches = world.manifold_batches.batches;
  world.manifold_batches.clear();
  for (int c = 0; c < own; ++c) {
    if (count[c] == 0) continue;
    const int first = static_cast<int>(batches.size());
    at[c] = first * kLaneCount;
    batches.resize(batches.size() + static_cast<std::size_t>((count[c] + kLaneCount - 1) / kLaneCount), blank(world));
    world.manifold_batches.colours.push_back({first, static_cast<int>(batches.size()), Side::two_balls});
  }
  for (std::size_t i = 0; i < colour.size(); ++i) put_manifold(world, static_cast<int>(i), at[colour[i]]++);
}

// ---- within a step ------------------------------------------------------------------------------------------------
// At most, of points of the two surfaces against each other.
template <class S> S moved_since_found(const World<S>& world, const FoundManifold<S>& found) {
  const ManifoldBatch<S>& batch = world.manifold_batches.batches[static_cast<std::size_t>(found.slot / kLaneCount)];
  const int k = found.slot % kLaneCount;
  const auto turn = [&](int body, const Vec3<S>& before) {
    return world.bodies.moves[body] ? world.geometry[body].bounding_radius * norm(turned_by(world, body) - before)
                                    : S(0);
  };
  return norm(center(world, found.b) - center(world, found.a) - found.between_W) +
         turn(found.a, lane_of(batch.turned_a, k)) + turn(found.b, lane_of(batch.turned_b, k));
}

template <class S> S coming_motion(const World<S>& world, const FoundManifold<S>& found) {
  const S *a = world.bodies.velocity[found.a].at, *b = world.bodies.velocity[found.b].at;
  const auto turn = [&](int body, const S* v) {
    return world.bodies.moves[body] ? world.geometry[body].bounding_radius * norm(load3(v + 3)) : S(0);
  };
  return world.sub_s * (norm(load3(b) - load3(a)) + turn(found.a, a) + turn(found.b, b));
}

template <class S> bool is_stale(const World<S>& world, const FoundManifold<S>& found) {
  const S moved = moved_since_found(world, found);
  if (!(moved > S(kStaleShare) * smaller_size(world, found.a, found.b))) return false;
  S gap = found.shape.points[0].gap;
  for (int i = 1; i < found.shape.count; ++i) gap = real::min(gap, found.shape.points[i].gap);
  return gap <= moved + S(2) * coming_motion(world, found);  // may touch within the substep
}

template <class S> bool stands_alone(const World<S>& world, std::size_t i) {  // its pair has no other manifold
  const auto same_pair = [&](const FoundManifold<S>& x) {
    return x.a == world.manifolds[i].a && x.b == world.manifolds[i].b;
  };
  return !(i > 0 && same_pair(world.manifolds[i - 1])) &&
         !(i + 1 < world.manifolds.size() && same_pair(world.manifolds[i + 1]));
}

template <class S> void list_restless(World<S>& world) {
  world.restless.clear();
  for (std::size_t i = 0; i < world.manifolds.size(); ++i) {
    const FoundManifold<S>& found = world.manifolds[i];
    const S most = world.bodies.reach[found.a] + (world.bodies.moves[found.b] ? world.bodies.reach[found.b] : S(0));
    if (most > S(kStaleShare) * smaller_size(world, found.a, found.b) && stands_alone(world, i))
      world.restless.push_back(static_cast<int>(i));
  }
}

// Of what rolls the point of contact runs along the surface, however little the bodies move against each other.
template <class S> void add_rolling(const World<S>& world, std::vector<int>& stale) {
  if (world.rolling.manifolds.empty()) return;
  for (const int i : world.rolling.manifolds)
    if (stands_alone(world, static_cast<std::size_t>(i))) stale.push_back(i);
  std::sort(stale.begin(), stale.end());
  stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
}

// What a step's sums tell of points that are no longer there goes to the first of the manifold.
template <class S> void hand_on_sums(World<S>& world, const FoundManifold<S>& found) {
  const std::size_t first = kLaneCount * world.balls.batches.size() + 4 * static_cast<std::size_t>(found.slot);
  for (int i = found.shape.count; i < 4; ++i) {
    Told<S>&to = world.told[first], &from = world.told[first + static_cast<std::size_t>(i)];
    to.size += from.size;
    to.along += from.along;
    to.across += from.across;
    from = {};
  }
}

template <class S> void renew(World<S>& world, FoundManifold<S>& found, const Manifold<S>& shape) {
  ManifoldBatch<S>& batch = world.manifold_batches.batches[static_cast<std::size_t>(found.slot / kLaneCount)];
  const int k = found.slot % kLaneCount;
  for (int i = 0; i < found.shape.count; ++i) found.impulse_W[i] = impulse_of(batch, k, i);
  FoundManifold<S> now{found.a, found.b, shape, {}, found.slot, {}};
  if (world.options.warm_start) hand_on(found, S(kHandedOnWithin) * smaller_size(world, found.a, found.b), now);
  found = now;
  put_shape(world, found, batch, k);
  if (world.sums_impulses) hand_on_sums(world, found);
}

}  // namespace

template <class S> void find_manifolds(World<S>& world) {
  if (world.other_pairs.empty() && world.manifolds.empty()) return;
  keep_impulses(world);
  world.manifolds.swap(world.manifolds_before);
  world.manifolds.clear();
  const int count = static_cast<int>(world.other_pairs.size());
  const int parts = world.team != nullptr && count >= kPairsWorthATeam ? world.team->size() : 1;
  auto& found = world.scratch.found;
  auto& shapes = world.scratch.shapes;
  if (static_cast<int>(found.size()) < parts) {
    found.resize(static_cast<std::size_t>(parts));
    shapes.resize(static_cast<std::size_t>(parts));
  }
  const auto work = [&](int part) {
    const Share own = share(count, part, parts);
    find_share(world, own.first, own.last, shapes[static_cast<std::size_t>(part)],
               found[static_cast<std::size_t>(part)]);
  };
  if (parts == 1) work(0);
  else world.team->run(true, work);
  for (int part = 0; part < parts; ++part) {
    const auto& own = found[static_cast<std::size_t>(part)];
    world.manifolds.insert(world.manifolds.end(), own.begin(), own.end());
  }
  for (const FoundManifold<S>& made : world.manifolds) report(world, made.shape);
  if (world.options.warm_start) hand_on(world);
  lay_out(world);
  weigh_manifolds(world);
  list_restless(world);
}

// A manifold knows the points that were nearest when it was found. Bodies that turn or pass along each other bring
// others near: a corner that none of them stands for would sink in until the next step.
template <class S> void renew_manifolds(World<S>& world) {
  std::vector<int>& stale = world.stale;
  stale.clear();
  for (const int i : world.restless)
    if (is_stale(world, world.manifolds[static_cast<std::size_t>(i)])) stale.push_back(i);
  add_rolling(world, stale);
  if (stale.empty()) return;
  const int count = static_cast<int>(stale.size());
  auto& shapes = world.scratch.renewed;
  if (shapes.size() < stale.size()) shapes.resize(stale.size());
  const int parts = world.team != nullptr && count >= kPairsWorthATeam ? 4 * world.team->size() : 1;
  const auto work = [&](int part) {
    const Share own = share(count, part, parts);
    for (int i = own.first; i < own.last; ++i) {
      const FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(stale[static_cast<std::size_t>(i)])];
      const S margin =
          world.bodies.reach[found.a] + world.bodies.reach[found.b] + S(kNear) * smaller_size(world, found.a, found.b);
      find_pair(world, found.a, found.b, margin, shapes[static_cast<std::size_t>(i)]);
    }
  };
  if (parts == 1) work(0);
  else world.team->run(parts, work);
  for (int i = 0; i < count; ++i) {
    if (shapes[static_cast<std::size_t>(i)].size() != 1) continue;
    FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(stale[static_cast<std::size_t>(i)])];
    report(world, shapes[static_cast<std::size_t>(i)].front());
    renew(world, found, shapes[static_cast<std::size_t>(i)].front());
    weigh_batch(world, world.manifold_batches.batches[static_cast<std::size_t>(found.slot / kLaneCount)]);
  }
  list_bouncing(world);
}

template void find_manifolds<float>(World<float>&);
template void find_manifolds<double>(World<double>&);
template void renew_manifolds<float>(World<float>&);
template void renew_manifolds<double>(World<double>&);

}  // namespace atwood::stepping
