#include "dynamics/last_bounces.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {

template <class S>
LastBounces<S> last_bounces(const Scene& scene, const Dynamics<S>& dynamics, const ContactPair& pair, S t_s, const S* y,
                            int interval, S speed_tolerance) {
  const Layout& layout = dynamics.layout();
  const int n = layout.size;
  const Gap<S> now = gap(scene, layout, pair, y);
  LastBounces<S> made;
  made.dydt.resize(n);
  dynamics.rate(t_s, y, made.dydt.data(), interval);
  const auto attraction = [&](const std::vector<S>& f) {
    S approach_acceleration = 0;
    for (const int body : {pair.a, pair.b})
      if (const int at = layout.slots[body].velocity; at >= 0)
        approach_acceleration += S(body == pair.a ? 1 : -1) * dot(read3(&f[at]), now.normal);
    return approach_acceleration;
  };
  const S approach_acceleration = attraction(made.dydt), speed = magnitude(now.rate_m_per_s), e = pair.restitution;
  made.at_rest = speed <= speed_tolerance;
  made.attracted = approach_acceleration > 0;
  if (!made.attracted || (e >= 1 && !made.at_rest)) return made;
  made.flight_s = 2 * speed / approach_acceleration;
  const S span = made.at_rest ? S(0) : made.flight_s / (1 - e);
  BounceSeries<S>& series = made.series;
  series.pair = pair;
  series.ball = ball_of(scene, pair);
  series.t_rest = t_s + span;
  if (series.ball < 0) return made;
  series.normal = std::get<Plane>(scene.bodies[plane_of(scene, pair)].shape).normal;
  // Three more states: the ball at rest now, falling at its rebound speed, and at rest after the series.
  const int at = layout.slots[series.ball].velocity;
  const S outward = series.ball == pair.b ? now.rate_m_per_s : -now.rate_m_per_s;
  made.y_at_rest.assign(y, y + n);
  std::vector<S> falling = made.y_at_rest, later, f(n), rates_at_rest(n);
  for (int k = 0; k < 3; ++k) {
    made.y_at_rest[at + k] -= outward * now.normal[k];
    falling[at + k] -= 2 * outward * now.normal[k];
  }
  later = made.y_at_rest;
  for (int i = 0; i < n; ++i) later[i] += span * made.dydt[i];
  for (int k = 0; k < 3; ++k) later[at + k] = made.y_at_rest[at + k];
  dynamics.rate(t_s, made.y_at_rest.data(), rates_at_rest.data(), interval);
  S low = std::min(approach_acceleration, attraction(rates_at_rest)),
    high = std::max(approach_acceleration, attraction(rates_at_rest));
  dynamics.rate(t_s + span, later.data(), f.data(), interval);
  low = std::min(low, attraction(f));
  high = std::max(high, attraction(f));
  dynamics.rate(t_s, falling.data(), f.data(), interval);
  low = std::min(low, attraction(f));
  high = std::max(high, attraction(f));
  // The rates that the series neglects. The reaction of the plane cancels the ball's normal component.
  const auto without_normal = [&](const std::vector<S>& rates) {
    std::vector<S> left(n, S(0));
    for (int i = 0; i < n; ++i)
      if (layout.kinds[i] != Kind::position) left[i] = rates[i] - rates_at_rest[i];
    const S along = dot(read3(&left[at]), now.normal);
    for (int k = 0; k < 3; ++k) left[at + k] -= along * now.normal[k];
    return left;
  };
  const std::vector<S> down = without_normal(f), up = without_normal(made.dydt);
  series.neglected.assign(n, S(0));
  for (int i = 0; i < n; ++i) series.neglected[i] = span * std::max(magnitude(down[i]), magnitude(up[i]));
  for (const Slot& slot : layout.slots)
    for (int k = 0; k < 3 && slot.velocity >= 0; ++k)
      series.neglected[slot.position + k] = span * series.neglected[slot.velocity + k];
  const S change = 2 * (high - low) / approach_acceleration;
  made.converges = made.at_rest || (low > 0 && change < 1 && e * (1 + change) < 1);
  if (made.at_rest || !made.converges) return made;
  series.bar_s = span * std::max((1 + change) * (1 - e) / (1 - e * (1 + change)) - 1,
                                 1 - (1 - change) * (1 - e) / (1 - e * (1 - change)));
  series.height_m = speed * speed / (2 * low);
  series.speed_m_per_s = speed;
  series.duration_per_speed = 2 / (low * (1 - e));
  return made;
}

template LastBounces<double> last_bounces(const Scene&, const Dynamics<double>&, const ContactPair&, double,
                                          const double*, int, double);
template LastBounces<Wide> last_bounces(const Scene&, const Dynamics<Wide>&, const ContactPair&, Wide, const Wide*, int,
                                        Wide);

}  // namespace atwood::dynamics
