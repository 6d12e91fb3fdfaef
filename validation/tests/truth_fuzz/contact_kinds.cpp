// Random scenes of contact: compliant impacts, bodies on a floor, stacks at rest, a struck rod.
#include <algorithm>
#include <cmath>

#include "compliant_check.hpp"
#include "contact_check.hpp"
#include "draw.hpp"

namespace atwood::fuzz {
namespace {

double of_bits(double x, int bits) {
  if (x == 0) return 0;
  const int down = bits - std::ilogb(x);
  return std::ldexp(std::round(std::ldexp(x, down)), -down);
}

// Orthogonal vectors of small whole numbers and of one whole length: with factors of few bits, positions and velocities
// lie along them exactly.
struct Lattice {
  Real3 n, e, about;  // about = n x e / length
  double length;
};
Lattice any_lattice(Random& r) {
  static const std::vector<Lattice> all{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1},
                                        {{3, 0, 4}, {4, 0, -3}, {0, 5, 0}, 5},
                                        {{1, 2, 2}, {2, 1, -2}, {-2, 2, -1}, 3},
                                        {{2, 3, 6}, {3, -6, 2}, {6, 2, -3}, 7}};
  return all[static_cast<std::size_t>(r.whole(0, static_cast<int>(all.size()) - 1))];
}

// ---- compliant contact --------------------------------------------------------------------------------------------

// Border: near critical damping, hardly any damping, slow or fast, a small gap, an end within the contact.
Scenario penalty(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "penalty", 1);
  const Lattice l = any_lattice(r);
  const bool against_plane = r.whole(0, 1) == 1;
  const double ra = r.uniform(0.1, 0.5), rb = against_plane ? 0 : r.uniform(0.1, 0.5);
  double speed = r.uniform(0.2, 3), gap = r.uniform(0.05, 1);
  if (border && r.whole(0, 2) == 0) speed = r.power(-6, 3);
  if (border && r.whole(0, 2) == 0) gap = r.power(-12, -1);
  Body a = ball("a", r.power(-1, 1), ra, scaled(few_bits(r.uniform(-1, 1)), l.n), {});
  double mass = a.mass_kg;
  if (against_plane) {
    const double away = a.position_m[0] * l.n[0] + a.position_m[1] * l.n[1] + a.position_m[2] * l.n[2];
    a.velocity_m_per_s = sum(scaled(-speed / l.length, l.n), r.whole(0, 1) ? r.vector(0) : r.vector(0.1 * speed));
    if (r.whole(0, 1)) a.angular_velocity_body_rad_per_s = r.vector(5);
    s.scene.bodies = {a, plane(l.n, away - l.length * (ra + gap))};
  } else {
    const double drift = few_bits(r.uniform(-1, 1)), closing = few_bits(-speed / l.length);
    const double apart = few_bits((ra + rb + gap) / l.length);
    gap = apart * l.length - ra - rb;
    Body b = ball("b", r.power(-1, 1), rb, sum(a.position_m, scaled(apart, l.n)), scaled(drift + closing, l.n));
    a.velocity_m_per_s = scaled(drift, l.n);
    if (r.whole(0, 1)) b.angular_velocity_body_rad_per_s = r.vector(5);
    mass = a.mass_kg * b.mass_kg / (a.mass_kg + b.mass_kg);
    s.scene.bodies = {a, b};
  }
  PairLaw& law = s.scene.pairs[0];
  double lasts = 0;
  if (r.whole(0, 1)) {
    law.contact_law = ContactLaw::linear;
    law.stiffness_N_per_m = r.power(1, 5);
    const double critical = 2 * std::sqrt(law.stiffness_N_per_m * mass);
    law.damping_N_s_per_m = r.whole(0, 3) ? critical * r.uniform(0, 0.99) : 0;
    if (border && r.whole(0, 1)) law.damping_N_s_per_m = critical * (1 - r.power(-15, -1));
    if (border && r.whole(0, 2) == 0) law.damping_N_s_per_m = critical * r.power(-18, -2);
    law.pull = r.whole(0, 1) == 1;
    lasts = 3 / std::sqrt(law.stiffness_N_per_m / mass);
  } else {
    law.contact_law = ContactLaw::hertz;
    law.modulus_Pa = r.power(2, 7);
    const double K = 4.0 / 3 * law.modulus_Pa * std::sqrt(against_plane ? ra : ra * rb / (ra + rb));
    lasts = 2.94 * std::pow(1.25 * mass * speed * speed / K, 0.4) / speed;
  }
  s.t_end_s = std::fabs(gap) / speed + lasts * r.uniform(border ? 0.2 : 0.8, 4);
  return s;
}

