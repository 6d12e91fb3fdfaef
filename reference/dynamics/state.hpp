// The layout of a scene's motion as one vector of unknowns, and the times at which its equations switch.
//
//   y = (p_WB of every mobile body, v_WB of every mobile body, then (q_WB, w_WB_B) of every body that rotates)
//
// Mobile: not fixed. A body with a later release is mobile; its rates are zero until then. For `problem = lorenz`
// y = (x, y, z).
#pragma once

#include <vector>

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

struct Slot {
  int position = -1;  // index of the first of 3 in y; -1: fixed
  int velocity = -1;
  int attitude = -1;  // first of 4 (w, x, y, z); -1: does not rotate
  int rate = -1;      // first of 3, body axes
};

// Kinds of components: a norm scales each component by the largest of its kind.
enum class Kind { position, velocity, attitude, rate };

struct Layout {
  int size = 0;
  int positions = 0;        // y[0, positions) are positions, y[positions, 2 positions) their velocities
  std::vector<Slot> slots;  // one a body of the scene
  std::vector<Kind> kinds;  // one a component
};

Layout layout(const Scene& scene);

// The state of the scene (initial) or of a sample in S. Conversion is exact to S except for the quaternion, which is
// normalised in S: the scene's doubles are of unit length to round-off only.
template <class S> std::vector<S> pack(const Scene& scene);
template <class S> std::vector<S> pack(const Scene& scene, const SampleView& sample);

// A sample from y, without loss. Fixed bodies have the scene's pose and zero velocity; `lorenz` has its rates as
// velocity.
template <class S> Sample unpack(const Scene& scene, S t_s, const S* y);
// Half-widths from a vector in the same layout; values that are not in y have the half-width 0.
template <class S> Sample unpack_bars(const Scene& scene, S t_s, const S* bar);

// Times strictly inside (0, t_end) [s] at which a force switches or a body is released; sorted, without duplicates.
// Between two of them the equations are smooth: interval k is [switch k-1, switch k).
std::vector<double> switch_times(const Scene& scene, double t_end_s);

}  // namespace atwood::dynamics
