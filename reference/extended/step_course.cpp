#include "extended/step_course.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace atwood::extended {

namespace {

constexpr int kDegree = 16;             // of a course
constexpr int kPoints = 8 * kDegree;    // at which its extrema are looked for
constexpr double kSlopeNoise = 1e-10;   // of the largest value a step
constexpr double kNarrowNoise = 1e-14;  // of the largest value: the polynomial is evaluated in double
// Dense output has the error of degree 5 and is compared with degree 3. From half of an oscillation a step on, it is
// less than this part of the difference.
constexpr double kFinerShare = 0.125;
constexpr std::array<double, 3> kCompared{0.25, 0.5, 0.75};

// Places of the nodes: x = (1 - cos(j pi / n)) / 2.
double place(int j, int of) { return (1 - std::cos(j * std::numbers::pi / of)) / 2; }

// sum c_k T_k(u) by Clenshaw's recurrence, u = 1 - 2 x.
double series(const std::array<double, kDegree + 1>& c, double x) {
  const double u = 1 - 2 * x;
  double b1 = 0, b2 = 0;
  for (int k = kDegree; k >= 1; --k) {
    const double b = c[k] + 2 * u * b1 - b2;
    b2 = b1;
    b1 = b;
  }
  return c[0] + u * b1 - b2;
}

// Coefficients of the polynomial through values at the Chebyshev-Lobatto nodes (C. W. Clenshaw and A. R. Curtis 1960).
std::array<double, kDegree + 1> coefficients(const std::array<double, kDegree + 1>& value) {
  std::array<double, kDegree + 1> c{};
  for (int k = 0; k <= kDegree; ++k) {
    for (int j = 0; j <= kDegree; ++j)
      c[k] += (j == 0 || j == kDegree ? 0.5 : 1) * value[j] * std::cos(j * k * std::numbers::pi / kDegree);
    c[k] *= (k == 0 || k == kDegree ? 1.0 : 2.0) / kDegree;
  }
  return c;
}

// What is left out of the series. The coefficients of a function with a kink, as of the gap of a wall that is crossed,
// fall with the square of k, and what is left out is k times the last ones.
double remainder(const std::array<double, kDegree + 1>& c) {
  return 4 * kDegree * std::max({std::fabs(c[kDegree - 2]), std::fabs(c[kDegree - 1]), std::fabs(c[kDegree])});
}

// The least value between two places, by golden section.
double least_between(const std::array<double, kDegree + 1>& c, double low, double high) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double at_a = series(c, a), at_b = series(c, b);
  for (int tries = 0; tries < 40; ++tries) {
    if (at_a <= at_b) {
      high = b, b = a, at_b = at_a;
      a = high - golden * (high - low), at_a = series(c, a);
    } else {
      low = a, a = b, at_a = at_b;
      b = low + golden * (high - low), at_b = series(c, b);
    }
  }
  return (low + high) / 2;
}

void find_minima(const std::array<double, kDegree + 1>& c, Course& made) {
  std::array<double, kPoints + 1> p{};
  for (int i = 0; i <= kPoints; ++i) p[i] = series(c, place(i, kPoints));
  made.least = *std::min_element(p.begin(), p.end());
  for (int i = 1; i < kPoints; ++i) {
    if (!(p[i] <= p[i - 1] && p[i] < p[i + 1])) continue;
    int left = i, right = i;
    while (left > 0 && p[left - 1] >= p[left]) --left;
    while (right < kPoints && p[right + 1] >= p[right]) ++right;
    Minimum at;
    at.x = least_between(c, place(i - 1, kPoints), place(i + 1, kPoints));
    at.value = std::min(series(c, at.x), p[i]);
    at.left = place(left, kPoints);
    at.right = place(right, kPoints);
    at.rise = std::min(p[left], p[right]) - at.value;
    made.least = std::min(made.least, at.value);
    made.minima.push_back(at);
  }
  int top = kPoints;
  while (top > 0 && p[top - 1] >= p[top]) --top;
  made.last_maximum = place(top, kPoints);
}

}  // namespace

bool Course::has_slopes(double first, double last, double round_off) const {
  const double noise = kSlopeNoise * largest + kDegree * kDegree * round_off;
  const auto same = [&](double a, double b) {
    return std::fabs(a - b) <= 0.1 * std::max(std::fabs(a), std::fabs(b)) + noise;
  };
  return same(first_slope, first) && same(last_slope, last);
}

