// A Sinai billiard on its own: a ball among fixed ones, elastic or not, without forces. Sixty digits, straight flights
// from sphere to sphere by the quadratic's root.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "protocol/truth.hpp"
#include "scenes.hpp"

namespace atwood::scenes {

using Digits60 = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>, boost::multiprecision::et_off>;
using Vector60 = std::array<Digits60, 3>;

// SplitMix64 (Steele, Lea and Flood 2014), in [0, 1).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

// A ball inside a ring of 8 large fixed balls, three of them moved at random, and one in the middle; everything
// times `unit` metres.
inline Scenario sinai(std::uint64_t seed, double restitution, double t_end_s, double unit = 1, bool solid = false) {
  Random random(seed);
  Scene scene = empty_scene();
  scene.materials[0].restitution = scene.pairs[0].restitution = restitution;
  for (int k = 0; k < 8; ++k) {
    const double angle = 0.78539816339744828 * k, r = 2 + 0.2 * random();
    scene.bodies.push_back(
        point("post" + std::to_string(k), 0, {unit * r * std::cos(angle), unit * r * std::sin(angle), 0}, {0, 0, 0}));
  }
  scene.bodies.push_back(point("post8", 0, {0.2 * unit * random(), 0.2 * unit * random(), 0}, {0, 0, 0}));
  for (Body& body : scene.bodies) {
    body.fixed = true;
    body.shape = Sphere{unit * (body.name == "post8" ? 0.3 : 0.85)};
  }
  const double heading = 6.28 * random(), at = 6.28 * random();
  Body ball = point("ball", 0.5 + random(), {0.7 * unit * std::cos(at), 0.7 * unit * std::sin(at), 0},
                    {unit * std::cos(heading), unit * std::sin(heading), 0});
  ball.shape = Sphere{unit * 0.05};
  if (solid) ball.inertia_kg_m2 = {0.001 * unit * unit, 0, 0, 0, 0.001 * unit * unit, 0, 0, 0, 0.001 * unit * unit};
  scene.bodies.push_back(ball);
  return scenario(scene, t_end_s);
}

struct Flight60 {
  Vector60 p{}, v{};
};

// The free ball (the last body) at t_end k / samples, and how many impacts there were.
inline std::vector<Flight60> fly60(const Scenario& given, int samples, int& impacts) {
  const Scene& scene = given.scene;
  const Body& ball = scene.bodies.back();
  const double radius = std::get<Sphere>(ball.shape).radius_m, e = scene.pairs[0].restitution;
  Vector60 p, v;
  for (int k = 0; k < 3; ++k) p[k] = ball.position_m[k], v[k] = ball.velocity_m_per_s[k];
  const auto dot = [](const Vector60& a, const Vector60& b) -> Digits60 {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  Digits60 t = 0;
  int last = -1;
  std::vector<Flight60> made;
  impacts = 0;
  for (int sample = 0; sample <= samples;) {
    Digits60 wait = Digits60(given.t_end_s) * 2;
    int next = -1;
    for (int i = 0; i + 1 < static_cast<int>(scene.bodies.size()); ++i) {
      if (i == last) continue;  // convex: not twice in a row
      Vector60 d;
      for (int k = 0; k < 3; ++k) d[k] = p[k] - Digits60(scene.bodies[i].position_m[k]);
      const Digits60 reach = Digits60(std::get<Sphere>(scene.bodies[i].shape).radius_m) + radius;
      const Digits60 b = dot(d, v), c = dot(d, d) - reach * reach, inside = b * b - dot(v, v) * c;
      if (!(b < 0) || !(inside > 0)) continue;
      const Digits60 at = c / (sqrt(inside) - b);
      if (at < wait) wait = at, next = i;
    }
    const Digits60 until = t + wait;
    for (; sample <= samples; ++sample) {
      const Digits60 when = Digits60(given.t_end_s) * sample / samples;
      if (next >= 0 && when > until) break;
      Flight60 here{p, v};
      for (int k = 0; k < 3; ++k) here.p[k] += (when - t) * v[k];
      made.push_back(here);
    }
    if (next < 0 || sample > samples) break;
    t = until;
    Vector60 n;
    const Digits60 reach = Digits60(std::get<Sphere>(scene.bodies[next].shape).radius_m) + radius;
    for (int k = 0; k < 3; ++k) {
      p[k] += wait * v[k];
      n[k] = (p[k] - Digits60(scene.bodies[next].position_m[k])) / reach;
    }
    const Digits60 rate = dot(v, n);
    for (int k = 0; k < 3; ++k) v[k] -= (1 + Digits60(e)) * rate * n[k];
    last = next;
    ++impacts;
  }
  return made;
}

inline Digits60 digits60(Wide x) {  // exact: two doubles do not hold 113 bits, three do
  const double a = static_cast<double>(x), b = static_cast<double>(x - a), c = static_cast<double>(x - a - b);
  return Digits60(a) + b + c;
}

// The largest error in units of its bar, positions and velocities of the free ball; in the samples that there are.
inline double worst_ratio(const Truth& truth, const std::vector<Flight60>& exact) {
  double worst = 0;
  const std::size_t ball = truth.values.empty() ? 0 : truth.values.front().bodies.size() - 1;
  for (std::size_t k = 1; k < truth.values.size() && k < exact.size(); ++k)
    for (int i = 0; i < 3; ++i) {
      const auto see = [&](Wide value, Wide bar, const Digits60& right) {
        const double error = static_cast<double>(abs(digits60(value) - right));
        if (error > 0) worst = std::max(worst, error / static_cast<double>(bar));
      };
      see(truth.values[k].bodies[ball].p_m[i], truth.bars[k].bodies[ball].p_m[i], exact[k].p[i]);
      see(truth.values[k].bodies[ball].v_m_per_s[i], truth.bars[k].bodies[ball].v_m_per_s[i], exact[k].v[i]);
    }
  return worst;
}

}  // namespace atwood::scenes
