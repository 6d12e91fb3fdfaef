// Sleep: bodies in contact form an island. An island whose bodies have all been at rest for sleep_after_s is put to
// sleep: its bodies are treated as fixed, and cost nothing. It wakes as a whole when a moving body may touch one of its
// own within the step, or when forces change.
//
// A body that comes to rest on a sleeping island joins it. The momentum of bodies slower than sleep_below_m_per_s is
// lost, so sleeping is off by default; contact forces offset sleeping bodies are not reported.
#include <algorithm>
#include <numeric>

#include "contact/stepping/contact_points.hpp"
#include "scene/union_find.hpp"

namespace atwood::stepping {
namespace {

// Bound on the speed of the body's surface points.
template <class S> S max_surface_speed(const World<S>& world, int body) {
  const S* v = world.bodies.velocity[body].at;
  return norm(load3(v)) + world.geometry[body].bounding_radius * norm(load3(v + 3));
}

// visit(a, b) of each contact that carries an impulse; a moves.
template <class S, class Visit> void for_loaded_pairs(const World<S>& world, const Visit& visit) {
  for (int contact = 0; contact < point_count(world); ++contact) {
    if (!is_contact(world, contact)) continue;
    const ContactAddress at = address_of(world, contact);
    const S impulse_n = at.point < 0 ? sphere_batch(world, at).impulse_n.lane[at.lane]
                                     : manifold_batch(world, at).point[at.point].impulse_n.lane[at.lane];
    if (!(impulse_n > S(0))) continue;
    const auto [a, b] = bodies_of(world, contact);
    visit(a, b);
  }
}

// Sets the velocity to 0 and treats the body as fixed.
template <class S> void stop(World<S>& world, int body) {
  BodyState<S> state{load3(world.bodies.pose[body].at), {}, world.bodies.q_WB[body], {}};
  world.model->set_body(body, state, world.y.data());
  freeze_body(world, body);
}

// Faster than the limit of sleep.
template <class S> bool is_moving(const World<S>& world, int body) {
  return world.bodies.moves[body] && world.sleep.time_at_rest_s[static_cast<std::size_t>(body)] == 0;
}

}  // namespace

template <class S> void freeze_body(World<S>& world, int body) {
  BodyRows<S>& bodies = world.bodies;
  bodies.moves[body] = 0;
  bodies.velocity[body] = bodies.inertia[body] = bodies.velocity_increment[body] = bodies.pose_increment[body] =
      bodies.impact_shift[body] = Row<S>{};
  bodies.motion_bound[body] = S(0);
}

template <class S> void wake_all(World<S>& world) {
  std::fill(world.sleep.sleeping_island.begin(), world.sleep.sleeping_island.end(), -1);
  std::fill(world.sleep.time_at_rest_s.begin(), world.sleep.time_at_rest_s.end(), 0.0);
}

template <class S> void put_islands_to_sleep(World<S>& world, S h_s) {
  Sleep& sleep = world.sleep;
  const int count = world.bodies.count;
  bool any_ready = false;
  for (int i = 0; i < count; ++i) {
    if (!world.bodies.moves[i]) continue;
    const bool slow = max_surface_speed(world, i) < S(world.options.sleep_below_m_per_s);
    sleep.time_at_rest_s[i] = slow ? sleep.time_at_rest_s[i] + static_cast<double>(h_s) : 0.0;
    any_ready = any_ready || sleep.time_at_rest_s[i] >= world.options.sleep_after_s;
  }
  if (!any_ready) return;
  std::iota(sleep.parent.begin(), sleep.parent.end(), 0);
  for (int i = 0; i < count; ++i)
    if (sleep.sleeping_island[i] >= 0) sleep.parent[i] = sleep.sleeping_island[i];  // sleeping islands stay together
  for_loaded_pairs(world, [&](int a, int b) {
    if (world.bodies.moves[b] || sleep.sleeping_island[b] >= 0) unite(sleep.parent, a, b);  // else b is a fixed body
  });
  std::vector<int>& awake = world.scratch.count;  // by root: bodies that are not ready to sleep
  awake.assign(static_cast<std::size_t>(count), 0);
  for (int i = 0; i < count; ++i)
    if (world.bodies.moves[i] && !(sleep.time_at_rest_s[i] >= world.options.sleep_after_s))
      ++awake[find_root(sleep.parent, i)];
  bool changed = false;
  std::vector<int>& first = world.scratch.colour;  // by root: the first sleeping body, which names the island
  first.assign(static_cast<std::size_t>(count), -1);
  for (int i = 0; i < count; ++i) {
    const bool asleep = sleep.sleeping_island[i] >= 0;
    if (!asleep && !world.bodies.moves[i]) continue;
    const int root = find_root(sleep.parent, i);
    if (!asleep && awake[root] > 0) continue;
    if (first[root] < 0) first[root] = i;
    sleep.sleeping_island[i] = first[root];
    if (asleep) continue;
    stop(world, i);
    changed = true;
  }
  if (changed) world.candidates.valid = false;
}

template <class S> bool wake_touched_islands(World<S>& world) {
  Sleep& sleep = world.sleep;
  std::vector<int>& woken = world.scratch.count;
  woken.clear();
  const auto wake_if_near = [&](int a, int b, S gap) {
    if (!world.bodies.moves[b] && sleep.sleeping_island[b] >= 0 && is_moving(world, a) &&
        gap <= world.bodies.motion_bound[a])
      woken.push_back(sleep.sleeping_island[b]);
  };
  for (const CandidatePair& pair : world.candidates.sphere_pairs) {
    const Vec3<S> offset = load3(world.bodies.pose[pair.b].at) - load3(world.bodies.pose[pair.a].at);
    wake_if_near(pair.a, pair.b, norm(offset) - world.geometry[pair.a].radius - world.geometry[pair.b].radius);
  }
  for (const ContactManifold<S>& manifold : world.manifolds)
    for (int i = 0; i < manifold.geometry.count; ++i)
      wake_if_near(manifold.a, manifold.b, manifold.geometry.points[i].gap);
  if (woken.empty()) return false;
  for (int i = 0; i < world.bodies.count; ++i) {
    if (sleep.sleeping_island[i] < 0 || std::find(woken.begin(), woken.end(), sleep.sleeping_island[i]) == woken.end())
      continue;
    sleep.sleeping_island[i] = -1;
    sleep.time_at_rest_s[i] = 0;
    world.bodies.moves[i] = 1;
    load_body(world, i);
  }
  world.candidates.valid = false;
  return true;
}

#define ATWOOD_SLEEP(S)                                \
  template void freeze_body<S>(World<S>&, int);        \
  template void wake_all<S>(World<S>&);                \
  template void put_islands_to_sleep<S>(World<S>&, S); \
  template bool wake_touched_islands<S>(World<S>&);
ATWOOD_SLEEP(float)
ATWOOD_SLEEP(double)
#undef ATWOOD_SLEEP

}  // namespace atwood::stepping
