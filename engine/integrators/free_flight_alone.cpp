#include "integrators/free_flight_alone.hpp"

#include "math/pack.hpp"

namespace atwood {
namespace {

using P = Pack<double>;

struct Row {
  int terms = 0;
  int stage[kMaxStagesAlone];
  double weight[kMaxStagesAlone];

  Row() = default;
  explicit Row(const ExplicitWeights<double>::Row& row) : terms(static_cast<int>(row.stage.size())) {
    for (int j = 0; j < terms; ++j) stage[j] = row.stage[j], weight[j] = row.weight[j];
  }
  ATWOOD_INLINE P slope(const P* k) const {
    P sum = weight[0] * k[stage[0]];
    for (int j = 1; j < terms; ++j) sum = sum + weight[j] * k[stage[j]];
    return sum;
  }
};

// Of y = (q_w q_x q_y q_z u_x u_y u_z 0), with u = w / 2 and L = I u in body axes:
//   q_w' = -(q_x u_x + q_y u_y + q_z u_z)     u_x' = 2 / I_x (u_z L_y - u_y L_z)
//   q_x' =   q_w u_x + q_y u_z - q_z u_y      u_y' = 2 / I_y (u_x L_z - u_z L_x)
//   q_y' =   q_w u_y + q_z u_x - q_x u_z      u_z' = 2 / I_z (u_y L_x - u_x L_y)
//   q_z' =   q_w u_z + q_x u_y - q_y u_x
// A column of factors is a permutation of y or of (q, L); lanes 8 to 15 of the latter are its negative. Where a row has
// no third product, -0 is added, which changes no number.
ATWOOD_INLINE P rate_of(const P& y, const P& inertia, const P& factor) {
  const P qL = inertia * y, minus = -qL;
  const P first =
      __builtin_shufflevector(qL, qL, 1, 0, 0, 0, 5, 6, 4, 7) * __builtin_shufflevector(y, y, 4, 4, 5, 6, 6, 4, 5, 7);
  const P second = __builtin_shufflevector(qL, minus, 2, 2, 3, 1, 14, 12, 13, 7) *
                   __builtin_shufflevector(y, y, 5, 6, 4, 5, 5, 6, 4, 7);
  const P third = __builtin_shufflevector(qL, minus, 3, 11, 9, 10, 15, 15, 15, 7) *
                  __builtin_shufflevector(y, y, 6, 5, 6, 4, 7, 7, 7, 7);
  return factor * ((first + second) + third);
}

ATWOOD_INLINE P with_unit_attitude(const P& y) {
  const double scale = 1 / real::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
  return __builtin_shufflevector(broadcast(scale), broadcast(1.0), 0, 0, 0, 0, 8, 8, 8, 8) * y;
}

ATWOOD_INLINE P pack3(const Vec3<double>& a) { return P{a.x, a.y, a.z, 0, 0, 0, 0, 0}; }

// Stage i has the slope k_i of (q, u) and the velocity v + fall_i, whose first one is v itself.
ATWOOD_INLINE void fly(const FlightSteps<double>& steps, const FlightInertia<double, 1>& body, std::int64_t count,
                       double* at) {
  const ExplicitWeights<double>& weights = steps.weights;
  const int stages = weights.stages() - (weights.first_same_as_last ? 1 : 0);
  const P inertia{1, 1, 1, 1, body.I[0][0], body.I[4][0], body.I[8][0], 0};
  const P factor{-1, 1, 1, 1, body.twice_I_inverse[0][0], body.twice_I_inverse[4][0], body.twice_I_inverse[8][0], 0};
  Row a[kMaxStagesAlone], b(weights.b);
  P fall[kMaxStagesAlone], k[kMaxStagesAlone], velocity[kMaxStagesAlone];
  for (int i = 0; i < weights.stages(); ++i) {
    if (i > 0 && i < stages) a[i] = Row(weights.a[i]);
    fall[i] = pack3(steps.stage_m_per_s[i]);
  }
  const P fall_of_step = pack3(steps.step_m_per_s);
  const double h_s = steps.h_s;
  P p = pack3(load3(at)), v = pack3(load3(at + 3));
  P y{at[6], at[7], at[8], at[9], 0.5 * at[10], 0.5 * at[11], 0.5 * at[12], 0};
  for (std::int64_t n = 0; n < count; ++n) {
    velocity[0] = v;
    for (int i = 1; i < weights.stages(); ++i) velocity[i] = v + fall[i];
    p = p + h_s * b.slope(velocity);
    v = v + fall_of_step;
    k[0] = rate_of(y, inertia, factor);
    for (int i = 1; i < stages; ++i) k[i] = rate_of(y + h_s * a[i].slope(k), inertia, factor);
    y = with_unit_attitude(y + h_s * b.slope(k));
  }
  for (int c = 0; c < 3; ++c) at[c] = p[c], at[3 + c] = v[c], at[10 + c] = 2 * y[4 + c];
  for (int c = 0; c < 4; ++c) at[6 + c] = y[c];
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
