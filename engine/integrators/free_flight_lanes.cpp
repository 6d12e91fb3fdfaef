#include "integrators/free_flight_lanes.hpp"

namespace atwood {
namespace {

// ---- the values of one lane; the compiler keeps them in vector registers in the loops below -----------------------
template <class S> ATWOOD_INLINE Vec3<S> get(const S (&rows)[3][kFlightLanes], int l) {
  return {rows[0][l], rows[1][l], rows[2][l]};
}
template <class S> ATWOOD_INLINE Quat<S> get(const S (&rows)[4][kFlightLanes], int l) {
  return {rows[0][l], rows[1][l], rows[2][l], rows[3][l]};
}
template <class S> ATWOOD_INLINE void put(const Vec3<S>& a, S (&rows)[3][kFlightLanes], int l) {
  rows[0][l] = a.x, rows[1][l] = a.y, rows[2][l] = a.z;
}
template <class S> ATWOOD_INLINE void put(const Quat<S>& a, S (&rows)[4][kFlightLanes], int l) {
  rows[0][l] = a.w, rows[1][l] = a.x, rows[2][l] = a.y, rows[3][l] = a.z;
}
template <class S> ATWOOD_INLINE Vec3<S> add(const Vec3<S>& a, const Vec3<S>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class S> ATWOOD_INLINE Quat<S> add(const Quat<S>& a, const Quat<S>& b) {
  return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class S> ATWOOD_INLINE Vec3<S> scale(S s, const Vec3<S>& a) { return {s * a.x, s * a.y, s * a.z}; }
template <class S> ATWOOD_INLINE Quat<S> scale(S s, const Quat<S>& a) { return {s * a.w, s * a.x, s * a.y, s * a.z}; }

template <FlightKind kind, class S, int lanes>
ATWOOD_INLINE Vec3<S> times(const S (&I)[9][lanes], const Vec3<S>& v, int l) {
  if constexpr (kind == FlightKind::about_body_axes) return {I[0][l] * v.x, I[4][l] * v.y, I[8][l] * v.z};
  return {I[0][l] * v.x + I[1][l] * v.y + I[2][l] * v.z, I[3][l] * v.x + I[4][l] * v.y + I[5][l] * v.z,
          I[6][l] * v.x + I[7][l] * v.y + I[8][l] * v.z};
}

// w' = I^-1 (0 - w x (I w)), as rate.cpp has it, for u = w / 2: u' = 2 I^-1 (0 - u x (I u)). About body axes the two
// products of each component of the cross product have the same sign, so 0 - (a - b) is b - a even where it is a zero.
template <FlightKind kind, class S, int lanes>
ATWOOD_INLINE Vec3<S> half_rate_rate(const FlightInertia<S, lanes>& inertia, const Vec3<S>& u, int l) {
  const Vec3<S> L = times<kind>(inertia.I, u, l);
  Vec3<S> torque;
  if constexpr (kind == FlightKind::about_body_axes) {
    torque = {u.z * L.y - u.y * L.z, u.x * L.z - u.z * L.x, u.y * L.x - u.x * L.y};
  } else {
    torque = {S(0) - (u.y * L.z - u.z * L.y), S(0) - (u.z * L.x - u.x * L.z), S(0) - (u.x * L.y - u.y * L.x)};
  }
  return times<kind>(inertia.twice_I_inverse, torque, l);
}

// q' = 1/2 q (0, w), given w / 2
template <class S> ATWOOD_INLINE Quat<S> attitude_rate(const Quat<S>& q, const Vec3<S>& half) {
  return {-(q.x * half.x + q.y * half.y + q.z * half.z), q.w * half.x + q.y * half.z - q.z * half.y,
          q.w * half.y + q.z * half.x - q.x * half.z, q.w * half.z + q.x * half.y - q.y * half.x};
}

template <class S> ATWOOD_INLINE Quat<S> unit(const Quat<S>& q) {
  return scale(S(1) / real::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z), q);
}

// ---- the classical Runge-Kutta method, one pass over registers ----------------------------------------------------
//   k1 = f(y)  k2 = f(y + h/2 k1)  k3 = f(y + h/2 k2)  k4 = f(y + h k3)  y_new = y + h (b1 k1 + b2 k2 + b2 k3 + b4 k4)
// h (k/2) and (h/2) k have the same bits because halving is exact.
template <class T, class S> ATWOOD_INLINE T weigh(const S* b, const T& k1, const T& k2, const T& k3, const T& k4) {
  return add(add(add(scale(b[0], k1), scale(b[1], k2)), scale(b[2], k3)), scale(b[3], k4));
}

template <class S> struct ClassicalSteps {
  S h, half_h, b[4];
  Vec3<S> fall_half, fall_whole, fall;

  explicit ClassicalSteps(const FlightSteps<S>& steps)  // of a classical tableau
      : h(steps.h_s), half_h(steps.h_s * S(0.5)), b{steps.weights.b.weight[0], steps.weights.b.weight[1],
                                                    steps.weights.b.weight[1], steps.weights.b.weight[3]},
        fall_half(steps.stage_m_per_s[1]), fall_whole(steps.stage_m_per_s[3]), fall(steps.step_m_per_s) {}
};

template <class S> ATWOOD_INLINE void translate_classically(const ClassicalSteps<S>& by, Vec3<S>& p, Vec3<S>& v) {
  const Vec3<S> v_half = add(v, by.fall_half), v_whole = add(v, by.fall_whole);
  p = add(p, scale(by.h, weigh(by.b, v, v_half, v_half, v_whole)));
  v = add(v, by.fall);
}

template <FlightKind kind, class S, int lanes>
ATWOOD_INLINE void rotate_classically(const ClassicalSteps<S>& by, const FlightInertia<S, lanes>& inertia, int l,
                                      Quat<S>& q, Vec3<S>& u) {
  const S h = by.h, half_h = by.half_h;
  const Vec3<S> u1 = half_rate_rate<kind>(inertia, u, l);
  const Quat<S> q1 = attitude_rate(q, u);
  const Vec3<S> u_b = add(u, scale(half_h, u1));
  const Vec3<S> u2 = half_rate_rate<kind>(inertia, u_b, l);
  const Quat<S> q2 = attitude_rate(add(q, scale(half_h, q1)), u_b);
  const Vec3<S> u_c = add(u, scale(half_h, u2));
  const Vec3<S> u3 = half_rate_rate<kind>(inertia, u_c, l);
  const Quat<S> q3 = attitude_rate(add(q, scale(half_h, q2)), u_c);
  const Vec3<S> u_d = add(u, scale(h, u3));
  const Vec3<S> u4 = half_rate_rate<kind>(inertia, u_d, l);
  const Quat<S> q4 = attitude_rate(add(q, scale(h, q3)), u_d);
  u = add(u, scale(h, weigh(by.b, u1, u2, u3, u4)));
  q = unit(add(q, scale(h, weigh(by.b, q1, q2, q3, q4))));
}

template <FlightKind kind, class S>
ATWOOD_INLINE void classical_steps(int bodies, const FlightSteps<S>& steps, std::int64_t count, FlightLanes<S>& lanes) {
  const ClassicalSteps<S> by(steps);
  for (std::int64_t n = 0; n < count; ++n) {
    ATWOOD_INDEPENDENT
    for (int l = 0; l < bodies; ++l) {
      Vec3<S> p = get(lanes.p, l), v = get(lanes.v, l);
      translate_classically(by, p, v);
      put(p, lanes.p, l);
      put(v, lanes.v, l);
      if constexpr (kind != FlightKind::point_mass) {
        Quat<S> q = get(lanes.q, l);
        Vec3<S> u = get(lanes.half_w, l);
        rotate_classically<kind>(by, lanes.inertia, l, q, u);
        put(u, lanes.half_w, l);
        put(q, lanes.q, l);
      }
    }
  }
}

// ---- any tableau, stage by stage ----------------------------------------------------------------------------------
// Row r of 7: four of the attitude's rate, then three of half the body rate's rate.
template <class S> ATWOOD_INLINE S* rates_row(FlightLanes<S>& lanes, int stage, int r) {
  return lanes.rates.data() + (static_cast<std::ptrdiff_t>(stage) * 7 + r) * kFlightLanes;
}

// to = from + h slope, for one row.
template <class S>
ATWOOD_INLINE void advance(const typename ExplicitWeights<S>::Row& row, int r, S h, int bodies, const S* from,
                           FlightLanes<S>& lanes, S* to) {
  S slope[kFlightLanes];
  const S* first = rates_row(lanes, row.stage[0], r);
  for (int l = 0; l < bodies; ++l) slope[l] = row.weight[0] * first[l];
  for (std::size_t j = 1; j < row.stage.size(); ++j) {
    const S* k = rates_row(lanes, row.stage[j], r);
    const S weight = row.weight[j];
    for (int l = 0; l < bodies; ++l) slope[l] += weight * k[l];
  }
  for (int l = 0; l < bodies; ++l) to[l] = from[l] + h * slope[l];
}

template <FlightKind kind, class S>
ATWOOD_INLINE void rotate_stages(int bodies, const FlightSteps<S>& steps, FlightLanes<S>& lanes) {
  const int stages = steps.weights.stages() - (steps.weights.first_same_as_last ? 1 : 0);
  for (int i = 0; i < stages; ++i) {
    if (i > 0) {
      for (int r = 0; r < 4; ++r)
        advance<S>(steps.weights.a[i], r, steps.h_s, bodies, lanes.q[r], lanes, lanes.q_stage[r]);
      for (int r = 0; r < 3; ++r)
        advance<S>(steps.weights.a[i], 4 + r, steps.h_s, bodies, lanes.half_w[r], lanes, lanes.half_w_stage[r]);
    }
    const auto& q_at = i > 0 ? lanes.q_stage : lanes.q;
    const auto& u_at = i > 0 ? lanes.half_w_stage : lanes.half_w;
    auto& q_rate = *reinterpret_cast<S(*)[4][kFlightLanes]>(rates_row(lanes, i, 0));
    auto& u_rate = *reinterpret_cast<S(*)[3][kFlightLanes]>(rates_row(lanes, i, 4));
    ATWOOD_INDEPENDENT
    for (int l = 0; l < bodies; ++l) {
      const Vec3<S> u = get(u_at, l);
      put(attitude_rate(get(q_at, l), u), q_rate, l);
      put(half_rate_rate<kind>(lanes.inertia, u, l), u_rate, l);
    }
  }
  for (int r = 0; r < 4; ++r) advance<S>(steps.weights.b, r, steps.h_s, bodies, lanes.q[r], lanes, lanes.q[r]);
  for (int r = 0; r < 3; ++r)
    advance<S>(steps.weights.b, 4 + r, steps.h_s, bodies, lanes.half_w[r], lanes, lanes.half_w[r]);
  ATWOOD_INDEPENDENT
  for (int l = 0; l < bodies; ++l) put(unit(get(lanes.q, l)), lanes.q, l);
}

template <class S> ATWOOD_INLINE void translate(const FlightSteps<S>& steps, Vec3<S>& p, Vec3<S>& v) {
  const auto& b = steps.weights.b;
  Vec3<S> slope = scale(b.weight[0], b.stage[0] == 0 ? v : add(v, steps.stage_m_per_s[b.stage[0]]));
  for (std::size_t j = 1; j < b.stage.size(); ++j)
    slope = add(slope, scale(b.weight[j], b.stage[j] == 0 ? v : add(v, steps.stage_m_per_s[b.stage[j]])));
  p = add(p, scale(steps.h_s, slope));
  v = add(v, steps.step_m_per_s);
}

template <class S> ATWOOD_INLINE void translate(int bodies, const FlightSteps<S>& steps, FlightLanes<S>& lanes) {
  for (int l = 0; l < bodies; ++l) {
    Vec3<S> p = get(lanes.p, l), v = get(lanes.v, l);
    translate(steps, p, v);
    put(p, lanes.p, l);
    put(v, lanes.v, l);
  }
}

template <FlightKind kind, class S>
ATWOOD_INLINE void any_steps(int bodies, const FlightSteps<S>& steps, std::int64_t count, FlightLanes<S>& lanes) {
  for (std::int64_t n = 0; n < count; ++n) {
    translate(bodies, steps, lanes);
    if constexpr (kind != FlightKind::point_mass) rotate_stages<kind>(bodies, steps, lanes);
  }
}

// ---- a single body ------------------------------------------------------------------------------------------------
template <class S> struct Turning {
  Quat<S> q;
  Vec3<S> u;
};

// Uninitialised storage.
template <class S> struct TurningRates {
  S rate[kMaxStagesAlone][7];

  ATWOOD_INLINE void put(int stage, const Quat<S>& q, const Vec3<S>& u) {
    store4(q, rate[stage]);
    store3(u, rate[stage] + 4);
  }
  ATWOOD_INLINE Turning<S> scaled(S weight, int stage) const {
    return {scale(weight, load4(rate[stage])), scale(weight, load3(rate[stage] + 4))};
  }
};
template <class S> ATWOOD_INLINE Turning<S> add(const Turning<S>& a, const Turning<S>& b) {
  return {add(a.q, b.q), add(a.u, b.u)};
}

template <class S>
ATWOOD_INLINE Turning<S> advance(const typename ExplicitWeights<S>::Row& row, S h, const Turning<S>& from,
                                 const TurningRates<S>& rates) {
  Turning<S> slope = rates.scaled(row.weight[0], row.stage[0]);
  for (std::size_t j = 1; j < row.stage.size(); ++j) slope = add(slope, rates.scaled(row.weight[j], row.stage[j]));
  return {add(from.q, scale(h, slope.q)), add(from.u, scale(h, slope.u))};
}

template <FlightKind kind, class S>
ATWOOD_INLINE void rotate(const FlightSteps<S>& steps, const FlightInertia<S, 1>& inertia, Quat<S>& q, Vec3<S>& u) {
  const int stages = steps.weights.stages() - (steps.weights.first_same_as_last ? 1 : 0);
  const Turning<S> start{q, u};
  TurningRates<S> rates;
  for (int i = 0; i < stages; ++i) {
    const Turning<S> at = i > 0 ? advance(steps.weights.a[i], steps.h_s, start, rates) : start;
    rates.put(i, attitude_rate(at.q, at.u), half_rate_rate<kind>(inertia, at.u, 0));
  }
  const Turning<S> end = advance(steps.weights.b, steps.h_s, start, rates);
  q = unit(end.q);
  u = end.u;
}

template <FlightKind kind, class S, class Translate, class Rotate>
ATWOOD_INLINE void fly_by(const S* from, S* to, const Translate& translate_by, const Rotate& rotate_by) {
  Vec3<S> p = load3(from), v = load3(from + 3);
  translate_by(p, v);
  store3(p, to);
  store3(v, to + 3);
  if constexpr (kind != FlightKind::point_mass) {
    Quat<S> q = load4(from + 6);
    Vec3<S> u = scale(S(0.5), load3(from + 10));
    rotate_by(q, u);
    store4(q, to + 6);
    store3(scale(S(2), u), to + 10);
  }
}

template <FlightKind kind, class S>
void fly_alone_as(const FlightSteps<S>& steps, const FlightInertia<S, 1>& inertia, const S* from, S* to) {
  if (!steps.classical)
    return fly_by<kind>(
        from, to, [&](auto& p, auto& v) { translate(steps, p, v); },
        [&](auto& q, auto& u) { rotate<kind>(steps, inertia, q, u); });
  const ClassicalSteps<S> by(steps);
  fly_by<kind>(
      from, to, [&](auto& p, auto& v) { translate_classically(by, p, v); },
      [&](auto& q, auto& u) { rotate_classically<kind>(by, inertia, 0, q, u); });
}

template <FlightKind kind, class S>
void fly_kind(VectorWidth width, int bodies, const FlightSteps<S>& steps, std::int64_t count, FlightLanes<S>& lanes) {
  at_width(
      width, [&]() __attribute__((always_inline)) {
        if (steps.classical) classical_steps<kind>(bodies, steps, count, lanes);
        else any_steps<kind>(bodies, steps, count, lanes);
      });
}

// sum of weight times g over the weights of a row, in their order
template <class S> Vec3<S> slope_of(const typename ExplicitWeights<S>::Row& row, const Vec3<S>& g) {
  Vec3<S> slope = row.weight[0] * g;
  for (std::size_t j = 1; j < row.weight.size(); ++j) slope += row.weight[j] * g;
  return slope;
}

template <class S> bool is_classical(const ExplicitWeights<S>& w) {
  if (w.stages() != 4 || w.b.stage != std::vector<int>{0, 1, 2, 3}) return false;
  for (int i = 1; i < 4; ++i)
    if (w.a[i].stage != std::vector<int>{i - 1}) return false;
  return w.a[1].weight[0] == S(0.5) && w.a[2].weight[0] == S(0.5) && w.a[3].weight[0] == S(1) &&
         w.b.weight[1] == w.b.weight[2];
}

}  // namespace

template <class S>
FlightSteps<S>::FlightSteps(const ExplicitWeights<S>& w)
    : weights(w), stage_m_per_s2(w.a.size()), stage_m_per_s(w.a.size()), classical(is_classical(w)) {}

template <class S> void FlightSteps<S>::set_gravity(const Vec3<S>& gravity_m_per_s2) {
  for (int i = 1; i < weights.stages(); ++i) stage_m_per_s2[i] = slope_of<S>(weights.a[i], gravity_m_per_s2);
  step_m_per_s2 = slope_of<S>(weights.b, gravity_m_per_s2);
}
template <class S> void FlightSteps<S>::set_step(S h) {
  h_s = h;
  for (int i = 1; i < weights.stages(); ++i) stage_m_per_s[i] = h * stage_m_per_s2[i];
  step_m_per_s = h * step_m_per_s2;
}

template <class S>
void fly(VectorWidth width, FlightKind kind, int bodies, const FlightSteps<S>& steps, std::int64_t count,
         FlightLanes<S>& lanes) {
  if (kind == FlightKind::about_body_axes) fly_kind<FlightKind::about_body_axes>(width, bodies, steps, count, lanes);
  else if (kind == FlightKind::about_any_axes) fly_kind<FlightKind::about_any_axes>(width, bodies, steps, count, lanes);
  else fly_kind<FlightKind::point_mass>(width, bodies, steps, count, lanes);
}

template <class S>
void fly_alone(FlightKind kind, const FlightSteps<S>& steps, const FlightInertia<S, 1>& inertia, const S* from, S* to) {
  if (kind == FlightKind::about_body_axes) fly_alone_as<FlightKind::about_body_axes>(steps, inertia, from, to);
  else if (kind == FlightKind::about_any_axes) fly_alone_as<FlightKind::about_any_axes>(steps, inertia, from, to);
  else fly_alone_as<FlightKind::point_mass>(steps, inertia, from, to);
}

template struct FlightSteps<float>;
template struct FlightSteps<double>;
template void fly(VectorWidth, FlightKind, int, const FlightSteps<float>&, std::int64_t, FlightLanes<float>&);
template void fly(VectorWidth, FlightKind, int, const FlightSteps<double>&, std::int64_t, FlightLanes<double>&);
template void fly_alone(FlightKind, const FlightSteps<float>&, const FlightInertia<float, 1>&, const float*, float*);
template void fly_alone(FlightKind, const FlightSteps<double>&, const FlightInertia<double, 1>&, const double*,
                        double*);

}  // namespace atwood
