// Balls in uniform gravity that meet each other and fixed planes, rectangles and boxes: parabolas between impacts,
// whose instants are roots of quadratics; Newton's restitution and Coulomb's friction (E. J. Routh, Dynamics of a
// System of Rigid Bodies, art. 169 and 180).
//
// Two free balls fall alike, so their distance is that of straight motion. A ball meets a face where it descends
// through a radius over it, within its sides; where it could meet an edge instead, the solution gives up.
//
// At an impact the feet slide at s = u_t - (r_a W_a + r_b W_b) x n. The impulse is J along n, J = -(1 + e) u_n /
// (1/m_a + 1/m_b), and the lesser of mu J and |s| / (1/m_a + 1/m_b + r_a^2/I_a + r_b^2/I_b) against s, which keeps its
// direction. Impacts at one instant come one after the other: of the pairs that touch the one that closes fastest, at
// equal speeds the one first in order, until none closes (E. Mariotte, 1673).
#include <type_traits>

#include "closed_form/obstacles.hpp"

namespace atwood::closed_form {

namespace {

constexpr std::size_t most_impacts = 20000;

template <class S>
struct Ball {
  int body = -1;
  S radius{}, inverse_mass{}, inverse_inertia{};
  S t{};                       // since when it flies as follows: its release, its last impact; held before
  Vec<S> p{}, v{}, w_B{};
  Quat<S> q{1, 0, 0, 0};
};

template <class S>
Pose<S> fly(const Ball<S>& ball, const Vec<S>& g, S t) {
  const S since = t - ball.t;
  if (!(since > 0)) return {ball.p, ball.v, ball.w_B, ball.q};
  const S rate = norm(ball.w_B);
  return {ball.p + since * (ball.v + (since / 2) * g), ball.v + since * g, ball.w_B,
          rate == 0 ? ball.q : ball.q * turn((1 / rate) * ball.w_B, rate * since)};
}

template <class S>
struct Meeting {
  bool happens = false;
  S t{}, closing{};            // speed
  int ball = -1, other = -1;   // other: a ball, or a face beyond them
  Vec<S> normal{};             // from ball to other
};

template <class S>
class Table {
 public:
  explicit Table(const Scenario& scenario)
      : scene_(scenario.scene), t_end_(scenario.t_end_s), g_(vec<S>(scene_.gravity_m_per_s2)) {
    gather();
  }

  Motion<S> play(const std::vector<S>& t_s) {
    motion_.misfit = misfit_;
    if (!motion_.misfit.empty()) return motion_;
    std::size_t next_sample = 0;
    for (std::size_t impacts = 0;; ++impacts) {
      const Meeting<S> next = first_meeting();
      const S until = next.happens && next.t <= t_end_ ? next.t : t_end_;
      pass_clear(until);
      if (impacts == most_impacts)
        misfit_ = "more than " + std::to_string(most_impacts) + " impacts: does a ball come to rest?";
      motion_.misfit = misfit_;
      if (!misfit_.empty()) return motion_;
      const bool last = !(next.happens && next.t <= t_end_);
      // Samples at the instant of an impact show what it leaves; the run's first one, the scene itself.
      while (next_sample < t_s.size() && (last || t_s[next_sample] < until || t_s[next_sample] == 0))
        sample(t_s[next_sample++]);
      if (last) return motion_;
      now_ = until;
      strike(next);
    }
  }

 private:
  void gather() {
    for (std::size_t i = 0; i < scene_.bodies.size() && misfit_.empty(); ++i) {
      const Body& body = scene_.bodies[i];
      const int at = static_cast<int>(i);
      if (body.fixed) {
        if (body.shape.index() != 0 && !add_obstacle(body, at, obstacles_))
          misfit_ = "`" + body.name + "` is neither a fixed plane nor a rectangle nor a box";
        continue;
      }
      const auto* sphere = std::get_if<Sphere>(&body.shape);
      if (sphere == nullptr) misfit_ = "`" + body.name + "` is no ball";
      else if (!turns_like_a_ball(body)) misfit_ = "`" + body.name + "` has moments of inertia that are not all alike";
      for (const Force& force : scene_.forces)
        if (acts_on(force, at)) misfit_ = named(scene_, force, at) + " is not covered";
      if (!misfit_.empty()) return;
      const Pose<S> start = initial_pose<S>(body);
      balls_.push_back({at, S(sphere->radius_m), 1 / S(body.mass_kg),
                        rotates(body) ? 1 / S(body.inertia_kg_m2[0]) : S(0), S(body.release_s), start.p_WB, start.v_WB,
                        start.w_WB_B, start.q_WB});
    }
    for (std::size_t i = 0; i < balls_.size() && misfit_.empty(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const S reach = balls_[i].radius + balls_[j].radius;
        if (norm(balls_[i].p - balls_[j].p) < reach * (1 - 4 * unit_round_off<double>())) overlap(i, balls_[j].body);
      }
      for (const Obstacle<S>& obstacle : obstacles_) {
        const S gap = distance(obstacle, balls_[i].p) - balls_[i].radius;
        const S noise = 8 * unit_round_off<double>() * (norm(balls_[i].p) + balls_[i].radius);
        if (gap < -noise || gap < -1e-9 * balls_[i].radius) overlap(i, obstacle.body);
      }
    }
  }
  void overlap(std::size_t ball, int other) {
    misfit_ =
        "`" + scene_.bodies[balls_[ball].body].name + "` overlaps `" + scene_.bodies[other].name + "` at the start";
  }

