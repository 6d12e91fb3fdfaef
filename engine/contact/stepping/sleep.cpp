// Sleep: bodies that touch each other form an island; one that has been at rest as a whole stands still from then on,
// as if fixed, and costs nothing. It wakes, as a whole, when a body that moves may meet one of its own within the step,
// or when the law changes.
//
// What lies down on sleepers joins their island. Momentum of the last tremble (below sleep_below_m_per_s) is lost,
// which is why sleeping is off unless asked for, and forces between sleepers are not told.
#include <algorithm>
#include <numeric>

#include "contact/stepping/islands.hpp"
#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

template <class S> S surface_speed(const World<S>& world, int body) {
  const S* v = world.bodies.velocity[body].at;
  return norm(load3(v)) + world.geometry[body].bounding_radius * norm(load3(v + 3));
}

// Pairs of bodies that push each other: visit(a, b), a moves.
template <class S, class Visit> void for_touching(const World<S>& world, const Visit& visit) {
  for (int contact = 0; contact < point_count(world); ++contact) {
    if (!used(world, contact)) continue;
    const Place at = place_of(world, contact);
    const S pushes = at.point < 0 ? balls_at(world, at).impulse_n.lane[at.lane]
                                  : manifolds_at(world, at).point[at.point].impulse_n.lane[at.lane];
    if (!(pushes > S(0))) continue;
    const auto [a, b] = bodies_of(world, contact);
    visit(a, b);
  }
}

template <class S> void stop(World<S>& world, int body) {
  BodyState<S> state{load3(world.bodies.place[body].at), {}, world.bodies.q_WB[body], {}};
  world.model->set_body(body, state, world.y.data());
  lay_down(world, body);
}

template <class S> bool moves_about(const World<S>& world, int body) {
  return world.bodies.moves[body] && world.sleep.still_s[static_cast<std::size_t>(body)] == 0;
}

}  // namespace

template <class S> void lay_down(World<S>& world, int body) {
  Bodies<S>& bodies = world.bodies;
  bodies.moves[body] = 0;
  bodies.velocity[body] = bodies.inertia[body] = bodies.kick[body] = bodies.rest[body] = bodies.shift[body] = Row<S>{};
  bodies.reach[body] = S(0);
}

template <class S> void wake_all(World<S>& world) {
  std::fill(world.sleep.island.begin(), world.sleep.island.end(), -1);
  std::fill(world.sleep.still_s.begin(), world.sleep.still_s.end(), 0.0);
}

template <class S> void fall_asleep(World<S>& world, S h_s) {
  Sleep& sleep = world.sleep;
  const int count = world.bodies.count;
  bool some = false;
  for (int i = 0; i < count; ++i) {
    if (!world.bodies.moves[i]) continue;
    const bool still = surface_speed(world, i) < S(world.options.sleep_below_m_per_s);
    sleep.still_s[i] = still ? sleep.still_s[i] + static_cast<double>(h_s) : 0.0;
    some = some || sleep.still_s[i] >= world.options.sleep_after_s;
  }
  if (!some) return;
  std::iota(sleep.parent.begin(), sleep.parent.end(), 0);
  for (int i = 0; i < count; ++i)
    if (sleep.island[i] >= 0) sleep.parent[i] = sleep.island[i];  // sleepers are together already
  for_touching(world, [&](int a, int b) {
    if (world.bodies.moves[b] || sleep.island[b] >= 0) join(sleep.parent, a, b);  // else b is fixed for good
  });
  std::vector<int>& awake = world.scratch.count;  // of each island: bodies that have not been at rest for long enough
  awake.assign(static_cast<std::size_t>(count), 0);
  for (int i = 0; i < count; ++i)
    if (world.bodies.moves[i] && !(sleep.still_s[i] >= world.options.sleep_after_s)) ++awake[root_of(sleep.parent, i)];
  bool changed = false;
  std::vector<int>& first = world.scratch.colour;  // sleeper of each island, which names it
  first.assign(static_cast<std::size_t>(count), -1);
  for (int i = 0; i < count; ++i) {
    const bool sleeper = sleep.island[i] >= 0;
    if (!sleeper && !world.bodies.moves[i]) continue;
    const int root = root_of(sleep.parent, i);
    if (!sleeper && awake[root] > 0) continue;
    if (first[root] < 0) first[root] = i;
    sleep.island[i] = first[root];
    if (sleeper) continue;
    stop(world, i);
    changed = true;
  }
  if (changed) world.candidates_hold = false;
}

template <class S> bool wake_whom_others_meet(World<S>& world) {
  Sleep& sleep = world.sleep;
  std::vector<int>& woken = world.scratch.count;
  woken.clear();
  const auto meet = [&](int a, int b, S gap) {
    if (!world.bodies.moves[b] && sleep.island[b] >= 0 && moves_about(world, a) && gap <= world.bodies.reach[a])
      woken.push_back(sleep.island[b]);
  };
  for (const Candidate& pair : world.ball_pairs) {
    const Vec3<S> between = load3(world.bodies.place[pair.b].at) - load3(world.bodies.place[pair.a].at);
    meet(pair.a, pair.b, norm(between) - world.geometry[pair.a].radius - world.geometry[pair.b].radius);
  }
  for (const FoundManifold<S>& found : world.manifolds)
    for (int i = 0; i < found.shape.count; ++i) meet(found.a, found.b, found.shape.points[i].gap);
  if (woken.empty()) return false;
  for (int i = 0; i < world.bodies.count; ++i) {
    if (sleep.island[i] < 0 || std::find(woken.begin(), woken.end(), sleep.island[i]) == woken.end()) continue;
    sleep.island[i] = -1;
    sleep.still_s[i] = 0;
    world.bodies.moves[i] = 1;
    load_body(world, i);
  }
  world.candidates_hold = false;
  return true;
}

#define ATWOOD_SLEEP(S)                       \
  template void lay_down<S>(World<S>&, int);  \
  template void wake_all<S>(World<S>&);       \
  template void fall_asleep<S>(World<S>&, S); \
  template bool wake_whom_others_meet<S>(World<S>&);
ATWOOD_SLEEP(float)
ATWOOD_SLEEP(double)
#undef ATWOOD_SLEEP

}  // namespace atwood::stepping
