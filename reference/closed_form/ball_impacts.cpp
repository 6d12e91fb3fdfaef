#include "closed_form/ball_impacts.hpp"

#include <algorithm>
#include <numeric>

#include "dynamics/complementarity.hpp"

namespace atwood::closed_form {

namespace {

constexpr std::size_t kMaxPermuted = 4;  // contacts of a group whose orders are all tried
constexpr int kMaxImpacts = 100000;      // of a group at one instant, in sequence

}  // namespace

template <class S> const PairLaw& BallImpacts<S>::law_of(const BallContact<S>& contact) const {
  return pair_law(scene_, contact.body_a, contact.body_b);
}

template <class S> bool BallImpacts<S>::coupled(const BallContact<S>& one, const BallContact<S>& other) const {
  const auto has = [](const BallContact<S>& contact, int ball) {
    return ball >= 0 && (contact.ball == ball || contact.other == ball);
  };
  if (!has(other, one.ball) && !has(other, one.other)) return false;
  if (law_of(one).friction > 0 || law_of(other).friction > 0) return true;
  return magnitude(dot(one.normal, other.normal)) > 8 * unit_round_off<S>();
}

template <class S> S BallImpacts<S>::approach_speed(const BallContact<S>& contact) const {
  const Vec<S> u =
      contact.other < 0 ? S(-1) * balls_[contact.ball].v : balls_[contact.other].v - balls_[contact.ball].v;
  return -dot(u, contact.normal);
}

template <class S> S BallImpacts<S>::speed_tolerance(const BallContact<S>& contact) const {
  return kSpeedRoundOff<S> *
         (largest_speed_ + norm(balls_[contact.ball].v) + (contact.other < 0 ? S(0) : norm(balls_[contact.other].v)));
}

template <class S>
bool BallImpacts<S>::same_velocities(const std::vector<Ball<S>>& end, const std::vector<Ball<S>>& start) const {
  for (std::size_t i = 0; i < end.size(); ++i) {
    const S speeds = norm(end[i].v) + norm(start[i].v) + largest_speed_, spins = norm(end[i].w_B) + norm(start[i].w_B);
    if (norm(end[i].v - balls_[i].v) > 1024 * unit_round_off<S>() * speeds) return false;
    if (norm(end[i].w_B - balls_[i].w_B) > 1024 * unit_round_off<S>() * spins) return false;
  }
  return true;
}

template <class S>
bool BallImpacts<S>::resolve_in_sequence(const std::vector<BallContact<S>>& group,
                                         const std::vector<std::size_t>& order) {
  for (int impacts = 0; impacts < kMaxImpacts; ++impacts) {
    const BallContact<S>* next = nullptr;
    S fastest = 0;
    for (std::size_t k = 0; k < group.size(); ++k) {
      const BallContact<S>& contact = group[order.empty() ? k : order[k]];
      const S speed = approach_speed(contact);
      if (!(speed > speed_tolerance(contact))) continue;
      if (next != nullptr && (!order.empty() || !(speed > fastest * (1 + 256 * unit_round_off<S>())))) continue;
      next = &contact;
      fastest = speed;
    }
    if (next == nullptr) return true;
    apply_impact_law(*next);
  }
  return false;
}

template <class S> bool BallImpacts<S>::solve_moreau(const std::vector<BallContact<S>>& group) {
  const std::size_t n = group.size();
  std::vector<std::vector<S>> A(n, std::vector<S>(n, S(0)));
  std::vector<S> q, before, impulse;
  S speed = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (law_of(group[i]).friction > 0) return false;
    before.push_back(-approach_speed(group[i]));
    q.push_back(before[i] + (before[i] < 0 ? S(law_of(group[i]).restitution) * before[i] : S(0)));
    speed = larger(speed, magnitude(q[i]));
    for (std::size_t j = 0; j < n; ++j)
      for (const int of : {group[i].ball, group[i].other})
        for (const int by : {group[j].ball, group[j].other})
          if (of >= 0 && of == by)
            A[i][j] = A[i][j] + S(of == group[i].ball ? -1 : 1) * S(by == group[j].ball ? -1 : 1) *
                                    balls_[of].inverse_mass * dot(group[i].normal, group[j].normal);
  }
  if (!dynamics::solve_lcp<S>(A, q, kSpeedRoundOff<S> * speed, kSpeedRoundOff<S> * S(n), impulse)) return false;
  for (std::size_t i = 0; i < n; ++i)
    for (const int at : {group[i].ball, group[i].other})
      if (at >= 0)
        balls_[at].v =
            balls_[at].v + (S(at == group[i].ball ? -1 : 1) * balls_[at].inverse_mass * impulse[i]) * group[i].normal;
  for (std::size_t i = 0; i < n; ++i)
    if (impulse[i] > 0) append_event(group[i], impulse[i], S(0), before[i], -approach_speed(group[i]));
  return true;
}

