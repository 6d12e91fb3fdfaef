// Balls in uniform gravity that collide with each other and with fixed planes, rectangles and boxes: parabolas between
// impacts, whose times are roots of quadratics; the outcome of impacts is in ball_impacts.hpp.
//
// Two free balls have the same acceleration, so that their relative motion is uniform. A ball hits a face where its
// height over the face decreases through its radius, within the sides of the face. A ball that could hit an edge is
// refused.
#include <algorithm>

#include "closed_form/ball_impacts.hpp"
#include "closed_form/obstacles.hpp"

namespace atwood::closed_form {

namespace {

// Impacts in a row between which the time does not advance by a unit in its last place.
constexpr int kMaxStalled = 1000;
constexpr std::size_t kMaxEvents = 4000000;  // each takes some 250 bytes in each of two motions

template <class S> struct PredictedImpact {
  bool happens = false;
  S t{}, approach_speed{};
  int ball = -1, other = -1;  // indices of balls; from the number of balls on `other` counts faces of obstacles
  Vec<S> normal{};            // from ball to other
};

template <class S> class BallFlights {
 public:
  explicit BallFlights(const Scenario& scenario)
      : scene_(scenario.scene), t_end_(scenario.t_end_s), g_(vec<S>(scene_.gravity_m_per_s2)) {
    read_scene();
  }

  Motion<S> solve(const std::vector<S>& t_s) {
    motion_.refusal = refusal_;
    if (!motion_.refusal.empty()) return motion_;
    std::size_t next_sample = 0;
    for (;;) {
      const PredictedImpact<S> next = first_impact();
      const S until = next.happens && next.t <= t_end_ ? next.t : t_end_;
      check_edges_and_held(until);
      if (stalled_ > kMaxStalled)
        refusal_ = "the time does not advance over " + std::to_string(kMaxStalled) + " impacts at t = " + at_now() +
                   ": a bouncing ball comes to rest, which is not covered";
      if (motion_.events.size() > kMaxEvents)
        refusal_ = "more than " + std::to_string(kMaxEvents) + " impacts are not covered";
      motion_.refusal = refusal_;
      if (!refusal_.empty()) return motion_;
      const bool last = !(next.happens && next.t <= t_end_);
      // A sample at the time of an impact has the state after it; the sample at t = 0 has the initial state.
      while (next_sample < t_s.size() && (last || t_s[next_sample] < until || t_s[next_sample] == 0))
        sample(t_s[next_sample++]);
      if (last) return motion_;
      stalled_ = until - now_ <= 2 * unit_round_off<S>() * until ? stalled_ + 1 : 0;
      now_ = until;
      resolve_group_of(next);
      if (!motion_.undecided.empty()) {
        motion_.end_s = now_;
        return motion_;
      }
    }
  }

 private:
  void read_scene() {
    for (std::size_t i = 0; i < scene_.bodies.size() && refusal_.empty(); ++i) {
      const Body& body = scene_.bodies[i];
      const int at = static_cast<int>(i);
      if (body.fixed) {
        if (body.shape.index() != 0 && !add_obstacle(body, at, obstacles_))
          refusal_ = "`" + body.name + "` is fixed and has another shape: expected a plane, a rectangle or a box";
        continue;
      }
      const auto* sphere = std::get_if<Sphere>(&body.shape);
      if (sphere == nullptr) refusal_ = "`" + body.name + "` is free and has another shape: expected a sphere";
      else if (!has_spherical_inertia(body))
        refusal_ = "`" + body.name + "` has different principal moments of inertia";
      for (const Force& force : scene_.forces)
        if (acts_on(force, at)) refusal_ = force_on_body(scene_, force, at) + " is not covered";
      if (!refusal_.empty()) return;
      const Pose<S> start = initial_pose<S>(body);
      balls_.push_back({at, S(sphere->radius_m), 1 / S(body.mass_kg),
                        rotates(body) ? 1 / S(body.inertia_kg_m2[0]) : S(0), S(body.release_s), start.p_WB, start.v_WB,
                        start.w_WB_B, start.q_WB});
    }
    for (std::size_t i = 0; i < balls_.size() && refusal_.empty(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const S radii = balls_[i].radius + balls_[j].radius;
        if (norm(balls_[i].p - balls_[j].p) < radii * (1 - 4 * unit_round_off<double>())) overlap(i, balls_[j].body);
      }
      for (const Obstacle<S>& obstacle : obstacles_) {
        const S gap = distance(obstacle, balls_[i].p) - balls_[i].radius;
        const S noise = 8 * unit_round_off<double>() * (norm(balls_[i].p) + balls_[i].radius);
        if (gap < -noise || gap < -1e-9 * balls_[i].radius) overlap(i, obstacle.body);
      }
    }
  }
  void overlap(std::size_t ball, int other) {
    refusal_ =
        "`" + scene_.bodies[balls_[ball].body].name + "` overlaps `" + scene_.bodies[other].name + "` at the start";
  }

  // The impact of two balls, both in flight from the later of `now` and their releases. check_edges_and_held() sees to
  // balls before their release.
  PredictedImpact<S> predict_impact(std::size_t i, std::size_t j) const {
    PredictedImpact<S> made;
    const Ball<S>&a = balls_[j], &b = balls_[i];
    S from = larger(now_, larger(a.t, b.t));
    const Pose<S> pose_a = pose_at(a, g_, from), pose_b = pose_at(b, g_, from);
    const Vec<S> d = pose_b.p_WB - pose_a.p_WB, u = pose_b.v_WB - pose_a.v_WB, aside = cross(d, u);
    const S radii = a.radius + b.radius, approach_speed = dot(d, u);
    const S discriminant = dot(u, u) * radii * radii - dot(aside, aside);
    if (!(approach_speed < -kSpeedRoundOff<S> * norm(d) * norm(u)) || !(discriminant > 0)) return made;
    made.happens = true;
    const S wait = larger(S(0), (norm(d) - radii) * (norm(d) + radii) / (sqrt(discriminant) - approach_speed));
    const Vec<S> apart = d + wait * u;  // of length R, but for balls that touch to round-off
    made.t = from + wait;
    made.approach_speed = wait > 0 ? sqrt(discriminant) / radii : -approach_speed / norm(d);
    made.ball = static_cast<int>(j);
    made.other = static_cast<int>(i);
    made.normal = (1 / norm(apart)) * apart;
    return made;
  }

  // The impact of a ball with a face. A ball that stays in contact is refused.
  PredictedImpact<S> predict_impact(std::size_t i, const Face<S>& face, int index) {
    PredictedImpact<S> made;
    const Ball<S>& ball = balls_[i];
    const S from = larger(now_, ball.t);
    const Pose<S> pose = pose_at(ball, g_, from);
    S speed{};
    const S acceleration = -dot(face.n, g_);
    const S height = dot(face.n, pose.p_WB) - face.offset - ball.radius;
    const S wait = descent_time<S>(height, dot(face.n, pose.v_WB), acceleration,
                                   kSpeedRoundOff<S> * (norm(pose.p_WB) + ball.radius), speed);
    if (wait < 0 || !within_sides(face, pose_at(ball, g_, from + wait).p_WB)) return made;
    if (!(speed > kSpeedRoundOff<S> * (norm(pose.v_WB) + wait * norm(g_)))) {
      if (acceleration > 0) refusal_ = "`" + scene_.bodies[ball.body].name + "` comes to rest";
      return made;
    }
    made = {true, from + wait, speed, static_cast<int>(i), index, S(-1) * face.n};
    return made;
  }

  // The earliest impact; among those at the same time the one with the fastest approach.
  PredictedImpact<S> first_impact() {
    std::vector<PredictedImpact<S>> all;
    const auto keep = [&](const PredictedImpact<S>& made) {
      if (made.happens) all.push_back(made);
    };
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) keep(predict_impact(i, j));
      int index = static_cast<int>(balls_.size());
      for (const Obstacle<S>& obstacle : obstacles_)
        for (const Face<S>& face : obstacle.faces) keep(predict_impact(i, face, index++));
    }
    if (all.empty()) return {};
    S earliest = all.front().t;
    for (const PredictedImpact<S>& made : all) earliest = made.t < earliest ? made.t : earliest;
    const S together = earliest + window(earliest);
    PredictedImpact<S> first;
    for (const PredictedImpact<S>& made : all)
      if (made.t <= together && made.approach_speed > first.approach_speed * (1 + 256 * unit_round_off<S>()))
        first = made;
    predicted_ = std::move(all);
    return first;
  }
  // Times closer than this are equal.
  S window(S t) const { return 256 * unit_round_off<S>() * (t + S(1e-3) * t_end_); }
  std::string at_now() const { return format_double(static_cast<double>(now_)) + " s"; }

