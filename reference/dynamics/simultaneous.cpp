#include "dynamics/simultaneous.hpp"

#include <algorithm>
#include <numeric>
#include <type_traits>

#include "dynamics/arithmetic.hpp"
#include "dynamics/complementarity.hpp"

namespace atwood::dynamics {

namespace {

template <class S> constexpr double kRoundOff = std::is_same_v<S, Wide> ? 0x1p-113 : 0x1p-52;
// Approach speeds, and velocities after the impacts, that differ by no more than this relative amount are equal.
template <class S> constexpr double kTieTolerance = std::is_same_v<S, Wide> ? 1e-26 : 1e-9;
constexpr int kMaxPermuted = 4;      // contacts of a group whose orders are all tried: 4! = 24
constexpr int kMaxImpacts = 100000;  // of one group at one instant, in sequence

template <class S> S approach_rate(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y) {
  return gap(scene, layout, pair, y).rate_m_per_s;
}

// An impulse J n at the contact changes the body's velocity by this times J n: -1/m for a, 1/m for b, 0 for a fixed
// body and for a body of another contact.
template <class S> S signed_inverse_mass(const Scene& scene, const Layout& layout, const ContactPair& pair, int body) {
  if (layout.slots[body].velocity < 0 || (body != pair.a && body != pair.b)) return 0;
  return S(body == pair.a ? -1 : 1) / S(scene.bodies[body].mass_kg);
}

// Element (i, j) of the Delassus matrix, n_i M^-1 n_j: the rate of gap i after a unit impulse at contact j.
template <class S>
S delassus(const Scene& scene, const Layout& layout, const ContactPair& i, const ContactPair& j, const Triple<S>& n_i,
           const Triple<S>& n_j) {
  S sum = 0;
  for (const int body : {i.a, i.b}) sum += S(body == i.a ? -1 : 1) * signed_inverse_mass<S>(scene, layout, j, body);
  return sum * dot(n_i, n_j);
}

// Moreau's impact law on all contacts at once; empty when no solution was found.
template <class S>
std::vector<Impulse<S>> solve_moreau(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& pairs,
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
    for (std::size_t j = 0; j < n; ++j) A[i][j] = delassus(scene, layout, pairs[i], pairs[j], normal[i], normal[j]);
  S speed = 0;
  for (const S& each : q) speed = std::max(speed, magnitude(each));
  if (!solve_lcp(A, q, S(kTieTolerance<S>) * speed, 64 * S(n) * S(kRoundOff<S>), impulse)) return {};
  std::vector<Impulse<S>> outcome(n);
  for (std::size_t i = 0; i < n; ++i) {
    outcome[i].normal_N_s = impulse[i];
    for (const int body : {pairs[i].a, pairs[i].b})
      for (int k = 0; k < 3 && layout.slots[body].velocity >= 0; ++k)
        y[layout.slots[body].velocity + k] +=
            signed_inverse_mass<S>(scene, layout, pairs[i], body) * impulse[i] * normal[i][k];
  }
  return outcome;
}

// One impact after another until none of the group approaches. `order` gives the order of preference; empty: the
// fastest approach first. False: it does not end within kMaxImpacts.
template <class S>
bool resolve_in_sequence(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& group,
                         const std::vector<S>& speed_tolerance, const std::vector<int>& order, S* y,
                         std::vector<Impact<S>>& impacts) {
  for (int count = 0; count < kMaxImpacts; ++count) {
    int next = -1;
    S fastest = 0;
    for (int k = 0; k < static_cast<int>(group.size()); ++k) {
      const int at = order.empty() ? k : order[k];
      const S closing = -approach_rate(scene, layout, group[at], y);
      if (!(closing > speed_tolerance[at])) continue;
      if (next >= 0 && (!order.empty() || !(closing > fastest * (1 + S(kTieTolerance<S>))))) continue;
      next = at;
      fastest = closing;
    }
    if (next < 0) return true;
    Impact<S> impact{{group[next]}, {}, std::vector<S>(y, y + layout.size)};
    impact.impulses.push_back(apply_impact_law(scene, layout, group[next], y));
    impacts.push_back(std::move(impact));
  }
  return false;
}

template <class S>
bool same_velocities(const Layout& layout, const std::vector<S>& one, const std::vector<S>& other,
                     const std::vector<S>& start) {
  for (const Kind kind : {Kind::velocity, Kind::rate}) {
    S scale = 0, difference = 0;
    for (int i = 0; i < layout.size; ++i) {
      if (layout.kinds[i] != kind) continue;
      scale = std::max({scale, magnitude(one[i]), magnitude(start[i])});
      difference = std::max(difference, magnitude(one[i] - other[i]));
    }
    if (!(difference <= S(kTieTolerance<S>) * scale)) return false;
  }
  return true;
}

std::string pair_names(const Scene& scene, const std::vector<ContactPair>& group) {
  std::string text;
  for (std::size_t k = 0; k < group.size() && k < 3; ++k)
    text += (k == 0 ? "`" : ", `") + scene.bodies[group[k].a].name + "` with `" + scene.bodies[group[k].b].name + "`";
  return text + (group.size() > 3 ? ", ..." : "");
}

// Do all orders of the contacts and the simultaneous solve give the same velocities as `end`?
template <class S>
bool orders_agree(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& group,
                  const std::vector<S>& speed_tolerance, const std::vector<S>& start, const std::vector<S>& end) {
  if (group.size() > kMaxPermuted) return false;
  std::vector<int> order(group.size());
  std::iota(order.begin(), order.end(), 0);
  do {
    std::vector<S> y = start;
    std::vector<Impact<S>> impacts;
    if (!resolve_in_sequence(scene, layout, group, speed_tolerance, order, y.data(), impacts) ||
        !same_velocities(layout, end, y, start))
      return false;
  } while (std::next_permutation(order.begin(), order.end()));
  for (const ContactPair& pair : group)
    if (pair.friction > 0) return false;
  std::vector<S> y = start;
  return !solve_moreau(scene, layout, group, y.data()).empty() && same_velocities(layout, end, y, start);
}

template <class S>
void resolve_group(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& group,
                   const std::vector<S>& speed_tolerance, S* y, ImpactOutcome<S>& outcome) {
  const std::vector<S> start(y, y + layout.size);
  const bool together = scene.simultaneous_impacts == SimultaneousImpacts::together;
  if (group.size() == 1 || !together) {
    if (!resolve_in_sequence(scene, layout, group, speed_tolerance, {}, y, outcome.impacts))
      outcome.why = "(" + pair_names(scene, group) +
                    ") does not converge: resolved pair by pair, they still approach after " +
                    std::to_string(kMaxImpacts) + " impacts";
    const bool unspecified = scene.simultaneous_impacts == SimultaneousImpacts::unspecified;
    if (group.size() > 1 && unspecified && outcome.why.empty() &&
        !orders_agree(scene, layout, group, speed_tolerance, start, std::vector<S>(y, y + layout.size))) {
      outcome.valid_until_failure = true;
      outcome.why = "(" + pair_names(scene, group) +
                    ") depends on a convention, and the scene states none ([world] simultaneous_impacts)";
    }
    return;
  }
  for (const ContactPair& pair : group)
    if (pair.friction > 0)
      outcome.why =
          "(" + pair_names(scene, group) + ") with friction and simultaneous_impacts = \"together\" is not covered";
  if (group.size() > kMaxSimultaneous)
    outcome.why = "with simultaneous_impacts = \"together\" is covered for at most " +
                  std::to_string(kMaxSimultaneous) + " contacts; found " + std::to_string(group.size());
  if (!outcome.why.empty()) return;
  Impact<S> impact{group, {}, start};
  impact.impulses = solve_moreau(scene, layout, group, y);
  if (impact.impulses.empty())
    outcome.why = "(" + pair_names(scene, group) +
                  ") was not found: the complementarity problem has no solution within its tolerance";
  outcome.impacts.push_back(std::move(impact));
}

}  // namespace

template <class S>
bool coupled(const Scene& scene, const Layout& layout, const ContactPair& one, const ContactPair& other, const S* y) {
  bool shared = false;
  for (const int body : {one.a, one.b})
    shared |= layout.slots[body].velocity >= 0 && (body == other.a || body == other.b);
  if (!shared) return false;
  if (one.friction > 0 || other.friction > 0) return true;
  const S along = dot(gap(scene, layout, one, y).normal, gap(scene, layout, other, y).normal);
  return magnitude(along) > 8 * S(kRoundOff<S>);
}

template <class S>
ImpactOutcome<S> resolve_impacts(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& contacts,
                                 const std::vector<S>& speed_tolerance, S* y) {
  ImpactOutcome<S> outcome;
  const std::size_t n = contacts.size();
  std::vector<bool> grouped(n, false);
  for (std::size_t first = 0; first < n && outcome.why.empty(); ++first) {
    if (grouped[first]) continue;
    std::vector<std::size_t> members{first};
    grouped[first] = true;
    for (std::size_t at = 0; at < members.size(); ++at)
      for (std::size_t other = 0; other < n; ++other)
        if (!grouped[other] && coupled(scene, layout, contacts[members[at]], contacts[other], y)) {
          grouped[other] = true;
          members.push_back(other);
        }
    std::sort(members.begin(), members.end());
    std::vector<ContactPair> group;
    std::vector<S> limits;
    bool approaches = false;
    for (const std::size_t at : members) {
      group.push_back(contacts[at]);
      limits.push_back(speed_tolerance[at]);
      approaches |= approach_rate(scene, layout, contacts[at], y) < -speed_tolerance[at];
    }
    if (approaches) resolve_group(scene, layout, group, limits, y, outcome);
  }
  return outcome;
}

template <class S>
void reapply_impact(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& pairs, S* y) {
  if (pairs.size() == 1) apply_impact_law(scene, layout, pairs.front(), y);
  else solve_moreau(scene, layout, pairs, y);
}

#define ATWOOD_SIMULTANEOUS(S)                                                                            \
  template bool coupled(const Scene&, const Layout&, const ContactPair&, const ContactPair&, const S*);   \
  template ImpactOutcome<S> resolve_impacts(const Scene&, const Layout&, const std::vector<ContactPair>&, \
                                            const std::vector<S>&, S*);                                   \
  template void reapply_impact(const Scene&, const Layout&, const std::vector<ContactPair>&, S*);
ATWOOD_SIMULTANEOUS(double)
ATWOOD_SIMULTANEOUS(Wide)
#undef ATWOOD_SIMULTANEOUS

}  // namespace atwood::dynamics
