// The interval of an observed order, from noise, bars and curvature. Private to this room.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace atwood::metrics {

// From at least 4 rungs, coarse to fine: x = log h, y = log error, bar = the rung's bar over its error.
struct OrderInterval {
  bool settles = true;    // false: the local slopes do not converge as h decreases; the interval has no meaning
  bool smooth = false;    // of scatter_interval: another smooth deviation describes the rungs much better
  std::size_t first = 0;  // of scatter_interval: the coarsest rung of its window
  double low = 0, high = 0;
  double finest = 0;           // local slope of the two finest rungs
  double extrapolated = 0;     // to h = 0, by a model with one further power of h
  double range_of_slopes = 0;  // the largest local slope less the smallest, beyond what the bars allow
};
// Of rungs that deviate from a power smoothly.
OrderInterval order_interval(std::span<const double> x, std::span<const double> y, std::span<const double> bar);
// Of rungs that scatter about h^p (1 + a h), with the window that this describes; none where bars explain all.
std::optional<OrderInterval> scatter_interval(std::span<const double> x, std::span<const double> y,
                                              std::span<const double> bar);

}  // namespace atwood::metrics
