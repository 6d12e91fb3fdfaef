// How the reference lays a scene's motion out as one vector of unknowns, and when that motion's equations switch.
//
//   y = (p_WB of every mobile body, v_WB of every mobile body, then (q_WB, w_WB_B) of every body that rotates)
//
// Mobile: not fixed. A body that waits for its release is mobile; its rates are zero until then. `problem = lorenz`
// has y = (x, y, z).
#pragma once

#include <vector>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

struct Slot {
  int position = -1;  // index of the first of 3 in y; -1: fixed
  int velocity = -1;
  int attitude = -1;  // first of 4 (w, x, y, z); -1: does not rotate
  int rate = -1;      // first of 3, body axes
};

// Components that are measured together: a norm scales each by the largest of its kind.
enum class Kind { position, velocity, attitude, rate };

struct Layout {
  int size = 0;
  int positions = 0;        // y[0, positions) are positions, y[positions, 2 positions) their velocities
  std::vector<Slot> slots;  // one a body of the scene
  std::vector<Kind> kinds;  // one a component
};

Layout layout(const Scene& scene);

// The initial state, exact in S but for the quaternion, which is normalised in S (the scene's doubles are unit to
// round-off only; the error of orientation is what they say, not their length).
template <class S> std::vector<S> pack(const Scene& scene);
template <class S> std::vector<S> pack(const Scene& scene, const Sample& sample);

// Widened without loss. Fixed bodies come with the scene's pose and zero velocity; `lorenz` with its rates as velocity.
template <class S> Sample unpack(const Scene& scene, S t_s, const S* y);
// A vector of uncertainties in the same layout; what is not in y has bar 0.
template <class S> Sample unpack_bars(const Scene& scene, S t_s, const S* bar);

// Instants strictly inside (0, t_end) where a force switches or a body is released; sorted, each once. Between two of
// them the equations are smooth: interval k is [switch k-1, switch k).
std::vector<double> switch_times(const Scene& scene, double t_end_s);

}  // namespace atwood::dynamics