  // Both fly from the later of `now` and their releases on; a held one is a target at rest.
  Meeting<S> meeting(std::size_t i, std::size_t j) const {
    Meeting<S> made;
    const Ball<S> &a = balls_[j], &b = balls_[i];
    S from = larger(now_, larger(a.t, b.t));
    const Pose<S> pose_a = fly(a, g_, from), pose_b = fly(b, g_, from);
    const Vec<S> d = pose_b.p_WB - pose_a.p_WB, u = pose_b.v_WB - pose_a.v_WB, aside = cross(d, u);
    const S reach = a.radius + b.radius, closing = dot(d, u);
    const S inside = dot(u, u) * reach * reach - dot(aside, aside);
    if (!(closing < -still * norm(d) * norm(u)) || !(inside > 0)) return made;
    made.happens = true;
    made.t = from + larger(S(0), (norm(d) - reach) * (norm(d) + reach) / (root(inside) - closing));
    made.closing = root(inside) / reach;
    made.ball = static_cast<int>(j);
    made.other = static_cast<int>(i);
    made.normal = (1 / reach) * (d + (made.t - from) * u);
    return made;
  }

  Meeting<S> meeting(std::size_t i, const Face<S>& face, int index) {
    Meeting<S> made;
    const Ball<S>& ball = balls_[i];
    const S from = larger(now_, ball.t);
    const Pose<S> pose = fly(ball, g_, from);
    S speed{};
    const S pull = -dot(face.n, g_);
    const S height = dot(face.n, pose.p_WB) - face.offset - ball.radius;
    const S wait = descends<S>(height, dot(face.n, pose.v_WB), pull, still * (norm(pose.p_WB) + ball.radius), speed);
    if (wait < 0 || !within_sides(face, fly(ball, g_, from + wait).p_WB)) return made;
    if (!(speed > still * (norm(pose.v_WB) + wait * norm(g_)))) {
      if (pull > 0) misfit_ = "`" + scene_.bodies[ball.body].name + "` comes to rest";
      return made;
    }
    made = {true, from + wait, speed, static_cast<int>(i), index, S(-1) * face.n};
    return made;
  }

  // The first of all; among those at its instant the one that closes fastest.
  Meeting<S> first_meeting() {
    std::vector<Meeting<S>> all;
    const auto keep = [&](const Meeting<S>& made) {
      if (made.happens) all.push_back(made);
    };
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) keep(meeting(i, j));
      int index = static_cast<int>(balls_.size());
      for (const Obstacle<S>& obstacle : obstacles_)
        for (const Face<S>& face : obstacle.faces) keep(meeting(i, face, index++));
    }
    if (all.empty()) return {};
    S earliest = all.front().t;
    for (const Meeting<S>& made : all) earliest = made.t < earliest ? made.t : earliest;
    const S together = earliest + 256 * unit_round_off<S>() * (earliest + S(1e-3) * t_end_);
    Meeting<S> first;
    for (const Meeting<S>& made : all)
      if (made.t <= together && made.closing > first.closing * (1 + 256 * unit_round_off<S>())) first = made;
    return first;
  }

  // What quadratics do not see until `until`: edges and corners, and balls that are held.
  void pass_clear(S until) {
    for (std::size_t i = 0; i < balls_.size() && misfit_.empty(); ++i) {
      const Ball<S>& ball = balls_[i];
      const S from = larger(now_, ball.t);
      if (!(from < until)) continue;
      const Arc<S> arc{from, until, fly(ball, g_, from).p_WB, fly(ball, g_, from).v_WB, g_};
      for (const Obstacle<S>& obstacle : obstacles_)
        if (meets_an_edge(obstacle, ball.radius, arc))
          misfit_ =
              "`" + scene_.bodies[ball.body].name + "` may meet an edge of `" + scene_.bodies[obstacle.body].name + "`";
      for (const Ball<S>& held : balls_) {
        if (!(held.t > from)) continue;
        const Arc<S> part{from, until < held.t ? until : held.t, arc.p, arc.v, g_};
        const auto between = [&](const Vec<S>& p) { return norm(p - held.p); };
        if (!stays_clear<S>(part, ball.radius + held.radius, between))
          misfit_ = "`" + scene_.bodies[ball.body].name + "` may meet `" + scene_.bodies[held.body].name +
                    "`, which is still held";
      }
    }
  }

