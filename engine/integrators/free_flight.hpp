// Free flight of many bodies by an explicit Runge-Kutta method: under uniform gravity alone the bodies are independent,
// so a few bodies at a time are taken through many steps while their data stay in the first-level cache.
//
// Data are structures of arrays with one body per lane, and each lane computes what the general stepper computes for
// the equations of rigid/rate.cpp: the same bits, at every vector width and number of threads.
#pragma once

#include <cstdint>
#include <memory>

#include "integrators/free_flight_lanes.hpp"
#include "rigid/model.hpp"

namespace atwood {

template <class S> class FreeFlight {
 public:
  FreeFlight(RigidModel<S>& model, ExplicitWeights<S> weights);
  FreeFlight(const FreeFlight&) = delete;
  FreeFlight& operator=(const FreeFlight&) = delete;

  // `count` equal steps of h_s from the state y, in place, under the force law of the model's present interval, which
  // must be the law of all of them. Counts the rate evaluations that the general stepper would make. Allocates nothing.
  void march(S h_s, std::int64_t count, S* y);

  // One step from y to y_new, which do not overlap: the same bits.
  void step(S h_s, const S* y, S* y_new);

 private:
  void sort_bodies();
  void count_evaluations(std::int64_t steps);
  void march_group(FlightKind kind, std::int64_t count, S* y, Share bodies, FlightLanes<S>& lanes) const;
  void gather(FlightKind kind, const S* y, Share bodies, FlightLanes<S>& lanes) const;
  void scatter(FlightKind kind, S* y, Share bodies, const FlightLanes<S>& lanes) const;

  RigidModel<S>& model_;
  ExplicitWeights<S> weights_;
  FlightSteps<S> steps_;
  VectorWidth width_ = widest_vectors();
  std::vector<FlightLanes<S>> lanes_;         // one per thread
  std::vector<FlightInertia<S, 1>> inertia_;  // of each body
  int fixed_ = 0;
  std::vector<int> sorted_;  // the moving bodies by kind, and in each kind by index
  int end_[3] = {};          // of each kind in sorted_
  std::int64_t epoch_ = -1, counted_epoch_ = -1;
};

// Null if any force besides uniform gravity acts, if the problem is a bare system of equations, if `weights` is null,
// or if the scalar has no vector lanes.
template <class S>
std::unique_ptr<FreeFlight<S>> make_free_flight(RigidModel<S>& model, const ExplicitWeights<S>* weights);

}  // namespace atwood
