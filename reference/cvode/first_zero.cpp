#include "cvode/first_zero.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::cvode {

namespace {

constexpr int kMaxParts = 4000;              // of one search: what is not decided then is open
constexpr double kLeastPart = 0x1p-44;       // of a step: narrower parts are judged by their ends
constexpr double kIntervalRoundOff = 1e-14;  // of the terms that an enclosure sums

double horner(const Polynomial& c, double u) {
  double sum = 0;
  for (std::size_t k = c.size(); k-- > 0;) sum = sum * u + c[k];
  return sum;
}
double horner_slope(const Polynomial& c, double u) {
  double sum = 0;
  for (std::size_t k = c.size(); k-- > 1;) sum = sum * u + static_cast<double>(k) * c[k];
  return sum;
}

Interval hull(const Interval& a, const Interval& b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }
Interval sum(const Interval& a, const Interval& b) { return {a.low + b.low, a.high + b.high}; }
Interval product(const Interval& a, const Interval& b) {
  const double each[] = {a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
  return {*std::min_element(each, each + 4), *std::max_element(each, each + 4)};
}
Interval square(const Interval& a) {
  const double low = a.low * a.low, high = a.high * a.high;
  return {a.low <= 0 && a.high >= 0 ? 0 : std::min(low, high), std::max(low, high)};
}
Interval times(double s, const Interval& a) {
  return s < 0 ? Interval{s * a.high, s * a.low} : Interval{s * a.low, s * a.high};
}
Interval common(const Interval& a, const Interval& b) { return {std::max(a.low, b.low), std::min(a.high, b.high)}; }
double farthest(const Interval& a) { return std::max(std::fabs(a.low), std::fabs(a.high)); }
bool excludes_zero(const Interval& a) { return a.low > 0 || a.high < 0; }

struct Range {
  Interval value, slope, curvature;
};

// Of a polynomial within r of m: from its coefficients about m.
Range range_of(const Polynomial& c, double m, double r) {
  const Polynomial at = shifted(c, m);
  double value = 0, slope = 0, curvature = 0, power = r;
  for (std::size_t k = 1; k < at.size(); ++k) {
    const double size = std::fabs(at[k]) * power, n = static_cast<double>(k);
    value += size;
    if (k >= 2) slope += n * size;
    if (k >= 3) curvature += n * (n - 1) * size;
    power *= r;
  }
  slope /= r;
  curvature /= r * r;
  const double first = at.size() > 1 ? at[1] : 0, second = at.size() > 2 ? 2 * at[2] : 0;
  return {{at[0] - value, at[0] + value}, {first - slope, first + slope}, {second - curvature, second + curvature}};
}

// max(|x| - half, 0) with the sign of x; monotonic.
double beyond(double x, double half) { return x > half ? x - half : x < -half ? x + half : 0; }

}  // namespace

Polynomial shifted(Polynomial c, double to) {
  for (std::size_t i = 0; i + 1 < c.size(); ++i)
    for (std::size_t k = c.size() - 1; k-- > i;) c[k] += to * c[k + 1];
  return c;
}

double SwitchingFunction::value(double u) const {
  if (flat) return sign * (horner(x[0], u) - level);
  double total = -level * level;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double z = beyond(horner(x[k], u), half[k]);
    total += z * z;
  }
  return sign * total;
}

double SwitchingFunction::slope(double u) const {
  if (flat) return sign * horner_slope(x[0], u);
  double total = 0;
  for (std::size_t k = 0; k < x.size(); ++k) total += 2 * beyond(horner(x[k], u), half[k]) * horner_slope(x[k], u);
  return sign * total;
}

// The naive sums, and Taylor's formula about the middle with the slope and the curvature of the whole part: the slope
// is continuous, also where a coordinate enters the box.
SwitchingFunction::Enclosure SwitchingFunction::enclose(double from, double to) const {
  const double m = from + (to - from) / 2, r = std::max((to - from) / 2, 0x1p-60);
  Enclosure made;
  double terms = 0;
  if (flat) {
    const Range of = range_of(x[0], m, r);
    made = {sum(of.value, {-level, -level}), of.slope, of.curvature};
    terms = farthest(of.value) + std::fabs(level);
  } else {
    made.value = {-level * level, -level * level};
    terms = level * level;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const Range of = range_of(x[k], m, r);
      const Interval z{beyond(of.value.low, half[k]), beyond(of.value.high, half[k])};
      made.value = sum(made.value, square(z));
      made.slope = sum(made.slope, times(2, product(z, of.slope)));
      const bool outside = half[k] == 0 || of.value.low > half[k] || of.value.high < -half[k];
      const bool inside = half[k] > 0 && of.value.low > -half[k] && of.value.high < half[k];
      Interval bend = times(2, sum(square(of.slope), product(z, of.curvature)));
      if (!outside) bend = inside ? Interval{} : hull(bend, {});
      made.curvature = sum(made.curvature, bend);
      const double size = farthest(of.value);
      terms += size * size;
    }
  }
  made = {times(sign, made.value), times(sign, made.slope), times(sign, made.curvature)};
  const double at = value(m), tilt = slope(m);
  made.slope = common(made.slope, sum({tilt, tilt}, product(made.curvature, {-r, r})));
  made.value = common(made.value, sum({at, at}, product(made.slope, {-r, r})));
  made.value = common(
      made.value, sum(sum({at, at}, times(tilt, {-r, r})),
                      {std::min(0.0, made.curvature.low) * r * r / 2, std::max(0.0, made.curvature.high) * r * r / 2}));
  const double rounding = kIntervalRoundOff * terms;
  made.value = {made.value.low - rounding, made.value.high + rounding};
  made.slope = {made.slope.low - rounding, made.slope.high + rounding};
  made.curvature = {made.curvature.low - rounding, made.curvature.high + rounding};
  return made;
}

