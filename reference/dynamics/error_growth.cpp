#include "dynamics/error_growth.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {

namespace {

constexpr double kRelativeStep = 1e-7;       // of a component's own size, for derivatives of the flow in double
constexpr double kQuadRelativeStep = 1e-13;  // for derivatives of an impact, in quad
// The derivative has converged when halving the step changes it by at most kDerivativeTolerance of its size, or, from
// kRoundOffSubsteps on (where round-off of the differences may dominate), by at most kDerivativeToleranceAtRoundOff.
// The inflation then covers the change.
constexpr double kDerivativeTolerance = 1e-6, kDerivativeToleranceAtRoundOff = 1e-3;
constexpr int kRoundOffSubsteps = 128;
constexpr int kMaxSubsteps = 1 << 14;
constexpr double kMinInflation = 1 + 1e-5;  // for the error of difference quotients

using Eigen::VectorXd;
Eigen::Map<const VectorXd> vector_of(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}

double length(const Wide* v) { return std::sqrt(static_cast<double>(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])); }

bool couples_bodies(const Force& force) {
  if (std::holds_alternative<MutualGravity>(force) || std::holds_alternative<Coulomb>(force)) return true;
  const auto* spring = std::get_if<Spring>(&force);
  return spring != nullptr && spring->bodies.size() > 1;
}

double radius_of(const Body& body) {
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  return sphere == nullptr ? 0 : sphere->radius_m;
}

}  // namespace

ErrorGrowth::ErrorGrowth(const Scene& scene, double t_end_s, double round_off)
    : scene_(scene), dynamics_(scene, t_end_s), free_dynamics_(scene, t_end_s), double_dynamics_(scene, t_end_s),
      layout_(dynamics_.layout()), round_off_(round_off), body_(layout_.size), scale_(layout_.size, 1),
      rho_(layout_.size, 0) {
  for (const Force& force : scene.forces) coupled_ |= couples_bodies(force);
  const std::vector<Wide> y = pack<Wide>(scene);
  std::vector<Wide> f(y.size());
  dynamics_.rate(0, y.data(), f.data(), 0);
  double far = 0, fast = 0, turning = 0, pull = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Slot& slot = layout_.slots[i];
    far = std::max(far, radius_of(scene.bodies[i]));
    if (slot.position < 0) continue;
    for (int k = 0; k < 3; ++k) body_[slot.position + k] = static_cast<int>(i);
    far = std::max(far, length(&y[slot.position]));
    if (slot.velocity < 0) continue;
    for (int k = 0; k < 3; ++k) body_[slot.velocity + k] = static_cast<int>(i);
    fast = std::max(fast, length(&y[slot.velocity]));
    pull = std::max(pull, length(&f[slot.velocity]));
    if (slot.attitude < 0) continue;
    for (int k = 0; k < 7; ++k) body_[slot.attitude + k] = static_cast<int>(i);
    turning = std::max(turning, length(&y[slot.rate]));
  }
  if (!(far > 0)) far = 1;
  fast = std::max({fast, std::sqrt(pull * far), far / t_end_s});
  turning = std::max(turning, fast / far);
  for (int i = 0; i < layout_.size; ++i) switch (layout_.kinds[i]) {
      case Kind::position: scale_[i] = far; break;
      case Kind::velocity: scale_[i] = fast; break;
      case Kind::attitude: scale_[i] = 1; break;
      case Kind::rate: scale_[i] = turning; break;
    }
  Q_.assign(layout_.size, std::vector<double>(layout_.size, 0));
  for (int i = 0; i < layout_.size; ++i) Q_[i][i] = 1;
}

// Magnitude of the numbers from which a body's position is computed: round-off is relative to it.
double ErrorGrowth::position_magnitude(int body, const Wide* y, double span_s) const {
  const Slot& slot = layout_.slots[body];
  const Body& given = scene_.bodies[body];
  if (const auto* plane = std::get_if<Plane>(&given.shape)) return std::fabs(plane->offset_m);
  if (slot.position < 0) {
    const auto& p = given.position_m;
    return radius_of(given) + std::hypot(p[0], p[1], p[2]);
  }
  return radius_of(given) + length(y + slot.position) + (slot.velocity < 0 ? 0 : span_s * length(y + slot.velocity));
}

