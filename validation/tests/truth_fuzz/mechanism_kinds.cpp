// Random scenes of mechanisms that one driven hinge or a rope moves, of four-bars and of welded bodies.
#include <cmath>

#include "draw.hpp"
#include "mechanism_check.hpp"
#include "welded_check.hpp"

namespace atwood::fuzz {
namespace {

// Border: the crank's radius and the rail's height almost reach the rod's length, a crank almost without radius, or a
// slow one; the rod may point backwards. The start's doubles close the loop to round-off: the truth moves all joints
// but the driven one onto it, which leaves one place for each.
Scenario slider_crank(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "slider-crank", r.uniform(0.2, 2));
  const double L = r.uniform(0.9, 1.5);
  double radius = r.uniform(0.2, 0.5), h = r.uniform(-0.2, 0.2), W = r.uniform(-4, 4);
  if (border) {
    switch (r.whole(0, 3)) {
      case 0: radius = (L - std::fabs(h)) * (1 - r.power(-5.9, -1)); break;
      case 1: radius = r.power(-6, -1); break;
      case 2: h = 0; break;
      default: W = r.sign() * r.power(-9, 2); s.t_end_s *= std::fabs(W) > 10 ? 0.1 : 1;
    }
  }
  const double angle = r.uniform(-3, 3), side = r.sign(), up = h - radius * std::sin(angle),
               phi = side > 0 ? std::asin(up / L) : kPi - std::asin(up / L),
               rate = -W * radius * std::cos(angle) / (L * std::cos(phi)), flip = r.sign();
  Joint motor = joint("motor", JointKind::hinge, -1, 2, {0, 0, 0}, {-radius / 2, 0, 0});
  motor.coordinates[0] = angle;
  motor.driven_rate = motor.rates[0] = W;
  Joint pin = joint("pin", JointKind::hinge, 2, 0, {radius / 2, 0, 0}, {-L / 2, 0, 0.125}, {0, 0, flip});
  pin.coordinates[0] = flip * (phi - angle);
  pin.rates[0] = flip * (rate - W);
  Joint rail = joint("rail", JointKind::slider, -1, 1, {0, h, 0}, {0, 0, 0}, {1, 0, 0});
  rail.coordinates[0] = radius * std::cos(angle) + L * std::cos(phi);
  rail.rates[0] = -W * radius * std::sin(angle) - L * std::sin(phi) * rate;
  Joint wrist = joint("wrist", JointKind::hinge, 0, 1, {L / 2, 0, 0.125}, {0, 0, 0});
  wrist.closes_loop = true;
  wrist.coordinates[0] = -phi;
  wrist.rates[0] = -rate;
  s.scene.gravity_m_per_s2 = r.vector(9);
  s.scene.bodies = {any_body("rod", r), any_body("piston", r), any_body("crank", r)};
  s.scene.joints = {motor, pin, rail, wrist};
  stand_on_body(s, r);
  return s;
}

// Border: shafts almost in line, almost orthogonal, or with an obtuse angle.
Scenario hooke_shaft(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "hooke-shaft", r.uniform(0.2, 3));
  double bend = r.uniform(-1.2, 1.2);
  if (border) {
    const int what = r.whole(0, 2);
    bend = r.sign() * (what == 0 ? r.power(-17, -1) : what == 1 ? kPi / 2 - r.power(-2.9, -1) : r.uniform(1.8, 2.9));
  }
  const double W = r.uniform(-5, 5), a = r.uniform(-1.5, 1.5), cosine = std::cos(bend), sine = std::sin(bend);
  const double b = std::atan2(cosine * std::sin(a), std::cos(a));
  Joint motor = joint("motor", JointKind::hinge, -1, 0, {0, 0, -0.5}, {0, 0, 0.125});
  motor.coordinates[0] = a;
  motor.driven_rate = motor.rates[0] = W;
  Joint bearing = joint("bearing", JointKind::hinge, -1, 1, {0, 0, 0}, {0, 0, -0.75});
  bearing.frame_wxyz = {std::cos(bend / 2), std::sin(bend / 2), 0, 0};
  bearing.coordinates[0] = b;
  bearing.rates[0] = W * cosine / (1 - sine * sine * std::sin(a) * std::sin(a));
  Joint cross = joint("cross", JointKind::universal, 0, 1, {0, 0, 0.625}, {0, 0, -0.75});
  cross.axes_body = {Real3{1, 0, 0}, Real3{0, 1, 0}};
  const double q0 = std::atan2(sine * std::cos(a), cosine);
  cross.coordinates = {q0, std::asin(-sine * std::sin(a)), 0, 0};
  cross.closes_loop = r.whole(0, 1) == 1;
  if (!cross.closes_loop) {  // the cross places the second shaft: w2 - w1 = u0 (first pin) + u1 (second pin)
    const double rate = bearing.rates[0];
    cross.rates[0] = -rate * sine * std::sin(a);
    cross.rates[1] = rate * (-sine * std::cos(b) * 0) - W * sine * std::cos(b);
    bearing.closes_loop = bearing.assemble = true;
  }
  s.scene.gravity_m_per_s2 = r.whole(0, 1) ? Real3{} : r.vector(9);
  s.scene.bodies = {any_body("first", r), any_body("second", r)};
  s.scene.joints = {motor, bearing, cross};
  stand_on_body(s, r);
  return s;
}

