// Balls in uniform gravity that meet each other and fixed planes, rectangles and boxes: parabolas between impacts,
// whose instants are roots of quadratics; Newton's restitution and Coulomb's friction (E. J. Routh, Dynamics of a
// System of Rigid Bodies, art. 169 and 180).
//
// Two free balls fall alike, so their distance is that of straight motion. A ball meets a face where it descends
// through a radius over it, within its sides; where it could meet an edge instead, the solution gives up.
//
// At an impact the feet slide at s = u_t - (r_a W_a + r_b W_b) x n. The impulse is J along n, J = -(1 + e) u_n /
// (1/m_a + 1/m_b), and the lesser of mu J and |s| / (1/m_a + 1/m_b + r_a^2/I_a + r_b^2/I_b) against s, which keeps its
// direction. Impacts at one instant whose impulses act on each other follow the scene's convention: one after another,
// of the pairs that touch the one that closes fastest, at equal speeds the one first in order, until none closes
// (E. Mariotte, 1673); or together (J. J. Moreau, 1988). Without one the motion ends there, unless all of them agree.
#include <algorithm>
#include <numeric>
#include <type_traits>

#include "closed_form/obstacles.hpp"
#include "dynamics/complementarity.hpp"

namespace atwood::closed_form {

namespace {

// Impacts in a row during which the time advances by less than a unit in its last place: there is no progress.
constexpr int kMostStalled = 1000;
constexpr std::size_t kMostTold = 4000000;  // events: some 250 bytes each, twice
constexpr std::size_t kMostTried = 4;       // contacts of a group whose orders are all tried
constexpr int kMostBlows = 100000;          // of a group at one instant

template <class S> struct Ball {
  int body = -1;
  S radius{}, inverse_mass{}, inverse_inertia{};
  S t{};  // since when it flies as follows: its release, its last impact; held before
  Vec<S> p{}, v{}, w_B{};
  Quat<S> q{1, 0, 0, 0};
};

template <class S> Pose<S> fly(const Ball<S>& ball, const Vec<S>& g, S t) {
  const S since = t - ball.t;
  if (!(since > 0)) return {ball.p, ball.v, ball.w_B, ball.q};
  const S rate = norm(ball.w_B);
  return {ball.p + since * (ball.v + (since / 2) * g), ball.v + since * g, ball.w_B,
          rate == 0 ? ball.q : ball.q * turn((1 / rate) * ball.w_B, rate * since)};
}

template <class S> struct Meeting {
  bool happens = false;
  S t{}, closing{};           // speed
  int ball = -1, other = -1;  // other: a ball, or a face beyond them
  Vec<S> normal{};            // from ball to other
};

// Two bodies that touch now.
template <class S> struct Touch {
  int ball = -1, other = -1;     // other: a ball, or -1
  int body_a = -1, body_b = -1;  // a < b
  S sign{};                      // 1: ball is body_a
  Vec<S> normal{};               // from ball to other
};

template <class S> class Table {
 public:
  explicit Table(const Scenario& scenario)
      : scene_(scenario.scene), t_end_(scenario.t_end_s), g_(vec<S>(scene_.gravity_m_per_s2)) {
    gather();
  }

  Motion<S> play(const std::vector<S>& t_s) {
    motion_.misfit = misfit_;
    if (!motion_.misfit.empty()) return motion_;
    std::size_t next_sample = 0;
    for (;;) {
      const Meeting<S> next = first_meeting();
      const S until = next.happens && next.t <= t_end_ ? next.t : t_end_;
      pass_clear(until);
      if (stalled_ > kMostStalled)
        misfit_ = "the time does not advance over " + std::to_string(kMostStalled) + " impacts at t = " + at_now() +
                  ": what bounces there comes to rest";
      if (motion_.happenings.size() > kMostTold)
        misfit_ = "more impacts than the memory for " + std::to_string(kMostTold) + " of them holds";
      motion_.misfit = misfit_;
      if (!misfit_.empty()) return motion_;
      const bool last = !(next.happens && next.t <= t_end_);
      // Samples at the instant of an impact show what it leaves; the run's first one, the scene itself.
      while (next_sample < t_s.size() && (last || t_s[next_sample] < until || t_s[next_sample] == 0))
        sample(t_s[next_sample++]);
      if (last) return motion_;
      stalled_ = until - now_ <= 2 * unit_round_off<S>() * until ? stalled_ + 1 : 0;
      now_ = until;
      strike(next);
      if (!motion_.branch.empty()) {
        motion_.end_s = now_;
        return motion_;
      }
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
    const Ball<S>&a = balls_[j], &b = balls_[i];
    S from = larger(now_, larger(a.t, b.t));
    const Pose<S> pose_a = fly(a, g_, from), pose_b = fly(b, g_, from);
    const Vec<S> d = pose_b.p_WB - pose_a.p_WB, u = pose_b.v_WB - pose_a.v_WB, aside = cross(d, u);
    const S reach = a.radius + b.radius, closing = dot(d, u);
    const S inside = dot(u, u) * reach * reach - dot(aside, aside);
    if (!(closing < -still * norm(d) * norm(u)) || !(inside > 0)) return made;
    made.happens = true;
    made.t = from + larger(S(0), (norm(d) - reach) * (norm(d) + reach) / (sqrt(inside) - closing));
    made.closing = sqrt(inside) / reach;
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
    const S together = earliest + window(earliest);
    Meeting<S> first;
    for (const Meeting<S>& made : all)
      if (made.t <= together && made.closing > first.closing * (1 + 256 * unit_round_off<S>())) first = made;
    due_ = std::move(all);
    return first;
  }
  // Instants nearer than this are one.
  S window(S t) const { return 256 * unit_round_off<S>() * (t + S(1e-3) * t_end_); }
  std::string at_now() const { return format_double(static_cast<double>(now_)) + " s"; }

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

  // ---- impacts ----------------------------------------------------------------------------------------------------
  Touch<S> touch_of(int ball, int other, const Vec<S>& normal) const {
    Touch<S> made;
    const int count = static_cast<int>(balls_.size());
    int other_body = -1, left = other - count;
    if (other < count) other_body = balls_[other].body;
    for (const Obstacle<S>& obstacle : obstacles_) {
      if (other_body < 0 && left < static_cast<int>(obstacle.faces.size())) other_body = obstacle.body;
      left -= static_cast<int>(obstacle.faces.size());
    }
    const int body = balls_[ball].body;
    made = {ball,
            other < count ? other : -1,
            std::min(body, other_body),
            std::max(body, other_body),
            S(body < other_body ? 1 : -1),
            normal};
    return made;
  }

  // What touches now, in the order of the bodies. `hit` does, to round-off of the flight to it.
  std::vector<Touch<S>> touches(const Meeting<S>& hit) const {
    std::vector<Touch<S>> made{touch_of(hit.ball, hit.other, hit.normal)};
    const auto keep = [&](const Touch<S>& touch) {
      const Touch<S>& first = made.front();
      if (touch.body_a != first.body_a || touch.body_b != first.body_b || touch.other >= 0 ||
          dot(touch.normal, first.normal) < S(0.5))
        if (touch.body_a != first.body_a || touch.body_b != first.body_b || first.other < 0) made.push_back(touch);
    };
    std::vector<Pose<S>> poses;
    for (const Ball<S>& ball : balls_) poses.push_back(fly(ball, g_, now_));
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      const Pose<S>& here = poses[i];
      const S size = norm(here.p_WB) + balls_[i].radius;
      if (balls_[i].t > now_) continue;  // still held
      for (std::size_t j = 0; j < i; ++j) {
        if (balls_[j].t > now_) continue;
        const Vec<S> d = here.p_WB - poses[j].p_WB;
        const S far = norm(d), near = 256 * unit_round_off<S>() * (size + norm(poses[j].p_WB) + balls_[j].radius) +
                                      window(now_) * (norm(here.v_WB) + norm(poses[j].v_WB));
        if (far - balls_[i].radius - balls_[j].radius <= near)
          keep(touch_of(static_cast<int>(j), static_cast<int>(i), (1 / far) * d));
      }
      int index = static_cast<int>(balls_.size());
      for (const Obstacle<S>& obstacle : obstacles_)
        for (const Face<S>& face : obstacle.faces) {
          const S height = dot(face.n, here.p_WB) - face.offset - balls_[i].radius;
          const S near = 256 * unit_round_off<S>() * (size + magnitude(face.offset)) + window(now_) * norm(here.v_WB);
          if (magnitude(height) <= near && within_sides(face, here.p_WB))
            keep(touch_of(static_cast<int>(i), index, S(-1) * face.n));
          ++index;
        }
    }
    std::stable_sort(made.begin(), made.end(), [](const Touch<S>& a, const Touch<S>& b) {
      return a.body_a != b.body_a ? a.body_a < b.body_a : a.body_b < b.body_b;
    });
    return made;
  }

  const PairLaw& law_of(const Touch<S>& touch) const { return pair_law(scene_, touch.body_a, touch.body_b); }

  // Do their impulses act on each other?
  bool couple(const Touch<S>& one, const Touch<S>& other) const {
    const auto has = [](const Touch<S>& touch, int ball) {
      return ball >= 0 && (touch.ball == ball || touch.other == ball);
    };
    if (!has(other, one.ball) && !has(other, one.other)) return false;
    if (law_of(one).friction > 0 || law_of(other).friction > 0) return true;
    return magnitude(dot(one.normal, other.normal)) > 8 * unit_round_off<S>();
  }

  S closing(const Touch<S>& touch) const {
    const Vec<S> u = touch.other < 0 ? S(-1) * balls_[touch.ball].v : balls_[touch.other].v - balls_[touch.ball].v;
    return -dot(u, touch.normal);
  }
  S slow(const Touch<S>& touch) const {
    return still * (fast_ + norm(balls_[touch.ball].v) + (touch.other < 0 ? S(0) : norm(balls_[touch.other].v)));
  }

  // The earliest group of contacts that act on each other, `hit` among them.
  void strike(const Meeting<S>& hit) {
    const std::vector<Touch<S>> all = touches(hit);
    std::vector<Touch<S>> group;
    std::vector<bool> in(all.size(), false);
    for (std::size_t k = 0; k < all.size(); ++k)
      in[k] = all[k].ball == hit.ball && dot(all[k].normal, hit.normal) > S(0.5) &&
              all[k].other == (hit.other < static_cast<int>(balls_.size()) ? hit.other : -1);
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t k = 0; k < all.size(); ++k)
        for (std::size_t m = 0; m < all.size() && !in[k]; ++m)
          if (in[m] && couple(all[k], all[m])) in[k] = grown = true;
    }
    for (std::size_t k = 0; k < all.size(); ++k)
      if (in[k]) group.push_back(all[k]);
    fast_ = 0;
    for (const Touch<S>& touch : group) {
      if (law_of(touch).rolling_friction_m != 0) misfit_ = "rolling friction is not covered";
      for (const int at : {touch.ball, touch.other}) {
        if (at < 0) continue;
        Ball<S>& ball = balls_[at];
        const Pose<S> here = fly(ball, g_, now_);
        ball.p = here.p_WB, ball.v = here.v_WB, ball.q = here.q_WB, ball.t = larger(ball.t, now_);
        fast_ = larger(fast_, norm(ball.v));
      }
    }
    const std::size_t first = motion_.happenings.size();
    resolve(group);
    const S rival = rival_of(group);
    for (std::size_t k = first; k < motion_.happenings.size(); ++k) motion_.happenings[k].rival_s = rival;
  }