double ErrorGrowth::speed(int body, const Wide* y) const {
  const Slot& slot = layout_.slots[body];
  return slot.velocity < 0 ? 0 : length(y + slot.velocity);
}

// Round-off of a stretch: `ulps` units in the last place of each body's own values.
std::vector<double> ErrorGrowth::round_off_bound(const std::vector<Wide>& y, double span_s, double ulps) const {
  std::vector<double> made(layout_.size);
  for (int i = 0; i < layout_.size; ++i) {
    const int body = body_[i];
    double size = 1;
    if (layout_.kinds[i] == Kind::position) size = position_magnitude(body, y.data(), span_s);
    if (layout_.kinds[i] == Kind::velocity) size = speed(body, y.data());
    if (layout_.kinds[i] == Kind::rate) size = length(&y[layout_.slots[body].rate]);
    made[i] = ulps * round_off_ * size;
  }
  return made;
}

// Columns of the flow's derivative by central differences, with `steps` steps of RK4 for the flow. Without coupling
// between bodies the same component of all bodies is perturbed at once.
ErrorGrowth::Columns ErrorGrowth::derivative(double t_s, double span_s, const std::vector<double>& y, int interval,
                                             int steps) {
  const int n = layout_.size;
  const double h = span_s / steps;
  std::vector<double> k1(n), k2(n), k3(n), k4(n), stage(n);
  // The change of the state: over a short span the state itself would lose digits by cancellation.
  const auto flow = [&](const std::vector<double>& start) {
    std::vector<double> from = start, added(n, 0);
    for (int step = 0; step < steps; ++step) {
      const double t = t_s + step * h;
      const auto shifted = [&](const std::vector<double>& k, double part) {
        for (int i = 0; i < n; ++i) stage[i] = from[i] + part * h * k[i];
        return stage.data();
      };
      double_dynamics_.rate(t, from.data(), k1.data(), interval);
      double_dynamics_.rate(t + h / 2, shifted(k1, 0.5), k2.data(), interval);
      double_dynamics_.rate(t + h / 2, shifted(k2, 0.5), k3.data(), interval);
      double_dynamics_.rate(t + h, shifted(k3, 1), k4.data(), interval);
      for (int i = 0; i < n; ++i) {
        added[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
        from[i] = start[i] + added[i];
      }
    }
    return added;
  };
  Columns made(n, std::vector<double>(n, 0));
  std::vector<bool> done(n, false);
  for (int first = 0; first < n; ++first) {
    if (done[first]) continue;
    // The same component of every other body.
    std::vector<int> at{first};
    if (!coupled_) {
      const auto place = [&](int i) {
        const Slot& slot = layout_.slots[body_[i]];
        if (layout_.kinds[i] == Kind::position) return i - slot.position;
        if (layout_.kinds[i] == Kind::velocity) return 3 + i - slot.velocity;
        return 6 + i - slot.attitude;
      };
      for (int i = first + 1; i < n; ++i)
        if (!done[i] && body_[i] != body_[first] && place(i) == place(first)) at.push_back(i);
    }
    std::vector<double> up = y, down = y, step(n, 0);
    for (const int i : at) {
      done[i] = true;
      const bool turns = layout_.kinds[i] == Kind::attitude || layout_.kinds[i] == Kind::rate;
      step[i] = kRelativeStep * std::max((turns ? 1 : 1e-3) * scale_[i], std::fabs(y[i]));
      up[i] += step[i];
      down[i] -= step[i];
      step[i] = up[i] - down[i];
    }
    up = flow(up);
    down = flow(down);
    for (const int i : at)
      for (int j = 0; j < n; ++j)
        if (at.size() == 1 || body_[j] == body_[i])
          made[i][j] = (i == j ? 1 : 0) + (up[j] - down[j]) / step[i] * scale_[i] / scale_[j];
  }
  return made;
}

void ErrorGrowth::flow(Wide t_s, Wide t_next_s, const std::vector<Wide>& y, int interval, double steps) {
  const double span = static_cast<double>(t_next_s - t_s);
  if (!(span > 0) || !finite_) return;
  const std::vector<double> narrow = [&] {
    std::vector<double> made;
    for (const Wide& each : y) made.push_back(static_cast<double>(each));
    return made;
  }();
  const double t = static_cast<double>(t_s);
  const int n = layout_.size;
  Columns T = derivative(t, span, narrow, interval, 1);
  bool known = false;
  double inflation = kMinInflation;
  for (int count = 2; count <= kMaxSubsteps && !known; count *= 2) {
    Columns finer = derivative(t, span, narrow, interval, count);
    double largest = 0, change = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        largest = std::max(largest, std::fabs(finer[i][j]));
        change = std::max(change, std::fabs(finer[i][j] - T[i][j]));
        if (!std::isfinite(finer[i][j])) change = HUGE_VAL;
      }
    known = change <= (count < kRoundOffSubsteps ? kDerivativeTolerance : kDerivativeToleranceAtRoundOff) * largest;
    if (known) inflation = kMinInflation + change / largest;
    T = std::move(finer);
  }
  if (!known) {
    finite_ = false;
    return;
  }
  Columns moved(n, std::vector<double>(n, 0));
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) {
      if (Q_[k][i] == 0) continue;
      for (int j = 0; j < n; ++j) moved[k][j] += T[i][j] * Q_[k][i];
    }
  std::vector<double> fresh = round_off_bound(y, span, 64 * (1 + steps));
  add_round_off_at_rest(t_s, y, interval, span, fresh);
  apply(moved, fresh, inflation);
}

