#include "kinds.hpp"

#include <algorithm>
#include <cmath>

#include "draw.hpp"
#include "flights_check.hpp"
#include "smooth_check.hpp"

namespace atwood::fuzz {
namespace {

// ---- points in force fields ---------------------------------------------------------------------------------------

Scenario ballistic(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "ballistic", r.power(-2, 3));
  s.scene.gravity_m_per_s2 = scaled(r.power(-6, 3), r.direction());
  const int bodies = r.whole(1, 3);
  for (int i = 0; i < bodies; ++i) {
    s.scene.bodies.push_back(point("p" + std::to_string(i), r.power(-6, 6), scaled(r.power(-9, 9), r.direction()),
                                   scaled(r.power(-9, 4), r.direction())));
    if (border) s.scene.bodies.back().release_s = s.t_end_s * r.uniform(0, 1.2);
  }
  return s;
}

Scenario linear_drag(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "linear-drag", r.uniform(0.1, 20));
  s.scene.gravity_m_per_s2 = scaled(r.uniform(0, 20), r.direction());
  s.scene.bodies = {point("ball", r.power(-2, 2), r.vector(10), r.vector(30))};
  const double rate = border ? r.power(-18, -3) : r.uniform(0.01, 5);  // c t / m near 0
  s.scene.forces = {LinearDrag{{0}, rate * s.scene.bodies[0].mass_kg, r.vector(5), 0}};
  if (r.whole(0, 3) == 0) s.scene.bodies[0].release_s = r.uniform(0, s.t_end_s);
  return s;
}

Scenario quadratic_drag(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "vertical-quadratic-drag", r.uniform(0.1, 6));
  const double g = r.uniform(1, 20), kappa = r.power(-4, 0.5), terminal = std::sqrt(g / kappa);
  s.scene.gravity_m_per_s2 = {0, 0, -g};
  double up = r.uniform(-3, 3) * terminal;
  if (border) up = r.whole(0, 1) == 0 ? -terminal * (1 + r.sign() * r.power(-17, -1)) : r.sign() * r.power(-17, -1);
  s.scene.bodies = {point("ball", 1, r.vector(10), {0, 0, up})};
  s.scene.forces = {QuadraticDrag{{0}, 2 * kappa, 1, 1, {0, 0, border ? 0 : r.uniform(-5, 5)}, 0}};
  return s;
}

Scenario oscillator(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "oscillator", r.uniform(0.5, 20));
  s.scene.gravity_m_per_s2 = r.vector(10);
  const double mass = r.uniform(0.2, 5), k = r.uniform(0.5, 20);
  s.scene.bodies = {point("bob", mass, r.vector(2), r.vector(5))};
  Spring spring{{0}, r.vector(1), k, 0, 0, {}};
  const int what = r.whole(0, 3);
  if (what >= 1) {  // border: near critical damping
    const double critical = 2 * std::sqrt(k * mass);
    spring.damping_N_s_per_m = border ? critical * (1 + r.sign() * r.power(-17, -1)) : critical * r.uniform(0.01, 2);
    // Damping acts along the line through the anchor, so the motion stays on it.
    s.scene.gravity_m_per_s2 = scaled(r.uniform(-10, 10), {1, 0, 0});
    s.scene.bodies[0].position_m = {r.uniform(0.5, 2), 0, 0};
    s.scene.bodies[0].velocity_m_per_s = {r.uniform(-5, 5), 0, 0};
    spring.anchor_m = {r.uniform(-1, 0.25), 0, 0};
  }
  s.scene.forces = {spring};
  if (what == 3 || what == 0) {
    double w = r.uniform(0.1, 6);
    if (border && what == 0) w = std::sqrt(k / mass) * (1 + r.sign() * r.power(-17, -1));  // resonance
    s.scene.forces.push_back(
        Drive{{0}, what == 3 ? Real3{r.uniform(-5, 5), 0, 0} : r.vector(5), w, r.uniform(-kPi, kPi)});
  }
  return s;
}