  // How much later the next contact that acts on the group would have been struck.
  S rival_of(const std::vector<Touch<S>>& group) const {
    S rival = -1;
    for (const Meeting<S>& other : due_) {
      const Touch<S> touch = touch_of(other.ball, other.other, other.normal);
      bool among = false, coupled = false;
      for (const Touch<S>& member : group) {
        among = among || (member.body_a == touch.body_a && member.body_b == touch.body_b);
        coupled = coupled || couple(member, touch);
      }
      if (!among && coupled && (rival < 0 || other.t - now_ < rival)) rival = larger(S(0), other.t - now_);
    }
    return rival;
  }

  void resolve(const std::vector<Touch<S>>& group) {
    const bool alone = group.size() == 1;
    if (!alone && scene_.simultaneous_impacts == SimultaneousImpacts::together) {
      if (!strike_together(group))
        motion_.branch = "simultaneous impacts solved together are not covered with friction or for more than " +
                         std::to_string(dynamics::kMaxSimultaneous) + " contacts";
      return;
    }
    const std::vector<Ball<S>> start = balls_;
    if (!strike_in_turn(group, {})) motion_.branch = "simultaneous impacts pair by pair have no end";
    if (alone || scene_.simultaneous_impacts == SimultaneousImpacts::sequential || !motion_.branch.empty()) return;
    const std::vector<Ball<S>> end = balls_;
    const std::size_t told = motion_.happenings.size();
    bool agree = group.size() <= kMostTried;
    std::vector<std::size_t> order(group.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    while (agree) {
      balls_ = start;
      agree = strike_in_turn(group, order) && same(end, start);
      if (!std::next_permutation(order.begin(), order.end())) break;
    }
    if (agree) {
      balls_ = start;
      agree = strike_together(group) && same(end, start);
    }
    balls_ = end;
    motion_.happenings.resize(told);
    if (agree) return;
    motion_.branch = "the outcome of simultaneous impacts (";
    for (std::size_t k = 0; k < group.size() && k < 3; ++k)
      motion_.branch += (k == 0 ? "`" : ", `") + scene_.bodies[group[k].body_a].name + "` with `" +
                        scene_.bodies[group[k].body_b].name + "`";
    motion_.branch += ") hangs on a convention: [world] simultaneous_impacts names none";
  }

  bool same(const std::vector<Ball<S>>& end, const std::vector<Ball<S>>& start) const {
    for (std::size_t i = 0; i < end.size(); ++i) {
      const S speeds = norm(end[i].v) + norm(start[i].v) + fast_, spins = norm(end[i].w_B) + norm(start[i].w_B);
      if (norm(end[i].v - balls_[i].v) > 1024 * unit_round_off<S>() * speeds) return false;
      if (norm(end[i].w_B - balls_[i].w_B) > 1024 * unit_round_off<S>() * spins) return false;
    }
    return true;
  }

  // `order`: of preference among those that close; empty: the fastest.
  bool strike_in_turn(const std::vector<Touch<S>>& group, const std::vector<std::size_t>& order) {
    for (int blows = 0; blows < kMostBlows; ++blows) {
      const Touch<S>* next = nullptr;
      S fastest = 0;
      for (std::size_t k = 0; k < group.size(); ++k) {
        const Touch<S>& touch = group[order.empty() ? k : order[k]];
        const S speed = closing(touch);
        if (!(speed > slow(touch))) continue;
        if (next != nullptr && (!order.empty() || !(speed > fastest * (1 + 256 * unit_round_off<S>())))) continue;
        next = &touch;
        fastest = speed;
      }
      if (next == nullptr) return true;
      blow(*next);
    }
    return false;
  }

  // Moreau's law: 0 <= Lambda_i, v_i+ + e_i min(v_i-, 0) >= 0, one of them 0. False: not covered.
  bool strike_together(const std::vector<Touch<S>>& group) {
    const std::size_t n = group.size();
    std::vector<std::vector<S>> A(n, std::vector<S>(n, S(0)));
    std::vector<S> q, before, impulse;
    S speed = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (law_of(group[i]).friction > 0) return false;
      before.push_back(-closing(group[i]));
      q.push_back(before[i] + (before[i] < 0 ? S(law_of(group[i]).restitution) * before[i] : S(0)));
      speed = larger(speed, magnitude(q[i]));
      for (std::size_t j = 0; j < n; ++j)
        for (const int of : {group[i].ball, group[i].other})
          for (const int by : {group[j].ball, group[j].other})
            if (of >= 0 && of == by)
              A[i][j] = A[i][j] + S(of == group[i].ball ? -1 : 1) * S(by == group[j].ball ? -1 : 1) *
                                      balls_[of].inverse_mass * dot(group[i].normal, group[j].normal);
    }
    if (!dynamics::solve_lcp<S>(A, q, still * speed, still * S(n), impulse)) return false;
    for (std::size_t i = 0; i < n; ++i)
      for (const int at : {group[i].ball, group[i].other})
        if (at >= 0)
          balls_[at].v =
              balls_[at].v + (S(at == group[i].ball ? -1 : 1) * balls_[at].inverse_mass * impulse[i]) * group[i].normal;
    for (std::size_t i = 0; i < n; ++i)
      if (impulse[i] > 0) tell(group[i], impulse[i], S(0), before[i], -closing(group[i]));
    return true;
  }