// The plane's reaction cancels the acceleration of a ball at rest to round-off of gravity and of the forces, which may
// nearly cancel each other.
void ErrorGrowth::add_round_off_at_rest(Wide t_s, const std::vector<Wide>& y, int interval, double span_s,
                                        std::vector<double>& delta) const {
  if (at_rest_.empty()) return;
  std::vector<Wide> f(layout_.size);
  free_dynamics_.rate(t_s, y.data(), f.data(), interval);
  for (const int body : at_rest_) {
    const Slot& slot = layout_.slots[body];
    const Real3& g = scene_.gravity_m_per_s2;
    const double pull = 2 * std::hypot(g[0], g[1], g[2]) + length(&f[slot.velocity]);
    const double noise = 64 * round_off_ * pull * span_s;
    for (int k = 0; k < 3; ++k) {
      delta[slot.velocity + k] += noise;
      delta[slot.position + k] += noise * span_s;
    }
  }
}

// Modified Gram-Schmidt, each column orthogonalised twice; a linearly dependent column is replaced by a unit vector.
void ErrorGrowth::apply(const Columns& moved, const std::vector<double>& delta, double inflation) {
  const int n = layout_.size;
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::vector<double> weight(n, 0);
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) weight[k] += moved[k][i] * rho_[k] * moved[k][i] * rho_[k];
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return weight[a] > weight[b]; });
  Eigen::MatrixXd fresh(n, n);
  int found = 0;
  VectorXd v(n);
  const auto project = [&] {
    for (int twice = 0; twice < 2; ++twice)
      for (int i = 0; i < found; ++i) v -= v.dot(fresh.col(i)) * fresh.col(i);
    return v.norm();
  };
  const auto take = [&](double size) { fresh.col(found++) = v / size; };
  for (const int k : order) {
    v = vector_of(moved[k]);
    const double before = v.norm();
    if (!(before > 0)) continue;
    v /= before;
    if (const double left = project(); left > 1e-8) take(left);
  }
  for (int unit = 0; unit < n && found < n; ++unit) {
    v.setUnit(unit);
    if (const double left = project(); left > 0.5 / std::sqrt(n)) take(left);
  }
  std::vector<double> rho(n, 0);
  for (int i = 0; i < found; ++i) {
    for (int k = 0; k < n; ++k) rho[i] += inflation * rho_[k] * std::fabs(vector_of(moved[k]).dot(fresh.col(i)));
    for (int j = 0; j < n; ++j) rho[i] += std::fabs(fresh(j, i)) * delta[j] / scale_[j];
  }
  finite_ &= found == n;
  for (const double each : rho) finite_ &= std::isfinite(each);
  if (!finite_) return;
  for (int i = 0; i < n; ++i) VectorXd::Map(Q_[i].data(), n) = fresh.col(i);
  rho_ = std::move(rho);
}

void ErrorGrowth::add(const std::vector<double>& delta) {
  for (int i = 0; i < layout_.size; ++i)
    for (int j = 0; j < layout_.size; ++j) rho_[i] += std::fabs(Q_[i][j]) * delta[j] / scale_[j];
}

