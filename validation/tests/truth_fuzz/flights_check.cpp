#include "flights_check.hpp"

#include <algorithm>

namespace atwood::fuzz {
namespace {

using Polynomial = std::vector<Long>;  // coefficients, constant first

Long value(const Polynomial& p, const Long& t) {
  Long sum = 0;
  for (std::size_t k = p.size(); k-- > 0;) sum = sum * t + p[k];
  return sum;
}

// All roots in (from, to) where the sign changes, ascending: by bisection between the roots of the derivative.
std::vector<Long> roots(const Polynomial& p, const Long& from, const Long& to) {
  if (p.size() < 2) return {};
  Polynomial slope;
  for (std::size_t k = 1; k < p.size(); ++k) slope.push_back(Long(static_cast<int>(k)) * p[k]);
  std::vector<Long> borders{from}, found;
  for (const Long& root : roots(slope, from, to)) borders.push_back(root);
  borders.push_back(to);
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) {
    Long low = borders[i], high = borders[i + 1];
    const bool rises = value(p, low) < 0;
    if (rises == (value(p, high) < 0)) continue;
    for (int halving = 0; halving < 210; ++halving) {
      const Long middle = (low + high) / 2;
      ((value(p, middle) < 0) == rises ? low : high) = middle;
    }
    found.push_back((low + high) / 2);
  }
  return found;
}

struct Ball {
  bool free = false, turns = false;
  Long mass = 0, moment = 0, radius = 0;
  LongBody now;
  Long3 w_world{};
};
struct Wall {
  Long3 n{};
  Long offset = 0;
  int body = 0;
};

struct Flights {
  const Scenario& scenario;
  Long moved = 0;  // relative shift of each impact time within its flight
  Long3 gravity{};
  std::vector<Ball> balls{};  // in the order of the bodies; planes too, as fixed ones
  std::vector<Wall> walls{};
  std::string refused{};

  Long3 pull(const Ball& ball) const { return ball.free ? gravity : Long3{}; }

  void read() {
    gravity = widened(scenario.scene.gravity_m_per_s2);
    if (!scenario.scene.forces.empty()) refused = "the checker of impacts has no forces but gravity";
    for (std::size_t i = 0; i < scenario.scene.bodies.size(); ++i) {
      const Body& body = scenario.scene.bodies[i];
      Ball ball;
      ball.free = !body.fixed;
      ball.mass = body.mass_kg;
      ball.now.p = widened(body.position_m);
      ball.now.v = widened(body.velocity_m_per_s);
      for (int k = 0; k < 4; ++k) ball.now.q[k] = body.orientation_wxyz[k];
      for (int k = 0; k < 3; ++k) ball.w_world[k] = body.angular_velocity_body_rad_per_s[k];
      ball.turns = rotates(body);
      ball.moment = body.inertia_kg_m2[0];
      if (ball.now.q != Long4{1, 0, 0, 0}) refused = "the checker of impacts starts from unturned balls";
      if (ball.turns &&
          (body.inertia_kg_m2[4] != body.inertia_kg_m2[0] || body.inertia_kg_m2[8] != body.inertia_kg_m2[0]))
        refused = "different principal moments of inertia";
      if (body.release_s != 0) refused = "a late release";
      if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
        ball.radius = sphere->radius_m;
      } else if (const auto* plane = std::get_if<Plane>(&body.shape)) {
        Long3 n = widened(plane->normal);
        const Long length = sqrt(dot(n, n));
        walls.push_back({Long(1) / length * n, Long(plane->offset_m) / length, static_cast<int>(i)});
      } else {
        refused = "the checker of impacts knows balls and planes";
      }
      balls.push_back(ball);
    }
  }

  bool is_wall(int i) const { return std::holds_alternative<Plane>(scenario.scene.bodies[i].shape); }

