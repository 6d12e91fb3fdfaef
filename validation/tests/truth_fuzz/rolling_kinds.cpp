// Random scenes of bodies that roll.
#include <algorithm>
#include <cmath>

#include "draw.hpp"
#include "rolling_check.hpp"

namespace atwood::fuzz {
namespace {

// ---- balls on a pushed slab ---------------------------------------------------------------------------------------

// Border: the push at the limit of the floor's friction, a ball's friction at what its roll takes, hardly any friction,
// a slab that is about to tip.
Scenario friction_cone(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "friction-cone", r.uniform(0.1, 1));
  const double g = r.uniform(1, 15), thick = few_bits(r.uniform(0.02, 0.3)), mass = r.power(-1, 1.5);
  static const std::vector<Real3> ways{{1, 0, 0}, {0, -1, 0}, {3, 4, 0}, {-5, 12, 0}};
  const Real3 way = ways[static_cast<std::size_t>(r.whole(0, 3))];
  const double length = std::sqrt(inner(way, way));
  s.scene.gravity_m_per_s2 = {0, 0, -g};
  Body slab = solid("slab", mass, {mass, mass, mass}, {0, 0, 0});
  slab.position_m = {few_bits(r.uniform(-1, 1)), few_bits(r.uniform(-1, 1)), thick};
  const int balls = r.whole(0, 4), what = border ? r.whole(0, 3) : -1;
  double carried = mass;
  s.scene.bodies = {plane({0, 0, 1}, 0), slab};
  for (int k = 0; k < balls; ++k) {
    const double radius = few_bits(r.uniform(0.05, 0.2));
    Body body = ball("ball" + std::to_string(k), r.power(-1.5, 1), radius,
                     sum(slab.position_m, scaled(few_bits((k - 1.5) / length), way)), {});
    body.position_m[2] = 2 * thick + radius;
    const double I = r.uniform(0.1, 1) * body.mass_kg * radius * radius;
    body.inertia_kg_m2 = {I, 0, 0, 0, I, 0, 0, 0, I};
    body.orientation_wxyz = any_orientation(r);
    body.material = k + 1;
    carried += body.mass_kg;
    s.scene.materials.push_back({body.name, 0, 0, 0});
    s.scene.pairs.push_back({0, k + 1, 0, r.uniform(0.02, 0.6)});
    for (int j = 1; j <= k + 1; ++j) s.scene.pairs.push_back({j, k + 1, 0, 0});
    s.scene.bodies.push_back(body);
  }
  const double mu = what == 2 ? r.power(-17, -2) : r.uniform(0.05, 0.8);
  s.scene.pairs[0].friction = mu;
  double force = mu * carried * g * r.uniform(0.5, 3);
  if (what == 0) force = mu * carried * g * (1 + r.sign() * r.power(-17, -1));
  if (what == 1 && balls > 0) {  // the first ball's limit, as if all rolled
    double inertia = mass;
    const auto share = [](const Body& b) {
      const double R = std::get<Sphere>(b.shape).radius_m;
      return 1 / (1 + b.mass_kg * R * R / b.inertia_kg_m2[0]);
    };
    for (std::size_t i = 2; i < s.scene.bodies.size(); ++i)
      inertia += s.scene.bodies[i].mass_kg * share(s.scene.bodies[i]);
    const double A = (force - mu * carried * g) / inertia;
    if (A > 0) s.scene.pairs[1].friction = A * share(s.scene.bodies[2]) / g * (1 + r.sign() * r.power(-17, -1));
  }
  const double high = r.whole(0, 1) ? 0 : r.uniform(-thick, thick);
  double wide = r.uniform(2.5, 6);
  if (what == 3) wide = std::max(2.0, thick * force / (carried * g) * (1 + r.sign() * r.power(-9, -1)));
  s.scene.bodies[1].shape = Box{{wide, wide, thick}};
  s.scene.forces = {PointForce{1, {0, 0, high}, scaled(few_bits(force / length), way), {}}};
  return s;
}

// ---- a coin on its rim --------------------------------------------------------------------------------------------

// Border: nearly upright or flat, Euler's disc, off the steady roll by as much as the truth takes for round-off.
Scenario steady_roll(Random& r, bool border) {
  Scenario s = empty(TruthKind::closed_form, "steady-roll", 1);
  const double m = r.power(-2, 1), R = r.power(-2, 0),
               l = r.whole(0, 1) ? R * r.uniform(0.01, 0.3) : R * r.power(-5, -2);
  const double axial = m * R * R * r.uniform(0.3, 0.9), across = axial * r.uniform(0.5, 0.9), g = r.uniform(1, 15);
  const int what = border ? r.whole(0, 3) : -1;
  const double lean = what == 0 ? kPi / 2 - r.power(-3, -1) : what == 1 ? r.power(-1.5, -0.5) : r.uniform(0.3, 1.4);
  const double c = std::cos(lean), sn = std::sin(lean), rho_x = R * c - l * sn, H = R * sn + l * c;
  s.t_end_s = r.uniform(0.2, 6) * std::sqrt(R / g);
  double W = r.sign() * std::sqrt(g / R) * r.uniform(0.3, 4);
  double spin =
      (-m * H * W * W * rho_x - m * g * rho_x - W * W * sn * c * (axial - across)) / (W * sn * axial + m * H * W * R);
  const bool disc = what == 2 || r.whole(0, 3) == 0;
  const double square = -m * g * rho_x / (sn * (axial * (c - rho_x / R) - across * c));
  if (disc && square > 0) {
    W = r.sign() * std::sqrt(square);
    spin = -W * rho_x / R;
  }
  if (what == 3) spin *= 1 + r.sign() * r.power(-17, -12.5);
  const double round = -rho_x - spin * R / W;  // the centre from the middle of its circle
  const double yaw = r.uniform(-kPi, kPi), own = r.uniform(-kPi, kPi);
  const bool over = r.whole(0, 1) == 1;
  const auto turn = [](double angle, int axis) {
    Real4 made{std::cos(angle / 2), 0, 0, 0};
    made[static_cast<std::size_t>(axis)] = std::sin(angle / 2);
    return made;
  };
  const auto times = [](const Real4& a, const Real4& b) {
    return Real4{
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3], a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1]};
  };
  Body coin = solid("coin", m, {across, across, axial}, {0, 0, 0});
  coin.shape = Cylinder{R, l};
  coin.orientation_wxyz = times(times(turn(yaw, 3), turn(over ? lean + kPi : lean, 2)), turn(own, 3));
  coin.position_m = {r.uniform(-1, 1), r.uniform(-1, 1), H};
  coin.velocity_m_per_s = {-W * round * std::sin(yaw), W * round * std::cos(yaw), 0};
  // W z + spin a in the body's axes: z is -sin x + cos z before the last turn, of the upper end's axes.
  const double wx = -W * sn, wz = W * c + spin, side = over ? -1 : 1;
  coin.angular_velocity_body_rad_per_s = {side * wx * std::cos(own), -side * wx * std::sin(own), side * wz};
  s.scene.gravity_m_per_s2 = {0, 0, -g};
  s.scene.pairs[0].friction = W * W * std::fabs(round) / g * r.uniform(1.05, 3) + (disc || r.whole(0, 1) ? 0.1 : 0);
  s.scene.bodies = {plane({0, 0, 1}, 0), coin};
  return s;
}

}  // namespace

std::vector<Kind> rolling_kinds() {
  const auto coin = [](const Scenario& s, std::int64_t samples) { return check_steady_roll(s, samples, 24); };
  return {{"closed-form", "friction-cone", friction_cone, check_friction_cone, 0.1},
          {"closed-form", "steady-roll", steady_roll, coin, 0.2}};
}

}  // namespace atwood::fuzz