std::vector<Wide> ErrorGrowth::gap_gradient(const ContactPair& pair, const std::vector<Wide>& y) const {
  const Gap<Wide> now = gap(scene_, layout_, pair, y.data());
  std::vector<Wide> row(layout_.size, 0);
  for (const int body : {pair.a, pair.b})
    for (int k = 0; k < 3 && layout_.slots[body].position >= 0; ++k)
      row[layout_.slots[body].position + k] = (body == pair.a ? -1 : 1) * now.normal[k];
  return row;
}

void ErrorGrowth::impact(Wide t_s, const Impact<Wide>& impact, const std::vector<Wide>& after, int interval,
                         double gap_error_m) {
  if (!finite_) return;
  const int n = layout_.size;
  const std::vector<Wide>& before = impact.before;
  std::vector<double> place(n, 0), kick(n, 0);
  std::vector<bool> struck(scene_.bodies.size(), false);
  const ContactPair* first = &impact.pairs.front();
  Wide fastest = 0;
  for (const ContactPair& pair : impact.pairs) {
    const Wide rate = gap(scene_, layout_, pair, before.data()).rate_m_per_s;
    if (rate < fastest) {
      fastest = rate;
      first = &pair;
    }
    const double size = position_magnitude(pair.a, before.data(), 0) + position_magnitude(pair.b, before.data(), 0);
    const double speeds = speed(pair.a, before.data()) + speed(pair.b, before.data()) + speed(pair.a, after.data()) +
                          speed(pair.b, after.data());
    for (const int body : {pair.a, pair.b}) {
      const Slot& slot = layout_.slots[body];
      if (slot.velocity < 0) continue;
      struck[body] = true;
      for (int k = 0; k < 3; ++k) {
        place[slot.position + k] = gap_error_m + 16 * round_off_ * size;
        kick[slot.velocity + k] += 64 * round_off_ * speeds;
        if (slot.rate >= 0)
          kick[slot.rate + k] += 64 * round_off_ * (length(&before[slot.rate]) + length(&after[slot.rate]));
      }
    }
  }
  if (!(fastest < 0)) return;
  add(place);
  std::vector<Wide> f_before(n), f_after(n), jump(n);
  dynamics_.rate(t_s, before.data(), f_before.data(), interval);
  dynamics_.rate(t_s, after.data(), f_after.data(), interval);
  // Columns of DR; the identity for bodies without an impact.
  std::vector<std::vector<Wide>> DR(n, std::vector<Wide>(n, 0));
  for (int i = 0; i < n; ++i) {
    DR[i][i] = 1;
    if (!struck[body_[i]]) continue;
    const Wide h = kQuadRelativeStep * std::max(1e-3 * scale_[i], std::fabs(static_cast<double>(before[i])));
    std::vector<Wide> up = before, down = before;
    up[i] += h;
    down[i] -= h;
    reapply_impact(scene_, layout_, impact.pairs, up.data());
    reapply_impact(scene_, layout_, impact.pairs, down.data());
    for (int j = 0; j < n; ++j) DR[i][j] = (up[j] - down[j]) / (2 * h);
  }
  jump = f_after;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) jump[j] -= DR[i][j] * f_before[i];
  const std::vector<Wide> g = gap_gradient(*first, before);
  Columns moved(n, std::vector<double>(n, 0));
  for (int k = 0; k < n; ++k) {
    Wide opened = 0;
    for (int i = 0; i < n; ++i) opened += g[i] * Wide(Q_[k][i] * scale_[i]);
    for (int j = 0; j < n; ++j) {
      Wide sum = jump[j] * (opened / fastest);
      for (int i = 0; i < n; ++i)
        if (DR[i][j] != 0) sum += DR[i][j] * Wide(Q_[k][i] * scale_[i]);
      moved[k][j] = static_cast<double>(sum / scale_[j]);
    }
  }
  for (int i = 0; i < n; ++i) kick[i] += place[i];
  apply(moved, kick, kMinInflation);
}

void ErrorGrowth::hold_on_plane(int body, const Real3& normal) {
  dynamics_.hold_on_plane(body, normal);
  double_dynamics_.hold_on_plane(body, normal);
  at_rest_.push_back(body);
}

