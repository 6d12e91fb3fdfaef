// The solution within one step of CVODE: its own interpolating polynomial, of the method's order.
#pragma once

#include <vector>

#include "cvode/first_zero.hpp"
#include "dynamics/contacts.hpp"

namespace atwood::cvode {

struct Trajectory {
  double t_s = 0, span_s = 0;          // u = (t - t_s) / span_s, in [-1, 0]
  std::vector<std::vector<double>> c;  // [power of u][component of y]

  double unit(double at_s) const { return (at_s - t_s) / span_s; }
  double time(double u) const { return t_s + u * span_s; }
  void state(double at_s, std::vector<double>& y) const;
  Polynomial component(int i) const;
};

// The gap of a pair minus `shift_m`, as a function with the sign of sign (gap - shift).
SwitchingFunction gap_function(const Scene& scene, const dynamics::Layout& layout, const dynamics::ContactPair& pair,
                               const Trajectory& path, double shift_m, double sign);

// Where the bodies of a scene are between two instants, so that most pairs are known to stay apart.
class Reaches {
 public:
  Reaches(const Scene& scene, const dynamics::Layout& layout, const Trajectory& path, double from_s, double to_s);
  // A lower bound of the gap.
  double least_gap(const dynamics::ContactPair& pair) const;

 private:
  const Scene& scene_;
  const dynamics::Layout& layout_;
  std::vector<double> middle_, radius_m_;  // the state in the middle; of each body
};

// The first zero of a function of time that no polynomial gives: on polynomials through its values at Chebyshev's
// points, in parts so short that the last coefficients are round-off. `longest_s`: of a part.
struct Sampled {
  std::optional<double> zero_s, open_s;
};
template <class Function>
Sampled first_zero_of_samples(const Function& f, double from_s, double to_s, double longest_s, double round_off,
                              Watch& watch);

// ---- the template --------------------------------------------------------------------------------------------------
inline constexpr int kSamplePoints = 13;
// The points in [-1, 1], and the polynomial through values at them: `tail` is the size of its last coefficients in
// Chebyshev's polynomials, `size` that of all.
const std::array<double, kSamplePoints>& sample_points();
Polynomial through(const std::array<double, kSamplePoints>& values, double& size, double& tail);

template <class Function>
Sampled first_zero_of_samples(const Function& f, double from_s, double to_s, double longest_s, double round_off,
                              Watch& watch) {
  constexpr double least_part = 1e-5, resolved = 1e-9;
  const double whole_s = to_s - from_s;
  double begin_s = from_s, span_s = whole_s > longest_s ? longest_s : whole_s;
  Sampled made;
  while (begin_s < to_s) {
    const bool last = !(begin_s + span_s * (1 + 1e-9) < to_s);
    const double end_s = last ? to_s : begin_s + span_s, half_s = (end_s - begin_s) / 2, middle_s = begin_s + half_s;
    std::array<double, kSamplePoints> values;
    for (int k = 0; k < kSamplePoints; ++k) values[k] = f(middle_s + half_s * sample_points()[k]);
    SwitchingFunction g;
    g.flat = true;
    g.round_off = round_off;
    double size = 0, tail = 0;
    g.x = {through(values, size, tail)};
    if (tail > resolved * size && tail > round_off && end_s - begin_s > least_part * whole_s) {
      span_s = (end_s - begin_s) / 2;
      continue;
    }
    const Searched found = first_zero(g, -1, 1, 0, watch);
    if (found.zero) {
      made.zero_s = std::min(middle_s + half_s * *found.zero, to_s);
      return made;
    }
    if (found.open) {
      made.open_s = middle_s + half_s * *found.open;
      return made;
    }
    begin_s = end_s;
    span_s = std::min(2 * span_s, longest_s);
  }
  return made;
}

}  // namespace atwood::cvode
