// Where the certified part of a truth ends.
#pragma once

#include <optional>
#include <string>

#include "protocol/sample.hpp"

namespace atwood::dynamics {

// " at t = 0.25 s": what ends the reason of an end.
inline std::string at_time(Wide t_s) { return " at t = " + format_double(static_cast<double>(t_s)) + " s"; }

// Of the time: the distance of the last sample and the last event from the end.
inline constexpr double kEndMargin = 1e-9;

// A truth is certified for samples before t_s only; `why` says what is not decided there.
struct CertifiedEnd {
  Wide t_s = 0;
  std::string why;

  bool is_after(Wide at_s) const { return at_s < t_s * (1 - Wide(kEndMargin)); }
};

// Moves the end to t_s where it was later, or where there was none.
inline void end_at(std::optional<CertifiedEnd>& end, Wide t_s, const std::string& why) {
  if (!end || t_s < end->t_s) end = CertifiedEnd{t_s, why};
}

}  // namespace atwood::dynamics