// With l_i the Lagrange polynomials on 0, 1/2, 1: y = sum (1 - 2 l_i'(x_i) (x - x_i)) l_i^2 y_i + (x - x_i) l_i^2 h
// f_i.
template <class S> std::vector<S> StepCourse<S>::state(S x) const {
  const S a = (2 * x - 1) * (x - 1), m = 4 * x * (1 - x), b = x * (2 * x - 1);
  const S a2 = a * a, m2 = m * m, b2 = b * b, h = step_.span;
  const S y0 = (1 + 6 * x) * a2, f0 = h * x * a2, fm = h * (x - S(0.5)) * m2, y1 = (7 - 6 * x) * b2,
          f1 = h * (x - 1) * b2;
  std::vector<S> made(step_.y0.size());
  for (std::size_t i = 0; i < made.size(); ++i)
    made[i] =
        y0 * step_.y0[i] + m2 * step_.ym[i] + y1 * step_.y1[i] + f0 * step_.f0[i] + fm * step_.fm[i] + f1 * step_.f1[i];
  return made;
}

template <class S> std::vector<S> StepCourse<S>::cubic_state(S x) const {
  const S z = 1 - x, h = step_.span;
  const S y0 = z * z * (1 + 2 * x), y1 = x * x * (3 - 2 * x), f0 = h * x * z * z, f1 = -h * x * x * z;
  std::vector<S> made(step_.y0.size());
  for (std::size_t i = 0; i < made.size(); ++i)
    made[i] = y0 * step_.y0[i] + y1 * step_.y1[i] + f0 * step_.f0[i] + f1 * step_.f1[i];
  return made;
}

template <class S> const std::vector<std::vector<S>>& StepCourse<S>::nodes() const {
  if (!nodes_.empty()) return nodes_;
  nodes_.push_back(step_.y0);
  for (int j = 1; j < kDegree; ++j) nodes_.push_back(j == kDegree / 2 ? step_.ym : state(S(place(j, kDegree))));
  nodes_.push_back(step_.y1);
  for (const double x : kCompared) {
    coarse_.push_back(state(S(x)));
    coarse_.push_back(cubic_state(S(x)));
  }
  return nodes_;
}

template <class S> Course StepCourse<S>::of(const Value& value) const {
  const std::vector<std::vector<S>>& states = nodes();
  const auto at = [&](double x) { return step_.t + S(x) * step_.span; };
  std::array<double, kDegree + 1> values{};
  Course made;
  for (int j = 0; j <= kDegree; ++j) {
    values[j] = static_cast<double>(value(at(place(j, kDegree)), states[j].data()));
    made.largest = std::isfinite(values[j]) ? std::max(made.largest, std::fabs(values[j])) : HUGE_VAL;
  }
  if (!std::isfinite(made.largest)) {
    made.error = HUGE_VAL;
    made.least = -HUGE_VAL;
    return made;
  }
  for (std::size_t k = 0; k < kCompared.size(); ++k) {
    const S fine = value(at(kCompared[k]), coarse_[2 * k].data()),
            rough = value(at(kCompared[k]), coarse_[2 * k + 1].data());
    made.error = std::max(made.error, kFinerShare * std::fabs(static_cast<double>(fine - rough)));
  }
  const std::array<double, kDegree + 1> c = coefficients(values);
  made.error += remainder(c) + kNarrowNoise * made.largest;
  if (!(made.error >= 0)) made.error = HUGE_VAL;
  for (int k = 1; k <= kDegree; ++k) {  // T_k' = k^2 at 1 and (-1)^(k+1) k^2 at -1
    made.first_slope -= 2 * c[k] * k * k;
    made.last_slope -= 2 * c[k] * k * k * (k % 2 == 0 ? -1 : 1);
  }
  find_minima(c, made);
  return made;
}

