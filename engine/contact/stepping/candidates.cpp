// Which pairs may touch soon: found with a margin around every body, and kept until somebody has used up his.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

constexpr int kPairsWorthATeam = 2000;
constexpr double kSkin = 0.08;     // of a body's size: margin of one at rest
constexpr double kStepsAhead = 2;  // ... and what one in motion has besides the coming step, in steps
// ... of its size: in a crowd that falls, far pairs would cost more than finding anew
constexpr double kMostAhead = 0.25;

template <class S> bool is_ball(const World<S>& world, int i) { return world.geometry[i].kind == ShapeKind::sphere; }

template <class S> S size_of(const World<S>& world, int i) { return world.geometry[i].bounding_radius; }

// How far a point of the surface gets within the coming step; and whether nobody can have left his margin by its end.
// Places are compared with where they were, so that what rests or trembles keeps its candidates; turns are added up.
template <class S> bool candidates_still_hold(World<S>& world, S h_s) {
  Bodies<S>& bodies = world.bodies;
  const S fall_m_per_s = norm(world.gravity_W) * h_s;
  std::atomic<bool> hold = world.candidates_hold;
  for_bodies(world, [&](int first, int last) {
    bool all = true;
    for (int i = first; i < last; ++i) {
      if (!bodies.moves[i]) continue;
      const S* v = bodies.velocity[i].at;
      const S turn = is_ball(world, i) ? S(0) : h_s * norm(load3(v + 3)) * size_of(world, i);
      bodies.reach[i] = h_s * (norm(load3(v)) + fall_m_per_s) + turn;
      const S gone = norm(load3(bodies.place[i].at) - world.found_at[i]) + world.turned[i];
      all = all && gone + bodies.reach[i] <= world.margin[i];
      world.turned[i] += turn;
    }
    if (!all) hold.store(false, std::memory_order_relaxed);
  });
  return hold;
}

template <class S> void gather_items(World<S>& world, S h_s) {
  world.items.clear();
  world.item_body.clear();
  const Bodies<S>& bodies = world.bodies;
  for (int i = 0; i < bodies.count; ++i) {
    const ShapeKind kind = world.geometry[i].kind;
    if (kind == ShapeKind::none || kind == ShapeKind::plane) continue;
    BroadItem<S> item;
    const S size = size_of(world, i), ahead = real::min(S(kStepsAhead) * bodies.reach[i], S(kMostAhead) * size);
    const S margin = world.margin[i] = bodies.moves[i] ? S(kSkin) * size + bodies.reach[i] + ahead : S(0);
    item.center = world.found_at[i] = load3(bodies.place[i].at);
    world.turned[i] = is_ball(world, i) ? S(0) : h_s * norm(load3(bodies.velocity[i].at + 3)) * size;
    item.radius = size + margin;
    item.moves = bodies.moves[i] != 0;
    if (kind == ShapeKind::sphere) {
      const Vec3<S> out{item.radius, item.radius, item.radius};
      item.box = {item.center - out, item.center + out};
    } else {
      const Vec3<S> out{margin, margin, margin};
      const Aabb<S> tight = bounds(world.geometry[i], placement(item.center, bodies.q_WB[i]));
      item.box = {tight.low - out, tight.high + out};
    }
    world.items.push_back(item);
    world.item_body.push_back(i);
  }
}

// ---- the balls' contacts, laid out by colours
template <class S> BallBatch<S> blank_batch(const World<S>& world) {
  BallBatch<S> batch;
  std::fill(std::begin(batch.a), std::end(batch.a), world.bodies.count);
  std::fill(std::begin(batch.b), std::end(batch.b), world.bodies.count);
  const auto fill = [](Lanes<S>& lanes, S value) { std::fill(lanes.lane, lanes.lane + kLaneCount, value); };
  for (Lanes<S>* lanes :
       {&batch.slop, &batch.normal[0], &batch.normal[1], &batch.radius_a, &batch.radius_b, &batch.friction,
        &batch.restitution, &batch.gap, &batch.closing, &batch.arm_a, &batch.arm_b, &batch.mass_n, &batch.mass_t,
        &batch.impulse_n, &batch.impulse_t[0], &batch.impulse_t[1], &batch.impulse_t[2]})
    fill(*lanes, S(0));
  fill(batch.normal[2], S(1));
  return batch;
}

