#include "dynamics/shared_errors.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"
#include "dynamics/error_growth.hpp"

namespace atwood::dynamics {

namespace {

// The linearisation of an impact is valid while the relative error of the gap's rate is at most this.
constexpr double kMaxRelativeRateError = 0.01;
constexpr double kPositionResolution = 1e-27;  // relative to the positions: quad does not resolve smaller gaps

class ErrorPropagation {
 public:
  ErrorPropagation(const Scene& scene, double t_end_s, const std::vector<Instant<Wide>>& instants,
                   const std::vector<Event>& events, const std::vector<double>& run_difference_s,
                   const RaggedArray<Wide>& run_difference, double round_off)
      : scene_(scene), layout_(dynamics::layout(scene)), instants_(instants), events_(events),
        run_difference_s_(run_difference_s), run_difference_(run_difference), growth_(scene, t_end_s, round_off),
        pairs_(contact_pairs(scene).pairs) {
    result_.samples.assign(run_difference.size(), std::vector<Wide>(layout_.size, Wide(0)));
    result_.events_s.assign(events.size(), 0);
  }

  SharedErrors propagate() {
    const Instant<Wide>* last = nullptr;
    for (const Instant<Wide>& now : instants_) {
      if (last != nullptr) growth_.flow(last->t, now.t, last->after, now.interval, now.steps);
      if (!growth_.finite()) end(now.t, "the growth of errors cannot be followed" + at_time(now.t));
      if (result_.end) break;
      if (now.sample >= 0) add_sample_bars(now);
      if (now.passage) check_passage(now);
      for (const int ball : now.lifted) growth_.release_from_plane(ball);
      if (!now.impacts.empty()) propagate_impacts(now);
      for (const BounceSeries<Wide>& series : now.series) add_series(now, series);
      if (result_.end) break;
      last = &now;
    }
    add_velocity_jumps();
    return std::move(result_);
  }

