#include "dynamics/last_bounces.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {

template <class S>
LastBounces<S> last_bounces(const Scene& scene, const Dynamics<S>& dynamics, const ContactPair& pair, S t_s, const S* y,
                            int interval, S slow) {
  const Layout& layout = dynamics.layout();
  const int n = layout.size;
  const Gap<S> now = gap(scene, layout, pair, y);
  LastBounces<S> made;
  made.dydt.resize(n);
  dynamics.rate(t_s, y, made.dydt.data(), interval);
  const auto pull_of = [&](const std::vector<S>& f) {
    S pull = 0;
    for (const int body : {pair.a, pair.b})
      if (const int at = layout.slots[body].velocity; at >= 0)
        pull += S(body == pair.a ? 1 : -1) * dot(read3(&f[at]), now.normal);
    return pull;
  };
  const S pull = pull_of(made.dydt), speed = magnitude(now.rate_m_per_s), e = pair.restitution;
  made.lies = speed <= slow;
  made.pulled = pull > 0;
  if (!made.pulled || (e >= 1 && !made.lies)) return made;
  made.flight_s = 2 * speed / pull;
  const S span = made.lies ? S(0) : made.flight_s / (1 - e);
  Laid<S>& laid = made.laid;
  laid.pair = pair;
  laid.ball = ball_of(scene, pair);
  laid.until = t_s + span;
  if (laid.ball < 0) return made;
  laid.normal = std::get<Plane>(scene.bodies[plane_of(scene, pair)].shape).normal;
  // The ball held, falling as fast as it leaves, and at the end of its bounces.
  const int at = layout.slots[laid.ball].velocity;
  const S outward = laid.ball == pair.b ? now.rate_m_per_s : -now.rate_m_per_s;
  made.held.assign(y, y + n);
  std::vector<S> falling = made.held, later, f(n), quiet(n);
  for (int k = 0; k < 3; ++k) {
    made.held[at + k] -= outward * now.normal[k];
    falling[at + k] -= 2 * outward * now.normal[k];
  }
  later = made.held;
  for (int i = 0; i < n; ++i) later[i] += span * made.dydt[i];
  for (int k = 0; k < 3; ++k) later[at + k] = made.held[at + k];
  dynamics.rate(t_s, made.held.data(), quiet.data(), interval);
  S low = std::min(pull, pull_of(quiet)), high = std::max(pull, pull_of(quiet));
  dynamics.rate(t_s + span, later.data(), f.data(), interval);
  low = std::min(low, pull_of(f));
  high = std::max(high, pull_of(f));
  dynamics.rate(t_s, falling.data(), f.data(), interval);
  low = std::min(low, pull_of(f));
  high = std::max(high, pull_of(f));
  // What is left out of the rates; the plane answers for the ball's part along the normal.
  const auto without_normal = [&](const std::vector<S>& rates) {
    std::vector<S> left(n, S(0));
    for (int i = 0; i < n; ++i)
      if (layout.kinds[i] != Kind::position) left[i] = rates[i] - quiet[i];
    const S along = dot(read3(&left[at]), now.normal);
    for (int k = 0; k < 3; ++k) left[at + k] -= along * now.normal[k];
    return left;
  };
  const std::vector<S> down = without_normal(f), up = without_normal(made.dydt);
  laid.push.assign(n, S(0));
  for (int i = 0; i < n; ++i) laid.push[i] = span * std::max(magnitude(down[i]), magnitude(up[i]));
  for (const Slot& slot : layout.slots)
    for (int k = 0; k < 3 && slot.velocity >= 0; ++k)
      laid.push[slot.position + k] = span * laid.push[slot.velocity + k];
  const S change = 2 * (high - low) / pull;
  made.ends = made.lies || (low > 0 && change < 1 && e * (1 + change) < 1);
  if (made.lies || !made.ends) return made;
  laid.bar_s = span * std::max((1 + change) * (1 - e) / (1 - e * (1 + change)) - 1,
                               1 - (1 - change) * (1 - e) / (1 - e * (1 - change)));
  laid.height_m = speed * speed / (2 * low);
  laid.speed_m_per_s = speed;
  laid.per_speed = 2 / (low * (1 - e));
  return made;
}

template LastBounces<double> last_bounces(const Scene&, const Dynamics<double>&, const ContactPair&, double,
                                          const double*, int, double);
template LastBounces<Wide> last_bounces(const Scene&, const Dynamics<Wide>&, const ContactPair&, Wide, const Wide*, int,
                                        Wide);

}  // namespace atwood::dynamics