// Border: the bore almost along the axis or across it, a slow rod.
Scenario turning_rod(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "turning-rod", r.uniform(0.2, 2));
  s.scene.bodies = {any_body("rod", r), any_body("bead", r)};
  Joint motor = joint("motor", JointKind::hinge, -1, 0, r.vector(1), r.vector(0.5), r.direction());
  motor.coordinates[0] = r.uniform(-3, 3);
  motor.driven_rate = motor.rates[0] = r.uniform(-4, 4);
  motor.frame_wxyz = any_orientation(r);
  Joint bore = joint("bore", JointKind::slider, 0, 1, r.vector(0.5), r.vector(0.5), r.direction());
  bore.coordinates[0] = r.uniform(-1, 1);
  bore.rates[0] = r.uniform(-1, 1);
  bore.frame_wxyz = any_orientation(r);
  if (border) {
    const int what = r.whole(0, 2);
    if (what == 0) motor.driven_rate = motor.rates[0] = r.sign() * r.power(-9, -1);
    if (what > 0) {
      bore.frame_wxyz = {1, 0, 0, 0};
      motor.axis_body = {0, 0, 1};
      const double off = what == 1 ? r.power(-17, -1) : 1;
      bore.axis_body = {off, 0, what == 1 ? 1 : r.power(-17, -1)};
    }
  }
  s.scene.gravity_m_per_s2 = r.whole(0, 2) ? r.vector(9) : Real3{};
  s.scene.joints = {motor, bore};
  stand_on_body(s, r);
  return s;
}

