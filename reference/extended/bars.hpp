// Bars of the extended truths, with and without joints.
#pragma once

#include <string>
#include <vector>

#include "dynamics/certified_end.hpp"
#include "protocol/refusal.hpp"
#include "protocol/truth.hpp"

namespace atwood::extended {

inline constexpr double kTargetBar = 1e-20;  // of the scale
inline constexpr double kUselessBar = 1e-3;  // relative to the scale: values with larger bars are not bounded
// If one of the methods is exact, the largest difference is the whole error of the other. The bar is twice that.
inline constexpr double kBarSafety = 2;

// The events before the end, with their bars, and the end as the outcome's reason.
inline void append_certified_events(const std::vector<Event>& events, const std::vector<double>& bar_s,
                                    const std::optional<dynamics::CertifiedEnd>& end, Truth& truth) {
  for (std::size_t k = 0; k < events.size() && (!end || end->is_after(events[k].t_s)); ++k) {
    truth.events.push_back(events[k]);
    truth.event_bar_s.push_back(bar_s[k]);
  }
  if (end) truth.outcome = refused(end->why);
}

}  // namespace atwood::extended