void ErrorGrowth::release_from_plane(int body) {
  dynamics_.release_from_plane(body);
  double_dynamics_.release_from_plane(body);
  std::erase(at_rest_, body);
}

void ErrorGrowth::keep_to_plane(int body, const Real3& normal, double gap_error_m) {
  const double size = std::hypot(normal[0], normal[1], normal[2]);
  Columns moved = Q_;
  std::vector<double> delta(layout_.size, 0);
  for (const int from : {layout_.slots[body].position, layout_.slots[body].velocity})
    for (auto& column : moved) {
      double project_bound = 0;
      for (int k = 0; k < 3; ++k) project_bound += column[from + k] * normal[k] / size;
      for (int k = 0; k < 3; ++k) column[from + k] -= project_bound * normal[k] / size;
    }
  for (int k = 0; k < 3; ++k) delta[layout_.slots[body].position + k] = gap_error_m;
  apply(moved, delta, 1);
}

double ErrorGrowth::project_bound(const std::vector<double>& row) const {
  double sum = 0;
  for (int k = 0; k < layout_.size; ++k) {
    double part = 0;
    for (int i = 0; i < layout_.size; ++i) part += row[i] * Q_[k][i] * scale_[i];
    sum += std::fabs(part) * rho_[k];
  }
  return finite_ ? sum : HUGE_VAL;
}

std::vector<double> ErrorGrowth::bounds() const {
  std::vector<double> made(layout_.size, 0);
  for (int k = 0; k < layout_.size; ++k)
    for (int i = 0; i < layout_.size; ++i) made[i] += std::fabs(Q_[k][i]) * rho_[k] * scale_[i];
  if (!finite_) made.assign(layout_.size, HUGE_VAL);
  return made;
}

double ErrorGrowth::gap_bound(const ContactPair& pair, const std::vector<Wide>& y) const {
  std::vector<double> row;
  for (const Wide& each : gap_gradient(pair, y)) row.push_back(static_cast<double>(each));
  return project_bound(row) +
         16 * round_off_ * (position_magnitude(pair.a, y.data(), 0) + position_magnitude(pair.b, y.data(), 0));
}

double ErrorGrowth::gap_acceleration(const ContactPair& pair, Wide t_s, const std::vector<Wide>& y,
                                     int interval) const {
  std::vector<Wide> f(layout_.size), up = y, down = y;
  dynamics_.rate(t_s, y.data(), f.data(), interval);
  Wide size = 0, change = 0;
  for (int i = 0; i < layout_.size; ++i) {
    size = std::max(size, std::max(magnitude(y[i]), Wide(1e-3 * scale_[i])) / Wide(scale_[i]));
    change = std::max(change, magnitude(f[i]) / Wide(scale_[i]));
  }
  if (!(change > 0)) return 0;
  const Wide h = Wide(kQuadRelativeStep) * size / change;
  for (int i = 0; i < layout_.size; ++i) {
    up[i] += h * f[i];
    down[i] -= h * f[i];
  }
  return static_cast<double>(
      (gap(scene_, layout_, pair, up.data()).rate_m_per_s - gap(scene_, layout_, pair, down.data()).rate_m_per_s) /
      (2 * h));
}

// The rate is u . n: its gradient is n with respect to the velocities, and u . dn with respect to the positions.
double ErrorGrowth::rate_bound(const ContactPair& pair, const std::vector<Wide>& y) const {
  std::vector<double> row(layout_.size, 0);
  for (const int body : {pair.a, pair.b}) {
    const Slot& slot = layout_.slots[body];
    if (slot.velocity < 0) continue;
    for (int from : {slot.position, slot.velocity})
      for (int k = from; k < from + 3; ++k) {
        const Wide h = kQuadRelativeStep * std::max(1e-3 * scale_[k], std::fabs(static_cast<double>(y[k])));
        std::vector<Wide> up = y, down = y;
        up[k] += h;
        down[k] -= h;
        row[k] = static_cast<double>((gap(scene_, layout_, pair, up.data()).rate_m_per_s -
                                      gap(scene_, layout_, pair, down.data()).rate_m_per_s) /
                                     (2 * h));
      }
  }
  return project_bound(row) + 16 * round_off_ * (speed(pair.a, y.data()) + speed(pair.b, y.data()));
}

}  // namespace atwood::dynamics