// An orbit from its perihelion, with `speed` relative to the escape speed, in a random plane.
Scenario kepler(Random& r, bool border) {
  const double mu = r.power(-2, 2), distance = r.power(-1, 1), escape = std::sqrt(2 * mu / distance);
  const double period = 2 * kPi * std::sqrt(distance * distance * distance / mu);
  Scenario s = empty(TruthKind::closed_form, "kepler", period * r.uniform(0.05, 1.5));
  const Real3 n = r.direction(), side = across(n, r);
  double along = r.uniform(-1.2, 1.2), outward = r.uniform(-0.6, 0.6);
  if (border) {
    switch (r.whole(0, 3)) {
      case 0:
        along = 1 + r.sign() * r.power(-17, -2);
        outward = 0;
        break;  // near the parabola
      case 1:
        along = std::sqrt(0.5) * (1 + r.sign() * r.power(-17, -2));
        outward = r.sign() * r.power(-17, -2);
        break;  // circle
      case 2:
        along = r.power(-4, -1);
        outward = r.uniform(0.2, 1.5);
        break;  // nearly radial, outwards
      default: along = r.uniform(1.5, 20); break;
    }
  }
  const Real3 v = sum(scaled(along * escape, side), scaled(outward * escape, n));
  s.scene.bodies = {point("planet", r.power(-3, 3), scaled(distance, n), v)};
  s.scene.forces = {Attractor{{0}, border ? Real3{} : scaled(0.3 * distance, r.direction()), mu}};
  return s;
}

// Straight from the centre or, at the border, from rest, to it, or near the escape speed; before the centre is reached.
Scenario radial_orbit(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "kepler", 1);
  const Real3 from = scaled(r.power(-1, 1), r.direction());
  const double distance = std::sqrt(inner(from, from)), per_s = std::ldexp(1, r.whole(-4, 4));  // exactly parallel
  double ratio = r.uniform(0.6, 3), share = r.uniform(0.2, 3);  // of the escape speed, of the distance at this speed
  int outward = 1;
  if (border) switch (r.whole(0, 2)) {
      case 0: outward = 0; break;
      case 1: outward = -1; break;
      default: ratio = 1 + r.sign() * r.power(-16, -2);
    }
  const double speed = per_s * distance, mu = speed * speed * distance / (2 * ratio * ratio);
  // A fall takes pi / 2 of this time from rest, and 2 / 3 with the escape speed.
  const double escape_s = distance / speed * ratio;
  if (outward == 0) share = r.uniform(0.1, 0.95) * kPi / 2;
  if (outward < 0) share = r.uniform(0.1, 0.9) / (1.5 + ratio);
  if (outward > 0 && ratio < 1) share = std::min(share, 1.5);
  s.t_end_s = share * escape_s;
  s.scene.bodies = {point("planet", r.power(-3, 3), from, scaled(outward * per_s, from))};
  s.scene.forces = {Attractor{{0}, {}, mu}};
  return s;
}

Scenario coulomb(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "coulomb-two-body", r.uniform(0.1, 5));
  const double distance = r.uniform(0.5, 3);
  const Real3 n = r.direction();
  s.scene.bodies = {point("a", r.power(-1, 1), r.vector(1), r.vector(1)), point("b", r.power(-1, 1), {}, r.vector(1))};
  s.scene.bodies[1].position_m = sum(s.scene.bodies[0].position_m, scaled(distance, n));
  s.scene.bodies[0].charge_C = r.sign() * r.uniform(0.1, 2);
  s.scene.bodies[1].charge_C = r.sign() * r.uniform(0.1, 2);
  if (border) {
    const int what = r.whole(0, 2);
    if (what == 0) s.scene.bodies[1].charge_C = r.sign() * r.power(-18, -3);
    if (what == 1)  // like charges (nearly) at rest relative to each other
      s.scene.bodies[1].velocity_m_per_s =
          sum(s.scene.bodies[0].velocity_m_per_s, scaled(r.power(-18, -3), r.direction()));
    if (what <= 1) s.scene.bodies[1].charge_C = std::copysign(s.scene.bodies[1].charge_C, s.scene.bodies[0].charge_C);
  }
  s.scene.forces = {Coulomb{{0, 1}, 1}};
  return s;
}

