// Taylor series of arbitrary order: the coefficients of the motion by recurrences on the force laws (Jorba, Zou, Exp.
// Math. 14 (2005) 99), summed by Horner's scheme.
#include "integrators/taylor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrators/taylor_series.hpp"
#include "math/elementary.hpp"

namespace atwood {
namespace {

constexpr int kKinds = 4;  // position, velocity, attitude, body rate

template <class S> Vec3<S> times(const Vec3<S> (&row)[3], const S* v_at) {
  const Vec3<S> v = load3(v_at);
  return {dot(row[0], v), dot(row[1], v), dot(row[2], v)};
}

// Jorba and Zou, section 3.1: with this order successive terms of the series decrease by a factor of e^2.
int order_of_tolerance(double rtol) { return std::clamp(static_cast<int>(std::ceil(1 - real::log(rtol) / 2)), 4, 60); }

}  // namespace

template <class S>
Taylor<S>::Taylor(RigidModel<S>& model, const TaylorOptions& options)
    : Stepper<S>(model.system()), model_(model), forces_(model.series_forces()), wanted_order_(options.order),
      size_(model.state_size()), increment_(size_), acceleration_(model.body_count()),
      sine_(forces_.oscillating.size()), cosine_(forces_.oscillating.size()), kind_(size_),
      compensation_(options.compensated, size_) {
  tops_.reserve(model.body_count());
  if (!model.bare_problem())
    for (int body = 0; body < model.body_count(); ++body) {
      const int offset = model.offset(body);
      if (offset < 0) continue;
      const bool rotates = model.rotates(body);
      for (int i = 0; i < (rotates ? kBodyScalars : kAtAttitude); ++i)
        kind_[offset + i] = i < kAtVelocity ? 0 : i < kAtAttitude ? 1 : i < kAtBodyRate ? 2 : 3;
      if (rotates) tops_.push_back({body, offset + kAtAttitude, forces_.linear[body].angular_drag});
    }
  set_order(wanted_order_ > 0 ? wanted_order_ : kTaylorEqualStepsOrder);
}

template <class S> void Taylor<S>::set_order(int order) {
  valid_ = false;
  if (order == order_) return;
  order_ = order;
  series_.assign(static_cast<std::size_t>(order + 1) * size_, S(0));
  momentum_.assign(static_cast<std::size_t>(order + 1) * 3 * tops_.size(), S(0));
  turning_.assign(static_cast<std::size_t>(order + 1) * series::kTopScalars, S(0));
  reciprocal_.resize(order + 1);
  for (int k = 1; k <= order; ++k) reciprocal_[k] = S(1) / S(k);
  half_.resize(3 * order + 1);
  for (int n = 0; n <= 3 * order; ++n) half_[n] = S(n) / S(2);
  lay_out_pairs();
}

template <class S> void Taylor<S>::lay_out_pairs() {
  const int count = static_cast<int>(forces_.inverse_square.size());
  pairs_.blocks = has_vector_lanes<S> && count > 2;
  pairs_.lanes = pairs_.blocks ? (count + kLaneCount - 1) / kLaneCount * kLaneCount : count;
  pairs_.rows.assign(static_cast<std::size_t>(order_ + 1) * 5 * pairs_.lanes, S(0));
  pairs_.softening2.assign(pairs_.lanes, S(0));
  pairs_.inverse_u.assign(pairs_.lanes, S(0));
  pairs_.acceleration.assign(3 * static_cast<std::size_t>(pairs_.lanes), S(0));
  for (int n = 0; n < count; ++n) pairs_.softening2[n] = forces_.inverse_square[n].softening2;
  for (int n = count; n < pairs_.lanes; ++n) pairs_.softening2[n] = S(1);  // lanes without a pair: |r|^2 = 0 + 1
}

template <class S> void Taylor<S>::set_tolerance(S rtol, S atol) {
  rtol_ = rtol;
  atol_ = atol;
  set_order(wanted_order_ > 0 ? wanted_order_ : order_of_tolerance(static_cast<double>(rtol)));
}

template <class S> bool Taylor<S>::known(S t_s, const S* y) const {
  return valid_ && t_s == start_s_ && epoch_ == this->system_.epoch && std::equal(y, y + size_, row(0));
}

// One coefficient after the other: y' = f(y) gives (k + 1) y_(k+1) = f_k, where f_k is the k-th coefficient of f along
//   y_0 + y_1 t + ... + y_k t^k.
template <class S> void Taylor<S>::find_series(S t_s, S h_s, const S* y) {
  start_s_ = t_s;
  unit_s_ = h_s;
  epoch_ = this->system_.epoch;
  std::copy(y, y + size_, row(0));
  if (static_cast<int>(model_.moving().size()) < model_.body_count()) std::fill(row(1), row(1) + size_ * order_, S(0));
  for (std::size_t n = 0; n < cosine_.size(); ++n) {
    const auto& force = forces_.oscillating[n];
    real::sin_cos(force.angular_frequency * t_s + force.phase, sine_[n], cosine_[n]);
  }
  for (int k = 0; k < order_; ++k) {
    if (model_.bare_problem()) next_lorenz(k);
    else next_bodies(k);
  }
  for (std::size_t top = 0; top < tops_.size(); ++top) find_turning(top);
  if (rtol_ > S(0)) bound_s_ = longest_step();
  valid_ = true;
}

template <class S> void Taylor<S>::next_bodies(int k) {
  for (int body = 0; body < model_.body_count(); ++body)
    acceleration_[body] = k == 0 ? forces_.linear[body].constant : Vec3<S>{};
  if (pairs_.lanes > 0) attract(k);
  add_linear(k);
  add_oscillating(k);
  add_quadratic(k);
  const S factor = unit_s_ / S(k + 1);
  for (const int body : model_.moving()) {
    const S* now = row(k) + model_.offset(body);
    S* next = row(k + 1) + model_.offset(body);
    store3(factor * load3(now + kAtVelocity), next + kAtPosition);
    store3(factor * acceleration_[body], next + kAtVelocity);
  }
}

template <class S> void Taylor<S>::attract(int k) {
  const Motion<S> motion = model_.motion(start_s_, row(0));
  S *x = pairs_.row(k, 0), *y = pairs_.row(k, 1), *z = pairs_.row(k, 2);
  const auto position = [&](int body) {
    const auto& slot = motion.slots[body];
    if (slot.resting != nullptr || slot.offset < 0) return k == 0 ? motion.p_WB(body) : Vec3<S>{};
    return load3(row(k) + slot.offset);
  };
  const int count = static_cast<int>(forces_.inverse_square.size());
  for (int n = 0; n < count; ++n) {
    const auto& pair = forces_.inverse_square[n];
    const Vec3<S> from = pair.a >= 0 ? position(pair.a) : k == 0 ? pair.centre : Vec3<S>{};
    const Vec3<S> r = position(pair.b) - from;
    x[n] = r.x;
    y[n] = r.y;
    z[n] = r.z;
  }
  in_lanes<S>(width_, [&](auto) ATWOOD_INLINED {
    if (pairs_.blocks) series::inverse_cube_series<kLaneCount>(pairs_, half_.data(), k);
    else series::inverse_cube_series<1>(pairs_, half_.data(), k);
  });
  const S *ax = pairs_.acceleration.data(), *ay = ax + pairs_.lanes, *az = ay + pairs_.lanes;
  for (int n = 0; n < count; ++n) {
    const auto& pair = forces_.inverse_square[n];
    const Vec3<S> a{ax[n], ay[n], az[n]};
    if (pair.a >= 0) acceleration_[pair.a] += pair.on_a * a;
    acceleration_[pair.b] += pair.on_b * a;
  }
}

template <class S> void Taylor<S>::add_linear(int k) {
  for (const int body : model_.moving()) {
    const auto& law = forces_.linear[body];
    if (law.none) continue;
    const S* now = row(k) + model_.offset(body);
    acceleration_[body] += times(law.of_position, now + kAtPosition) + times(law.of_velocity, now + kAtVelocity);
  }
  for (const auto& link : forces_.links) {
    const Motion<S> motion = model_.motion(start_s_, row(k));
    const auto position = [&](int body) {
      return k > 0 && motion.slots[body].resting != nullptr ? Vec3<S>{} : motion.p_WB(body);
    };
    const Vec3<S> r = position(link.b) - position(link.a);
    acceleration_[link.a] += link.on_a * r;
    acceleration_[link.b] += link.on_b * r;
  }
}

// c = cos(omega t + phase), s = sin: c' = -omega s, s' = omega c.
template <class S> void Taylor<S>::add_oscillating(int k) {
  for (std::size_t n = 0; n < cosine_.size(); ++n) {
    const auto& force = forces_.oscillating[n];
    acceleration_[force.body] += cosine_[n] * force.amplitude;
    const S factor = unit_s_ / S(k + 1) * force.angular_frequency, cosine = cosine_[n];
    cosine_[n] = -factor * sine_[n];
    sine_[n] = factor * cosine;
  }
}

template <class S> void Taylor<S>::add_quadratic(int k) {
  for (const auto& force : forces_.quadratic) {
    const int offset = model_.offset(force.body);
    if (offset < 0) continue;
    const S *x = row(0) + offset, *y = x + 1;
    const S xy = series::product(x, y, size_, k), xx = series::product(x, x, size_, k),
            yy = series::product(y, y, size_, k);
    acceleration_[force.body] -= force.strength * Vec3<S>{S(2) * xy, xx - yy, S(0)};
  }
}

//   q' = 1/2 q (0, w),   I w' = -w x (I w) - angular_drag w
// No other torque acts on bodies here, so the series of a top does not depend on other bodies.
template <class S> void Taylor<S>::find_turning(std::size_t top) {
  const auto [body, at, angular_drag] = tops_[top];
  const auto& moving = model_.moving();
  if (moving.size() < acceleration_.size() && std::find(moving.begin(), moving.end(), body) == moving.end()) return;
  const MassProperties<S>& mass = model_.mass(body);
  S* rows = turning_.data();
  in_lanes<S>(width_, [&, at = at, drag = angular_drag](auto) ATWOOD_INLINED {
    S* now = row(0) + at;
    for (int k = 0; k < order_; ++k, now += size_) {
      S turn[4], p[3];
      series::store_rotation_rows(now, now + 4, rows + k * series::kTopScalars);
      series::rotation_products(rows, series::kTopScalars, k, turn, p);
      const auto& I = mass.I_row;
      Vec3<S> torque{(I[1].y - I[2].z) * p[0], (I[2].z - I[0].x) * p[1], (I[0].x - I[1].y) * p[2]};
      if (!mass.diagonal) torque = gyroscopic_torque(k, top);
      const S factor = unit_s_ * reciprocal_[k + 1], half = factor * S(0.5);
      for (int l = 0; l < 4; ++l) now[size_ + l] = half * turn[l];
      torque -= Vec3<S>{drag * now[4], drag * now[5], drag * now[6]};
      store3(factor * mass.times_inverse_inertia(torque), now + size_ + 4);
    }
  });
}

// -w x (I w) in axes that are not principal.
template <class S> Vec3<S> Taylor<S>::gyroscopic_torque(int k, std::size_t top) {
  const auto [body, at, angular_drag] = tops_[top];
  const std::ptrdiff_t stride = 3 * static_cast<std::ptrdiff_t>(tops_.size());
  S* L = momentum_.data() + 3 * top;
  store3(model_.mass(body).times_inertia(load3(row(k) + at + 4)), L + k * stride);
  Vec3<S> torque;
  for (int j = 0; j <= k; ++j) torque -= cross(load3(row(j) + at + 4), load3(L + (k - j) * stride));
  return torque;
}

// Lorenz, J. Atmos. Sci. 20 (1963) 130, as in rigid/bare_problems.cpp.
template <class S> void Taylor<S>::next_lorenz(int k) {
  const S sigma = S(10), rho = S(28), beta = S(8) / S(3), factor = unit_s_ / S(k + 1);
  const S *start = row(0), *now = row(k);
  const S xy = series::product(start, start + 1, size_, k), xz = series::product(start, start + 2, size_, k);
  store3(factor * Vec3<S>{sigma * (now[1] - now[0]), (rho * now[0] - xz) - now[1], xy - beta * now[2]}, row(k + 1));
}

// Jorba and Zou, section 3.2, for each kind of component: c_j h^j of the last two coefficients is at most the
// tolerance. With the order of order_of_tolerance(), h is the radius of convergence estimated from them, divided by
// e^2. Returns 0 where coefficients are not finite.
template <class S> S Taylor<S>::longest_step() const {
  double size[kKinds]{}, last[2][kKinds]{};
  const auto grow = [&](double(&largest)[kKinds], int k) {
    for (int i = 0; i < size_; ++i) {
      const double value = std::abs(static_cast<double>(row(k)[i]));
      if (!(value <= largest[kind_[i]])) largest[kind_[i]] = value;
    }
  };
  grow(size, 0);
  grow(last[0], order_ - 1);
  grow(last[1], order_);
  double most = 1e6;  // in units of the attempted step
  for (int n = 0; n < 2; ++n) {
    double ratio = std::numeric_limits<double>::infinity();
    for (int kind = 0; kind < kKinds; ++kind) {
      if (!std::isfinite(last[n][kind])) return S(0);
      const double wanted = static_cast<double>(rtol_) * size[kind] + static_cast<double>(atol_);
      if (last[n][kind] > 0) ratio = std::min(ratio, wanted / last[n][kind]);
    }
    if (std::isfinite(ratio)) most = std::min(most, real::step_power(ratio, 1.0 / (order_ - 1 + n)));
  }
  return S(most * real::exp(-0.7 / (order_ - 1))) * real::abs(unit_s_);
}

// increment_ = the series at theta units minus its value at 0.
template <class S> void Taylor<S>::sum(S theta) {
  in_lanes<S>(width_,
              [&](auto) ATWOOD_INLINED { series::horner(series_.data(), size_, order_, theta, increment_.data()); });
}

template <class S> bool Taylor<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  if (!known(t_s, y)) find_series(t_s, h_s, y);
  this->set_last_step(t_s, h_s, y, y_new);
  if (rtol_ > S(0) && !(real::abs(h_s) <= bound_s_)) {  // advise() then rejects the step
    std::copy(y, y + size_, y_new);
    return true;
  }
  sum(h_s / unit_s_);
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y[i], increment_[i]);
  if (compensation_.on()) project_compensated(this->system_, compensation_, y_new, increment_.data());
  else this->system_.project(y_new);
  compensation_.end(y_new);
  return true;
}

