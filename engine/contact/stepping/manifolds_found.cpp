// The narrow phase of all pairs but balls with balls and planes: manifolds of the step, with the impulses that their points
// carried in the last one, laid out by colours.
#include <algorithm>

#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

constexpr double near = 0.01;        // of the smaller body's size: contacts within this gap are watched, moving or not
constexpr int pairs_worth_a_team = 32;

template <class S> void keep_impulses(World<S>& world) {
  for (const ManifoldBatch<S>& batch : world.manifold_batches.batches)
    for (int k = 0; k < batch.count; ++k) {
      FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(batch.manifold[k])];
      const Vec3<S> n = lane_of(batch.normal, k), t = lane_of(batch.tangent, k), s = cross(n, t);
      for (int i = 0; i < found.shape.count; ++i) {
        const ManifoldPoint<S>& point = batch.point[i];
        found.impulse_W[i] = point.impulse_n.lane[k] * n + point.impulse_t[0].lane[k] * t + point.impulse_t[1].lane[k] * s;
      }
    }
}

// Pairs [first, last) of other_pairs, in their order.
template <class S>
void find_share(const World<S>& world, int first, int last, std::vector<Manifold<S>>& shapes, std::vector<FoundManifold<S>>& out) {
  const Bodies<S>& bodies = world.bodies;
  out.clear();
  for (int i = first; i < last; ++i) {
    const Candidate& pair = world.other_pairs[static_cast<std::size_t>(i)];
    const Geometry<S>&a = world.geometry[pair.a], &b = world.geometry[pair.b];
    const S margin = bodies.reach[pair.a] + bodies.reach[pair.b] + S(near) * real::min(a.bounding_radius, b.bounding_radius);
    const Vec3<S> p_a = load3(bodies.place[pair.a].at), p_b = load3(bodies.place[pair.b].at);
    if (b.kind != ShapeKind::plane) {
      const S most = a.bounding_radius + b.bounding_radius + margin;
      if (dot(p_b - p_a, p_b - p_a) > most * most) continue;
    }
    shapes.clear();
    find_contacts(a, placement(p_a, bodies.q_WB[pair.a]), b, placement(p_b, bodies.q_WB[pair.b]), margin, shapes);
    for (const Manifold<S>& shape : shapes) out.push_back({pair.a, pair.b, shape, {}});
  }
}

bool pair_before(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) { return a != c ? a < c : b < d; }

// Points of the same name go on with their impulse. What is left on both sides (the face that names them may change from one
// body's to the other's) goes to the nearest that is near, each once.
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
    const S near_m = S(0.1) * real::min(world.geometry[now.a].bounding_radius, world.geometry[now.b].bounding_radius);
    while (at < old.size() && pair_before(old[at].a, old[at].b, now.a, now.b)) ++at;
    for (std::size_t j = at; j < old.size() && old[j].a == now.a && old[j].b == now.b; ++j)
      if (old[j].shape.piece_a == now.shape.piece_a && old[j].shape.piece_b == now.shape.piece_b) hand_on(old[j], near_m, now);
  }
}

template <class S> ManifoldBatch<S> blank(const World<S>& world) {
  ManifoldBatch<S> batch{};
  std::fill(std::begin(batch.a), std::end(batch.a), world.bodies.count);
  std::fill(std::begin(batch.b), std::end(batch.b), world.bodies.count);
  std::fill(batch.normal[2].lane, batch.normal[2].lane + lane_count, S(1));
  std::fill(batch.tangent[0].lane, batch.tangent[0].lane + lane_count, S(1));
  for (ManifoldPoint<S>& point : batch.point) std::fill(point.gap_found.lane, point.gap_found.lane + lane_count, S(1e30));
  return batch;
}

template <class S> Outline<S> outline(const World<S>& world, int body) {
  const Geometry<S>& shape = world.geometry[body];
  if (shape.kind == ShapeKind::cylinder) return {rotate(world.bodies.q_WB[body], Vec3<S>{S(0), S(0), S(1)}), S(0)};
  return {{}, shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule ? shape.radius : S(0)};
}

// Of a ball on a slab what touches is under the ball, wherever the slab slides to; a box on a plane takes its corners along.
template <class S> S lean(ShapeKind a, ShapeKind b) {
  const auto is_round = [](ShapeKind kind) { return kind == ShapeKind::sphere || kind == ShapeKind::capsule || kind == ShapeKind::cylinder; };
  if (b == ShapeKind::plane || (is_round(a) && !is_round(b))) return S(-0.5);
  return is_round(b) && !is_round(a) ? S(0.5) : S(0);
}