namespace {

template <class S> constexpr bool is_wide = std::is_same_v<S, Wide>;
template <class S> constexpr double kValueNoise = is_wide<S> ? 1e-26 : 1e-11;        // of the largest value in the step
template <class S> constexpr double kInstantTolerance = is_wide<S> ? 1e-31 : 1e-15;  // relative

template <class S> struct FallSearch {
  const std::function<std::optional<S>(S)>& exact;
  S t, span, noise;
  Fall<S> found;

  // False: the motion could not be integrated to tau.
  bool evaluate(S tau, S& value) {
    const std::optional<S> at = exact(tau);
    if (!at) {
      found.tau = tau;
      found.located = false;
      return false;
    }
    value = *at;
    return true;
  }

  // The least value near a minimum of the polynomial, by parabolas through three values whose distance shrinks. It ends
  // early below zero, and where the parabola cannot reach zero.
  bool least(const Minimum& at, S& tau, S& value) {
    tau = S(at.x) * span;
    if (!evaluate(tau, value)) return false;
    S apart = S(std::min({at.x - at.left, at.right - at.x, 1e-2})) * span / 4;
    for (int tries = 0; tries < 20 && !(value < -noise); ++tries, apart /= 8) {
      S before{}, after{};
      if (!evaluate(tau - apart, before) || !evaluate(tau + apart, after)) return false;
      const S bend = before - 2 * value + after;
      if (!(bend > 0)) break;
      const S shift = std::clamp((before - after) / (2 * bend), S(-1), S(1));
      const S gain = bend * shift * shift / 2;
      if (4 * gain <= noise || value > noise + 16 * gain) break;
      S next{};
      if (!evaluate(tau + shift * apart, next)) return false;
      if (!(next < value)) continue;
      tau += shift * apart;
      value = next;
    }
    return true;
  }

  // Between a positive value at `low` and a negative one at `high`: false position, the value at the end that stays
  // being halved (Illinois).
  Fall<S> locate(S low, S high, S at_low, S at_high) {
    for (int tries = 0; high - low > S(kInstantTolerance<S>) * (t + high); ++tries) {
      found.located = tries < 200;
      if (!found.located) break;
      S x = high - at_high * (high - low) / (at_high - at_low);
      if (tries % 8 == 7 || !(x > low && x < high)) x = low + (high - low) / 2;
      if (!(x > low && x < high)) break;  // neighbours
      S now{};
      if (!evaluate(x, now)) return found;
      if (now < 0) {
        high = x, at_high = now;
        at_low /= 2;
      } else {
        low = x, at_low = now;
        at_high /= 2;
      }
      if (now == 0) break;
    }
    found.tau = high;
    return found;
  }
};

}  // namespace

template <class S>
Fall<S> first_fall(const StepCourse<S>& step, const typename StepCourse<S>::Value& value,
                   const std::function<std::optional<S>(S tau)>& exact) {
  const Course course = step.of(value);
  if (course.is_positive()) return {};
  const DenseStep<S>& all = step.step();
  FallSearch<S> search{exact, all.t, all.span, S(kValueNoise<S> * course.largest), {}};
  Fall<S>& found = search.found;
  const S first = value(all.t, all.y0.data()), last = value(all.t + all.span, all.y1.data());
  const auto bracketed = [&](double left, S high, S at_high) {
    const S low = S(left) * all.span;
    S at_low = first;
    if (left > 0 && !search.evaluate(low, at_low)) return found;
    if (at_low > 0) return search.locate(low, high, at_low, at_high);
    // It is zero at the start and falls at once, or the bracket does not begin above zero.
    if (left == 0) found.tau = S(0);
    else found.undecided = true;
    return found;
  };
  if (first < -search.noise) {  // a switch at the start made it negative
    found.tau = S(0);
    return found;
  }
  for (const Minimum& at : course.minima) {
    if (at.value > course.error) continue;
    if (!course.shows(at)) {
      found.undecided = true;
      return found;
    }
    S tau{}, least{};
    if (!search.least(at, tau, least)) return found;
    if (least < -search.noise) return bracketed(at.left, tau, least);
    if (least <= search.noise) {
      found.grazes = tau;
      return found;
    }
  }
  if (last < -search.noise) return bracketed(course.last_maximum < 1 ? course.last_maximum : 0, all.span, last);
  return found;
}

template class StepCourse<double>;
template class StepCourse<Wide>;
template Fall<double> first_fall(const StepCourse<double>&, const StepCourse<double>::Value&,
                                 const std::function<std::optional<double>(double)>&);
template Fall<Wide> first_fall(const StepCourse<Wide>&, const StepCourse<Wide>::Value&,
                               const std::function<std::optional<Wide>(Wide)>&);

}  // namespace atwood::extended