Scenario lorentz(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "lorentz", r.uniform(0.5, 20));
  s.scene.bodies = {point("charge", r.uniform(0.2, 5), r.vector(2), r.vector(3))};
  s.scene.bodies[0].charge_C = r.sign() * r.uniform(0.2, 2);
  if (r.whole(0, 1)) s.scene.gravity_m_per_s2 = r.vector(10);
  const Real3 b = border ? scaled(r.power(-20, -1), r.direction()) : r.vector(3);
  s.scene.forces = {Lorentz{{0}, r.whole(0, 2) ? r.vector(3) : Real3{}, b}};
  return s;
}

// ---- rotation -------------------------------------------------------------------------------------------------------

Scenario free_top(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "free-rigid-body", r.uniform(0.5, 12));
  Real3 I{r.uniform(0.5, 1), r.uniform(0.5, 1), r.uniform(0.5, 1)}, w = r.vector(1);
  if (border) {
    std::sort(I.begin(), I.end());
    switch (r.whole(0, 2)) {
      case 0: I[1] = I[0] * (1 + r.power(-16, -1)); break;  // nearly symmetric
      case 1: w[2] = w[0] * std::sqrt(I[0] * (I[1] - I[0]) / (I[2] * (I[2] - I[1]))) * (1 + r.power(-17, -1)); break;
      default: w[0] = r.sign() * r.power(-20, -1); w[2] = r.sign() * r.power(-20, -1);  // the middle axis
    }
  }
  s.scene.bodies = {turning(point("top", 1, {}, {}), I, w)};
  return s;
}

Scenario axis_torque(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "axis-torque", r.uniform(0.5, 6));
  const int axis = r.whole(0, 2);
  Real3 w{}, point_body{}, direction{};
  w[axis] = border ? r.sign() * r.power(-18, -1) : r.uniform(-3, 3);
  point_body[(axis + 1) % 3] = border ? r.power(-17, -1) : r.uniform(0.1, 1);
  direction[(axis + 2) % 3] = 1;
  s.scene.gravity_m_per_s2 = r.whole(0, 1) ? r.vector(5) : Real3{};
  s.scene.bodies = {turning(point("ship", r.uniform(0.5, 5), r.vector(1), r.vector(2)),
                            {r.uniform(0.5, 1), r.uniform(0.5, 1), r.uniform(0.5, 1)}, w)};
  const double from = s.t_end_s * r.uniform(0, 0.5);
  s.scene.forces = {
      Thruster{0, point_body, direction, r.uniform(0.1, 3), {{from, from + s.t_end_s * r.uniform(0.1, 0.7)}}}};
  return s;
}

// ---- impacts --------------------------------------------------------------------------------------------------------

Scenario bounce(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "bounce", 1);
  const Real3 n = r.direction();
  const double g = r.uniform(1, 20), radius = r.uniform(0.05, 0.5),
               height = border ? r.power(-15, -2) : r.uniform(0.1, 3);
  const double e = border && r.whole(0, 1) ? 1 - r.power(-17, -1) : r.uniform(0.3, 1);
  s.scene.pairs[0].restitution = e;
  s.scene.gravity_m_per_s2 = scaled(-g, n);
  if (r.whole(0, 1)) s.scene.gravity_m_per_s2 = sum(s.scene.gravity_m_per_s2, scaled(0.2 * g, across(n, r)));
  const double offset = r.uniform(-1, 1);
  s.scene.bodies = {plane(n, offset), ball("ball", r.power(-1, 1), radius, scaled(offset + radius + height, n),
                                           border ? Real3{} : r.vector(2))};
  // The run ends before the bounce series does: t_1 + 2 t_1 (e + ... + e^k) for a fall from rest.
  s.t_end_s = std::sqrt(2 * height / g) * (1 + 2 * e * std::min(30.0, e < 1 ? (1 - std::pow(e, 30)) / (1 - e) : 30.0)) *
              r.uniform(0.2, 0.9);
  return s;
}

