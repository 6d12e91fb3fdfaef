#include "dynamics/simultaneous.hpp"

#include <algorithm>
#include <numeric>
#include <type_traits>

#include "dynamics/arithmetic.hpp"
#include "dynamics/complementarity.hpp"

namespace atwood::dynamics {

namespace {

template <class S> constexpr double kRoundOff = std::is_same_v<S, Wide> ? 0x1p-113 : 0x1p-52;
// Approaches that differ by no more than this part of themselves are a tie; outcomes likewise are the same.
template <class S> constexpr double kAlike = std::is_same_v<S, Wide> ? 1e-26 : 1e-9;
constexpr int kMostTried = 4;       // contacts whose orders are all tried: 24
constexpr int kMostBlows = 100000;  // of one group at one instant

template <class S> S rate_of(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y) {
  return gap(scene, layout, pair, y).rate_m_per_s;
}

// What a body's velocity takes of an impulse J n at the contact: sign / m, and 0 for another body or a fixed one.
template <class S> S yields(const Scene& scene, const Layout& layout, const ContactPair& pair, int body) {
  if (layout.slots[body].velocity < 0 || (body != pair.a && body != pair.b)) return 0;
  return S(body == pair.a ? -1 : 1) / S(scene.bodies[body].mass_kg);
}

// n_i M^-1 n_j: how fast impulse j opens gap i.
template <class S>
S compliance(const Scene& scene, const Layout& layout, const ContactPair& i, const ContactPair& j, const Triple<S>& n_i,
             const Triple<S>& n_j) {
  S sum = 0;
  for (const int body : {i.a, i.b}) sum += S(body == i.a ? -1 : 1) * yields<S>(scene, layout, j, body);
  return sum * dot(n_i, n_j);
}

// Moreau's law on all contacts at once; empty when it has no solution.
template <class S>
std::vector<Strike<S>> strike_together(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& pairs,
                                       S* y) {
  const std::size_t n = pairs.size();
  std::vector<Triple<S>> normal;
  std::vector<S> q, impulse;
  for (const ContactPair& pair : pairs) {
    const Gap<S> now = gap(scene, layout, pair, y);
    normal.push_back(now.normal);
    q.push_back(now.rate_m_per_s + S(pair.restitution) * std::min(now.rate_m_per_s, S(0)));
  }
  std::vector<std::vector<S>> A(n, std::vector<S>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) A[i][j] = compliance(scene, layout, pairs[i], pairs[j], normal[i], normal[j]);
  S speed = 0;
  for (const S& each : q) speed = std::max(speed, magnitude(each));
  if (!complementary(A, q, S(kAlike<S>) * speed, 64 * S(n) * S(kRoundOff<S>), impulse)) return {};
  std::vector<Strike<S>> made(n);
  for (std::size_t i = 0; i < n; ++i) {
    made[i].normal_N_s = impulse[i];
    for (const int body : {pairs[i].a, pairs[i].b})
      for (int k = 0; k < 3 && layout.slots[body].velocity >= 0; ++k)
        y[layout.slots[body].velocity + k] += yields<S>(scene, layout, pairs[i], body) * impulse[i] * normal[i][k];
  }
  return made;
}

// `order`: of preference among those that approach; empty: the fastest approach.
template <class S>
bool strike_in_turn(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& group,
                    const std::vector<S>& slow, const std::vector<int>& order, S* y, std::vector<Blow<S>>& blows) {
  for (int count = 0; count < kMostBlows; ++count) {
    int next = -1;
    S fastest = 0;
    for (int k = 0; k < static_cast<int>(group.size()); ++k) {
      const int at = order.empty() ? k : order[k];
      const S closing = -rate_of(scene, layout, group[at], y);
      if (!(closing > slow[at])) continue;
      if (next >= 0 && (!order.empty() || !(closing > fastest * (1 + S(kAlike<S>))))) continue;
      next = at;
      fastest = closing;
    }
    if (next < 0) return true;
    Blow<S> blow{{group[next]}, {}, std::vector<S>(y, y + layout.size)};
    blow.impulses.push_back(strike(scene, layout, group[next], y));
    blows.push_back(std::move(blow));
  }
  return false;
}

template <class S>
bool same(const Layout& layout, const std::vector<S>& one, const std::vector<S>& other, const std::vector<S>& start) {
  for (const Kind kind : {Kind::velocity, Kind::rate}) {
    S scale = 0, apart = 0;
    for (int i = 0; i < layout.size; ++i) {
      if (layout.kinds[i] != kind) continue;
      scale = std::max({scale, magnitude(one[i]), magnitude(start[i])});
      apart = std::max(apart, magnitude(one[i] - other[i]));
    }
    if (!(apart <= S(kAlike<S>) * scale)) return false;
  }
  return true;
}

std::string named(const Scene& scene, const std::vector<ContactPair>& group) {
  std::string text;
  for (std::size_t k = 0; k < group.size() && k < 3; ++k)
    text += (k == 0 ? "`" : ", `") + scene.bodies[group[k].a].name + "` with `" + scene.bodies[group[k].b].name + "`";
  return text + (group.size() > 3 ? ", ..." : "");
}

// Does every order give what the fastest-first order gave, and the solve for all together?
template <class S>
bool orders_agree(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& group,
                  const std::vector<S>& slow, const std::vector<S>& start, const std::vector<S>& end) {
  if (group.size() > kMostTried) return false;
  std::vector<int> order(group.size());
  std::iota(order.begin(), order.end(), 0);
  do {
    std::vector<S> y = start;
    std::vector<Blow<S>> blows;
    if (!strike_in_turn(scene, layout, group, slow, order, y.data(), blows) || !same(layout, end, y, start))
      return false;
  } while (std::next_permutation(order.begin(), order.end()));
  for (const ContactPair& pair : group)
    if (pair.friction > 0) return false;
  std::vector<S> y = start;
  return !strike_together(scene, layout, group, y.data()).empty() && same(layout, end, y, start);
}

template <class S>
void strike_group(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& group,
                  const std::vector<S>& slow, S* y, Resolved<S>& made) {
  const std::vector<S> start(y, y + layout.size);
  const bool together = scene.simultaneous_impacts == SimultaneousImpacts::together;
  if (group.size() == 1 || !together) {
    if (!strike_in_turn(scene, layout, group, slow, {}, y, made.blows))
      made.why = "(" + named(scene, group) + ") has no end: pair by pair they approach each other again and again";
    const bool free_choice = scene.simultaneous_impacts == SimultaneousImpacts::unspecified;
    if (group.size() > 1 && free_choice && made.why.empty() &&
        !orders_agree(scene, layout, group, slow, start, std::vector<S>(y, y + layout.size))) {
      made.branch = true;
      made.why = "(" + named(scene, group) + ") hangs on a convention: [world] simultaneous_impacts names none";
    }
    return;
  }
  for (const ContactPair& pair : group)
    if (pair.friction > 0) made.why = "(" + named(scene, group) + ") solved together with friction is not covered";
  if (group.size() > kMostTogether)
    made.why = "solved together is not covered for more than " + std::to_string(kMostTogether) + " contacts";
  if (!made.why.empty()) return;
  Blow<S> blow{group, {}, start};
  blow.impulses = strike_together(scene, layout, group, y);
  if (blow.impulses.empty()) made.why = "(" + named(scene, group) + ") solved together was not found";
  made.blows.push_back(std::move(blow));
}

}  // namespace

template <class S>
bool couple(const Scene& scene, const Layout& layout, const ContactPair& one, const ContactPair& other, const S* y) {
  bool shared = false;
  for (const int body : {one.a, one.b})
    shared |= layout.slots[body].velocity >= 0 && (body == other.a || body == other.b);
  if (!shared) return false;
  if (one.friction > 0 || other.friction > 0) return true;
  const S along = dot(gap(scene, layout, one, y).normal, gap(scene, layout, other, y).normal);
  return magnitude(along) > 8 * S(kRoundOff<S>);
}

template <class S>
Resolved<S> strike_all(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& touching,
                       const std::vector<S>& slow, S* y) {
  Resolved<S> made;
  const std::size_t n = touching.size();
  std::vector<bool> grouped(n, false);
  for (std::size_t first = 0; first < n && made.why.empty(); ++first) {
    if (grouped[first]) continue;
    std::vector<std::size_t> members{first};
    grouped[first] = true;
    for (std::size_t at = 0; at < members.size(); ++at)
      for (std::size_t other = 0; other < n; ++other)
        if (!grouped[other] && couple(scene, layout, touching[members[at]], touching[other], y)) {
          grouped[other] = true;
          members.push_back(other);
        }
    std::sort(members.begin(), members.end());
    std::vector<ContactPair> group;
    std::vector<S> limits;
    bool approaches = false;
    for (const std::size_t at : members) {
      group.push_back(touching[at]);
      limits.push_back(slow[at]);
      approaches |= rate_of(scene, layout, touching[at], y) < -slow[at];
    }
    if (approaches) strike_group(scene, layout, group, limits, y, made);
  }
  return made;
}

template <class S>
void strike_again(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& pairs, S* y) {
  if (pairs.size() == 1) strike(scene, layout, pairs.front(), y);
  else strike_together(scene, layout, pairs, y);
}

#define ATWOOD_SIMULTANEOUS(S)                                                                                         \
  template bool couple(const Scene&, const Layout&, const ContactPair&, const ContactPair&, const S*);                 \
  template Resolved<S> strike_all(const Scene&, const Layout&, const std::vector<ContactPair>&, const std::vector<S>&, \
                                  S*);                                                                                 \
  template void strike_again(const Scene&, const Layout&, const std::vector<ContactPair>&, S*);
ATWOOD_SIMULTANEOUS(double)
ATWOOD_SIMULTANEOUS(Wide)
#undef ATWOOD_SIMULTANEOUS

}  // namespace atwood::dynamics
