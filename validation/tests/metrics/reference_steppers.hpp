// Small steppers of this test's own, templates over the scalar, so that the fits are tried on real integration errors
// without the engine: RK4, explicit, symplectic Euler and Verlet, each on a rate written where it is used.
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

namespace atwood::test {

inline double root(double x) { return std::sqrt(x); }
inline long double root(long double x) { return std::sqrt(x); }

template <class S> using State = std::vector<S>;
template <class S> using Rate = std::function<void(S t, const State<S>& y, State<S>& dydt)>;

// samples + 1 states, the first the initial one.
template <class S> std::vector<State<S>> rk4(const Rate<S>& rate, State<S> y, S t_end, int steps, int samples) {
  const S h = t_end / S(steps);
  State<S> k1(y.size()), k2 = k1, k3 = k1, k4 = k1, z = k1;
  const auto stage = [&](S c, const State<S>& k) {
    for (std::size_t i = 0; i < y.size(); ++i) z[i] = y[i] + c * h * k[i];
  };
  std::vector<State<S>> out{y};
  for (int n = 0; n < steps; ++n) {
    const S t = t_end * S(n) / S(steps);
    rate(t, y, k1);
    stage(S(0.5), k1);
    rate(t + h / 2, z, k2);
    stage(S(0.5), k2);
    rate(t + h / 2, z, k3);
    stage(S(1), k3);
    rate(t + h, z, k4);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    if ((n + 1) % (steps / samples) == 0) out.push_back(y);
  }
  return out;
}

template <class S>
std::vector<State<S>> explicit_euler(const Rate<S>& rate, State<S> y, S t_end, int steps, int samples) {
  const S h = t_end / S(steps);
  State<S> k(y.size());
  std::vector<State<S>> out{y};
  for (int n = 0; n < steps; ++n) {
    rate(t_end * S(n) / S(steps), y, k);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += h * k[i];
    if ((n + 1) % (steps / samples) == 0) out.push_back(y);
  }
  return out;
}

// y = (q, v), halves of equal length, q'' depending on q alone. Kick then drift; Verlet: half kick, drift, half kick.
template <class S>
std::vector<State<S>> kick_drift(const Rate<S>& rate, State<S> y, S t_end, int steps, int samples, bool verlet) {
  const S h = t_end / S(steps);
  const std::size_t half = y.size() / 2;
  State<S> k(y.size());
  std::vector<State<S>> out{y};
  const auto kick = [&](S dt) {
    rate(S(0), y, k);
    for (std::size_t i = half; i < y.size(); ++i) y[i] += dt * k[i];
  };
  for (int n = 0; n < steps; ++n) {
    kick(verlet ? h / 2 : h);
    for (std::size_t i = 0; i < half; ++i) y[i] += h * y[half + i];
    if (verlet) kick(h / 2);
    if ((n + 1) % (steps / samples) == 0) out.push_back(y);
  }
  return out;
}

template <class S> void kepler(S, const State<S>& y, State<S>& d) {
  const S r2 = y[0] * y[0] + y[1] * y[1], c = -1 / (r2 * root(r2));
  d = {y[2], y[3], c * y[0], c * y[1]};
}
template <class S> State<S> kepler_start(double e) { return {S(1 - e), S(0), S(0), S(std::sqrt((1 + e) / (1 - e)))}; }

// The near-separatrix box: I = (97/120, 41/60, 17/120), y = (w body, q). g = 0.
template <class S> void tumbling_box(S, const State<S>& y, State<S>& d) {
  const S a = S(97) / 120, b = S(41) / 60, c = S(17) / 120;
  d = {(b - c) / a * y[1] * y[2],
       (c - a) / b * y[2] * y[0],
       (a - b) / c * y[0] * y[1],
       (-y[4] * y[0] - y[5] * y[1] - y[6] * y[2]) / 2,
       (y[3] * y[0] + y[5] * y[2] - y[6] * y[1]) / 2,
       (y[3] * y[1] + y[6] * y[0] - y[4] * y[2]) / 2,
       (y[3] * y[2] + y[4] * y[1] - y[5] * y[0]) / 2};
}

template <class S>
void charge(S, const State<S>& y, State<S>& d) {  // unit charge and mass, E = (0.2, 0, 0), B = (0, 0, 1)
  d = {y[3], y[4], y[5], S(0.2) + y[4], -y[3], S(0)};
}

template <class S> void thrown(S, const State<S>& y, State<S>& d) {  // quadratic drag 0.05 |v| v
  const S c = S(-0.05) * root(y[2] * y[2] + y[3] * y[3]);
  d = {y[2], y[3], c * y[2], c * y[3] - S(9.81)};
}

}  // namespace atwood::test