  // The gap as a polynomial of the time from now; for two balls the squared distance minus the squared sum of the
  // radii.
  Polynomial gap(int a, int b) const {
    const Long3 g = pull(balls[b]) - pull(balls[a]);
    if (is_wall(a)) {
      const Wall& wall = *std::find_if(walls.begin(), walls.end(), [&](const Wall& w) { return w.body == a; });
      return {dot(wall.n, balls[b].now.p) - wall.offset - balls[b].radius, dot(wall.n, balls[b].now.v),
              dot(wall.n, g) / 2};
    }
    const Long3 d = balls[b].now.p - balls[a].now.p, u = balls[b].now.v - balls[a].now.v;
    const Long R = balls[a].radius + balls[b].radius;
    return {dot(d, d) - R * R, 2 * dot(d, u), dot(u, u) + dot(d, g), dot(u, g), dot(g, g) / 4};
  }

  void fly(const Long& t) {
    for (Ball& ball : balls) {
      if (!ball.free) continue;
      ball.now.p = ball.now.p + t * ball.now.v + t * t / 2 * gravity;
      ball.now.v = ball.now.v + t * gravity;
      turn(ball, t);
    }
  }
  // Constant spin in world axes: q = exp(w t / 2) q, the rotation on the left.
  static void turn(Ball& ball, const Long& t) {
    const Long rate = sqrt(dot(ball.w_world, ball.w_world));
    if (rate == 0) return;
    const Long c = cos(rate * t / 2), s = sin(rate * t / 2) / rate;
    const Long3 u = s * ball.w_world, v{ball.now.q[1], ball.now.q[2], ball.now.q[3]};
    const Long w = c * ball.now.q[0] - dot(u, v);
    const Long3 rest = c * v + ball.now.q[0] * u + cross(u, v);
    ball.now.q = {w, rest[0], rest[1], rest[2]};
  }

  // The relative velocity of the surfaces changes by
  //   J (1/m_a + 1/m_b)                          along n,
  //   T (1/m_a + 1/m_b + r_a^2/I_a + r_b^2/I_b)  across it;
  // T stops the slip, or has the size mu J.
  void collide(int a, int b) {
    Ball &one = balls[a], &other = balls[b];
    Long3 n;
    if (is_wall(a)) {
      n = std::find_if(walls.begin(), walls.end(), [&](const Wall& w) { return w.body == a; })->n;
    } else {
      n = other.now.p - one.now.p;
      n = 1 / sqrt(dot(n, n)) * n;
    }
    const PairLaw& law = pair_law(scenario.scene, a, b);
    const Long light = (one.free ? 1 / one.mass : Long(0)) + (other.free ? 1 / other.mass : Long(0));
    const Long3 arm_one = one.radius * n, arm_other = -other.radius * n;
    const Long3 u = other.now.v + cross(other.w_world, arm_other) - one.now.v - cross(one.w_world, arm_one);
    const Long approach = dot(other.now.v - one.now.v, n);
    const Long J = -(1 + Long(law.restitution)) * approach / light;
    Long3 slip = u - dot(u, n) * n;
    const Long speed = sqrt(dot(slip, slip));
    Long3 push = J * n;
    if (law.friction != 0 && speed > 0) {
      Long yields = light;
      for (const Ball* ball : {&one, &other})
        if (ball->free && ball->turns) yields += ball->radius * ball->radius / ball->moment;
      push = push - std::min(Long(law.friction * J), Long(speed / yields)) / speed * slip;
    }
    const auto kick = [&](Ball& ball, const Long3& arm, const Long3& impulse) {
      if (!ball.free) return;
      ball.now.v = ball.now.v + 1 / ball.mass * impulse;
      if (ball.turns && law.friction != 0) ball.w_world = ball.w_world + 1 / ball.moment * cross(arm, impulse);
    };
    kick(one, arm_one, Long(-1) * push);
    kick(other, arm_other, push);
  }

  // second: the next but one
  struct Next {
    Long t;
    int a = -1, b = -1;
    Long second;
  };

