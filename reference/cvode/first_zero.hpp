// Switching functions along one step's polynomial solution, and the first zero of such a function: found by enclosures
// of the function, its slope and its curvature over parts of the step, and not by signs at the step's ends.
#pragma once

#include <array>
#include <optional>
#include <vector>

namespace atwood::cvode {

using Polynomial = std::vector<double>;  // coefficients, constant first

struct Interval {
  double low = 0, high = 0;
};

// As a function of u, the time in units of the step:
//   round: sign (sum_k max(|x_k(u)| - half_k, 0)^2 - level^2)   the sign of a distance from a box, or from a point
//   flat:  sign (x_0(u) - level)
struct SwitchingFunction {
  std::vector<Polynomial> x;
  std::array<double, 3> half{};
  double level = 0, sign = 1;
  bool flat = false;
  double round_off = 0;  // of a value near zero

  struct Enclosure {
    Interval value, slope, curvature;
  };
  double value(double u) const;
  double slope(double u) const;
  Enclosure enclose(double from, double to) const;
};

// What is known of a function up to some instant. A function that starts at zero, as a gap after an impact, is armed
// once it has risen above its round-off. Its zero is where it falls to 0, or, as long as it is not armed, to its
// round-off below where it started.
struct Watch {
  bool armed = false, falling = false, started = false;
  double floor = 0;
};

struct Minimum {
  double u = 0, value = 0;
};

struct Searched {
  std::optional<double> zero;   // the first one; the function is not above it there
  std::optional<double> open;   // the search ended here without a decision
  std::vector<Minimum> minima;  // before the zero, above 0 and at most `reported`
};

// The first zero in [from, to]; updates `watch` up to it, or to `to`.
Searched first_zero(const SwitchingFunction& f, double from, double to, double reported, Watch& watch);

// c in f(u) = sum_k c_k u^k about another origin.
Polynomial shifted(Polynomial c, double to);

}  // namespace atwood::cvode
