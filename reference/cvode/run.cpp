#include "cvode/run.hpp"

#include <algorithm>

#include "cvode/compliant_contacts.hpp"
#include "cvode/contacts.hpp"
#include "dynamics/rates.hpp"
#include "protocol/refusal.hpp"

namespace atwood::cvode {

namespace {

std::vector<Wide> widened(const std::vector<double>& y) { return {y.begin(), y.end()}; }

dynamics::Instant<Wide> widened(const dynamics::Instant<double>& from) {
  dynamics::Instant<Wide> made;
  made.t = from.t;
  made.interval = from.interval;
  made.gap_error_m = from.gap_error_m;
  made.first_event = from.first_event;
  made.after = widened(from.after);
  for (const dynamics::Impact<double>& impact : from.impacts) {
    auto& wide = made.impacts.emplace_back();
    wide.pairs = impact.pairs;
    wide.before = widened(impact.before);
    for (const auto& impulse : impact.impulses) wide.impulses.push_back({impulse.normal_N_s, impulse.tangential_N_s});
  }
  for (const dynamics::BounceSeries<double>& series : from.series)
    made.series.push_back({series.pair, series.ball, series.normal, series.t_rest, series.bar_s, series.height_m,
                           series.speed_m_per_s, series.duration_per_speed, widened(series.neglected),
                           series.has_event});
  return made;
}

std::vector<double> tolerances(const dynamics::Layout& layout, const Options& options) {
  std::vector<double> made;
  for (const dynamics::Kind kind : layout.kinds)
    made.push_back(options.atol * (kind == dynamics::Kind::position   ? options.scales.position_m
                                   : kind == dynamics::Kind::velocity ? options.scales.velocity_m_per_s
                                   : kind == dynamics::Kind::rate     ? options.scales.rate_rad_per_s
                                                                      : 1));
  return made;
}

// The state of one integration.
struct Integration {
  const Scene& scene;
  double t_end_s;
  std::int64_t samples;
  const Observer& observer;
  Record* record;
  bool rigid_contacts = false;  // rigid contacts are possible
  std::int64_t logged_steps = 0;
  dynamics::Dynamics<double> equations;
  Contacts contacts;
  CompliantContacts compliant;
  Solver solver;
  int interval = 0;
  double t_s = 0;
  std::vector<double> y;
  std::int64_t sampled = 0;
  std::vector<Event> events;

  Integration(const Scene& given, double end, std::int64_t count, const Options& options, const Observer& to,
              Record* of)
      : scene(given), t_end_s(end), samples(count), observer(to), record(of), equations(given, end),
        contacts(given, equations, options), compliant(given, equations.layout()),
        solver(options, tolerances(equations.layout(), options),
               [this, repeats = options.rate_repeats](double t, const double* from, double* dydt) {
                 for (int k = 0; k < repeats; ++k) equations.rate(t, from, dydt, interval);
                 compliant.add_rates(from, dydt);
               }),
        y(dynamics::pack<double>(given)) {
    rigid_contacts = contacts.roots() > 0;
  }