  Next next_impact(const Long& within, int last_a, int last_b) const {
    Next next{within, -1, -1, within};
    for (int a = 0; a < static_cast<int>(balls.size()); ++a)
      for (int b = 0; b < static_cast<int>(balls.size()); ++b) {
        if (a == b || is_wall(b) || (!is_wall(a) && b < a) || (!balls[a].free && !balls[b].free)) continue;
        Polynomial p = gap(a, b);
        // The gap of the pair that has just collided is 0 at the start; this root is divided out.
        const bool apart_now = a == last_a && b == last_b;
        if (apart_now) p.erase(p.begin());
        for (const Long& t : roots(p, 0, within)) {
          const Long later = t + within * 1e-40;
          if (!(value(p, later) < 0)) continue;  // the gap opens
          if (t < next.t) {
            next.second = next.t;
            next.t = t;
            next.a = a;
            next.b = b;
          } else {
            next.second = std::min(next.second, t);
          }
          break;
        }
      }
    return next;
  }

  std::vector<std::vector<LongBody>> run(std::int64_t samples, int most_impacts) {
    read();
    std::vector<std::vector<LongBody>> at;
    const auto record = [&] {
      auto& row = at.emplace_back();
      for (const Ball& ball : balls) {
        row.push_back(ball.now);
        row.back().w = turned_back(ball.now.q, ball.w_world);
      }
    };
    if (!refused.empty()) return at;
    for (int a = 0; a < static_cast<int>(balls.size()); ++a)
      for (int b = 0; b < static_cast<int>(balls.size()); ++b)
        if (a != b && !is_wall(b) && (balls[a].free || balls[b].free) && gap(a, b)[0] <= 0)
          refused = "contact at the start";
    if (!refused.empty()) return at;
    record();
    Long t = 0;
    int impacts = 0, a = -1, b = -1;
    std::int64_t sample = 1;
    while (sample <= samples) {
      const Long end = scenario.t_end_s;
      const Next next = next_impact(end - t, a, b);
      while (sample <= samples) {
        const Long target = end * sample / samples;
        if (next.a >= 0 && target >= t + next.t) break;
        const std::vector<Ball> kept = balls;
        fly(target - t);
        record();
        balls = kept;
        ++sample;
      }
      if (next.a < 0) break;
      if (++impacts > most_impacts) return refused = "more than " + std::to_string(most_impacts) + " impacts", at;
      if (next.second - next.t < end * 1e-14) return refused = "two impacts at one instant", at;
      const Long flight = next.t * (1 + moved);
      fly(flight);
      t += flight;
      a = next.a;
      b = next.b;
      collide(a, b);
    }
    return at;
  }
};

}  // namespace

Checked check_flights(const Scenario& scenario, std::int64_t samples, int most_impacts) {
  Flights exact{scenario, 0}, moved{scenario, Long("1e-50")};
  Checked made;
  made.values = exact.run(samples, most_impacts);
  const auto other = moved.run(samples, most_impacts);
  made.refused = !exact.refused.empty() ? exact.refused : moved.refused;
  if (!made.refused.empty()) return made;
  for (std::size_t k = 0; k < made.values.size(); ++k) {
    auto& own = made.own.emplace_back(made.values[k].size());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const LongBody &x = made.values[k][i], &y = other[k][i];
      for (int c = 0; c < 3; ++c) {
        own[i].p[c] = abs(x.p[c] - y.p[c]) + abs(x.p[c]) * 1e-50;
        own[i].v[c] = abs(x.v[c] - y.v[c]) + abs(x.v[c]) * 1e-50;
        own[i].w[c] = abs(x.w[c] - y.w[c]) + abs(x.w[c]) * 1e-50;
      }
      for (int c = 0; c < 4; ++c) own[i].q[c] = abs(x.q[c] - y.q[c]) + Long("1e-50");
    }
  }
  return made;
}

}  // namespace atwood::fuzz
