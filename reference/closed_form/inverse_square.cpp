// Kepler's problem in universal variables: Stiefel and Scheifele, Linear and Regular Celestial Mechanics (1971),
// ch. 11. With dt = r ds, beta = 2 mu / r0 - v0^2, eta = r0 . v0 and Stumpff's G_k(beta, s),
//   t = r0 G1 + eta G2 + mu G3        Kepler's equation: t' = r > 0, so it has one root
//   r = r0 G0 + eta G1 + mu G2
//   f = 1 - mu G2 / r0,  g = r0 G1 + eta G2,  f' = -mu G1 / (r r0),  g' = 1 - mu G2 / r
// Nothing here is singular at e = 0 or e = 1, and no perihelion or node is needed.
#include "closed_form/inverse_square.hpp"

#include "closed_form/stumpff.hpp"

namespace atwood::closed_form {

namespace {

template <class S>
S last_step() { return std::ldexp(1.0, -digits<S> * 3 / 5); }

}  // namespace

template <class S>
std::string InverseSquare<S>::misfit() const {
  if (is_zero(r0)) return "starts at the centre";
  if (mu > 0 && is_zero(cross(r0, v0))) return "has no angular momentum and may fall into the centre";
  return "";
}

template <class S>
Flight<S> InverseSquare<S>::at(S t) const {
  const S distance = norm(r0), eta = dot(r0, v0), beta = 2 * mu / distance - dot(v0, v0);
  S low = 0, high = 0;
  if (beta > 0) {  // an ellipse: s grows by 2 pi / sqrt(beta) in each period 2 pi mu / beta^(3/2)
    high = 2 * pi<S>() / root(beta);
    const S period = high * mu / beta;
    t -= floor_of(t / period) * period;
  } else {
    high = t / distance + unit_round_off<S>();
    for (;; high *= 2) {
      const auto G = stumpff(beta, high);
      if (distance * G[1] + eta * G[2] + mu * G[3] >= t) break;
      low = high;
    }
  }
  S s = beta > 0 ? t * beta / mu : (low + high) / 2;
  for (int tries = 0; tries < 400; ++tries) {  // Newton, kept inside a bracket that only shrinks
    const auto G = stumpff(beta, s);
    const S late = distance * G[1] + eta * G[2] + mu * G[3] - t;
    if (late > 0) high = s; else low = s;
    const S step = late / (distance * G[0] + eta * G[1] + mu * G[2]);
    S next = s - step;
    if (!(next >= low && next <= high)) next = low + (high - low) / 2;
    // The error after a step is of the order of its square: a step that changes only the last two fifths of the digits
    // is the last.
    const bool done = magnitude(next - s) <= last_step<S>() * magnitude(s);
    s = next;
    if (done) break;
  }
  const auto G = stumpff(beta, s);
  const S r = distance * G[0] + eta * G[1] + mu * G[2];
  return {(1 - mu * G[2] / distance) * r0 + (distance * G[1] + eta * G[2]) * v0,
          (-mu * G[1] / (r * distance)) * r0 + (1 - mu * G[2] / r) * v0};
}

template struct InverseSquare<Narrow>;
template struct InverseSquare<Wide>;

}  // namespace atwood::closed_form
