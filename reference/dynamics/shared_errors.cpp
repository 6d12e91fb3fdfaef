#include "dynamics/shared_errors.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"
#include "dynamics/error_growth.hpp"

namespace atwood::dynamics {

namespace {

// An impact's derivative holds while the possible error of the gap's rate is a small part of the rate.
constexpr double kLinear = 0.01;
constexpr double kLeastScale = 1e-27;  // a passage nearer than this part of the places at hand is no decision of quad's

std::string when(Wide t_s) { return " at t = " + format_double(static_cast<double>(t_s)) + " s"; }

class Follower {
 public:
  Follower(const Scene& scene, double t_end_s, const std::vector<Instant<Wide>>& instants,
           const std::vector<Event>& events, const std::vector<double>& apart_s,
           const std::vector<std::vector<Wide>>& apart, double round_off)
      : scene_(scene), layout_(dynamics::layout(scene)), instants_(instants), events_(events), apart_s_(apart_s),
        apart_(apart), growth_(scene, t_end_s, round_off), pairs_(contact_pairs(scene).pairs) {
    made_.samples.assign(apart.size(), std::vector<Wide>(layout_.size, Wide(0)));
    made_.events_s.assign(events.size(), 0);
  }

  SharedErrors follow() {
    const Instant<Wide>* last = nullptr;
    for (const Instant<Wide>& now : instants_) {
      if (last != nullptr) growth_.flow(last->t, now.t, last->after, now.interval, now.steps);
      if (!growth_.finite()) end(now.t, "the growth of errors cannot be followed" + when(now.t));
      if (made_.end) break;
      if (now.sample >= 0) sample(now);
      if (now.passed) pass(now);
      if (!now.blows.empty()) strike(now);
      for (const Laid<Wide>& laid : now.laid) lay(now, laid);
      if (made_.end) break;
      last = &now;
    }
    jump();
    return std::move(made_);
  }