  // Refuses what the quadratics do not cover until `until`: impacts with edges and corners, and with balls before their
  // release.
  void check_edges_and_held(S until) {
    for (std::size_t i = 0; i < balls_.size() && refusal_.empty(); ++i) {
      const Ball<S>& ball = balls_[i];
      const S from = larger(now_, ball.t);
      if (!(from < until)) continue;
      const Arc<S> arc{from, until, pose_at(ball, g_, from).p_WB, pose_at(ball, g_, from).v_WB, g_};
      for (const Obstacle<S>& obstacle : obstacles_)
        if (may_meet_edge(obstacle, ball.radius, arc))
          refusal_ =
              "`" + scene_.bodies[ball.body].name + "` may hit an edge of `" + scene_.bodies[obstacle.body].name + "`";
      for (const Ball<S>& held : balls_) {
        if (!(held.t > from)) continue;
        const Arc<S> part{from, until < held.t ? until : held.t, arc.p, arc.v, g_};
        const auto between = [&](const Vec<S>& p) { return norm(p - held.p); };
        if (!stays_clear<S>(part, ball.radius + held.radius, between))
          refusal_ = "`" + scene_.bodies[ball.body].name + "` may hit `" + scene_.bodies[held.body].name +
                     "` before its release";
      }
    }
  }

