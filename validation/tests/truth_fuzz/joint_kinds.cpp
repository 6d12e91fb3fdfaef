// Random scenes of bodies on joints to the world.
#include <algorithm>
#include <cmath>

#include "draw.hpp"
#include "joint_check.hpp"

namespace atwood::fuzz {
namespace {

Joint any_joint(const std::string& name, JointKind kind, int child, Random& r) {
  Joint made = joint(name, kind, -1, child, r.vector(1), r.vector(0.7), r.direction());
  made.frame_wxyz = any_orientation(r);
  return made;
}

// ---- the pendulum --------------------------------------------------------------------------------------------------

// In border scenes the axis is z and the coordinate 0 hangs down, so that a double can be at a limit: the separatrix,
// rest in the upper and in the lower position, small and fast turns; or gravity is almost parallel to the axis.
Scenario pendulum(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "pendulum", 1);
  s.scene.bodies = {any_body("bar", r)};
  Joint pin = any_joint("pin", JointKind::hinge, 0, r);
  Real3 g = r.whole(0, 1) ? Real3{0, 0, -9.81} : r.vector(10);
  pin.coordinates[0] = r.uniform(-4, 4);
  pin.rates[0] = r.whole(0, 2) ? r.uniform(-8, 8) : 0;
  const int what = border ? r.whole(0, 5) : -1;
  if (border) {
    const double l = r.uniform(0.05, 0.8), size = r.uniform(1, 20);
    pin.axis_body = {0, 0, 1};
    pin.frame_wxyz = {1, 0, 0, 0};
    pin.anchors_body_m[1] = {0, l, r.uniform(-0.3, 0.3)};
    g = {0, -size, r.whole(0, 1) ? r.uniform(-5, 5) : 0};
    const Body& bar = s.scene.bodies[0];
    const double w = std::sqrt(bar.mass_kg * size * l / (bar.inertia_kg_m2[8] + bar.mass_kg * l * l));
    pin.coordinates[0] = what == 0 || what == 3 ? 0 : r.uniform(-3, 3);
    pin.rates[0] = 0;
    switch (what) {
      case 0: pin.rates[0] = 2 * w * (1 + r.sign() * r.power(-17, -1)); break;            // separatrix
      case 1: pin.rates[0] = r.sign() * 2 * w * std::cos(pin.coordinates[0] / 2); break;  // the same
      case 2: pin.coordinates[0] = r.sign() * (kPi - r.power(-12, -1)); break;            // upper position
      case 3: pin.coordinates[0] = r.sign() * r.power(-18, -1), pin.rates[0] = r.power(-18, -1); break;  // small
      case 4: pin.rates[0] = r.sign() * w * r.power(0.5, 3); break;                                      // fast
      default: g = {r.uniform(-1, 1) * r.power(-13, -2), -r.power(-14, -2), -9.81}; break;
    }
  }
  s.scene.gravity_m_per_s2 = g;
  s.scene.joints = {pin};
  if (border) s.scene.joints[0].anchors_body_m[0] = r.vector(1);
  else stand_on_body(s, r);
  s.t_end_s = r.uniform(0.3, 4) * (what == 4 ? 0.2 : 1);
  if (r.whole(0, 3) == 0) {
    s.scene.bodies.push_back(any_body("other", r));
    s.scene.joints.push_back(any_joint("nail", JointKind::hinge, static_cast<int>(s.scene.bodies.size()) - 1, r));
  }
  return s;
}

// ---- springs, dampers and motors -----------------------------------------------------------------------------------

// A hinge through the centre of mass or along gravity, or a slider. Border: near critical damping, nearly without
// damping or stiffness, at resonance or as near to it as the solution goes.
Scenario linear_joint(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "linear-joint", r.uniform(0.2, 2));
  const int joints = r.whole(1, 2);
  const bool falls = r.whole(0, 1) == 1;
  if (falls) s.scene.gravity_m_per_s2 = r.vector(10);
  for (int j = 0; j < joints; ++j) {
    s.scene.bodies.push_back(any_body("body" + std::to_string(j), r));
    const Body& body = s.scene.bodies.back();
    Joint joint = any_joint("joint" + std::to_string(j), r.whole(0, 1) ? JointKind::hinge : JointKind::slider, j, r);
    double inertia = body.mass_kg;
    if (joint.kind == JointKind::hinge) {
      if (falls) joint.anchors_body_m[1] = r.whole(0, 1) ? Real3{} : scaled(0.5, joint.axis_body);
      if (joint.anchors_body_m[1] == scaled(0.5, joint.axis_body)) {  // exactly along the axis only where it is a side
        joint.axis_body = {0, 0, 1};
        joint.anchors_body_m[1] = {0, 0, 0.5};
      }
      const Real3& n = joint.axis_body;
      inertia = 0;
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) inertia += n[a] * body.inertia_kg_m2[3 * a + b] * n[b];
      const Real3& d = joint.anchors_body_m[1];
      inertia += body.mass_kg * (inner(d, d) - inner(d, n) * inner(d, n));
    }
    joint.coordinates[0] = r.uniform(-2, 2);
    joint.rates[0] = r.uniform(-3, 3);
    const int what = r.whole(0, 4);
    const double k = r.uniform(0.5, 10), w0 = std::sqrt(k / inertia), critical = 2 * std::sqrt(k * inertia);
    JointSpring spring{j, 0, k, r.uniform(-1, 1), critical * r.uniform(0, 2)};
    if (border && what == 0) spring.damping = critical * (1 + r.sign() * r.power(-17, -1));
    if (border && what == 1) spring.damping = critical * (r.whole(0, 1) ? r.power(-18, -2) : r.power(0.5, 1.3));
    if (border && what == 2) spring.stiffness = r.whole(0, 1) ? 0 : k * r.power(-18, -3);
    if (border && what == 3) spring.damping = 0;
    s.scene.joint_forces.push_back(spring);
    const int motors = r.whole(0, 2);
    for (int m = 0; m < motors; ++m) {
      JointTorque motor{j, 0, r.uniform(-5, 5), r.whole(0, 3) ? r.uniform(0, 8) : 0, r.uniform(-kPi, kPi), {}};
      if (border && what == 3) motor.angular_frequency_rad_per_s = w0 * (1 + r.sign() * r.power(-6.1, -1));
      if (border && what == 4) motor.angular_frequency_rad_per_s = r.power(-18, -3);
      s.scene.joint_forces.push_back(motor);
    }
    s.scene.joints.push_back(joint);
  }
  stand_on_body(s, r);
  return s;
}