template <class S> void BallImpacts<S>::apply_impact_law(const BallContact<S>& contact) {
  const PairLaw& law = law_of(contact);
  Ball<S>* pair[2] = {&balls_[contact.ball], contact.other < 0 ? nullptr : &balls_[contact.other]};
  // Relative velocity of the surfaces, other minus ball.
  Vec<S> u{}, spin{};
  S inverse_mass_n{}, inverse_mass_spin{};
  for (int k = 0; k < 2; ++k) {
    if (pair[k] == nullptr) continue;
    u = u + S(k == 0 ? -1 : 1) * pair[k]->v;
    spin = spin + pair[k]->radius * rotate(pair[k]->q, pair[k]->w_B);
    inverse_mass_n = inverse_mass_n + pair[k]->inverse_mass;
    inverse_mass_spin = inverse_mass_spin + pair[k]->radius * pair[k]->radius * pair[k]->inverse_inertia;
  }
  const S speed_in = -dot(u, contact.normal), impulse = (1 + S(law.restitution)) * speed_in / inverse_mass_n;
  const Vec<S> slip = u + speed_in * contact.normal - cross(spin, contact.normal);
  const S speed = norm(slip);
  S friction_impulse = 0;
  Vec<S> along{};
  if (speed > kSpeedRoundOff<S> * (norm(u) + norm(spin))) {
    along = (1 / speed) * slip;
    friction_impulse = S(law.friction) * impulse < speed / (inverse_mass_n + inverse_mass_spin)
                           ? S(law.friction) * impulse
                           : speed / (inverse_mass_n + inverse_mass_spin);
  }
  for (int k = 0; k < 2; ++k) {
    if (pair[k] == nullptr) continue;
    pair[k]->v = pair[k]->v +
                 (S(k == 0 ? -1 : 1) * pair[k]->inverse_mass) * (impulse * contact.normal - friction_impulse * along);
    if (friction_impulse == 0) continue;
    const Vec<S> moment_direction =
        cross(contact.normal, along);  // the moment of the friction impulse has this direction for both
    pair[k]->w_B = pair[k]->w_B + (friction_impulse * pair[k]->radius * pair[k]->inverse_inertia) *
                                      rotate(conjugate(pair[k]->q), moment_direction);
  }
  append_event(contact, impulse, friction_impulse, -speed_in, S(law.restitution) * speed_in);
}

template <class S>
void BallImpacts<S>::append_event(const BallContact<S>& contact, S normal_impulse, S friction_impulse, S vn_before,
                                  S vn_after) {
  ContactEvent<S> made;
  made.t_s = t_s_;
  made.body_a = contact.body_a;
  made.body_b = contact.body_b;
  made.x_W = balls_[contact.ball].p + balls_[contact.ball].radius * contact.normal;
  made.normal_W = contact.sign * contact.normal;
  made.impulse_n_N_s = normal_impulse;
  made.impulse_t_N_s = friction_impulse;
  made.vn_before_m_per_s = vn_before;
  made.vn_after_m_per_s = vn_after;
  events_->push_back(made);
}

template <class S>
std::string BallImpacts<S>::resolve(const std::vector<BallContact<S>>& group, S t_s,
                                    std::vector<ContactEvent<S>>& events) {
  t_s_ = t_s;
  events_ = &events;
  largest_speed_ = 0;
  for (const BallContact<S>& contact : group)
    for (const int at : {contact.ball, contact.other})
      if (at >= 0) largest_speed_ = larger(largest_speed_, norm(balls_[at].v));
  const bool single = group.size() == 1;
  if (!single && scene_.simultaneous_impacts == SimultaneousImpacts::together) {
    if (solve_moreau(group)) return "";
    return "simultaneous_impacts = \"together\" is not covered with friction or for more than " +
           std::to_string(dynamics::kMaxSimultaneous) + " contacts, or its complementarity problem has no solution";
  }
  const std::vector<Ball<S>> start = balls_;
  if (!resolve_in_sequence(group, {}))
    return "simultaneous impacts resolved in sequence still approach after " + std::to_string(kMaxImpacts) + " impacts";
  if (single || scene_.simultaneous_impacts == SimultaneousImpacts::sequential) return "";
  const std::vector<Ball<S>> end = balls_;
  const std::size_t event_count = events.size();
  bool agree = group.size() <= kMaxPermuted;
  std::vector<std::size_t> order(group.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  while (agree) {
    balls_ = start;
    agree = resolve_in_sequence(group, order) && same_velocities(end, start);
    if (!std::next_permutation(order.begin(), order.end())) break;
  }
  if (agree) {
    balls_ = start;
    agree = solve_moreau(group) && same_velocities(end, start);
  }
  balls_ = end;
  events.resize(event_count);
  if (agree) return "";
  std::string why = "the outcome of simultaneous impacts (";
  for (std::size_t k = 0; k < group.size() && k < 3; ++k)
    why += (k == 0 ? "`" : ", `") + scene_.bodies[group[k].body_a].name + "` with `" +
           scene_.bodies[group[k].body_b].name + "`";
  return why + ") depends on a convention, and the scene states none ([world] simultaneous_impacts)";
}

template class BallImpacts<Narrow>;
template class BallImpacts<Wide>;

}  // namespace atwood::closed_form