  void strike(const Meeting<S>& hit) {
    Ball<S>* two[2] = {&balls_[hit.ball], nullptr};
    int other_body = -1;
    if (hit.other < static_cast<int>(balls_.size())) {
      two[1] = &balls_[hit.other];
      other_body = two[1]->body;
    } else {
      int left = hit.other - static_cast<int>(balls_.size());
      for (const Obstacle<S>& obstacle : obstacles_) {
        if (other_body < 0 && left < static_cast<int>(obstacle.faces.size())) other_body = obstacle.body;
        left -= static_cast<int>(obstacle.faces.size());
      }
    }
    const PairLaw& law = pair_law(scene_, two[0]->body, other_body);
    if (law.rolling_friction_m != 0) misfit_ = "rolling friction is not covered";
    for (Ball<S>* ball : two) {
      if (ball == nullptr) continue;
      const Pose<S> here = fly(*ball, g_, now_);
      ball->p = here.p_WB, ball->v = here.v_WB, ball->q = here.q_WB, ball->t = now_;
    }
    // The relative velocity of the feet, other minus ball.
    Vec<S> u{}, spin{};
    S yields{}, turns{};
    for (int k = 0; k < 2; ++k) {
      if (two[k] == nullptr) continue;
      u = u + S(k == 0 ? -1 : 1) * two[k]->v;
      spin = spin + two[k]->radius * rotate(two[k]->q, two[k]->w_B);
      yields = yields + two[k]->inverse_mass;
      turns = turns + two[k]->radius * two[k]->radius * two[k]->inverse_inertia;
    }
    const S closing = -dot(u, hit.normal), impulse = (1 + S(law.restitution)) * closing / yields;
    const Vec<S> sliding = u + closing * hit.normal - cross(spin, hit.normal);
    const S speed = norm(sliding);
    S rub = 0;
    Vec<S> along{};
    if (speed > still * (norm(u) + norm(spin))) {
      along = (1 / speed) * sliding;
      rub = S(law.friction) * impulse < speed / (yields + turns) ? S(law.friction) * impulse : speed / (yields + turns);
    }
    for (int k = 0; k < 2; ++k) {
      if (two[k] == nullptr) continue;
      two[k]->v = two[k]->v + (S(k == 0 ? -1 : 1) * two[k]->inverse_mass) * (impulse * hit.normal - rub * along);
      if (rub == 0) continue;
      const Vec<S> about = cross(hit.normal, along);  // the arm times the impulse points this way for both
      two[k]->w_B =
          two[k]->w_B + (rub * two[k]->radius * two[k]->inverse_inertia) * rotate(conjugate(two[k]->q), about);
    }
    Happening<S> made;
    made.t_s = now_;
    const bool in_order = two[0]->body < other_body;
    made.body_a = in_order ? two[0]->body : other_body;
    made.body_b = in_order ? other_body : two[0]->body;
    made.x_W = two[0]->p + two[0]->radius * hit.normal;
    made.normal_W = S(in_order ? 1 : -1) * hit.normal;
    made.impulse_n_N_s = impulse;
    made.impulse_t_N_s = rub;
    made.vn_before_m_per_s = -closing;
    made.vn_after_m_per_s = S(law.restitution) * closing;
    motion_.happenings.push_back(made);
  }

  void sample(S t) {
    auto& poses = motion_.poses.emplace_back();
    for (const Body& body : scene_.bodies) poses.push_back(initial_pose<S>(body));
    for (const Ball<S>& ball : balls_) poses[ball.body] = fly(ball, g_, t);
  }

  // Slower than this part of the speeds at hand is round-off.
  static constexpr double still = 64 * (std::is_same_v<S, Wide> ? 0x1p-113 : 0x1p-64);
  const Scene& scene_;
  S t_end_, now_{};
  Vec<S> g_;
  std::vector<Ball<S>> balls_;
  std::vector<Obstacle<S>> obstacles_;
  std::string misfit_;
  Motion<S> motion_;
};

template <class S>
Motion<S> solve(const Scenario& scenario, const std::vector<S>& t_s) {
  return Table<S>(scenario).play(t_s);
}

}  // namespace

Solution ball_flights() {
  return {"ball-flights",
          "balls between impacts on parabolas, impacts at roots of quadratics, Newton's law and Coulomb's: "
          "Routh, art. 169, 180",
          feature::flying | feature::touching, solve<Narrow>, solve<Wide>};
}

}  // namespace atwood::closed_form