// ---- stops --------------------------------------------------------------------------------------------------------

// Border: starts at a stop, ends near the end of the series of bounces or past it, hardly any force, or none.
Scenario joint_stop(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "joint-stop", r.uniform(0.3, 3));
  s.scene.bodies = {any_body("door", r)};
  Joint joint = any_joint("stop", r.whole(0, 1) ? JointKind::hinge : JointKind::slider, 0, r);
  const double lower = r.uniform(-2, 0), upper = lower + r.uniform(0.3, 2.5);
  joint.limits = JointLimits{lower, upper, r.whole(0, 4) ? r.uniform(0.2, 1) : static_cast<double>(r.whole(0, 1))};
  joint.coordinates[0] = r.uniform(lower, upper);
  joint.rates[0] = r.whole(0, 3) ? r.uniform(-4, 4) : 0;
  JointTorque push{0, 0, r.uniform(-5, 5), 0, r.whole(0, 1) ? 0 : r.uniform(-1, 1), {}};
  if (border) {
    switch (r.whole(0, 4)) {
      case 0:
        joint.coordinates[0] = r.whole(0, 1) ? lower : upper;
        // With e = 1 a start from rest at a stop returns to it at rest, which is no impact.
        joint.rates[0] = (joint.coordinates[0] == lower ? 1 : -1) * (r.whole(0, 2) ? r.power(-12, 0.5) : 0);
        break;
      case 1: {  // against the lower stop alone
        const double a = 3 / (joint.kind == JointKind::hinge ? 0.5 : s.scene.bodies[0].mass_kg);
        push = {0, 0, -3, 0, 0, {}};
        joint.limits->upper = upper + 20;
        joint.limits->restitution = r.uniform(0.2, 0.8);
        const double first = std::sqrt(2 * (joint.coordinates[0] - lower) / a), e = joint.limits->restitution;
        joint.rates[0] = 0;
        s.t_end_s = first * (1 + 2 * e / (1 - e)) * (1 + r.sign() * r.power(-9, -1));
        break;
      }
      case 2: push.torque = r.sign() * r.power(-17, -2); break;
      case 3: push.torque = 0; break;
      default: joint.coordinates[0] = r.whole(0, 1) ? lower + r.power(-16, -1) : upper - r.power(-16, -1); break;
    }
    joint.coordinates[0] = std::clamp(joint.coordinates[0], joint.limits->lower, joint.limits->upper);
  }
  if (joint.kind == JointKind::slider) s.scene.gravity_m_per_s2 = r.whole(0, 1) ? r.vector(5) : Real3{};
  s.scene.joints = {joint};
  s.scene.joint_forces = {push};
  stand_on_body(s, r);
  return s;
}