  // ---- impacts ----------------------------------------------------------------------------------------------------
  BallContact<S> make_contact(int ball, int other, const Vec<S>& normal) const {
    BallContact<S> made;
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

  // All contacts now, in the order of the bodies; `impact` is one of them, whatever the round-off of the flights to it.
  std::vector<BallContact<S>> contacts_now(const PredictedImpact<S>& impact) const {
    std::vector<BallContact<S>> made{make_contact(impact.ball, impact.other, impact.normal)};
    const auto keep = [&](const BallContact<S>& contact) {
      const BallContact<S>& first = made.front();
      if (contact.body_a != first.body_a || contact.body_b != first.body_b || contact.other >= 0 ||
          dot(contact.normal, first.normal) < S(0.5))
        if (contact.body_a != first.body_a || contact.body_b != first.body_b || first.other < 0)
          made.push_back(contact);
    };
    std::vector<Pose<S>> poses;
    for (const Ball<S>& ball : balls_) poses.push_back(pose_at(ball, g_, now_));
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
          keep(make_contact(static_cast<int>(j), static_cast<int>(i), (1 / far) * d));
      }
      int index = static_cast<int>(balls_.size());
      for (const Obstacle<S>& obstacle : obstacles_)
        for (const Face<S>& face : obstacle.faces) {
          const S height = dot(face.n, here.p_WB) - face.offset - balls_[i].radius;
          const S near = 256 * unit_round_off<S>() * (size + magnitude(face.offset)) + window(now_) * norm(here.v_WB);
          if (magnitude(height) <= near && within_sides(face, here.p_WB))
            keep(make_contact(static_cast<int>(i), index, S(-1) * face.n));
          ++index;
        }
    }
    std::stable_sort(made.begin(), made.end(), [](const BallContact<S>& a, const BallContact<S>& b) {
      return a.body_a != b.body_a ? a.body_a < b.body_a : a.body_b < b.body_b;
    });
    return made;
  }

  // Resolves the group of coupled contacts that contains `impact`.
  void resolve_group_of(const PredictedImpact<S>& impact) {
    const std::vector<BallContact<S>> all = contacts_now(impact);
    std::vector<BallContact<S>> group;
    std::vector<bool> in(all.size(), false);
    for (std::size_t k = 0; k < all.size(); ++k)
      in[k] = all[k].ball == impact.ball && dot(all[k].normal, impact.normal) > S(0.5) &&
              all[k].other == (impact.other < static_cast<int>(balls_.size()) ? impact.other : -1);
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t k = 0; k < all.size(); ++k)
        for (std::size_t m = 0; m < all.size() && !in[k]; ++m)
          if (in[m] && impacts_.coupled(all[k], all[m])) in[k] = grown = true;
    }
    for (std::size_t k = 0; k < all.size(); ++k)
      if (in[k]) group.push_back(all[k]);
    for (const BallContact<S>& contact : group) {
      if (impacts_.law_of(contact).rolling_friction_m != 0) refusal_ = "rolling friction is not covered";
      for (const int at : {contact.ball, contact.other}) {
        if (at < 0) continue;
        Ball<S>& ball = balls_[at];
        const Pose<S> here = pose_at(ball, g_, now_);
        ball.p = here.p_WB, ball.v = here.v_WB, ball.q = here.q_WB, ball.t = larger(ball.t, now_);
      }
    }
    const std::size_t first = motion_.events.size();
    motion_.undecided = impacts_.resolve(group, now_, motion_.events);
    const S delay = coupled_delay(group);
    for (std::size_t k = first; k < motion_.events.size(); ++k) motion_.events[k].coupled_delay_s = delay;
  }

  // The time until the next impact that is coupled with the group; negative: there is none.
  S coupled_delay(const std::vector<BallContact<S>>& group) const {
    S delay = -1;
    for (const PredictedImpact<S>& other : predicted_) {
      const BallContact<S> contact = make_contact(other.ball, other.other, other.normal);
      bool member_itself = false, acts = false;
      for (const BallContact<S>& member : group) {
        member_itself = member_itself || (member.body_a == contact.body_a && member.body_b == contact.body_b);
        acts = acts || impacts_.coupled(member, contact);
      }
      if (!member_itself && acts && (delay < 0 || other.t - now_ < delay)) delay = larger(S(0), other.t - now_);
    }
    return delay;
  }

  void sample(S t) {
    auto& poses = motion_.poses.emplace_back();
    for (const Body& body : scene_.bodies) poses.push_back(initial_pose<S>(body));
    for (const Ball<S>& ball : balls_) poses[ball.body] = pose_at(ball, g_, t);
  }

  const Scene& scene_;
  S t_end_, now_{};
  int stalled_ = 0;
  std::vector<PredictedImpact<S>> predicted_;
  Vec<S> g_;
  std::vector<Ball<S>> balls_;
  BallImpacts<S> impacts_{scene_, balls_};
  std::vector<Obstacle<S>> obstacles_;
  std::string refusal_;
  Motion<S> motion_;
};

template <class S> Motion<S> solve_ball_flights(const Scenario& scenario, const std::vector<S>& t_s) {
  return BallFlights<S>(scenario).solve(t_s);
}

}  // namespace

Solution ball_flights() {
  return {"ball-flights",
          "balls between impacts on parabolas, impacts at roots of quadratics, Newton's law and Coulomb's: "
          "Routh, art. 169, 180",
          feature::kFreeMotion | feature::kSimpleContact, solve_ball_flights<Narrow>, solve_ball_flights<Wide>};
}

}  // namespace atwood::closed_form