// Numbers of few bits, so that the bars are parallel and of one length, exactly. Border: the separatrix, rest in the
// upper position or beside it, hardly any motion, fast turns.
Scenario four_bar(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "four-bar", r.uniform(0.2, 2));
  const int couplings = r.whole(1, 3);
  const auto few = [&](double size) {
    const Real3 v = r.vector(size);
    return Real3{std::round(v[0] * 1024) / 1024, std::round(v[1] * 1024) / 1024, std::round(v[2] * 1024) / 1024};
  };
  const Real3 bar{0, few(1)[0] + 1.25, few(0.2)[2]}, lean = few(0.5), b = sum(bar, {lean[0], 0, 0});
  double angle = r.uniform(-3, 3), rate = r.whole(0, 2) ? r.uniform(-5, 5) : 0;
  const Real3 g = r.whole(0, 1) ? Real3{0, -9.81, 0} : r.vector(10);
  std::vector<Real3> feet{{0, 0, 0}};
  for (int k = 0; k < couplings; ++k) feet.push_back(sum(feet.back(), sum({1.5, 0, 0}, few(0.5))));
  for (Real3& foot : feet) foot[2] = 0;
  double inertia = 0;
  Real3 moment{};
  std::vector<Real3> below;  // of each bar: its foot, in its own axes
  for (int k = 0; k <= couplings; ++k) {
    below.push_back(few(0.6));
    s.scene.bodies.push_back(any_body("bar" + std::to_string(k), r));
    const Body& body = s.scene.bodies.back();
    inertia += body.inertia_kg_m2[8] + body.mass_kg * (below[k][0] * below[k][0] + below[k][1] * below[k][1]);
    moment = sum(moment, scaled(-body.mass_kg, below[k]));
  }
  for (int k = 0; k < couplings; ++k) {
    s.scene.bodies.push_back(any_body("link" + std::to_string(k), r));
    inertia += s.scene.bodies.back().mass_kg * (b[0] * b[0] + b[1] * b[1]);
    moment = sum(moment, scaled(s.scene.bodies.back().mass_kg, b));
  }
  if (border) {
    const double size = std::hypot(moment[0], moment[1]), pull = std::hypot(g[0], g[1]);
    const double lowest = std::atan2(g[1], g[0]) - std::atan2(moment[1], moment[0]);
    const double w = std::sqrt(size * pull / inertia), fast = r.power(1, 2);
    switch (r.whole(0, 4)) {
      case 0: rate = r.sign() * 2 * w * std::cos((angle - lowest) / 2) * (1 + r.sign() * r.power(-17, -1)); break;
      case 1: angle = lowest + kPi + r.sign() * r.power(-12, -1), rate = 0; break;
      case 2: angle = lowest + r.sign() * r.power(-15, -2), rate = r.power(-17, -2); break;
      case 3: rate = r.sign() * fast, s.t_end_s = 5 / fast; break;
      default: rate = 0; break;
    }
  }
  const auto hinge = [&](const std::string& name, int parent, int child, Real3 on_parent, Real3 on_child, double way) {
    const double side = r.sign();
    Joint made = joint(name, JointKind::hinge, parent, child, on_parent, on_child, {0, 0, side});
    made.coordinates[0] = side * way * angle;
    made.rates[0] = side * way * rate;
    s.scene.joints.push_back(made);
  };
  for (int k = 0; k <= couplings; ++k) hinge("foot" + std::to_string(k), -1, k, feet[k], below[k], 1);
  std::vector<Real3> ends;
  for (int k = 0; k < couplings; ++k) {
    ends.push_back(few(0.5));
    hinge("left" + std::to_string(k), k, couplings + 1 + k, sum(below[k], b), ends[k], -1);
  }
  for (int k = 0; k < couplings; ++k) {
    // The tips' heights along z: of bar k at -below z + (below + b) z = b z, and so of bar k + 1.
    const Real3 apart = sum(feet[k + 1], scaled(-1, feet[k]));
    hinge("right" + std::to_string(k), couplings + 1 + k, k + 1, sum(ends[k], apart), sum(below[k + 1], b), 1);
    s.scene.joints.back().closes_loop = true;
  }
  s.scene.gravity_m_per_s2 = g;
  return s;
}

// Border: hardly any spin, much of it, a spin about one axis of the base, arms that are nearly nothing, parts of hardly
// any mass.
Scenario welded_bodies(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "welded-bodies", r.uniform(0.2, 2));
  if (r.whole(0, 1)) s.scene.gravity_m_per_s2 = r.vector(10);
  const int assemblies = r.whole(1, 2);
  for (int k = 0; k < assemblies; ++k) {
    const int what = border ? r.whole(0, 4) : -1, first = static_cast<int>(s.scene.bodies.size());
    const int parts = r.whole(2, 4);
    for (int i = 0; i < parts; ++i) {
      const int at = first + i;
      s.scene.bodies.push_back(any_body("part" + std::to_string(at), r));
      Body& body = s.scene.bodies.back();
      if (i == 0) {
        body.position_m = r.vector(1);
        body.velocity_m_per_s = r.vector(2);
        body.orientation_wxyz = any_orientation(r);
        body.angular_velocity_body_rad_per_s = r.vector(5);
        if (what == 0) body.angular_velocity_body_rad_per_s = r.vector(r.power(-16, -2));
        if (what == 1) {
          body.angular_velocity_body_rad_per_s = r.vector(r.power(1, 2));
          s.t_end_s *= 0.1;
        }
        if (what == 2) body.angular_velocity_body_rad_per_s = {0, r.sign() * r.uniform(0.5, 5), r.power(-17, -2)};
        continue;
      }
      if (what == 4) {
        const double less = r.power(-9, -3);
        body.mass_kg *= less;
        for (double& moment : body.inertia_kg_m2) moment *= less;
      }
      Joint weld = joint("weld" + std::to_string(at), JointKind::fixed, first + r.whole(0, i - 1), at, r.vector(0.7),
                         r.vector(0.7));
      if (what == 3) weld.anchors_body_m = {r.vector(r.power(-12, -2)), r.vector(r.power(-12, -2))};
      weld.frame_wxyz = any_orientation(r);
      s.scene.joints.push_back(weld);
    }
  }
  return s;
}