// ---- on a floor ---------------------------------------------------------------------------------------------------

// Border: at the limit of rolling or of holding, slip that has just ended or is hardly there, an end at its end, hardly
// any friction.
Scenario slide_or_roll(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "slide-or-roll", r.uniform(0.3, 3));
  Lattice l = any_lattice(r);
  const int shape = r.whole(0, 2);  // ball, cylinder, box
  if (shape == 1)
    l = r.whole(0, 1) ? Lattice{{3, 4, 0}, {4, -3, 0}, {0, 0, -5}, 5} : Lattice{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 1};
  if (shape == 2)
    l = r.whole(0, 1) ? Lattice{{0, 0, 5}, {3, 4, 0}, {-4, 3, 0}, 5} : Lattice{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1};
  const double rho = std::ldexp(1, -r.whole(3, 6)), offset = few_bits(r.uniform(-1, 1)), radius = l.length * rho;
  const double down = few_bits(r.uniform(1, 15) / l.length);
  const double slope = r.whole(0, 1) ? few_bits(r.uniform(-0.5, 0.5) * down) : 0;
  s.scene.gravity_m_per_s2 = sum(scaled(-down, l.n), scaled(slope, l.e));
  const Real3 p = scaled(offset + rho, l.n);
  Body body = ball("body", r.power(-1, 1), radius, p, {});
  const double share = r.uniform(0.2, 1), I = share * body.mass_kg * radius * radius;
  body.inertia_kg_m2 = {I, 0, 0, 0, I, 0, 0, 0, I};
  if (shape == 1) body.shape = Cylinder{radius, r.uniform(0.02, 0.3)};
  if (shape == 2) body.shape = Box{{radius * r.uniform(0.5, 4), radius * r.uniform(0.5, 4), radius}};
  const double kappa = shape == 2 ? 1 : 1 + 1 / share;
  const double v = r.whole(0, 3) ? l.length * few_bits(r.uniform(-2, 2) / l.length) : 0;
  double w = shape == 2 ? 0 : v / rho / l.length;  // rolls
  const bool rolls = r.whole(0, 3) == 0;
  if (shape != 2 && !rolls) w = few_bits(r.uniform(-3, 3) / rho / l.length);
  double mu = r.uniform(0.02, 1);
  if (border) {
    switch (r.whole(0, 5)) {
      case 5: w = shape == 2 ? 0 : of_bits(v / rho / l.length * (1 + r.sign() * r.power(-13.5, -1)), 48); break;
      case 0: mu = std::fabs(slope) / down / kappa * (1 + r.sign() * r.power(-17, -1)); break;
      case 1: w = shape == 2 ? 0 : v / rho / l.length * (1 + r.sign() * r.power(-16, -1)); break;
      case 2: mu = r.power(-17, -1); break;
      case 3:
        s.t_end_s = std::fabs(v - rho * l.length * w) * l.length / std::fmax(0.01, kappa * mu * down * l.length) *
                        (1 + r.sign() * r.power(-15, -1)) +
                    1e-3;
        break;
      default: mu = r.power(0, 3);
    }
  }
  body.velocity_m_per_s = scaled(v, l.e);
  body.angular_velocity_body_rad_per_s = scaled(w, l.about);
  s.scene.pairs[0].friction = mu;
  s.scene.bodies = {plane(l.n, l.length * l.length * offset), body};
  return s;
}

// ---- at rest ------------------------------------------------------------------------------------------------------

