#include "cvode/giving_contacts.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::cvode {

using dynamics::Gap;

namespace {

// 1/r of a ball; flat bodies have none.
double curvature(const Body& body) {
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  return sphere != nullptr ? 1 / sphere->radius_m : 0;
}

}  // namespace

GivingContacts::GivingContacts(const Scene& scene, const dynamics::Layout& layout) : scene_(scene), layout_(layout) {
  double size = 0;
  for (const dynamics::ContactPair& bodies : dynamics::contact_pairs(scene).pairs) {
    if (!bodies.gives) continue;
    Pair pair{bodies, &pair_law(scene, bodies.a, bodies.b)};
    const double curved = curvature(scene.bodies[bodies.a]) + curvature(scene.bodies[bodies.b]);
    pair.hertz_N_per_m32 = 4 * pair.law->modulus_Pa / (3 * std::sqrt(curved));
    size = std::max(size, 1 / curved);
    if (bodies.friction != 0)
      failure_ = "CVODE: `" + scene.bodies[bodies.a].name + "` and `" + scene.bodies[bodies.b].name +
                 "` give way and have friction: not covered";
    pairs_.push_back(pair);
  }
  tiny_m_ = 1e-10 * size;
}

double GivingContacts::force(const Pair& pair, const Gap<double>& gap) const {
  const double d = -gap.gap_m, closing = -gap.rate_m_per_s;
  if (pair.law->contact_law == ContactLaw::linear)
    return pair.law->stiffness_N_per_m * d + pair.law->damping_N_s_per_m * closing;
  return d <= 0 ? 0 : pair.hertz_N_per_m32 * d * std::sqrt(d) * (1 + pair.law->damping_s_per_m * closing);
}

void GivingContacts::settle(const double* y) {
  for (Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, layout_, pair.bodies, y);
    const bool closes = now.rate_m_per_s < 0;
    if (now.gap_m > tiny_m_ || (now.gap_m >= -tiny_m_ && !closes)) {
      pair.mode = Mode::apart;
    } else if (pair.mode == Mode::apart || pair.law->pull) {
      pair.mode = Mode::pressed;
    } else {
      // At a root of the force: it has fallen to 0 from pressed, or risen from spent.
      const double push = force(pair, now), about = std::fabs(pair.law->stiffness_N_per_m) * tiny_m_;
      if (pair.mode == Mode::pressed && push <= about && !closes) pair.mode = Mode::spent;
      else if (pair.mode == Mode::spent && push >= -about && closes) pair.mode = Mode::pressed;
    }
  }
}

void GivingContacts::add_rates(const double* y, double* dydt) const {
  for (const Pair& pair : pairs_) {
    if (pair.mode != Mode::pressed) continue;
    const Gap<double> now = gap(scene_, layout_, pair.bodies, y);
    const double push = force(pair, now);
    for (const int body : {pair.bodies.a, pair.bodies.b}) {
      const int at = layout_.slots[body].velocity;
      if (at < 0) continue;
      const double along = (body == pair.bodies.b ? push : -push) / scene_.bodies[body].mass_kg;
      for (int k = 0; k < 3; ++k) dydt[at + k] += along * now.normal[k];
    }
  }
}

// Found where they fall through zero. A force that is 0 where the contact begins is no root: it grows from there.
void GivingContacts::evaluate(const double* y, double* g) const {
  for (const Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, layout_, pair.bodies, y);
    const bool hertz = pair.law->contact_law == ContactLaw::hertz;
    const double push = hertz ? 1 - pair.law->damping_s_per_m * now.rate_m_per_s : force(pair, now);
    *g++ = pair.mode == Mode::apart ? now.gap_m : -now.gap_m;
    *g++ = pair.mode == Mode::apart || pair.law->pull ? 1 : pair.mode == Mode::pressed ? push : -push;
  }
}

}  // namespace atwood::cvode