Scenario sphere_impact(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "sphere-impact", r.uniform(0.5, 3));
  s.scene.pairs[0].restitution = r.whole(0, 3) ? r.uniform(0, 1) : 1;
  const bool rough = r.whole(0, 1) == 1;
  if (rough) s.scene.pairs[0].friction = border ? r.power(-17, 1) : r.uniform(0.05, 1);
  if (r.whole(0, 1)) s.scene.gravity_m_per_s2 = r.vector(10);
  const double ra = r.uniform(0.1, 0.5), rb = r.uniform(0.1, 0.5), R = ra + rb, speed = r.uniform(1, 4);
  const Real3 n = r.direction(), side = across(n, r);
  double aside = r.uniform(0, 0.95) * R;
  if (border) aside = r.whole(0, 1) ? R * (1 - r.power(-16, -1)) : R * r.power(-17, -1);  // a graze, or head on
  const double away = R + (border ? r.power(-12, 0) : r.uniform(0.1, 1));
  Body a = ball("a", r.power(-1, 1), ra, {}, {}),
       b = ball("b", r.power(-1, 1), rb, sum(scaled(away, n), scaled(aside, side)), scaled(-speed, n));
  const Real3 drift = r.vector(2);
  a.velocity_m_per_s = drift;
  b.velocity_m_per_s = sum(b.velocity_m_per_s, drift);
  if (rough) {
    a.angular_velocity_body_rad_per_s = r.vector(10);
    b.angular_velocity_body_rad_per_s = r.vector(10);
  }
  s.scene.bodies = {a, b};
  return s;
}

// Balls, smooth, without gravity among fixed balls: a ball among four scatterers, or two free balls and a wall.
Scenario billiard(TruthKind truth, const char* solution, Random& r, bool border) {
  Scenario s = empty(truth, solution, border ? r.uniform(4, 10) : r.uniform(0.5, 4));
  s.scene.pairs[0].restitution = r.whole(0, 2) ? 1 : r.uniform(0.5, 1);
  if (r.whole(0, 2) == 0) {
    s.scene.bodies = {plane({1, 0, 0}, 0), ball("near", 1, 0.1, {r.uniform(0.3, 0.6), 0, 0}, {}),
                      ball("far", border ? std::pow(100.0, r.whole(0, 2)) : r.uniform(0.2, 30), 0.1,
                           {r.uniform(0.9, 1.5), border ? 0 : r.uniform(-0.1, 0.1), 0}, {-r.uniform(0.5, 2), 0, 0})};
    return s;
  }
  const double side = 1.2;
  for (int i = 0; i < 4; ++i) {
    s.scene.bodies.push_back(peg("peg" + std::to_string(i), r.uniform(0.3, 0.55),
                                 {side * (i % 2 ? 0.5 : -0.5), side * (i / 2 ? 0.5 : -0.5), 0}));
  }
  const double angle = border ? kPi / 4 * r.whole(0, 7) + r.sign() * r.power(-12, -2) : r.uniform(-kPi, kPi);
  s.scene.bodies.push_back(ball("ball", 1, 0.01, {r.uniform(-0.03, 0.03), r.uniform(-0.03, 0.03), 0},
                                scaled(r.uniform(1, 3), {std::cos(angle), std::sin(angle), 0})));
  return s;
}