// ---- the top -----------------------------------------------------------------------------------------------------

// Border: close to the vertical, released at rest (cusps), close to the critical spin of the sleeping top, without spin
// through the vertical, fast, or nearly in a steady precession.
Scenario heavy_top(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "heavy-top", r.uniform(0.2, 2));
  const auto axis = static_cast<std::size_t>(border ? 2 : r.whole(0, 2));
  const double across = r.uniform(0.1, 0.5), along = r.uniform(0.02, 2 * across), mass = r.uniform(0.5, 2);
  const double l = r.sign() * r.uniform(0.05, 0.6), size = r.uniform(2, 15);
  Real3 moments{across, across, across}, anchor{0, 0, 0};
  moments[axis] = along;
  anchor[axis] = -l;
  Joint tip = joint("tip", JointKind::ball, -1, 0, r.vector(1), anchor);
  tip.coordinates = any_orientation(r);
  tip.frame_wxyz = any_orientation(r);
  tip.rates = r.vector(3);
  tip.rates[axis] = r.whole(0, 2) ? r.uniform(-30, 30) : 0;
  s.scene.gravity_m_per_s2 = r.whole(0, 1) ? Real3{0, 0, -size} : r.vector(10);
  if (border) {
    tip.frame_wxyz = {1, 0, 0, 0};
    s.scene.gravity_m_per_s2 = {0, 0, r.whole(0, 2) ? -size : size};
    const double pivot = across + mass * l * l, critical = 2 * std::sqrt(pivot * mass * size * std::fabs(l)) / along;
    const int what = r.whole(0, 5);
    const double tilt = what == 0 || what == 2 ? r.power(-12, -1) : r.uniform(0.1, 3);
    tip.coordinates = {std::cos(tilt / 2), std::sin(tilt / 2), 0, 0};
    tip.rates = what == 0 ? scaled(r.power(-12, 0), r.direction()) : Real3{};
    switch (what) {
      case 0:
      case 1: tip.rates[axis] = r.uniform(-30, 30); break;
      case 2: tip.rates[axis] = critical * (1 + r.sign() * r.power(-16, -1)); break;
      case 3: tip.rates[0] = r.uniform(-8, 8) + (r.whole(0, 1) ? 8 : 0); break;
      case 4:
        tip.rates[axis] = r.power(1.5, 3);
        s.t_end_s *= 0.1;
        break;
      default: {  // W^2 pivot cos - W along spin + m g l = 0 with the spin w3
        const double spin = critical * r.uniform(1.1, 2), c = std::cos(tilt), b = along * spin;
        const double W = 2 * mass * size * l / (b + std::sqrt(std::max(0.0, b * b - 4 * pivot * c * mass * size * l)));
        tip.rates = {0, W * std::sin(tilt) * (1 + (r.whole(0, 1) ? r.sign() * r.power(-16, -2) : 0)), spin};
      }
    }
  }
  s.scene.bodies = {solid("top", mass, moments, {0, 0, 0})};
  s.scene.joints = {tip};
  if (!border) stand_on_body(s, r);
  return s;
}

}  // namespace

std::vector<Kind> joint_kinds() {
  const auto check = [](const Scenario& s, std::int64_t samples) { return check_joints(s, samples, 44); };
  return {{"closed-form", "pendulum", pendulum, check},
          {"closed-form", "linear-joint", linear_joint, check, 0.01},
          {"closed-form", "joint-stop", joint_stop, check, 0.006},
          {"closed-form", "heavy-top", heavy_top, check, 0.01}};
}

}  // namespace atwood::fuzz