// Coincident centres keep the normal that a new contact starts with.
template <class S> void put_ball_contact(World<S>& world, BallBatch<S>& batch, int lane, const Candidate& pair) {
  const Bodies<S>& bodies = world.bodies;
  batch.a[lane] = pair.a;
  batch.b[lane] = pair.b;
  batch.radius_a.lane[lane] = world.geometry[pair.a].radius;
  const Geometry<S>& other = world.geometry[pair.b];
  const Law& law = world.law(pair.a, pair.b);
  batch.friction.lane[lane] = S(law.friction);
  batch.restitution.lane[lane] = S(law.restitution);
  batch.gap.lane[lane] = S(1e30);
  batch.slop.lane[lane] =
      S(kSlopShare) * (other.kind == ShapeKind::plane ? world.geometry[pair.a].radius
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

// What a pair had before, over from the old batches.
template <class S>
void keep_impulses(const World<S>& world, const std::vector<Candidate>& pairs, std::vector<Kept<S>>& kept) {
  kept.clear();
  for (const Candidate& pair : pairs) {
    const BallBatch<S>& batch = world.balls.batches[static_cast<std::size_t>(pair.slot / kLaneCount)];
    const int k = pair.slot % kLaneCount;
    if (!(batch.impulse_n.lane[k] > S(0))) continue;
    Kept<S> one{pair.a, pair.b, batch.impulse_n.lane[k], {}, {}};
    for (int c = 0; c < 3; ++c) {
      one.impulse_t[c] = batch.impulse_t[c].lane[k];
      one.normal[c] = batch.normal[c].lane[k];
    }
    kept.push_back(one);
  }
}

bool before(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) { return a != c ? a < c : b < d; }

// Both lists are sorted: by a and then b, or, contacts with planes, by b and then a.
template <class S>
void put_back(World<S>& world, const std::vector<Candidate>& pairs, const std::vector<Kept<S>>& kept, bool by_b) {
  const auto earlier = [&](const Kept<S>& k, const Candidate& pair) {
    return by_b ? before(k.b, k.a, pair.b, pair.a) : before(k.a, k.b, pair.a, pair.b);
  };
  std::size_t at = 0;
  for (const Candidate& pair : pairs) {
    while (at < kept.size() && earlier(kept[at], pair)) ++at;
    if (at == kept.size()) return;
    if (kept[at].a != pair.a || kept[at].b != pair.b) continue;
    BallBatch<S>& batch = world.balls.batches[static_cast<std::size_t>(pair.slot / kLaneCount)];
    const int k = pair.slot % kLaneCount;
    batch.impulse_n.lane[k] = kept[at].impulse_n;
    for (int c = 0; c < 3; ++c) {
      batch.impulse_t[c].lane[k] = kept[at].impulse_t[c];
      batch.normal[c].lane[k] = kept[at].normal[c];
    }
  }
}

// Batches of one colour after another; `colour[i]` is that of pair i.
template <class S>
void lay_out(World<S>& world, std::vector<Candidate>& pairs, const std::vector<int>& colour, int colours, Side side) {
  std::vector<int>&count = world.scratch.count, &at = world.scratch.at;
  count.assign(static_cast<std::size_t>(colours), 0);
  at.assign(static_cast<std::size_t>(colours), 0);
  for (const int c : colour)
    if (c >= 0) ++count[c];
  auto& batches = world.balls.batches;
  for (int c = 0; c < colours; ++c) {
    if (count[c] == 0) continue;
    const int first = static_cast<int>(batches.size());
    at[c] = first * kLaneCount;
    batches.resize(batches.size() + static_cast<std::size_t>((count[c] + kLaneCount - 1) / kLaneCount),
                   blank_batch(world));
    world.balls.colours.push_back({first, static_cast<int>(batches.size()), side});
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (colour[i] < 0) continue;
    const int slot = pairs[i].slot = at[colour[i]]++;
    batches[static_cast<std::size_t>(slot / kLaneCount)].count = slot % kLaneCount + 1;
  }
  const auto put = [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const Candidate& pair = pairs[static_cast<std::size_t>(i)];
      if (colour[static_cast<std::size_t>(i)] < 0) continue;
      put_ball_contact(world, batches[static_cast<std::size_t>(pair.slot / kLaneCount)], pair.slot % kLaneCount, pair);
    }
  };
  const int count_of_pairs = static_cast<int>(pairs.size());
  if (world.team == nullptr || count_of_pairs < kPairsWorthATeam) return put(0, count_of_pairs);
  world.team->run(true, [&](int part) {
    const Share own = share(count_of_pairs, part, world.team->size());
    put(own.first, own.last);
  });
}

template <class S> void colour_pairs(World<S>& world) {
  const Bodies<S>& bodies = world.bodies;
  world.balls.clear();
  Palette& palette = world.scratch.palette;
  palette.used.assign(static_cast<std::size_t>(bodies.count), 0);
  std::vector<int>&moving = world.scratch.colour, &fixed = world.scratch.other_colour;
  moving.resize(world.ball_pairs.size());
  fixed.resize(world.ball_pairs.size());
  int own = kColourCount, own_fixed = kColourCount;  // beyond the palette: a colour each
  for (std::size_t i = 0; i < world.ball_pairs.size(); ++i) {
    const Candidate& pair = world.ball_pairs[i];
    const bool b_moves = bodies.moves[pair.b] != 0;
    const int colour = palette.take(pair.a, pair.b, b_moves);
    moving[i] = fixed[i] = -1;
    if (b_moves) moving[i] = colour < kColourCount ? colour : own++;
    else fixed[i] = colour < kColourCount ? colour : own_fixed++;
  }
  lay_out(world, world.ball_pairs, moving, own, Side::two_balls);
  lay_out(world, world.ball_pairs, fixed, own_fixed, Side::fixed_ball);
  std::vector<int>& plane = world.scratch.colour;
  plane.resize(world.plane_pairs.size());
  int planes = 0;
  for (std::size_t i = 0; i < plane.size(); ++i) {  // sorted by plane: a ball meets each once
    if (i > 0 && world.plane_pairs[i].b != world.plane_pairs[i - 1].b) ++planes;
    plane[i] = planes;
  }
  lay_out(world, world.plane_pairs, plane, planes + 1, Side::plane);
}

template <class S> void pairs_with_planes(World<S>& world) {
  for (int p = 0; p < world.bodies.count; ++p) {
    const Geometry<S>& plane = world.geometry[p];
    if (plane.kind != ShapeKind::plane) continue;
    for (int i = 0; i < world.bodies.count; ++i) {
      const ShapeKind kind = world.geometry[i].kind;
      if (!world.bodies.moves[i] || kind == ShapeKind::none) continue;
      const S height = dot(plane.normal_W, load3(world.bodies.place[i].at)) - plane.offset;
      if (!(height <= size_of(world, i) + world.margin[i])) continue;
      (kind == ShapeKind::sphere ? world.plane_pairs : world.other_pairs).push_back({i, p, 0});
    }
  }
}

}  // namespace