// Numbers of few bits, so that the ends hang exactly straight down. Border: nearly equal masses, heavy or light
// pulleys, ends that almost reach their pulleys, and a turn of the motion at the end.
Scenario atwood_machine(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "atwood-machine", r.uniform(0.2, 2));
  const double g = r.uniform(1, 20);
  s.scene.gravity_m_per_s2 = {0, 0, -g};
  const int ropes = r.whole(1, 2);
  for (int k = 0; k < ropes; ++k) {
    const double y = 10 * k, radius = r.whole(0, 3) ? r.whole(1, 64) / 64.0 : 0, apart = r.whole(0, 64) / 32.0;
    double m1 = r.uniform(0.2, 5), m2 = r.uniform(0.2, 5), u = r.whole(0, 1) ? r.uniform(-1, 1) : 0;
    if (border && r.whole(0, 1)) m2 = m1 * (1 + r.sign() * r.power(-17, -1));
    std::vector<Pulley> over{{{0, y, 0}, {0, 1, 0}, radius, 0, r.uniform(-3, 3)}};
    if (apart > 0) over.push_back({{2 * radius + apart, y, 0}, {0, 1, 0}, radius, 0, 0});
    double total = m1 + m2;
    for (Pulley& pulley : over) {
      if (radius > 0 && r.whole(0, 2))
        pulley.inertia_kg_m2 = border ? r.power(-9, 3) : r.uniform(0, 2) * radius * radius;
      if (radius > 0) total += pulley.inertia_kg_m2 / (radius * radius);
    }
    const double a = (m2 - m1) * g / total, far = over.back().axle_m[0] + radius;
    double up = 0, down = 0;  // farthest of the first end
    const double turns = a != 0 ? -u / a : 0;
    for (const double t : {s.t_end_s, turns > 0 && turns < s.t_end_s ? turns : 0.0}) {
      up = std::fmax(up, u * t + a * t * t / 2);
      down = std::fmin(down, u * t + a * t * t / 2);
    }
    const double room = border ? r.power(-9, 0) : r.uniform(0.1, 2);
    const int at = static_cast<int>(s.scene.bodies.size());
    s.scene.bodies.push_back(point("left" + std::to_string(k), m1, {-radius, y, -up - room}, {0, 0, u}));
    s.scene.bodies.push_back(point("right" + std::to_string(k), m2, {far, y, down - room}, {0, 0, -u}));
    Rope rope;
    rope.name = "rope" + std::to_string(k);
    rope.bodies = {at, at + 1};
    rope.over = over;
    s.scene.ropes.push_back(rope);
  }
  return s;
}

}  // namespace

std::vector<Kind> mechanism_kinds() {
  const auto rod = [](const Scenario& s, std::int64_t samples) { return check_turning_rod(s, samples, 44); };
  const auto bars = [](const Scenario& s, std::int64_t samples) { return check_four_bar(s, samples, 44); };
  const auto weld = [](const Scenario& s, std::int64_t samples) { return check_welded_bodies(s, samples, 48); };
  return {{"closed-form", "slider-crank", slider_crank, check_slider_crank},
          {"closed-form", "hooke-shaft", hooke_shaft, check_hooke_shaft, 0.006},
          {"closed-form", "turning-rod", turning_rod, rod, 0.08},
          {"closed-form", "four-bar", four_bar, bars, 0.02},
          {"closed-form", "welded-bodies", welded_bodies, weld, 0.05},
          {"closed-form", "atwood-machine", atwood_machine, check_atwood_machine}};
}

}  // namespace atwood::fuzz