 private:
  void end(Wide t_s, std::string why) {
    if (!made_.end || t_s < made_.end->t_s) made_.end = End{t_s, std::move(why)};
  }
  std::string names(const ContactPair& pair) const {
    return "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name + "`";
  }
  // The runs' own differences at the sample before, as a part of every bound: what they say of a gap.
  double apart_gap(const ContactPair& pair) const {
    if (last_sample_ >= apart_.size()) return 0;
    Wide sum = 0;
    for (const int body : {pair.a, pair.b})
      for (int k = 0; k < 3 && layout_.slots[body].position >= 0; ++k)
        sum += apart_[last_sample_][layout_.slots[body].position + k];
    return static_cast<double>(sum);
  }
  double apart_rate(const ContactPair& pair) const {
    if (last_sample_ >= apart_.size()) return 0;
    Wide sum = 0;
    for (const int body : {pair.a, pair.b})
      for (int k = 0; k < 3 && layout_.slots[body].velocity >= 0; ++k)
        sum += apart_[last_sample_][layout_.slots[body].velocity + k];
    return static_cast<double>(sum);
  }

  void sample(const Instant<Wide>& now) {
    if (static_cast<std::size_t>(now.sample) >= made_.samples.size()) return;
    last_sample_ = static_cast<std::size_t>(now.sample);
    if (now.sample == 0) return;
    const std::vector<double> bounds = growth_.bounds();
    std::vector<Wide>& bars = made_.samples[last_sample_];
    for (int i = 0; i < layout_.size; ++i) bars[i] = bounds[i];
    for (const Laid<Wide>& laid : bouncing_) {
      if (now.t > laid.until + 2 * laid.bar_s) continue;
      const Slot& slot = layout_.slots[laid.ball];
      for (int k = 0; k < 3; ++k) {
        bars[slot.position + k] += laid.height_m;
        bars[slot.velocity + k] += laid.speed_m_per_s;
      }
    }
  }

  // Does it pass, or does it touch?
  void pass(const Instant<Wide>& now) {
    const Gap<Wide> least = dynamics::gap(scene_, layout_, *now.passed, now.after.data());
    double size = 0;
    for (const int body : {now.passed->a, now.passed->b})
      if (const int at = layout_.slots[body].position; at >= 0)
        for (int k = 0; k < 3; ++k) size += std::fabs(static_cast<double>(now.after[at + k]));
    const double bar = growth_.gap_bound(*now.passed, now.after) + apart_gap(*now.passed) + kLeastScale * size;
    if (magnitude(least.gap_m) > Wide(bar)) return;
    end(now.t,
        names(*now.passed) + " graze each other" + when(now.t) + ": whether they touch is not decided within the bars");
  }

  // Contacts that would have been struck too, had their turn come first.
  void tell_apart(const Instant<Wide>& now, const Blow<Wide>& blow, double bar_s) {
    for (const ContactPair& other : pairs_) {
      bool in_group = false, coupled = false;
      for (const Blow<Wide>& each : now.blows)
        for (const ContactPair& pair : each.pairs) in_group |= pair.a == other.a && pair.b == other.b;
      if (in_group) continue;
      for (const ContactPair& pair : blow.pairs) coupled |= couple(scene_, layout_, pair, other, blow.before.data());
      if (!coupled) continue;
      const Gap<Wide> there = gap(scene_, layout_, other, blow.before.data());
      const Wide way = there.rate_m_per_s < 0 ? -there.rate_m_per_s * Wide(2 * bar_s) : Wide(0);
      const Wide bar = growth_.gap_bound(other, blow.before) + apart_gap(other) + way;
      if (there.gap_m > bar) continue;
      end(now.t, "the impacts of " + names(blow.pairs.front()) + " and of " + names(other) + when(now.t) +
                     " cannot be told apart in time, and their order decides what follows");
    }
  }

  void strike(const Instant<Wide>& now) {
    double bar_s = 0;
    std::size_t event = now.first_event;
    for (std::size_t k = 0; k < now.blows.size(); ++k) {
      const Blow<Wide>& blow = now.blows[k];
      bool settling = false;
      Wide fastest = 0;
      for (const ContactPair& pair : blow.pairs)
        fastest = std::min(fastest, gap(scene_, layout_, pair, blow.before.data()).rate_m_per_s);
      const double rate = static_cast<double>(-fastest);
      for (const ContactPair& pair : blow.pairs) {
        const double gap_bar = growth_.gap_bound(pair, blow.before) + static_cast<double>(now.off_m);
        const double bar = gap_bar / rate + (event < apart_s_.size() ? apart_s_[event] : 0);
        bar_s = std::max(bar_s, now.t > 0 ? bar : 0);
        const double bend = std::fabs(growth_.gap_acceleration(pair, now.t, blow.before, now.interval));
        const double rate_bar = growth_.rate_bound(pair, blow.before) + apart_rate(pair);
        if (rate_bar + bend * bar <= kLinear * rate || now.t == 0) continue;
        if (settles(now, pair, blow, rate + rate_bar + std::sqrt(2 * std::fabs(bend) * gap_bar))) settling = true;
        else
          end(now.t,
              names(pair) + " graze each other" + when(now.t) + ": how they part is not decided within the bars");
      }
      if (now.t > 0) tell_apart(now, blow, bar_s);
      if (made_.end) return;
      const std::vector<Wide>& after = k + 1 < now.blows.size() ? now.blows[k + 1].before : now.after;
      if (settling) {
        const Laid<Wide>& last = bouncing_.back();
        bar_s = static_cast<double>(last.until - now.t + last.bar_s);
        growth_.keep_to_plane(last.ball, last.normal, static_cast<double>(last.height_m));
      } else growth_.strike(now.t, blow, after, now.interval, static_cast<double>(now.off_m));
      for (const auto& impulse : blow.impulses)
        if (impulse.normal_N_s > 0 && event < made_.events_s.size()) made_.events_s[event++] = bar_s;
    }
    hits_.push_back({now.t, bar_s, &now});
  }

  // The last low bounces of a ball that is pulled towards its plane and loses speed: they hang on the errors, and stay
  // below what `speed` reaches until they end.
  bool settles(const Instant<Wide>& now, const ContactPair& pair, const Blow<Wide>& blow, double speed) {
    const int ball = ball_of(scene_, pair);
    const double pull = -growth_.gap_acceleration(pair, now.t, blow.before, now.interval), e = pair.restitution;
    if (ball < 0 || blow.pairs.size() != 1 || pair.friction > 0 || !(e < 1) || !(pull > 0)) return false;
    Laid<Wide> made;
    made.pair = pair;
    made.ball = ball;
    made.normal = std::get<Plane>(scene_.bodies[plane_of(scene_, pair)].shape).normal;
    made.speed_m_per_s = speed;
    made.height_m = speed * speed / (2 * pull);
    made.until = now.t + 2 * speed / (pull * (1 - e));
    bouncing_.push_back(made);
    return true;
  }

  void lay(const Instant<Wide>& now, const Laid<Wide>& laid) {
    const double own = hits_.empty() || hits_.back().t_s != now.t ? 0 : hits_.back().bar_s;
    const double speed = growth_.rate_bound(laid.pair, now.after);
    Laid<Wide> kept = laid;
    kept.bar_s += own + laid.per_speed * speed;
    if (laid.told)
      for (std::size_t k = now.first_event; k < events_.size(); ++k)
        if (events_[k].kind == EventKind::rest && events_[k].body_a == laid.pair.a &&
            events_[k].body_b == laid.pair.b) {
          made_.events_s[k] = static_cast<double>(kept.bar_s);
          break;
        }
    std::vector<double> push;
    for (const Wide& each : laid.push) push.push_back(static_cast<double>(each));
    growth_.add(push);
    const double off = static_cast<double>(magnitude(gap(scene_, layout_, laid.pair, now.after.data()).gap_m));
    growth_.keep_to_plane(laid.ball, laid.normal, off);
    growth_.hold_on_plane(laid.ball, laid.normal);
    bouncing_.push_back(std::move(kept));
  }

  // At a sample within an impact's time bar the velocity before it is as good as the one after it.
  void jump() {
    std::vector<Wide> at;
    for (const Instant<Wide>& each : instants_)
      if (each.sample >= 0) at.push_back(each.t);
    for (const Hit& hit : hits_) {
      auto s = std::lower_bound(at.begin(), at.end(), hit.t_s - hit.bar_s);
      for (; s != at.end() && *s <= hit.t_s + hit.bar_s; ++s) {
        const auto k = static_cast<std::size_t>(s - at.begin());
        if (k == 0 || k >= made_.samples.size()) continue;
        std::vector<Wide>& bars = made_.samples[k];
        const std::vector<Wide>& before = hit.at->blows.front().before;
        for (int i = 0; i < layout_.size; ++i)
          if (layout_.kinds[i] == Kind::velocity || layout_.kinds[i] == Kind::rate)
            bars[i] += magnitude(hit.at->after[i] - before[i]);
      }
    }
  }

  struct Hit {
    Wide t_s = 0;
    double bar_s = 0;
    const Instant<Wide>* at = nullptr;
  };
  const Scene& scene_;
  const Layout layout_;
  const std::vector<Instant<Wide>>& instants_;
  const std::vector<Event>& events_;
  const std::vector<double>& apart_s_;
  const std::vector<std::vector<Wide>>& apart_;
  ErrorGrowth growth_;
  std::vector<ContactPair> pairs_;
  SharedErrors made_;
  std::vector<Laid<Wide>> bouncing_;
  std::vector<Hit> hits_;
  std::size_t last_sample_ = 0;
};

}  // namespace

SharedErrors shared_errors(const Scene& scene, double t_end_s, const std::vector<Instant<Wide>>& instants,
                           const std::vector<Event>& events, const std::vector<double>& apart_s,
                           const std::vector<std::vector<Wide>>& apart, double round_off) {
  return Follower(scene, t_end_s, instants, events, apart_s, apart, round_off).follow();
}

}  // namespace atwood::dynamics
