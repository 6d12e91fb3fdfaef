#include "cvode/compliant_contacts.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::cvode {

using dynamics::Gap;

namespace {

// 1/r of a sphere; 0 for flat bodies.
double curvature(const Body& body) {
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  return sphere != nullptr ? 1 / sphere->radius_m : 0;
}

}  // namespace

CompliantContacts::CompliantContacts(const Scene& scene, const dynamics::Layout& layout)
    : scene_(scene), layout_(layout) {
  double size = 0;
  for (const dynamics::ContactPair& bodies : dynamics::contact_pairs(scene).pairs) {
    if (!bodies.compliant) continue;
    Pair pair{bodies, &pair_law(scene, bodies.a, bodies.b)};
    const double relative_curvature = curvature(scene.bodies[bodies.a]) + curvature(scene.bodies[bodies.b]);
    pair.hertz_N_per_m32 = 4 * pair.law->modulus_Pa / (3 * std::sqrt(relative_curvature));
    size = std::max(size, 1 / relative_curvature);
    if (bodies.friction != 0)
      failure_ = "CVODE: `" + scene.bodies[bodies.a].name + "` and `" + scene.bodies[bodies.b].name +
                 "` have a compliant contact law and friction: not covered";
    pairs_.push_back(pair);
  }
  gap_tolerance_m_ = 1e-10 * size;
}

double CompliantContacts::force(const Pair& pair, const Gap<double>& gap) const {
  const double d = -gap.gap_m, closing = -gap.rate_m_per_s;
  if (pair.law->contact_law == ContactLaw::linear)
    return pair.law->stiffness_N_per_m * d + pair.law->damping_N_s_per_m * closing;
  return d <= 0 ? 0 : pair.hertz_N_per_m32 * d * std::sqrt(d) * (1 + pair.law->damping_s_per_m * closing);
}

void CompliantContacts::update_modes(const double* y) {
  for (Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, layout_, pair.bodies, y);
    const bool approaching = now.rate_m_per_s < 0;
    if (now.gap_m > gap_tolerance_m_ || (now.gap_m >= -gap_tolerance_m_ && !approaching)) {
      pair.mode = Mode::separated;
    } else if (pair.mode == Mode::separated || pair.law->pull) {
      pair.mode = Mode::loaded;
    } else {
      // At a root of the force: it has fallen to 0 (loaded) or risen from 0 (unloaded).
      const double force_N = force(pair, now),
                   force_tolerance_N = std::fabs(pair.law->stiffness_N_per_m) * gap_tolerance_m_;
      if (pair.mode == Mode::loaded && force_N <= force_tolerance_N && !approaching) pair.mode = Mode::unloaded;
      else if (pair.mode == Mode::unloaded && force_N >= -force_tolerance_N && approaching) pair.mode = Mode::loaded;
    }
  }
}

void CompliantContacts::add_rates(const double* y, double* dydt) const {
  for (const Pair& pair : pairs_) {
    if (pair.mode != Mode::loaded) continue;
    const Gap<double> now = gap(scene_, layout_, pair.bodies, y);
    const double force_N = force(pair, now);
    for (const int body : {pair.bodies.a, pair.bodies.b}) {
      const int at = layout_.slots[body].velocity;
      if (at < 0) continue;
      const double along = (body == pair.bodies.b ? force_N : -force_N) / scene_.bodies[body].mass_kg;
      for (int k = 0; k < 3; ++k) dydt[at + k] += along * now.normal[k];
    }
  }
}

// Roots are found where a function falls through zero. A force that is 0 at the start of the contact is not a root
// because it grows from there.
void CompliantContacts::evaluate(const double* y, double* g) const {
  for (const Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, layout_, pair.bodies, y);
    const bool hertz = pair.law->contact_law == ContactLaw::hertz;
    const double force_N = hertz ? 1 - pair.law->damping_s_per_m * now.rate_m_per_s : force(pair, now);
    *g++ = pair.mode == Mode::separated ? now.gap_m : -now.gap_m;
    *g++ = pair.mode == Mode::separated || pair.law->pull ? 1 : pair.mode == Mode::loaded ? force_N : -force_N;
  }
}

}  // namespace atwood::cvode