// A rejected step needs no new series, so each step begins with a long proposal and is shortened to its own bound.
template <class S> auto Taylor<S>::advise(S, S) -> typename Stepper<S>::Advice {
  const S h_s = real::abs(this->h_s_);
  if (!(bound_s_ > S(0))) {  // coefficients beyond the scalar's range: a smaller unit
    valid_ = false;
    return {false, h_s / S(16)};
  }
  if (h_s > bound_s_) return {false, bound_s_};
  return {true, real::min(S(4) * bound_s_, S(100) * h_s)};
}

template <class S> void Taylor<S>::dense(S theta, S* y_at) {
  sum(theta * (this->h_s_ / unit_s_));
  for (int i = 0; i < size_; ++i) y_at[i] = row(0)[i] + increment_[i];
  this->system_.project(y_at);
}

MethodInfo taylor_method() {
  MethodInfo info = fixed_step("taylor", claims_everywhere(kTaylorEqualStepsOrder),
                               "The state's power series in time, by recurrences of products and powers of series: no "
                               "rates are evaluated, so only time "
                               "measures its work. With equal steps, of order 12; with a tolerance, of order 1 - "
                               "ln(rtol) / 2 (4 to 60), each step as long "
                               "as the last two coefficients allow; the setting `order` fixes it. Inverse-square "
                               "forces, uniform fields, linear drag, springs "
                               "without rest length, drives, the Henon-Heiles potential, Lorenz's equations and bodies "
                               "that rotate without torque, up to 128 "
                               "bodies; other forces are refused by name. A dashpot only where the motion stays on a "
                               "line through its anchor. Samples by the "
                               "series." +
                                   embedded_attitude,
                               "Jorba, Zou, Exp. Math. 14 (2005) 99; Hairer, Norsett, Wanner, Solving ODEs I, I.8");
  info.adaptive = true;
  declare_settings(info, {atol_over_rtol(),
                          {"order",
                           std::int64_t(0),
                           {between(0, kTaylorMaxOrder), "Order of the series, 2 or more; 0: by the tolerance."}}});
  return info;
}