  void blow(const Touch<S>& touch) {
    const PairLaw& law = law_of(touch);
    Ball<S>* two[2] = {&balls_[touch.ball], touch.other < 0 ? nullptr : &balls_[touch.other]};
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
    const S speed_in = -dot(u, touch.normal), impulse = (1 + S(law.restitution)) * speed_in / yields;
    const Vec<S> sliding = u + speed_in * touch.normal - cross(spin, touch.normal);
    const S speed = norm(sliding);
    S rub = 0;
    Vec<S> along{};
    if (speed > still * (norm(u) + norm(spin))) {
      along = (1 / speed) * sliding;
      rub = S(law.friction) * impulse < speed / (yields + turns) ? S(law.friction) * impulse : speed / (yields + turns);
    }
    for (int k = 0; k < 2; ++k) {
      if (two[k] == nullptr) continue;
      two[k]->v = two[k]->v + (S(k == 0 ? -1 : 1) * two[k]->inverse_mass) * (impulse * touch.normal - rub * along);
      if (rub == 0) continue;
      const Vec<S> about = cross(touch.normal, along);  // the arm times the impulse points this way for both
      two[k]->w_B =
          two[k]->w_B + (rub * two[k]->radius * two[k]->inverse_inertia) * rotate(conjugate(two[k]->q), about);
    }
    tell(touch, impulse, rub, -speed_in, S(law.restitution) * speed_in);
  }