namespace {

// Of a function that is positive at `low` and not positive at `high`; the end where it is not.
template <class Function> double falling_zero(const Function& f, double low, double high) {
  double f_low = f(low), f_high = f(high);
  int stuck = 0;  // at the same end: Illinois halves its value
  for (int tries = 0; tries < 200; ++tries) {
    double middle = low + (high - low) * (f_low / (f_low - f_high));
    if (tries % 4 == 3 || !(middle > low && middle < high)) middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) break;
    const double now = f(middle);
    if (now > 0) {
      low = middle;
      f_low = now;
      f_high /= stuck > 0 ? 2 : 1;
      stuck = 1;
    } else {
      high = middle;
      f_high = now;
      f_low /= stuck < 0 ? 2 : 1;
      stuck = -1;
      if (now == 0 && high - low < 0x1p-50) break;
    }
  }
  return high;
}

class Search {
 public:
  Search(const SwitchingFunction& f, double reported, Watch& watch) : f_(f), reported_(reported), watch_(watch) {}

  Searched run(double from, double to) {
    if (from <= to) {
      const double start = f_.value(from), tilt = f_.slope(from);
      if (!watch_.started) {
        watch_.started = true;
        watch_.floor = std::min(start, 0.0) - f_.round_off;
        arm(start);
      }
      // Falling at the end of one step and rising from the start of the next: closest in between.
      if (watch_.armed && watch_.falling && tilt >= 0) report(from, start);
      if (start <= target()) made_.zero = from;
      else visit(from, to, 0);
      if (!made_.zero) watch_.falling = f_.slope(to) < 0;
    }
    return std::move(made_);
  }

 private:
  double target() const { return watch_.armed ? 0 : watch_.floor; }
  void arm(double value) { watch_.armed |= value > f_.round_off; }
  void report(double u, double value) {
    if (value > 0 && value <= reported_) made_.minima.push_back({u, value});
  }
  void falls(double from, double to) {
    arm(f_.value(from));
    const double to_value = target();
    if (f_.value(to) <= to_value) made_.zero = falling_zero([&](double u) { return f_.value(u) - to_value; }, from, to);
  }
  void judge_ends(double from, double to) {  // of a part in which the function changes by no more than its round-off
    falls(from, to);
    if (!made_.zero) rises(to);
  }
  void rises(double to) { arm(f_.value(to)); }

  bool ended() const { return made_.zero.has_value() || made_.open.has_value(); }

  void visit(double from, double to, int depth) {
    if (ended()) return;
    if (++parts_ > kMaxParts) {
      made_.open = from;
      return;
    }
    const auto [value, slope, curvature] = f_.enclose(from, to);
    if (value.low > std::max(reported_, watch_.armed ? 0 : f_.round_off)) {
      watch_.armed = true;
      return;
    }
    if (-f_.round_off <= value.low && value.high <= f_.round_off) {  // zero throughout
      if (f_.value(to) <= target()) made_.zero = to;
      return;
    }
    if (slope.low > 0) return rises(to);
    if (slope.high < 0) return falls(from, to);
    if (excludes_zero(curvature)) return bends(from, to, curvature.low > 0);
    const bool positive = watch_.armed && value.low > 0;
    if (positive && value.high - value.low <= value.low / 2) return report(from + (to - from) / 2, value.low);
    if (to - from < kLeastPart || value.high - value.low <= 4 * f_.round_off) return judge_ends(from, to);
    const double middle = from + (to - from) / 2;
    visit(from, middle, depth + 1);
    visit(middle, to, depth + 1);
  }

  // The slope has at most one zero in this part.
  void bends(double from, double to, bool up) {
    const double start = f_.slope(from), end = f_.slope(to);
    if (up ? start >= 0 : end >= 0) return rises(to);
    if (up ? end <= 0 : start <= 0) return falls(from, to);
    const double turn = falling_zero([&](double u) { return up ? -f_.slope(u) : f_.slope(u); }, from, to);
    if (!up) {
      rises(turn);
      return falls(turn, to);
    }
    falls(from, turn);
    if (made_.zero) return;
    if (watch_.armed) report(turn, f_.value(turn));
    rises(to);
  }

  const SwitchingFunction& f_;
  double reported_;
  Watch& watch_;
  Searched made_;
  int parts_ = 0;
};

}  // namespace

Searched first_zero(const SwitchingFunction& f, double from, double to, double reported, Watch& watch) {
  return Search(f, reported, watch).run(from, to);
}

}  // namespace atwood::cvode
