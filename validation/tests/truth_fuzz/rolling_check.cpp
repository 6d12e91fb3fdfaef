#include "rolling_check.hpp"

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

const Long3 kUp{0, 0, 1};

// ---- balls on a pushed slab ---------------------------------------------------------------------------------------

struct Carried {
  Long mass = 0, radius = 0, inertia = 0, grip = 0, place = 0;  // grip: mu g; place: along the push, from the slab
  Long a = 0;                                                   // along the push
};

// The slab's acceleration where bit i of `rolling` says that ball i rolls; false: not consistent with Coulomb's law.
bool accelerated(Long pushed, Long inertia, unsigned rolling, std::vector<Carried>& balls, Long& slab) {
  const auto rolls = [&](std::size_t i) { return (rolling >> i & 1) != 0; };
  // Of a ball that rolls on a deck with the acceleration A: f = m a, r alpha = -m r^2 a / I, a - r alpha = A.
  const auto share = [](const Carried& ball) {
    return Long(1 / (1 + ball.mass * ball.radius * ball.radius / ball.inertia));
  };
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (rolls(i)) inertia += balls[i].mass * share(balls[i]);
    else pushed -= balls[i].mass * balls[i].grip;
  }
  slab = pushed / inertia;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Long held = share(balls[i]) * slab;
    if (rolls(i) != (held <= balls[i].grip)) return false;
    balls[i].a = rolls(i) ? held : balls[i].grip;
  }
  return true;
}

}  // namespace

Checked check_friction_cone(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const Body& slab = scene.bodies[1];
  const auto& push = std::get<PointForce>(scene.forces[0]);
  const Long3 force = widened(push.force_N);
  const Long g = -scene.gravity_m_per_s2[2], F = sqrt(dot(force, force)),
             half = std::get<Box>(slab.shape).half_extents_m[2];
  const Long3 e = normalised(force), roll_axis = cross(kUp, e);
  std::vector<Carried> balls;
  Long carried = slab.mass_kg;
  for (std::size_t i = 2; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const Long grip = Long(pair_law(scene, 1, static_cast<int>(i)).friction) * g;
    balls.push_back({body.mass_kg, std::get<Sphere>(body.shape).radius_m, body.inertia_kg_m2[0], grip,
                     dot(e, widened(body.position_m) - widened(slab.position_m))});
    carried += body.mass_kg;
  }
  const Long most = Long(pair_law(scene, 0, 1).friction) * carried * g, ground = F <= most ? F : most;
  Long A = 0;
  for (unsigned rolling = 0; F > most && !accelerated(F - most, slab.mass_kg, rolling, balls, A);)
    if (++rolling >> balls.size() != 0) return {"no assignment of roll and slip is consistent", {}, {}};
  Checked made = of_starts(scenario, samples);
  bool tips = false;
  for (std::size_t k = 0; k < made.values.size(); ++k) {
    const Long t = Long(scenario.t_end_s) * static_cast<int>(k) / samples;
    LongBody& deck = made.values[k][1];
    deck.p = deck.p + A * t * t / 2 * e;
    deck.v = A * t * e;
    // About the slab's centre, forwards: its own forces and the balls' weights and friction.
    Long moment = half * ground + Long(push.point_body_m[2]) * F;
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const Carried& ball = balls[i];
      const Long spin = -ball.radius * ball.mass * ball.a / ball.inertia;  // per second
      LongBody& now = made.values[k][i + 2];
      now.p = now.p + ball.a * t * t / 2 * e;
      now.v = ball.a * t * e;
      now.q = product(quaternion_about(roll_axis, spin * t * t / 2), now.q);
      now.w = turned_back(now.q, spin * t * roll_axis);
      moment += ball.mass * (g * (ball.place + (ball.a - A) * t * t / 2) - half * ball.a);
    }
    const Long3 pressed = moment / (carried * g) * e;
    for (std::size_t c = 0; c < 2; ++c)
      if (abs(pressed[c]) > std::get<Box>(slab.shape).half_extents_m[c] * (1 + Long("1e-12"))) tips = true;
  }
  set_own(made, made, Long("1e-52"));
  widen_bodies(made, Long("1e-52"));
  if (tips) made.contradicts = "the centre of pressure leaves the slab's base";
  return made;
}

// ---- a coin on its rim --------------------------------------------------------------------------------------------

namespace {

struct Coin {
  Long mass, gravity, radius, half, axial, across;