template <class S> StepperResult<S> make_taylor(const StepperRequest<S>& request) {
  const std::int64_t order = request.count("order");
  if (request.model == nullptr) return cannot_step_bare("taylor", "expands the forces on bodies in power series");
  if (has_mechanisms(request)) return cannot_step_mechanisms("taylor", "it has no power series of their accelerations");
  const std::string& refusal = request.model->series_forces().refusal;
  if (!refusal.empty()) return cannot_step("taylor", "has no power series for " + refusal);
  if (order == 1)
    return Fault{"atwood/taylor: `order` is `1`; expected 0 (chosen by the tolerance) or 2 to " +
                 std::to_string(kTaylorMaxOrder)};
  return StepperPointer<S>(
      std::make_unique<Taylor<S>>(*request.model, TaylorOptions{static_cast<int>(order), request.flag("compensated")}));
}

template StepperResult<float> make_taylor(const StepperRequest<float>&);
template StepperResult<double> make_taylor(const StepperRequest<double>&);
template StepperResult<long double> make_taylor(const StepperRequest<long double>&);
template StepperResult<Quad> make_taylor(const StepperRequest<Quad>&);

template class Taylor<float>;
template class Taylor<double>;
template class Taylor<long double>;
template class Taylor<Quad>;

}  // namespace atwood