// Up to three balls, smooth or rough, fall and collide with each other and with walls.
Scenario table(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "ball-flights", r.uniform(0.5, 2));
  s.scene.pairs[0].restitution = r.whole(0, 2) ? r.uniform(0.6, 1) : 1;
  const bool rough = r.whole(0, 1) == 1;
  if (rough) s.scene.pairs[0].friction = border ? r.power(-17, 1) : r.uniform(0.05, 1);
  s.scene.gravity_m_per_s2 = r.whole(0, 2) ? Real3{0, 0, -r.uniform(1, 10)} : Real3{};
  s.scene.bodies = {plane({0, 0, 1}, 0)};
  if (r.whole(0, 1)) s.scene.bodies.push_back(plane({1, 0, 0}, -1));
  if (r.whole(0, 1)) s.scene.bodies.push_back(plane({-std::sin(0.3), 0, std::cos(0.3)}, -2));
  const int balls = r.whole(1, 3);
  for (int i = 0; i < balls; ++i) {
    const double radius = r.uniform(0.05, 0.15);
    s.scene.bodies.push_back(ball("ball" + std::to_string(i), r.power(-1, 1), radius,
                                  {0.45 * i - 0.5, border ? r.power(-16, -1) : r.uniform(-0.1, 0.1), r.uniform(0.3, 1)},
                                  {r.uniform(-2, 2), border ? 0 : r.uniform(-0.3, 0.3), r.uniform(-1, 1)}));
    if (rough) s.scene.bodies.back().angular_velocity_body_rad_per_s = r.vector(10);
  }
  return s;
}

// A ball falls on fixed balls or on a tilted plane, smooth, under gravity.
Scenario drop(TruthKind truth, const char* solution, Random& r, bool border) {
  Scenario s = empty(truth, solution, r.uniform(0.5, 1.5));
  s.scene.pairs[0].restitution = r.whole(0, 2) ? r.uniform(0.6, 1) : 1;
  s.scene.gravity_m_per_s2 = {0, 0, -r.uniform(2, 12)};
  const double height = r.uniform(0.5, 1.5), aside = border ? r.power(-15, -1) : r.uniform(0, 0.2);
  Body below = plane({0, 0, 1}, 0);
  if (r.whole(0, 1)) {
    below = peg("peg", 0.3, {0, 0, -0.3});
  } else {
    const double tilt = r.uniform(0, 0.4);
    below.shape = Plane{{std::sin(tilt), 0, std::cos(tilt)}, 0};
  }
  s.scene.bodies = {below, ball("ball", 1, 0.1, {aside, 0, 0.1 + height}, {})};
  return s;
}

// ---- scenes without a closed form -----------------------------------------------------------------------------------

Scenario orbits(TruthKind truth, Random& r, bool border) {
  Scenario s = empty(truth, "", r.uniform(0.5, 4));
  s.truth.solution.clear();
  const int bodies = r.whole(2, 4);
  std::vector<int> all;
  for (int i = 0; i < bodies; ++i) {
    const double angle = 2 * kPi * i / bodies + r.uniform(-0.3, 0.3), distance = r.uniform(0.7, 1.6);
    s.scene.bodies.push_back(point("star" + std::to_string(i), border ? r.power(-6, 0) : r.uniform(0.1, 1),
                                   {distance * std::cos(angle), distance * std::sin(angle), r.uniform(-0.3, 0.3)},
                                   scaled(border ? 0.3 : 0.8, r.vector(1))));
    all.push_back(i);
  }
  s.scene.forces = {MutualGravity{all, r.uniform(0.3, 1.5), r.whole(0, 2) ? 0 : r.power(-3, -1)}};
  if (r.whole(0, 1)) s.scene.forces.push_back(Attractor{all, {0, 0, 2.5}, r.uniform(0.1, 1)});
  return s;
}