template <class S> void find_candidates(World<S>& world, S h_s) {
  if (candidates_still_hold(world, h_s)) return;
  std::vector<Kept<S>>&kept_balls = world.scratch.balls, &kept_planes = world.scratch.planes;
  keep_impulses(world, world.ball_pairs, kept_balls);
  keep_impulses(world, world.plane_pairs, kept_planes);
  gather_items(world, h_s);
  world.broad_phase->find(world.items, world.found);
  world.ball_pairs.clear();
  world.plane_pairs.clear();
  world.other_pairs.clear();
  world.some_fixed = false;
  for (const auto& [first, second] : world.found) {
    std::int32_t a = world.item_body[first], b = world.item_body[second];
    if (!world.bodies.moves[a]) {  // a moves
      std::swap(a, b);
      world.some_fixed = true;
    }
    const bool balls = is_ball(world, a) && is_ball(world, b);
    (balls ? world.ball_pairs : world.other_pairs).push_back({a, b, 0});
  }
  pairs_with_planes(world);
  const auto by_a = [](const Candidate& x, const Candidate& y) { return before(x.a, x.b, y.a, y.b); };
  // else as the broad phase sorts
  if (world.some_fixed) std::sort(world.ball_pairs.begin(), world.ball_pairs.end(), by_a);
  std::sort(world.other_pairs.begin(), world.other_pairs.end(), by_a);
  const auto by_plane = [](const Candidate& x, const Candidate& y) { return before(x.b, x.a, y.b, y.a); };
  std::sort(world.plane_pairs.begin(), world.plane_pairs.end(), by_plane);
  colour_pairs(world);
  put_back(world, world.ball_pairs, kept_balls, false);
  put_back(world, world.plane_pairs, kept_planes, true);
  world.candidates_hold = true;
}

template void find_candidates<float>(World<float>&, float);
template void find_candidates<double>(World<double>&, double);

}  // namespace atwood::stepping
