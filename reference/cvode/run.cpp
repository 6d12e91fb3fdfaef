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
  made.lifted = from.lifted;
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
  CompliantContacts compliant;
  Contacts contacts;
  Solver solver;
  int interval = 0;
  double t_s = 0;
  std::vector<double> y;
  std::int64_t sampled = 0;
  std::vector<Event> events;
  Trajectory path;  // of the last step
  std::vector<double> end_of_step;
  std::vector<Contacts::Passage> passages;

  Integration(const Scene& given, double end, std::int64_t count, const Options& options, const Observer& to,
              Record* of)
      : scene(given), t_end_s(end), samples(count), observer(to), record(of), equations(given, end),
        compliant(given, equations.layout()), contacts(given, equations, compliant, options),
        solver(options, tolerances(equations.layout(), options),
               [this, repeats = options.rate_repeats](double t, const double* from, double* dydt) {
                 for (int k = 1; k < repeats; ++k) equations.rate(t, from, dydt, interval);
                 free_rate(t, from, dydt);
                 contacts.hold(dydt);
               }),
        y(dynamics::pack<double>(given)) {
    rigid_contacts = contacts.any();
  }

  void free_rate(double t, const double* from, double* dydt) const {  // without the planes' normal forces
    equations.rate(t, from, dydt, interval);
    compliant.add_rates(from, dydt);
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
  void log_state(std::int64_t sample, double at_s, const std::vector<double>& state,
                 std::optional<dynamics::ContactPair> passage) {
    if (record == nullptr || !rigid_contacts) return;
    dynamics::Instant<Wide> made;
    made.t = sample >= 0 ? Wide(t_end_s) * sample / samples : Wide(at_s);
    made.interval = interval;
    made.sample = sample;
    made.passage = passage;
    made.first_event = events.size();
    made.after = widened(state);
    log(std::move(made));
  }
  void take_sample(const std::vector<double>& state) {
    if (record != nullptr) record->states.push_back(state);
    if (observer.sample) {
      Sample made = dynamics::unpack<double>(scene, sample_time(sampled), state.data());
      made.t_s = Wide(t_end_s) * sampled / samples;
      observer.sample(made);
    }
    log_state(sampled, sample_time(sampled), state, std::nullopt);
    ++sampled;
  }
  double next_stop() const {
    const std::vector<double>& switches = equations.switch_times();
    return interval < static_cast<int>(switches.size()) ? switches[interval] : t_end_s;
  }
  void restart() {
    dynamics::Instant<double> instant;
    contacts.resolve(t_s, y, interval, events, instant);
    if (!instant.after.empty()) log(widened(instant));
    compliant.update_modes(y.data());
    solver.start(t_s, y, next_stop(), 0, {});
  }

  void start() {
    take_sample(y);
    restart();
  }
  const std::string& failure() const { return contacts.failure().empty() ? compliant.failure() : contacts.failure(); }
  // Until t_end_s or a failure. A sample at the time of an impact or a switch has the state before it.
  Outcome integrate() {
    const bool events_possible = contacts.any() || compliant.any();
    while (failure().empty() && (t_s < t_end_s || sampled <= samples)) {
      const double stop = next_stop();
      if (events_possible ? !step(stop) : !advance(stop)) break;
      if (t_s >= stop && t_s < t_end_s) {
        log_state(-1, t_s, y, std::nullopt);
        ++interval;
        restart();
      }
    }
    return finish();
  }
  // To the next sample or the stop.
  bool advance(double stop) {
    const double sample_s = sampled <= samples ? sample_time(sampled) : t_end_s;
    const double target = observer.sample || observer.event ? std::min(stop, sample_s) : stop;
    if (solver.advance(target, t_s, y) == Stop::failed) return false;
    t_s = target;
    while (sampled <= samples && sample_time(sampled) <= t_s) take_sample(y);
    return true;
  }
  // One step, or up to the first event in it. The steps do not depend on the samples, which are taken from the step's
  // polynomial.
  bool step(double stop) {
    const double from_s = t_s;
    double reached_s = t_s;
    if (solver.step(stop, reached_s, end_of_step, path) == Stop::failed) return false;
    double to_s = reached_s;
    const Reaches reaches(scene, equations.layout(), path, from_s, to_s);
    passages.clear();
    const auto rate = [this](double t, const double* state, double* dydt) { free_rate(t, state, dydt); };
    bool event = contacts.first_event(path, reaches, rate, from_s, to_s, passages);
    event = (compliant.any() && compliant.first_event(path, reaches, from_s, to_s)) || event;
    if (event && to_s < reached_s) path.state(to_s, y);
    else y = end_of_step;
    t_s = to_s;
    record_step(to_s);
    if (!failure().empty()) return false;
    if (!event) {
      contacts.check(t_s, y, rate);
      if (!failure().empty()) t_s = from_s;
    }
    if (event && (t_s < stop || t_s >= t_end_s)) restart();
    return failure().empty();
  }
  // The samples and the passages up to `to_s`, in order.
  void record_step(double to_s) {
    std::erase_if(passages, [&](const Contacts::Passage& each) { return each.t_s > to_s; });
    std::stable_sort(passages.begin(), passages.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
    auto passage = passages.begin();
    std::vector<double> state;
    const auto pass = [&](double until_s) {
      for (; passage != passages.end() && passage->t_s <= until_s; ++passage) {
        path.state(passage->t_s, state);
        log_state(-1, passage->t_s, state, passage->pair);
      }
    };
    for (; sampled <= samples && sample_time(sampled) <= to_s;) {
      const double at_s = sample_time(sampled);
      pass(at_s);
      if (at_s < to_s) path.state(at_s, state);
      take_sample(at_s < to_s ? state : y);
    }
    pass(to_s);
  }

  Outcome finish() {
    Outcome outcome;
    outcome.steps_taken = solver.steps();
    outcome.rate_evaluations = solver.rate_evaluations();
    if (record != nullptr) {
      record->valid_until_failure = contacts.valid_until_failure();
      record->end_s = t_s;
    }
    if (!failure().empty()) {
      outcome.status = Status::unsupported;
      outcome.reason = failure();
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
