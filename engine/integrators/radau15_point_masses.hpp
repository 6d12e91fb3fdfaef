// Radau 15 for a few point masses under central and mutual gravity, in double: a whole step (prediction, sweeps, end)
// in one kernel, with the numbers of bodies and dimensions known to the compiler. radau15.cpp says what a step is; here
// the same stages are solved with fewer sweeps, since the gradient of gravity is known: equal to those of the general
// sweeps to round-off, or to the part of a tolerance that these leave.
#pragma once

#include <memory>

#include "integrators/radau15.hpp"

namespace atwood {

// Bodies whose state is p v p v ..., and the forces on them:
//   a = field - mu r / (r^2 + s^2)^(3/2), r from a centre; of a pair: a_a += on_a r / (r^2 + s^2)^(3/2) and
//   a_b -= on_b r / (r^2 + s^2)^(3/2), r = p_b - p_a
inline constexpr int kMaxGravitating = 10;
struct GravitatingBodies {
  struct Centre {
    int body;
    double at_m[3], mu_m3_per_s2, softening2_m2, three_by_mu;  // 0: mu is 0
  };
  struct Pair {
    int a, b;
    double on_a, on_b, softening2_m2;
  };
  int count = 0;
  double field_m_per_s2[kMaxGravitating][3] = {};
  std::vector<Centre> centres;
  std::vector<Pair> pairs;

  // Whether all remain in the plane z = constant in which they are at y, so that z needs no stages.
  bool in_plane(const double* y) const;
};

// Null: other forces act, a body rotates, or there are more than kMaxGravitating.
std::unique_ptr<GravitatingBodies> gravitating_bodies(const RigidModel<double>& model);

// What a step reads and writes. Arrays are those of Radau15: of the state, or of eight nodes a component of it.
struct GravitatingStep {
  double h_s, rtol, atol_over_rtol;
  bool in_plane, compensated;
  const double *y, *compensation;
  // the rates of the step from which those of this one are extrapolated, and their errors then; null: none
  const double *rate_from, *error_from;
  const RadauExtrapolation<double>* extrapolation_from;
  double offset, ratio;  // of the start and the length of this step, in units of that one
  double *y_new, *compensation_new, *rate, *prediction_error;
  RadauExtrapolation<double>* extrapolation;  // written where offset is 1
  double contraction;                         // before, and after
  double rate_size = 0;                       // largest rate, as the first sweep knew it
  double last_coefficient = 0;                // largest last coefficient of the rates' polynomials
  SolveReport report = {};                    // the rates at the nodes; its residual is the change that remains
};
void step_gravitating_bodies(VectorWidth width, const GravitatingBodies& bodies, GravitatingStep& step);

}  // namespace atwood
