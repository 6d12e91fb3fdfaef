// Kepler's problem in universal variables: Stiefel and Scheifele, Linear and Regular Celestial Mechanics (1971), ch.
// 11. With dt = r ds, beta = 2 mu / r0 - v0^2, eta = r0 . v0 and Stumpff's G_k(beta, s),
//   t = r0 G1 + eta G2 + mu G3        Kepler's equation: t' = r > 0, so it has one root
//   r = r0 G0 + eta G1 + mu G2
//   f = 1 - mu G2 / r0,  g = r0 G1 + eta G2,  f' = -mu G1 / (r r0),  g' = 1 - mu G2 / r
// Nothing here is singular at e = 0 or e = 1, and no perihelion or node is needed.
#include "closed_form/inverse_square.hpp"

#include "closed_form/stumpff.hpp"

namespace atwood::closed_form {

namespace {

template <class S> S last_step() { return std::ldexp(1.0, -kDigits<S> * 3 / 5); }

// The anomaly s at time t after the start, by Newton's iteration inside a bracket.
template <class S> class Anomaly {
 public:
  Anomaly(S distance, S eta, S mu, S beta) : distance_(distance), eta_(eta), mu_(mu), beta_(beta) {}

  // False: it did not converge.
  bool solve(S t, S& s) const {
    S low = 0, high = 0;
    s = 0;
    if (!(t > 0)) return true;
    if (!bracket(t, low, high)) return false;
    s = start(t);
    if (!(s > low && s < high)) s = low + (high - low) / 2;
    S width = high - low;  // at the last bisection
    for (int tries = 0, slow = 0; tries < kMaxTries; ++tries) {
      const Time now = time(s);
      const S late = now.t - t;
      if (!is_finite(late)) return false;
      if (late > 0) high = s;
      else low = s;
      // Converged to the round-off of the sum.
      if (magnitude(late) <= 2 * unit_round_off<S>() * (now.size + t)) return true;
      S next = s - late / now.r;
      slow = 2 * (high - low) <= width ? 0 : slow + 1;
      if (slow == 0) width = high - low;
      const bool newton = next >= low && next <= high && slow < 5;
      if (!newton) next = low + (high - low) / 2, slow = 0, width = high - low;
      // The error after a step is of the order of the square of the step: a step that changes only the last two fifths
      // of the digits is the last.
      const bool done = newton && magnitude(next - s) <= last_step<S>() * magnitude(s);
      s = next;
      if (done || !(low < high)) return true;
    }
    return false;
  }

 private:
  static constexpr int kMaxTries = 1000;
  // t and r = dt/ds at s; size: of the terms that make t
  struct Time {
    S t{}, r{}, size{};
  };

  Time time(S s) const {
    const auto G = stumpff(beta_, s);
    const S first = distance_ * G[1], second = eta_ * G[2], third = mu_ * G[3];
    return {first + second + third, distance_ * G[0] + eta_ * G[1] + mu_ * G[2],
            magnitude(first) + magnitude(second) + magnitude(third)};
  }

  // Doubled from a small part of the orbit on, so that no exponential overflows; of an ellipse, one revolution at most.
  bool bracket(S t, S& low, S& high) const {
    const S whole = beta_ > 0 ? 2 * pi<S>() / sqrt(beta_) : S(0);
    high = t / distance_;
    if (beta_ != 0 && high > 1 / sqrt(magnitude(beta_))) high = 1 / sqrt(magnitude(beta_));
    for (int tries = 0; tries < 8 * kMaxTries; ++tries) {
      if (beta_ > 0 && high >= whole) {
        high = whole;
        return true;
      }
      const S reached = time(high).t;
      if (!is_finite(reached)) return false;
      if (reached >= t) return true;
      low = high;
      high *= 2;
    }
    return false;
  }

  // Of an ellipse the mean motion. Of a hyperbola, with b = -beta and k = sqrt b, G1 and G2 tend to exp(k s) / 2 k and
  // exp(k s) / 2 b, so t tends to (r0 + mu / b + eta / k) exp(k s) / 2 k, which is solved by a logarithm.
  S start(S t) const {
    if (beta_ > 0) return t * beta_ / mu_;
    if (beta_ == 0) return 0;
    const S b = -beta_, k = sqrt(b), lead = distance_ + mu_ / b + eta_ / k;
    return lead > 0 ? log(2 * k * t / lead) / k : S(0);
  }

  S distance_, eta_, mu_, beta_;
};

}  // namespace

template <class S> std::string InverseSquare<S>::refusal() const {
  if (is_zero(r0)) return "a body starts at the centre of attraction";
  if (mu > 0 && is_zero(cross(r0, v0))) return "a body has no angular momentum and may fall into the centre";
  return "";
}

template <class S> CenterMotion<S> InverseSquare<S>::at(S t) const {
  if (mu == 0) return {r0 + t * v0, v0};
  const S distance = norm(r0), eta = dot(r0, v0), beta = 2 * mu / distance - dot(v0, v0);
  if (beta >
      0) {  // an ellipse: s grows by 2 pi / sqrt(beta) in each period 2 pi mu / beta^(3/2), which changes nothing
    const S period = 2 * pi<S>() * mu / (beta * sqrt(beta));
    t -= floor(t / period) * period;
  }
  S s{};
  if (!Anomaly<S>(distance, eta, mu, beta).solve(t, s)) return {{}, {}, "Kepler's equation was not solved"};
  const auto G = stumpff(beta, s);
  const S r = distance * G[0] + eta * G[1] + mu * G[2];
  return {(1 - mu * G[2] / distance) * r0 + (distance * G[1] + eta * G[2]) * v0,
          (-mu * G[1] / (r * distance)) * r0 + (1 - mu * G[2] / r) * v0};
}

template struct InverseSquare<Narrow>;
template struct InverseSquare<Wide>;

}  // namespace atwood::closed_form
