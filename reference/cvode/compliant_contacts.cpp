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

bool CompliantContacts::damped(const Pair& pair) const {
  return pair.law->contact_law == ContactLaw::hertz ? pair.law->damping_s_per_m != 0 : pair.law->damping_N_s_per_m != 0;
}

// What has the sign of the force where the bodies overlap, and is smooth.
double CompliantContacts::sign_of_force(const Pair& pair, const Gap<double>& gap) const {
  return pair.law->contact_law == ContactLaw::hertz ? 1 - pair.law->damping_s_per_m * gap.rate_m_per_s
                                                    : force(pair, gap);
}

double CompliantContacts::force_round_off(const Pair& pair) const {
  return pair.law->contact_law == ContactLaw::hertz ? 1e-13 : pair.law->stiffness_N_per_m * 1e-3 * gap_tolerance_m_;
}

void CompliantContacts::update_modes(const double* y) {
  for (Pair& pair : pairs_) {
    pair.gap = pair.force = {};
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

bool CompliantContacts::presses_on(int body) const {
  return std::any_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
    return pair.mode == Mode::loaded && (pair.bodies.a == body || pair.bodies.b == body);
  });
}

bool CompliantContacts::first_event(const Trajectory& path, const Reaches& reaches, double from_s, double& to_s) {
  bool any = false;
  const auto end_at = [&](double t_s) {
    any = true;
    to_s = std::min(to_s, std::max(t_s, from_s));
  };
  const auto undecided = [&](const Pair& pair, double t_s) {
    failure_ = "CVODE: whether `" + scene_.bodies[pair.bodies.a].name + "` and `" + scene_.bodies[pair.bodies.b].name +
               "` touch at t = " + format_double(t_s) + " s is not decided";
    end_at(t_s);
  };
  std::vector<double> y;
  for (Pair& pair : pairs_) {
    if (pair.mode == Mode::separated && reaches.least_gap(pair.bodies) > 0) {
      pair.gap = {true, false, true, 0};
      continue;
    }
    const bool separated = pair.mode == Mode::separated;
    const Searched touch = first_zero(gap_function(scene_, layout_, pair.bodies, path, 0, separated ? 1 : -1),
                                      path.unit(from_s), path.unit(to_s), 0, pair.gap);
    if (touch.open) undecided(pair, path.time(*touch.open));
    else if (touch.zero) end_at(path.time(*touch.zero));
    // A linear force without a dashpot ends with the overlap, and so does Hertz's.
    if (separated || pair.law->pull || !damped(pair)) continue;
    const double sign = pair.mode == Mode::loaded ? 1 : -1;
    const auto force_N = [&](double t_s) {
      path.state(t_s, y);
      return sign * sign_of_force(pair, gap(scene_, layout_, pair.bodies, y.data()));
    };
    const Sampled spent = first_zero_of_samples(force_N, from_s, to_s, HUGE_VAL, force_round_off(pair), pair.force);
    if (spent.open_s) undecided(pair, *spent.open_s);
    else if (spent.zero_s) end_at(*spent.zero_s);
  }
  return any;
}

}  // namespace atwood::cvode