 private:
  void end(Wide t_s, const std::string& why) { end_at(result_.end, t_s, why); }
  std::string names(const ContactPair& pair) const {
    return "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name + "`";
  }
  // The runs' differences at the previous sample, as a bound of the gap and of its rate.
  double run_gap_difference(const ContactPair& pair) const {
    if (last_sample_ >= run_difference_.size()) return 0;
    Wide sum = 0;
    for (const int body : {pair.a, pair.b})
      for (int k = 0; k < 3 && layout_.slots[body].position >= 0; ++k)
        sum += run_difference_[last_sample_][layout_.slots[body].position + k];
    return static_cast<double>(sum);
  }
  double run_rate_difference(const ContactPair& pair) const {
    if (last_sample_ >= run_difference_.size()) return 0;
    Wide sum = 0;
    for (const int body : {pair.a, pair.b})
      for (int k = 0; k < 3 && layout_.slots[body].velocity >= 0; ++k)
        sum += run_difference_[last_sample_][layout_.slots[body].velocity + k];
    return static_cast<double>(sum);
  }

  void add_sample_bars(const Instant<Wide>& now) {
    if (static_cast<std::size_t>(now.sample) >= result_.samples.size()) return;
    last_sample_ = static_cast<std::size_t>(now.sample);
    if (now.sample == 0) return;
    const std::vector<double> bounds = growth_.bounds();
    std::vector<Wide>& bars = result_.samples[last_sample_];
    for (int i = 0; i < layout_.size; ++i) bars[i] = bounds[i];
    for (const BounceSeries<Wide>& series : series_) {
      if (now.t > series.t_rest + 2 * series.bar_s) continue;
      const Slot& slot = layout_.slots[series.ball];
      for (int k = 0; k < 3; ++k) {
        bars[slot.position + k] += series.height_m;
        bars[slot.velocity + k] += series.speed_m_per_s;
      }
    }
  }

  // The sum of the sizes of the pair's coordinates.
  double size_of_positions(const ContactPair& pair, const std::vector<Wide>& state) const {
    double size = 0;
    for (const int body : {pair.a, pair.b})
      if (const int at = layout_.slots[body].position; at >= 0)
        for (int k = 0; k < 3; ++k) size += std::fabs(static_cast<double>(state[at + k]));
    return size;
  }
  // What rounding the normal of a tilted plane to double changes of the gap: its length is 1 to round-off only.
  double input_round_off(const ContactPair& pair, const std::vector<Wide>& state) const {
    const int body = plane_of(scene_, pair);
    if (body < 0) return 0;
    const Real3& normal = std::get<Plane>(scene_.bodies[body].shape).normal;
    const bool tilted = std::count(normal.begin(), normal.end(), 0.0) < 2;
    return tilted ? 0x1p-52 * size_of_positions(pair, state) : 0;
  }

  // At a closest approach without contact: is it certain that the pair does not touch?
  void check_passage(const Instant<Wide>& now) {
    const Gap<Wide> least = dynamics::gap(scene_, layout_, *now.passage, now.after.data());
    const double bar = growth_.gap_bound(*now.passage, now.after) + run_gap_difference(*now.passage) +
                       kPositionResolution * size_of_positions(*now.passage, now.after);
    if (magnitude(least.gap_m) > Wide(bar)) return;
    end(now.t, names(*now.passage) + " pass each other" + at_time(now.t) +
                   " so closely that whether they touch is not decided within the bars");
  }

  // Coupled contacts whose impact could have come first within the half-widths of the time, or by the rounding of a
  // normal: the order is not decided.
  void check_order(const Instant<Wide>& now, const Impact<Wide>& impact, double bar_s) {
    for (const ContactPair& other : pairs_) {
      bool in_group = false, acts = false;
      for (const Impact<Wide>& each : now.impacts)
        for (const ContactPair& pair : each.pairs) in_group |= pair.a == other.a && pair.b == other.b;
      if (in_group) continue;
      for (const ContactPair& pair : impact.pairs) acts |= coupled(scene_, layout_, pair, other, impact.before.data());
      if (!acts) continue;
      const Gap<Wide> there = gap(scene_, layout_, other, impact.before.data());
      const Wide way = there.rate_m_per_s < 0 ? -there.rate_m_per_s * Wide(2 * bar_s) : Wide(0);
      double round_off = input_round_off(other, impact.before);
      for (const ContactPair& pair : impact.pairs) round_off += input_round_off(pair, impact.before);
      const Wide bar = growth_.gap_bound(other, impact.before) + run_gap_difference(other) + way + Wide(round_off);
      if (there.gap_m > bar) continue;
      end(now.t, "the impacts of " + names(impact.pairs.front()) + " and of " + names(other) + at_time(now.t) +
                     " are closer in time than their bars, and the motion depends on their order");
    }
  }

  void propagate_impacts(const Instant<Wide>& now) {
    double bar_s = 0;
    std::size_t event = now.first_event;
    for (std::size_t k = 0; k < now.impacts.size(); ++k) {
      const Impact<Wide>& impact = now.impacts[k];
      bool low_bounces = false;
      Wide fastest = 0;
      for (const ContactPair& pair : impact.pairs)
        fastest = std::min(fastest, gap(scene_, layout_, pair, impact.before.data()).rate_m_per_s);
      const double rate = static_cast<double>(-fastest);
      for (const ContactPair& pair : impact.pairs) {
        const double gap_bar = growth_.gap_bound(pair, impact.before) + static_cast<double>(now.gap_error_m);
        const double bar = gap_bar / rate + (event < run_difference_s_.size() ? run_difference_s_[event] : 0);
        bar_s = std::max(bar_s, now.t > 0 ? bar : 0);
        const double acceleration = std::fabs(growth_.gap_acceleration(pair, now.t, impact.before, now.interval));
        const double rate_bar = growth_.rate_bound(pair, impact.before) + run_rate_difference(pair);
        if (rate_bar + acceleration * bar <= kMaxRelativeRateError * rate || now.t == 0) continue;
        if (add_low_bounces(now, pair, impact, rate + rate_bar + std::sqrt(2 * std::fabs(acceleration) * gap_bar)))
          low_bounces = true;
        else
          end(now.t, names(pair) + " graze each other" + at_time(now.t) +
                         ": their velocities after the impact are not decided within the bars");
      }
      if (now.t > 0) check_order(now, impact, bar_s);
      if (result_.end) return;
      const std::vector<Wide>& after = k + 1 < now.impacts.size() ? now.impacts[k + 1].before : now.after;
      if (low_bounces) {
        const BounceSeries<Wide>& last = series_.back();
        bar_s = static_cast<double>(last.t_rest - now.t + last.bar_s);
        growth_.keep_to_plane(last.ball, last.normal, static_cast<double>(last.height_m));
      } else growth_.impact(now.t, impact, after, now.interval, static_cast<double>(now.gap_error_m));
      for (const auto& impulse : impact.impulses)
        if (impulse.normal_N_s > 0 && event < result_.events_s.size()) result_.events_s[event++] = bar_s;
    }
    impacts_.push_back({now.t, bar_s, &now});
  }

  // The last bounces of a ball that accelerates towards its plane and loses speed at each impact. Their times depend on
  // the errors; their height is at most that of a flight that starts at `speed`. False: the pair is not of this kind.
  bool add_low_bounces(const Instant<Wide>& now, const ContactPair& pair, const Impact<Wide>& impact, double speed) {
    const int ball = ball_of(scene_, pair);
    const double pull = -growth_.gap_acceleration(pair, now.t, impact.before, now.interval), e = pair.restitution;
    if (ball < 0 || impact.pairs.size() != 1 || pair.friction > 0 || !(e < 1) || !(pull > 0)) return false;
    BounceSeries<Wide> made;
    made.pair = pair;
    made.ball = ball;
    made.normal = std::get<Plane>(scene_.bodies[plane_of(scene_, pair)].shape).normal;
    made.speed_m_per_s = speed;
    made.height_m = speed * speed / (2 * pull);
    made.t_rest = now.t + 2 * speed / (pull * (1 - e));
    series_.push_back(made);
    return true;
  }

  void add_series(const Instant<Wide>& now, const BounceSeries<Wide>& series) {
    const double own = impacts_.empty() || impacts_.back().t_s != now.t ? 0 : impacts_.back().bar_s;
    const double speed = growth_.rate_bound(series.pair, now.after);
    BounceSeries<Wide> kept = series;
    kept.bar_s += own + series.duration_per_speed * speed;
    if (series.has_event)
      for (std::size_t k = now.first_event; k < events_.size(); ++k)
        if (events_[k].kind == EventKind::rest && events_[k].body_a == series.pair.a &&
            events_[k].body_b == series.pair.b) {
          result_.events_s[k] = static_cast<double>(kept.bar_s);
          break;
        }
    std::vector<double> push;
    for (const Wide& each : series.neglected) push.push_back(static_cast<double>(each));
    growth_.add(push);
    const double off = static_cast<double>(magnitude(gap(scene_, layout_, series.pair, now.after.data()).gap_m));
    growth_.keep_to_plane(series.ball, series.normal, off);
    growth_.hold_on_plane(series.ball, series.normal);
    series_.push_back(std::move(kept));
  }

  // At a sample within the half-width of an impact's time the velocity may be that before or that after the impact.
  void add_velocity_jumps() {
    std::vector<Wide> at;
    for (const Instant<Wide>& each : instants_)
      if (each.sample >= 0) at.push_back(each.t);
    for (const LocatedImpact& located : impacts_) {
      auto s = std::lower_bound(at.begin(), at.end(), located.t_s - located.bar_s);
      for (; s != at.end() && *s <= located.t_s + located.bar_s; ++s) {
        const auto k = static_cast<std::size_t>(s - at.begin());
        if (k == 0 || k >= result_.samples.size()) continue;
        std::vector<Wide>& bars = result_.samples[k];
        const std::vector<Wide>& before = located.at->impacts.front().before;
        for (int i = 0; i < layout_.size; ++i)
          if (layout_.kinds[i] == Kind::velocity || layout_.kinds[i] == Kind::rate)
            bars[i] += magnitude(located.at->after[i] - before[i]);
      }
    }
  }

  struct LocatedImpact {
    Wide t_s = 0;
    double bar_s = 0;
    const Instant<Wide>* at = nullptr;
  };
  const Scene& scene_;
  const Layout layout_;
  const std::vector<Instant<Wide>>& instants_;
  const std::vector<Event>& events_;
  const std::vector<double>& run_difference_s_;
  const RaggedArray<Wide>& run_difference_;
  ErrorGrowth growth_;
  std::vector<ContactPair> pairs_;
  SharedErrors result_;
  std::vector<BounceSeries<Wide>> series_;
  std::vector<LocatedImpact> impacts_;
  std::size_t last_sample_ = 0;
};

}  // namespace

SharedErrors shared_errors(const Scene& scene, double t_end_s, const std::vector<Instant<Wide>>& instants,
                           const std::vector<Event>& events, const std::vector<double>& run_difference_s,
                           const RaggedArray<Wide>& run_difference, double round_off) {
  return ErrorPropagation(scene, t_end_s, instants, events, run_difference_s, run_difference, round_off).propagate();
}

}  // namespace atwood::dynamics