// Border: friction close to the slope, a centre of mass close to an edge, slopes down to round-off.
Scenario rest(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "rest", 1);
  const int boxes = r.whole(1, 4), what = border ? r.whole(0, 2) : -1;
  const double down = r.uniform(5, 12), slope = what == 2                    ? r.power(-17, -5)
                                                : what == 0 || r.whole(0, 1) ? r.power(-3, -0.5)
                                                                             : 0;
  const double way = r.uniform(-kPi, kPi);
  const Real3 g{slope * down * std::cos(way), slope * down * std::sin(way), -down};
  s.scene.gravity_m_per_s2 = g;
  s.scene.pairs[0].friction =
      std::hypot(g[0], g[1]) / down * (what == 0 || what == 2 ? 1 + r.sign() * r.power(-14, -1) : r.uniform(1.1, 3));
  if (what == 2 && r.whole(0, 4) == 0) s.scene.pairs[0].friction = 0;
  s.scene.bodies = {plane({0, 0, 1}, 0)};
  double top = 0;
  Real3 at{few_bits(r.uniform(-1, 1)), few_bits(r.uniform(-1, 1)), 0}, below{};
  for (int k = 0; k < boxes; ++k) {
    const Real3 half{few_bits(r.uniform(0.1, 0.5)), few_bits(r.uniform(0.1, 0.5)), few_bits(r.uniform(0.03, 0.2))};
    if (k > 0)
      for (std::size_t c = 0; c < 2; ++c) {
        double shift = r.uniform(-0.2, 0.2) * below[c];
        // The box on top: its weight passes the edge of the one below.
        if (what == 1 && k == boxes - 1 && c == 0)
          shift = below[c] * (1 - r.sign() * r.power(-7, -1)) - half[2] * g[0] / down;
        at[c] = few_bits(at[c] + shift);
      }
    Body body = solid("box" + std::to_string(k), r.power(-1, 1), {1, 1, 1}, {0, 0, 0});
    for (std::size_t c = 0; c < 3; ++c)
      body.inertia_kg_m2[4 * c] = body.mass_kg / 3 * (inner(half, half) - half[c] * half[c]);
    body.shape = Box{half};
    at[2] = top + half[2];
    body.position_m = at;
    top += 2 * half[2];
    below = half;
    s.scene.bodies.push_back(body);
  }
  return s;
}

// ---- a struck rod -------------------------------------------------------------------------------------------------

// Border: near the end of the rod's straight part, near its middle, a graze, friction at the limit of what holds the
// slip, hardly any.
Scenario struck_rod(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "struck-rod", r.uniform(0.3, 2));
  s.scene.pairs[0].restitution = r.whole(0, 3) ? r.uniform(0, 1) : 1;
  const bool rough = r.whole(0, 1) == 1;
  const double own = r.uniform(0.02, 0.2), half = r.uniform(0.2, 1), radius = r.uniform(0.05, 0.3), R = own + radius;
  Body rod = solid("rod", r.power(-1, 1), {1, 1, 1}, {0, 0, 0});
  const double across = rod.mass_kg * half * half * r.uniform(0.2, 0.6);
  rod.inertia_kg_m2 = {across, 0, 0, 0, across, 0, 0, 0, rod.mass_kg * own * own / 2};
  rod.shape = Capsule{own, half};
  double along = r.uniform(-1, 1) * (half + 0.7 * R), aside = r.uniform(-0.6, 0.6) * R;
  const double away = R + r.uniform(0.05, 0.5), speed = r.uniform(0.5, 4);
  double slides = r.uniform(-1, 1) * speed;
  const int what = border ? r.whole(0, 4) : -1;
  if (what == 0) along = half * (1 + r.sign() * r.power(-15, -1)), slides = 0;
  if (what == 1) along = r.sign() * r.power(-17, -1), slides *= r.whole(0, 1);
  if (what == 2) aside = R * (1 - r.power(-12, -1));
  if (rough || what == 0) aside = 0;
  double mu = rough ? r.uniform(0.05, 1) : 0;
  if (rough && what == 3) mu = r.power(-17, -1);
  if (rough && what == 4) {  // K_tn / K_tt of a slip along the rod
    const double arm = along, tn = own * arm / across;
    const double tt = 1 / rod.mass_kg + own * own / across;
    mu = std::fabs(tn / tt) * (1 + r.sign() * r.power(-16, -1));
    slides = 0;
  }
  const double time = (away - R) / speed;
  Body other = ball("ball", r.power(-1, 1), radius, {away, aside, along - slides * time}, {-speed, 0, slides});
  const Real3 drift = rough ? Real3{} : r.vector(0.5);
  rod.velocity_m_per_s = drift;
  other.velocity_m_per_s = sum(other.velocity_m_per_s, drift);
  s.scene.pairs[0].friction = mu;
  s.scene.bodies = {rod, other};
  return s;
}

}  // namespace

std::vector<Kind> contact_kinds() {
  return {{"closed-form", "penalty", penalty, check_penalty, 0.04},
          {"closed-form", "slide-or-roll", slide_or_roll, check_slide_or_roll, 0.04},
          {"closed-form", "rest", rest, check_rest, 0.28},
          {"closed-form", "struck-rod", struck_rod, check_struck_rod, 0.25}};
}

}  // namespace atwood::fuzz