Scenario pushed_bodies(TruthKind truth, Random& r, bool border) {
  Scenario s = empty(truth, "", r.uniform(0.5, 4));
  s.truth.solution.clear();
  s.scene.gravity_m_per_s2 = r.vector(5);
  const auto top = [&](const char* name) {
    return turning(point(name, r.uniform(0.5, 3), r.vector(1), r.vector(2)),
                   {r.uniform(0.5, 1), r.uniform(0.5, 1), r.uniform(0.5, 1)}, r.vector(border ? 6 : 2));
  };
  s.scene.bodies = {top("one"), top("two")};
  Spring spring{{0, 1}, {}, r.uniform(1, 20), r.uniform(0, 1), 0, {r.vector(0.5), r.vector(0.5)}};
  if (!border) spring.damping_N_s_per_m = 0;
  s.scene.bodies[1].position_m = sum(s.scene.bodies[1].position_m, {6, 0, 0});  // far from a spring of no length
  s.scene.forces = {spring};
  if (r.whole(0, 1)) s.scene.forces.push_back(LinearDrag{{0, 1}, r.uniform(0, 1), r.vector(3), r.uniform(0, 0.5)});
  if (r.whole(0, 1)) {
    s.scene.bodies[0].charge_C = r.uniform(-1, 1);
    s.scene.forces.push_back(Lorentz{{0}, r.vector(2), r.vector(2)});
  }
  if (r.whole(0, 1)) s.scene.forces.push_back(Drive{{1}, r.vector(3), r.uniform(0.1, 4), r.uniform(-kPi, kPi)});
  if (border) {
    const double from = s.t_end_s * r.uniform(0, 0.6), to = from + s.t_end_s * r.power(-6, -0.3);
    s.scene.forces.push_back(Thruster{0, r.vector(0.5), r.direction(), r.uniform(0.1, 5), {{from, to}}});
    s.scene.forces.push_back(PointForce{1, r.vector(0.5), r.vector(3), {{from, to}}});
    if (r.whole(0, 1)) s.scene.bodies[1].release_s = s.t_end_s * r.uniform(0, 0.5);
  }
  return s;
}

std::vector<Kind> all_kinds() {
  const auto digits = [](int asked) {
    return [asked](const Scenario& s, std::int64_t samples) { return check_smooth(s, samples, asked); };
  };
  const auto flights = [](const Scenario& s, std::int64_t samples) { return check_flights(s, samples); };
  const auto closed = [&](const char* name, auto scene) { return Kind{"closed-form", name, scene, digits(42)}; };
  std::vector<Kind> all{closed("ballistic", ballistic),
                        closed("linear-drag", linear_drag),
                        closed("vertical-quadratic-drag", quadratic_drag),
                        closed("oscillator", oscillator),
                        closed("kepler", kepler),
                        closed("coulomb-two-body", coulomb),
                        closed("lorentz", lorentz),
                        closed("free-rigid-body", free_top),
                        closed("axis-torque", axis_torque)};
  for (Kind& kind : all)
    if (kind.name == "oscillator") kind.most_refused = 0.12;       // beside a resonance: of 77 scenes 8 %
  all.push_back({"closed-form", "bounce", bounce, flights, 0.1});  // of 4348 scenes 8 %
  all.push_back({"closed-form", "sphere-impact", sphere_impact, flights});
  all.push_back({"closed-form", "radial-orbit", radial_orbit, digits(42)});
  const auto of = [](TruthKind truth, const char* solution, auto scene) {
    return [=](Random& r, bool border) { return scene(truth, solution, r, border); };
  };
  all.push_back({"closed-form", "ball-flights", table, flights, 0.03});  // of 1675 scenes 2.1 %
  for (const auto& [truth, name, asked] :
       {std::tuple{TruthKind::extended, "extended", 36}, {TruthKind::cvode, "cvode", 22}}) {
    all.push_back({name, "orbits", [truth = truth](Random& r, bool b) { return orbits(truth, r, b); }, digits(asked)});
    all.push_back({name, "pushed-bodies", [truth = truth](Random& r, bool b) { return pushed_bodies(truth, r, b); },
                   digits(asked)});
    all.push_back({name, "billiards", of(truth, "", billiard), flights, 0.04});  // of 3064 scenes 2.8 %
    all.push_back({name, "drops", of(truth, "", drop), flights});
  }
  for (const auto& more : {contact_kinds(), rolling_kinds(), joint_kinds(), mechanism_kinds(), event_kinds()})
    for (const Kind& kind : more) all.push_back(kind);
  return all;
}

}  // namespace

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = all_kinds();
  return all;
}

}  // namespace atwood::fuzz
