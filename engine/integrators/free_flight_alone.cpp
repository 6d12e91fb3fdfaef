#include "integrators/free_flight_alone.hpp"

#include "math/pack.hpp"

namespace atwood {
namespace {

using V = FourDoubles;
using SignBits = Integers<V>::Unsigned;
constexpr std::uint64_t kMinus = 1ull << 63;

struct Slope {
  V q, u;
};

struct Row {
  int terms = 0;
  int stage[kMaxStagesAlone];
  double weight[kMaxStagesAlone];

  Row() = default;
  explicit Row(const ExplicitWeights<double>::Row& row) : terms(static_cast<int>(row.stage.size())) {
    for (int j = 0; j < terms; ++j) stage[j] = row.stage[j], weight[j] = row.weight[j];
  }
  ATWOOD_INLINE V mean(const V* of) const {
    V sum = weight[0] * of[stage[0]];
    for (int j = 1; j < terms; ++j) sum = sum + weight[j] * of[stage[j]];
    return sum;
  }
  ATWOOD_INLINE Slope mean(const Slope* of) const {
    V q = weight[0] * of[stage[0]].q, u = weight[0] * of[stage[0]].u;
    for (int j = 1; j < terms; ++j) {
      const Slope& term = of[stage[j]];
      q = q + weight[j] * term.q;
      u = u + weight[j] * term.u;
    }
    return {q, u};
  }
};

ATWOOD_INLINE V with_signs(const V& a, const SignBits& minus) { return bits_as<V>(bits_as<SignBits>(a) ^ minus); }

// I and 2 / I of the principal axes, as rate_of() multiplies by them.
struct Inertia {
  V next, after, twice_inverse;

  explicit Inertia(const FlightInertia<double, 1>& body)
      : next{body.I[4][0], body.I[8][0], body.I[0][0], 0}, after{body.I[8][0], body.I[0][0], body.I[4][0], 0},
        twice_inverse{body.twice_I_inverse[0][0], body.twice_I_inverse[4][0], body.twice_I_inverse[8][0], 0} {}
};

// Of q = (w x y z) and (u_x u_y u_z 0) with u = w / 2, and L = I u in body axes:
//   w' = -(x u_x + y u_y + z u_z)     u_x' = 2 / I_x (u_z L_y - u_y L_z)
//   x' =   w u_x + y u_z - z u_y      u_y' = 2 / I_y (u_x L_z - u_z L_x)
//   y' =   w u_y + z u_x - x u_z      u_z' = 2 / I_z (u_y L_x - u_x L_y)
//   z' =   w u_z + x u_y - y u_x
ATWOOD_INLINE Slope rate_of(const V& q, const V& u, const Inertia& inertia) {
  constexpr SignBits of_w{kMinus, 0, 0, 0}, of_vector{0, kMinus, kMinus, kMinus};
  const V u_next = __builtin_shufflevector(u, u, 1, 2, 0, 3), u_after = __builtin_shufflevector(u, u, 2, 0, 1, 3);
  const V moment = (inertia.next * u_next) * u_after - (inertia.after * u_after) * u_next;
  const V first = __builtin_shufflevector(q, q, 1, 0, 0, 0) * __builtin_shufflevector(u, u, 0, 0, 1, 2);
  const V second = __builtin_shufflevector(q, q, 2, 2, 3, 1) * __builtin_shufflevector(u, u, 1, 2, 0, 1);
  const V third = __builtin_shufflevector(q, q, 3, 3, 1, 2) * __builtin_shufflevector(u, u, 2, 1, 2, 0);
  return {with_signs((first + second) + with_signs(third, of_vector), of_w), inertia.twice_inverse * moment};
}

ATWOOD_INLINE V unit(const V& q) { return (1 / real::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])) * q; }

ATWOOD_INLINE V three(const Vec3<double>& a) { return V{a.x, a.y, a.z, 0}; }

// Stage i has the slope k_i of (q, u) and the velocity v + fall_i, whose first one is v itself.
ATWOOD_INLINE void fly(const FlightSteps<double>& steps, const FlightInertia<double, 1>& body, std::int64_t count,
                       double* at) {
  const ExplicitWeights<double>& weights = steps.weights;
  const int stages = weights.stages() - (weights.first_same_as_last ? 1 : 0);
  const Inertia inertia(body);
  Row a[kMaxStagesAlone], b(weights.b);
  V fall[kMaxStagesAlone], velocity[kMaxStagesAlone];
  Slope k[kMaxStagesAlone];
  for (int i = 0; i < weights.stages(); ++i) {
    if (i > 0 && i < stages) a[i] = Row(weights.a[i]);
    fall[i] = three(steps.stage_m_per_s[i]);
  }
  const V fall_of_step = three(steps.step_m_per_s);
  const double h_s = steps.h_s;
  V p = three(load3(at)), v = three(load3(at + 3)), q{at[6], at[7], at[8], at[9]}, u = 0.5 * three(load3(at + 10));
  for (std::int64_t n = 0; n < count; ++n) {
    velocity[0] = v;
    for (int i = 1; i < weights.stages(); ++i) velocity[i] = v + fall[i];
    p = p + h_s * b.mean(velocity);
    v = v + fall_of_step;
    k[0] = rate_of(q, u, inertia);
    for (int i = 1; i < stages; ++i) {
      const Slope mean = a[i].mean(k);
      k[i] = rate_of(q + h_s * mean.q, u + h_s * mean.u, inertia);
    }
    const Slope mean = b.mean(k);
    q = unit(q + h_s * mean.q);
    u = u + h_s * mean.u;
  }
  for (int c = 0; c < 3; ++c) at[c] = p[c], at[3 + c] = v[c], at[10 + c] = 2 * u[c];
  for (int c = 0; c < 4; ++c) at[6 + c] = q[c];
}

}  // namespace

bool flies_alone(VectorWidth width, FlightKind kind, const FlightSteps<double>& steps) {
  return width != VectorWidth::narrow && kind == FlightKind::about_body_axes && !steps.classical &&
         steps.weights.stages() <= kMaxStagesAlone;
}

void fly_many_alone(VectorWidth width, const FlightSteps<double>& steps, const FlightInertia<double, 1>& inertia,
                    std::int64_t count, double* y) {
  in_lanes<double>(width, [&](auto) ATWOOD_INLINED { fly(steps, inertia, count, y); });
}

}  // namespace atwood
