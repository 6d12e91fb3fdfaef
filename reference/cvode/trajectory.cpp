#include "cvode/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"

namespace atwood::cvode {

using dynamics::Triple;

namespace {

constexpr double kPositionRoundOff = 64 * 0x1p-52;  // of the coordinates from which a gap is computed

double radius_of(const Body& body) {
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  return sphere != nullptr ? sphere->radius_m : 0;
}

}  // namespace

void Trajectory::state(double at_s, std::vector<double>& y) const {
  const double u = unit(at_s);
  y = c.back();
  for (std::size_t k = c.size() - 1; k-- > 0;)
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = y[i] * u + c[k][i];
}

Polynomial Trajectory::component(int i) const {
  Polynomial made;
  for (const auto& power : c) made.push_back(power[i]);
  return made;
}

SwitchingFunction gap_function(const Scene& scene, const dynamics::Layout& layout, const dynamics::ContactPair& pair,
                               const Trajectory& path, double shift_m, double sign) {
  const auto position = [&](int body) {
    std::array<Polynomial, 3> made;
    const int at = layout.slots[body].position;
    for (int k = 0; k < 3; ++k)
      made[k] = at >= 0 ? path.component(at + k) : Polynomial{scene.bodies[body].position_m[k]};
    return made;
  };
  const auto add = [](Polynomial& to, double factor, const Polynomial& from) {
    to.resize(std::max(to.size(), from.size()), 0);
    for (std::size_t k = 0; k < from.size(); ++k) to[k] += factor * from[k];
  };
  const bool ball_first = std::holds_alternative<Sphere>(scene.bodies[pair.a].shape);
  const int ball = ball_first ? pair.a : pair.b, other = ball_first ? pair.b : pair.a;
  const Body& surface = scene.bodies[other];
  const std::array<Polynomial, 3> centre = position(ball);
  double size = radius_of(scene.bodies[ball]) + radius_of(surface);
  for (const Polynomial& x : centre) size += std::fabs(x[0]);
  SwitchingFunction made;
  made.sign = sign;
  made.level = radius_of(scene.bodies[ball]) + shift_m;
  if (const auto* plane = std::get_if<Plane>(&surface.shape)) {
    made.flat = true;
    const Triple<double> n = dynamics::widen<double>(plane->normal);
    const double inverse = dynamics::rsqrt(dynamics::dot(n, n));
    Polynomial along{-plane->offset_m * inverse};
    for (int k = 0; k < 3; ++k) add(along, n[k] * inverse, centre[k]);
    made.x = {along};
    made.round_off = kPositionRoundOff * size;
    return made;
  }
  std::array<Polynomial, 3> apart = centre;
  const std::array<Polynomial, 3> origin = position(other);
  for (int k = 0; k < 3; ++k) add(apart[k], -1, origin[k]);
  if (std::holds_alternative<Sphere>(surface.shape)) {
    made.level += radius_of(surface);
    made.x.assign(apart.begin(), apart.end());
  } else {
    std::array<double, 4> q = surface.orientation_wxyz;
    const double inverse = dynamics::rsqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& part : q) part *= inverse;
    for (int k = 0; k < 3; ++k) {
      Triple<double> axis{};
      axis[k] = 1;
      axis = dynamics::rotate(q, axis);
      Polynomial& local = made.x.emplace_back();
      for (int i = 0; i < 3; ++i) add(local, axis[i], apart[i]);
    }
    if (const auto* box = std::get_if<Box>(&surface.shape)) {
      made.half = {box->half_extents_m[0], box->half_extents_m[1], box->half_extents_m[2]};
    } else {
      const auto& rectangle = std::get<Rectangle>(surface.shape);
      made.half = {rectangle.half_extents_m[0], rectangle.half_extents_m[1], 0};
    }
  }
  made.round_off = 2 * made.level * kPositionRoundOff * size;
  return made;
}

Reaches::Reaches(const Scene& scene, const dynamics::Layout& layout, const Trajectory& path, double from_s, double to_s)
    : scene_(scene), layout_(layout), radius_m_(scene.bodies.size(), 0) {
  const double from = path.unit(from_s), to = path.unit(to_s), middle = from + (to - from) / 2, r = (to - from) / 2;
  path.state(path.time(middle), middle_);
  for (std::size_t i = 0; i < radius_m_.size(); ++i) {
    const int at = layout.slots[i].position;
    if (at < 0) continue;
    for (int k = 0; k < 3; ++k) {
      const Polynomial x = shifted(path.component(at + k), middle);
      double way = 0;
      for (std::size_t n = x.size(); n-- > 1;) way = (way + std::fabs(x[n])) * r;
      radius_m_[i] += way * way;
    }
    radius_m_[i] = std::sqrt(radius_m_[i]);
  }
}

double Reaches::least_gap(const dynamics::ContactPair& pair) const {
  return gap(scene_, layout_, pair, middle_.data()).gap_m - radius_m_[pair.a] - radius_m_[pair.b];
}

const std::array<double, kSamplePoints>& sample_points() {
  static const std::array<double, kSamplePoints> points = [] {
    std::array<double, kSamplePoints> made;
    for (int k = 0; k < kSamplePoints; ++k) made[k] = -std::cos(M_PI * k / (kSamplePoints - 1));
    return made;
  }();
  return points;
}

// a_n = (2/N) sum'' f(x_k) T_n(x_k), the first and last terms halved (and a_0, a_N); then in powers of x.
Polynomial through(const std::array<double, kSamplePoints>& values, double& size, double& tail) {
  constexpr int last = kSamplePoints - 1;
  std::array<double, kSamplePoints> a{};
  for (int n = 0; n <= last; ++n) {
    for (int k = 0; k <= last; ++k) {
      const double weight = (k == 0 || k == last) ? 0.5 : 1;
      a[n] += weight * values[k] * std::cos(M_PI * n * (last - k) / last);
    }
    a[n] *= (n == 0 || n == last ? 1.0 : 2.0) / last;
  }
  size = 0;
  for (const double each : a) size = std::max(size, std::fabs(each));
  tail = std::fabs(a[last]) + std::fabs(a[last - 1]) + std::fabs(a[last - 2]);
  Polynomial made(kSamplePoints, 0), before{1}, now{0, 1};
  made[0] = a[0];
  for (int n = 1; n <= last; ++n) {
    for (std::size_t k = 0; k < now.size(); ++k) made[k] += a[n] * now[k];
    Polynomial next(now.size() + 1, 0);
    for (std::size_t k = 0; k < now.size(); ++k) next[k + 1] += 2 * now[k];
    for (std::size_t k = 0; k < before.size(); ++k) next[k] -= before[k];
    before = std::move(now);
    now = std::move(next);
  }
  return made;
}

}  // namespace atwood::cvode
