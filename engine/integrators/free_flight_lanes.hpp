// A few bodies in free flight, one body per lane, and the loops over many steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "integrators/explicit_weights.hpp"
#include "math/quat.hpp"
#include "math/vector_width.hpp"

namespace atwood {

inline constexpr int kFlightLanes = 32;  // bodies stepped together: their data fit the first-level cache
// The body's inertia: diagonal in body axes; full; or the body does not rotate.
enum class FlightKind { about_body_axes, about_any_axes, point_mass };

// About body axes the diagonals are enough.
template <class S, int lanes> struct FlightInertia { S I[9][lanes], twice_I_inverse[9][lanes]; };

// Stores half the body rate, which is what the attitude's rate needs, and twice the inverse inertia. Scaling by 2
// commutes with every rounding, so the bits stay those of the equations in w, unless a product underflows.
template <class S> struct FlightLanes {
  template <int rows> using Rows = S[rows][kFlightLanes];
  Rows<3> p, v, half_w, half_w_stage;
  Rows<4> q, q_stage;
  FlightInertia<S, kFlightLanes> inertia;
  std::vector<S> rates;  // of q and half_w, 7 rows per stage
};

// Data shared by all steps. Gravity is uniform, so a stage's velocity is that of the step's start plus a constant:
//   v_i = v + h a_i g    p_new = p + h sum b_i v_i    v_new = v + h sum b_i g
template <class S> struct FlightSteps {
  const ExplicitWeights<S>& weights;
  S h_s{};
  std::vector<Vec3<S>> stage_m_per_s2, stage_m_per_s;  // a_i g, h a_i g
  Vec3<S> step_m_per_s2{}, step_m_per_s{};             // sum b_i g, h sum b_i g
  bool classical = false;                              // the tableau is that of RK4, which has a specialised loop

  explicit FlightSteps(const ExplicitWeights<S>& w);
  void set_gravity(const Vec3<S>& gravity_m_per_s2);
  void set_step(S h);
};

// `count` steps of the first `bodies` lanes. In float and double.
template <class S>
void fly(VectorWidth width, FlightKind kind, int bodies, const FlightSteps<S>& steps, std::int64_t count,
         FlightLanes<S>& lanes);

// One step of one body, of 13 scalars in the order of a state (6 of a point mass), with at most this many stages.
inline constexpr int kMaxStagesAlone = 16;
template <class S>
void fly_alone(FlightKind kind, const FlightSteps<S>& steps, const FlightInertia<S, 1>& inertia, const S* from, S* to);

}  // namespace atwood
