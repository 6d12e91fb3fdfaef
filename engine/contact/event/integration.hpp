// The method that steps a run, and the equations of motion without contacts.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "contact/event/report.hpp"
#include "integrators/free_flight.hpp"
#include "integrators/stepper.hpp"

namespace atwood::event {

// The model's own rates, which those with contact forces replace in its System.
template <class S> struct FreeRates {
  void (*rate_of)(void*, S, const S*, S*) = nullptr;
  void (*project_of)(void*, S*) = nullptr;
  void (*projection_of)(void*, const S*, S*) = nullptr;
  void* context = nullptr;

  void rate(S t_s, const S* y, S* dydt) const { rate_of(context, t_s, y, dydt); }
};

template <class S> struct Integration {
  explicit Integration(Stepper<S>& of_stepper) : stepper(of_stepper) {}

  Stepper<S>& stepper;
  std::unique_ptr<Stepper<S>> contact_stepper;  // for lasting contacts, where the method never evaluates rates
  std::unique_ptr<Stepper<S>> fine_stepper;     // of order 8, for slip that turns as it ends
  bool use_fine_stepper = false;                // in the present segment
  FreeFlight<S>* free_flight = nullptr;         // the stepper's equal steps, bit for bit, without contacts; may be null
  FreeRates<S> free;
  std::int64_t wrapped_calls = 0;  // of the rates with contact forces
  S rtol{}, atol{};                // rtol 0: equal steps
  S h_next_s{};                    // error control's advice; 0: none yet
};

// A body under quadratic drag: |u| u has a kink where the relative wind u = v - wind vanishes.
template <class S> struct DragBody {
  int body = 0;
  Vec3<S> velocity_W;  // of the wind
};

}  // namespace atwood::event