template <class S> void put_manifold(const World<S>& world, int index, ManifoldBatch<S>& batch, int k) {
  const FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(index)];
  const Law& law = world.law(found.a, found.b);
  const Vec3<S> n = found.shape.normal_W, t = tangent_of(n), s = cross(n, t);
  batch.a[k] = found.a;
  batch.b[k] = found.b;
  batch.manifold[k] = index;
  batch.count = k + 1;
  batch.points = std::max(batch.points, found.shape.count);
  put_lane(n, k, batch.normal);
  put_lane(t, k, batch.tangent);
  batch.friction.lane[k] = S(law.friction);
  batch.restitution.lane[k] = S(law.restitution);
  batch.slop.lane[k] = S(slop_share) * real::min(world.geometry[found.a].bounding_radius, world.geometry[found.b].bounding_radius);
  const Outline<S> a = outline(world, found.a), b = outline(world, found.b);
  put_lane(a.axis, k, batch.axis_a);
  put_lane(b.axis, k, batch.axis_b);
  batch.round_a.lane[k] = a.round_m;
  batch.round_b.lane[k] = b.round_m;
  batch.lean.lane[k] = lean<S>(world.geometry[found.a].kind, world.geometry[found.b].kind);
  for (int i = 0; i < found.shape.count; ++i) {
    ManifoldPoint<S>& point = batch.point[i];
    const ContactPoint<S>& from = found.shape.points[i];
    put_lane(from.x_W - load3(world.bodies.place[found.a].at), k, point.r_a);
    put_lane(from.x_W - load3(world.bodies.place[found.b].at), k, point.r_b);
    point.gap_found.lane[k] = from.gap;
    point.impulse_n.lane[k] = real::max(S(0), dot(found.impulse_W[i], n));
    point.impulse_t[0].lane[k] = dot(found.impulse_W[i], t);
    point.impulse_t[1].lane[k] = dot(found.impulse_W[i], s);
  }
}

// A colour's manifolds with few points stand apart from those with many.
template <class S> void lay_out(World<S>& world) {
  const Bodies<S>& bodies = world.bodies;
  auto& [palette, count, at, colour, other, balls, planes, found, shapes] = world.scratch;
  palette.used.assign(static_cast<std::size_t>(bodies.count), 0);
  colour.clear();
  int own = 2 * colour_count;  // beyond the palette: a colour each
  for (const FoundManifold<S>& manifold : world.manifolds) {
    const int taken = palette.take(manifold.a, manifold.b, bodies.moves[manifold.b] != 0);
    colour.push_back(taken < colour_count ? 2 * taken + (manifold.shape.count > 2 ? 1 : 0) : own++);
  }
  count.assign(static_cast<std::size_t>(own), 0);
  at.assign(static_cast<std::size_t>(own), 0);
  for (const int c : colour) ++count[c];
  auto& batches = world.manifold_batches.batches;
  world.manifold_batches.clear();
  for (int c = 0; c < own; ++c) {
    if (count[c] == 0) continue;
    const int first = static_cast<int>(batches.size());
    at[c] = first * lane_count;
    batches.resize(batches.size() + static_cast<std::size_t>((count[c] + lane_count - 1) / lane_count), blank(world));
    world.manifold_batches.colours.push_back({first, static_cast<int>(batches.size()), Side::two_balls});
  }
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const int slot = at[colour[i]]++;
    put_manifold(world, static_cast<int>(i), batches[static_cast<std::size_t>(slot / lane_count)], slot % lane_count);
  }
}

}  // namespace

template <class S> void find_manifolds(World<S>& world) {
  if (world.other_pairs.empty() && world.manifolds.empty()) return;
  keep_impulses(world);
  world.manifolds.swap(world.manifolds_before);
  world.manifolds.clear();
  const int count = static_cast<int>(world.other_pairs.size());
  const int parts = world.team != nullptr && count >= pairs_worth_a_team ? world.team->size() : 1;
  auto &found = world.scratch.found;
  auto &shapes = world.scratch.shapes;
  if (static_cast<int>(found.size()) < parts) {
    found.resize(static_cast<std::size_t>(parts));
    shapes.resize(static_cast<std::size_t>(parts));
  }
  const auto work = [&](int part) {
    const Share own = share(count, part, parts);
    find_share(world, own.first, own.last, shapes[static_cast<std::size_t>(part)], found[static_cast<std::size_t>(part)]);
  };
  if (parts == 1) work(0);
  else world.team->run(true, work);
  for (int part = 0; part < parts; ++part) {
    const auto& own = found[static_cast<std::size_t>(part)];
    world.manifolds.insert(world.manifolds.end(), own.begin(), own.end());
  }
  if (world.options.warm_start) hand_on(world);
  lay_out(world);
  weigh_manifolds(world);
}

template void find_manifolds<float>(World<float>&);
template void find_manifolds<double>(World<double>&);

}  // namespace atwood::stepping