  void tell(const Touch<S>& touch, S impulse, S rub, S before, S after) {
    Happening<S> made;
    made.t_s = now_;
    made.body_a = touch.body_a;
    made.body_b = touch.body_b;
    made.x_W = balls_[touch.ball].p + balls_[touch.ball].radius * touch.normal;
    made.normal_W = touch.sign * touch.normal;
    made.impulse_n_N_s = impulse;
    made.impulse_t_N_s = rub;
    made.vn_before_m_per_s = before;
    made.vn_after_m_per_s = after;
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
  S t_end_, now_{}, fast_{};  // fast_: of the group's balls before their impact
  int stalled_ = 0;
  std::vector<Meeting<S>> due_;
  Vec<S> g_;
  std::vector<Ball<S>> balls_;
  std::vector<Obstacle<S>> obstacles_;
  std::string misfit_;
  Motion<S> motion_;
};

template <class S> Motion<S> solve(const Scenario& scenario, const std::vector<S>& t_s) {
  return Table<S>(scenario).play(t_s);
}

}  // namespace

Solution ball_flights() {
  return {"ball-flights",
          "balls between impacts on parabolas, impacts at roots of quadratics, Newton's law and Coulomb's: "
          "Routh, art. 169, 180",
          feature::kFlying | feature::kTouching, solve<Narrow>, solve<Wide>};
}

}  // namespace atwood::closed_form
