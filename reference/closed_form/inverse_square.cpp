// Kepler's problem in universal variables: Stiefel and Scheifele, Linear and Regular Celestial Mechanics (1971), ch.
// 11. With dt = r ds, beta = 2 mu / r0 - v0^2, eta = r0 . v0 and Stumpff's G_k(beta, s),
//   t = r0 G1 + eta G2 + mu G3        Kepler's equation: t' = r > 0, so it has one root
//   r = r0 G0 + eta G1 + mu G2
//   f = 1 - mu G2 / r0,  g = r0 G1 + eta G2,  f' = -mu G1 / (r r0),  g' = 1 - mu G2 / r
// Nothing here is singular at e = 0 or e = 1, and no perihelion or node is needed. A radial orbit (Danby, Fundamentals
// of Celestial Mechanics (1988), 6.9) is measured from the instant at which it leaves or reaches the centre, where r0 =
// eta = 0:
//   t = mu G3,  r = mu G2,  r' = mu G1 / r
// in which nothing cancels as long as beta <= 0.
#include "closed_form/inverse_square.hpp"

#include <boost/multiprecision/cpp_int.hpp>

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
    high = distance_ > 0 ? t / distance_ : exp(log(6 * t / mu_) / 3);  // the roots while G1 = s and while G3 = s^3 / 6
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

template <class S> S period(S mu, S beta) { return 2 * pi<S>() * mu / (beta * sqrt(beta)); }

// An attracted orbit on a line through the centre. With k = sqrt|beta| / 2, r = (mu / 2) (sin(k s) / k)^2 and eta =
// r r' = dr / ds, so that tan(k s) = 2 k r / |eta| gives s at the start (tanh where beta < 0).
template <class S> struct Radial {
  explicit Radial(const InverseSquare<S>& of) : mu(of.mu) {
    const S distance = norm(of.r0), speed = norm(of.v0), eta = dot(of.r0, of.v0), along = magnitude(eta);
    direction = 1 / distance * of.r0;
    outward = !(eta < 0);
    beta = 2 * mu / distance - speed * speed;
    S s = 0;
    if (beta > 0) s = 2 * atan2(distance * sqrt(beta), along) / sqrt(beta);
    if (beta == 0) s = 2 * distance / along;
    if (beta < 0) {  // x = tanh(k s) = sqrt(-beta) / speed; 1 - x without cancellation
      const S rate = sqrt(-beta), x = rate / speed, rest = 2 * mu / distance / (speed * (speed + rate));
      s = log1p(2 * x / rest) / rate;
    }
    age_s = mu * stumpff(beta, s)[3];
  }

  CenterMotion<S> at(S t) const {
    S s{};
    if (!Anomaly<S>(S(0), S(0), mu, beta).solve(outward ? age_s + t : age_s - t, s))
      return {{}, {}, "Kepler's equation was not solved"};
    const auto G = stumpff(beta, s);
    const S rate = G[1] / G[2];
    return {mu * G[2] * direction, (outward ? rate : -rate) * direction};
  }

  S mu{}, beta{};
  Vec<S> direction{};
  bool outward = false;
  S age_s{};  // since the centre was left; inward: until it is reached
};

}  // namespace

bool is_radial(const Real3& a, const Real3& b, const Real3& va, const Real3& vb) {
  using Exact = boost::multiprecision::cpp_rational;
  std::array<Exact, 3> r, v;
  for (int i = 0; i < 3; ++i) {
    r[i] = Exact(b[i]) - Exact(a[i]);
    v[i] = Exact(vb[i]) - Exact(va[i]);
  }
  return r[1] * v[2] == r[2] * v[1] && r[2] * v[0] == r[0] * v[2] && r[0] * v[1] == r[1] * v[0];
}

template <class S> std::string InverseSquare<S>::refusal() const {
  return is_zero(r0) ? "a body starts at the centre of attraction" : "";
}

template <class S> S InverseSquare<S>::collision_s() const {
  if (!radial || !(mu > 0)) return std::numeric_limits<double>::infinity();
  const Radial<S> line(*this);
  if (!line.outward) return line.age_s;
  return line.beta > 0 ? period(mu, line.beta) - line.age_s : S(std::numeric_limits<double>::infinity());
}

template <class S> CenterMotion<S> InverseSquare<S>::at(S t) const {
  if (mu == 0) return {r0 + t * v0, v0};
  if (radial && mu > 0) return Radial<S>(*this).at(t);
  const S distance = norm(r0), eta = dot(r0, v0), beta = 2 * mu / distance - dot(v0, v0);
  if (beta >
      0) {  // an ellipse: s grows by 2 pi / sqrt(beta) in each period 2 pi mu / beta^(3/2), which changes nothing
    const S once = period(mu, beta);
    t -= floor(t / once) * once;
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