  explicit Coin(const Scene& scene)
      : mass(scene.bodies[1].mass_kg), gravity(-scene.gravity_m_per_s2[2]),
        radius(std::get<Cylinder>(scene.bodies[1].shape).radius_m),
        half(std::get<Cylinder>(scene.bodies[1].shape).half_length_m), axial(scene.bodies[1].inertia_kg_m2[8]),
        across(scene.bodies[1].inertia_kg_m2[0]) {}

  // From the centre to the lowest point of the rim: the lower end's centre, and from there down within the disc.
  Long3 touch(const Long3& axis) const {
    const Long3 upper = axis[2] < 0 ? Long(-1) * axis : axis, down = upper[2] * upper - kUp;
    return radius * normalised(down) - half * upper;
  }
  // Its change, as the axis changes by w x axis.
  Long3 touch_rate(const Long3& axis, const Long3& w) const {
    const Long3 upper = axis[2] < 0 ? Long(-1) * axis : axis, change = cross(w, upper);
    const Long3 down = upper[2] * upper - kUp, down_change = change[2] * upper + upper[2] * change;
    const Long length = sqrt(dot(down, down));
    return radius / length * (down_change - dot(down, down_change) / (length * length) * down) - half * change;
  }
  // Of the angular velocity, world axes. With rho the touch, v = rho x w and the floor's force m (v' + g z):
  // I w' + w x I w = rho x m (rho' x w + rho x w' + g z).
  Long3 change(const Long3& axis, const Long3& w) const {
    const Long3 rho = touch(axis), rho_rate = touch_rate(axis, w);
    const Long3 momentum = across * w + (axial - across) * dot(axis, w) * axis;
    const Long3 right = mass * cross(rho, cross(rho_rate, w) + gravity * kUp) - cross(w, momentum);
    std::array<Long3, 3> rows{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        rows[i][j] = (i == j ? across + mass * dot(rho, rho) : Long(0)) + (axial - across) * axis[i] * axis[j] -
                     mass * rho[i] * rho[j];
    const Long3 c0 = cross(rows[1], rows[2]), c1 = cross(rows[2], rows[0]), c2 = cross(rows[0], rows[1]);
    return 1 / dot(rows[0], c0) * (right[0] * c0 + right[1] * c1 + right[2] * c2);
  }
};

Long3 axis_of(const Long4& q) { return turned(q, kUp); }

Checked roll(const Scenario& scenario, std::int64_t samples, int digits) {
  const Coin coin(scenario.scene);
  const LongBody start = start_of(scenario.scene.bodies[1]);
  const std::vector<Long> times_s = sample_times(scenario.t_end_s, samples);
  // Orientation, angular velocity (world), the centre across the floor.
  const auto f = [&](const Long&, const State& y, State& dydt) {
    const Long4 q{y[0], y[1], y[2], y[3]};
    const Long3 w{y[4], y[5], y[6]}, axis = axis_of(q), dw = coin.change(axis, w), v = cross(coin.touch(axis), w);
    const Long4 half = product({0, w[0] / 2, w[1] / 2, w[2] / 2}, q);
    for (std::size_t c = 0; c < 4; ++c) dydt[c] = half[c];
    for (std::size_t c = 0; c < 3; ++c) dydt[4 + c] = dw[c];
    for (std::size_t c = 0; c < 2; ++c) dydt[7 + c] = v[c];
  };
  State first(start.q.begin(), start.q.end());
  const Long3 w0 = turned(start.q, start.w);
  first.insert(first.end(), w0.begin(), w0.end());
  first.insert(first.end(), start.p.begin(), start.p.begin() + 2);
  const std::vector<State> path = solve(f, first, {0, 0, 0, 0, 1, 1, 1, 2, 2}, times_s, digits);
  if (path.empty()) return {"the checker needs more than " + std::to_string(kMaxSteps) + " steps", {}, {}};
  Checked made = of_starts(scenario, samples);
  for (std::size_t k = 0; k < path.size(); ++k) {
    const State& y = path[k];
    LongBody& now = made.values[k][1];
    now.q = {y[0], y[1], y[2], y[3]};
    const Long3 w{y[4], y[5], y[6]}, rho = coin.touch(axis_of(now.q));
    now.p = {y[7], y[8], -rho[2]};
    now.v = cross(rho, w);
    now.w = turned_back(now.q, w);
  }
  return made;
}

}  // namespace

Checked check_steady_roll(const Scenario& scenario, std::int64_t samples, int digits) {
  return of_two(roll(scenario, samples, digits), roll(scenario, samples, digits - 4), Long("1e-55"));
}

}  // namespace atwood::fuzz