  double sample_time(std::int64_t k) const {
    return k == samples ? t_end_s : static_cast<double>(Wide(t_end_s) * k / samples);
  }
  void log(dynamics::Instant<Wide> what) {
    if (record == nullptr || !rigid_contacts) return;
    what.steps = static_cast<double>(solver.steps() - logged_steps);
    logged_steps = solver.steps();
    record->instants.push_back(std::move(what));
  }
  void log_state(std::int64_t sample, std::optional<dynamics::ContactPair> passage) {
    dynamics::Instant<Wide> made;
    made.t = sample >= 0 ? Wide(t_end_s) * sample / samples : Wide(t_s);
    made.interval = interval;
    made.sample = sample;
    made.passage = passage;
    made.first_event = events.size();
    made.after = widened(y);
    log(std::move(made));
  }
  bool resolve_contacts() {
    dynamics::Instant<double> instant;
    const bool changed = contacts.resolve(t_s, y, interval, events, instant);
    if (!instant.after.empty()) log(widened(instant));
    return changed;
  }
  void take_sample(const std::vector<double>& state) {
    if (record != nullptr) record->states.push_back(state);
    if (observer.sample) {
      Sample made = dynamics::unpack<double>(scene, sample_time(sampled), state.data());
      made.t_s = Wide(t_end_s) * sampled / samples;
      observer.sample(made);
    }
    contacts.check_penetration(sample_time(sampled), state);
    log_state(sampled, std::nullopt);
    ++sampled;
  }
  double next_stop() const {
    const std::vector<double>& switches = equations.switch_times();
    return interval < static_cast<int>(switches.size()) ? switches[interval] : t_end_s;
  }
  void restart() {
    resolve_contacts();
    compliant.update_modes(y.data());
    solver.start(t_s, y, next_stop(), contacts.roots() + compliant.roots(),
                 [this](double, const double* from, double* g) {
                   contacts.evaluate(from, g);
                   compliant.evaluate(from, g + contacts.roots());
                 });
  }

  void start() {
    take_sample(y);
    restart();
  }
  // Until t_end_s or a failure. A sample at the time of an impact or a switch has the state before it.
  Outcome integrate() {
    while (contacts.failure().empty() && (t_s < t_end_s || sampled <= samples)) {
      const double stop = next_stop();
      const double sample_s = sampled <= samples ? sample_time(sampled) : t_end_s;
      const double target = observer.sample || observer.event ? std::min(stop, sample_s) : stop;
      const Stop why = solver.advance(target, t_s, y);
      if (why == Stop::failed) break;
      if (why == Stop::root) {
        for (const dynamics::ContactPair& pair : contacts.closest_approaches(y)) log_state(-1, pair);
        if (resolve_contacts() || compliant.any()) restart();
        continue;
      }
      t_s = target;
      while (sampled <= samples && sample_time(sampled) <= t_s) take_sample(y);
      if (t_s >= stop && t_s < t_end_s) {
        log_state(-1, std::nullopt);
        ++interval;
        restart();
      }
    }
    return finish();
  }

  Outcome finish() {
    Outcome outcome;
    outcome.steps_taken = solver.steps();
    outcome.rate_evaluations = solver.rate_evaluations();
    if (record != nullptr) {
      record->valid_until_failure = contacts.valid_until_failure();
      record->end_s = t_s;
    }
    if (!contacts.failure().empty()) {
      outcome.status = Status::unsupported;
      outcome.reason = contacts.failure();
    } else if (!solver.failure().empty()) {
      outcome.status = solver.not_finite() ? Status::not_finite : Status::diverged;
      outcome.reason = solver.failure();
    }
    if (observer.event)
      for (const Event& event : events)
        if (event.t_s <= Wide(t_end_s)) observer.event(event);
    return outcome;
  }
};

}  // namespace

Outcome run(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options, const Observer& observer,
            Record* record, std::chrono::nanoseconds* busy) {
  if (const std::string why = dynamics::unsupported(scene); !why.empty()) return refused("CVODE: " + why);
  if (!(t_end_s > 0) || samples < 1)
    return refused("CVODE: expected t_end_s > 0 and at least 1 sample; found t_end_s = " + format_double(t_end_s) +
                   ", " + std::to_string(samples) + " samples");
  Integration integration(scene, t_end_s, samples, options, observer, record);
  for (const std::string& why : {integration.contacts.failure(), integration.compliant.failure()})
    if (!why.empty()) return refused(why);
  if (integration.equations.size() == 0) {  // nothing moves
    while (integration.sampled <= samples) integration.take_sample(integration.y);
    return {};
  }
  integration.start();
  const auto from = std::chrono::steady_clock::now();
  Outcome outcome = integration.integrate();
  if (busy != nullptr)
    *busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - from);
  return outcome;
}

}  // namespace atwood::cvode
