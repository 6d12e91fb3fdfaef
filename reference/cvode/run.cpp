#include "cvode/run.hpp"

#include <algorithm>

#include "cvode/contacts.hpp"
#include "cvode/giving_contacts.hpp"
#include "dynamics/rates.hpp"

namespace atwood::cvode {

namespace {

Outcome refusal(std::string reason) {
  Outcome made;
  made.status = Status::unsupported;
  made.reason = std::move(reason);
  return made;
}

std::vector<Wide> widened(const std::vector<double>& y) { return {y.begin(), y.end()}; }

dynamics::Instant<Wide> widened(const dynamics::Instant<double>& from) {
  dynamics::Instant<Wide> made;
  made.t = from.t;
  made.interval = from.interval;
  made.off_m = from.off_m;
  made.first_event = from.first_event;
  made.after = widened(from.after);
  for (const dynamics::Blow<double>& blow : from.blows) {
    auto& wide = made.blows.emplace_back();
    wide.pairs = blow.pairs;
    wide.before = widened(blow.before);
    for (const auto& impulse : blow.impulses) wide.impulses.push_back({impulse.normal_N_s, impulse.tangential_N_s});
  }
  for (const dynamics::Laid<double>& laid : from.laid)
    made.laid.push_back({laid.pair, laid.ball, laid.normal, laid.until, laid.bar_s, laid.height_m, laid.speed_m_per_s,
                         laid.per_speed, widened(laid.push), laid.told});
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

struct Course {  // one run under way
  const Scene& scene;
  double t_end_s;
  std::int64_t samples;
  const Observer& observer;
  Record* record;
  bool touches = false;  // rigid contacts are possible
  std::int64_t logged_steps = 0;
  dynamics::Dynamics<double> equations;
  Contacts contacts;
  GivingContacts giving;
  Solver solver;
  int interval = 0;
  double t_s = 0;
  std::vector<double> y;
  std::int64_t sampled = 0;
  std::vector<Event> events;

  Course(const Scene& given, double end, std::int64_t count, const Options& options, const Observer& to, Record* of)
      : scene(given), t_end_s(end), samples(count), observer(to), record(of), equations(given, end),
        contacts(given, equations, options), giving(given, equations.layout()),
        solver(options, tolerances(equations.layout(), options),
               [this, repeats = options.rate_repeats](double t, const double* from, double* dydt) {
                 for (int k = 0; k < repeats; ++k) equations.rate(t, from, dydt, interval);
                 giving.add_rates(from, dydt);
               }),
        y(dynamics::pack<double>(given)) {
    touches = contacts.roots() > 0;
  }

  double sample_time(std::int64_t k) const {
    return k == samples ? t_end_s : static_cast<double>(Wide(t_end_s) * k / samples);
  }
  void log(dynamics::Instant<Wide> what) {
    if (record == nullptr || !touches) return;
    what.steps = static_cast<double>(solver.steps() - logged_steps);
    logged_steps = solver.steps();
    record->instants.push_back(std::move(what));
  }
  void log_state(std::int64_t sample, std::optional<dynamics::ContactPair> passed) {
    dynamics::Instant<Wide> made;
    made.t = sample >= 0 ? Wide(t_end_s) * sample / samples : Wide(t_s);
    made.interval = interval;
    made.sample = sample;
    made.passed = passed;
    made.first_event = events.size();
    made.after = widened(y);
    log(std::move(made));
  }
  bool settle() {
    dynamics::Instant<double> told;
    const bool changed = contacts.settle(t_s, y, interval, events, told);
    if (!told.after.empty()) log(widened(told));
    return changed;
  }
  void take_sample(const std::vector<double>& state) {
    if (observer.sample) {
      Sample made = dynamics::unpack<double>(scene, sample_time(sampled), state.data());
      made.t_s = Wide(t_end_s) * sampled / samples;
      observer.sample(made);
    }
    contacts.check(state);
    log_state(sampled, std::nullopt);
    ++sampled;
  }
  double next_stop() const {
    const std::vector<double>& switches = equations.switch_times();
    return interval < static_cast<int>(switches.size()) ? switches[interval] : t_end_s;
  }
  void restart() {
    settle();
    giving.settle(y.data());
    solver.start(t_s, y, next_stop(), contacts.roots() + giving.roots(), [this](double, const double* from, double* g) {
      contacts.evaluate(from, g);
      giving.evaluate(from, g + contacts.roots());
    });
  }

  void begin() {
    take_sample(y);
    restart();
  }
  // Until the end or a failure. A sample at the instant of an impact or a switch shows the state before it.
  Outcome go() {
    while (contacts.failure().empty() && (t_s < t_end_s || sampled <= samples)) {
      const double stop = next_stop();
      const double sample_s = sampled <= samples ? sample_time(sampled) : t_end_s;
      const double target = observer.sample || observer.event ? std::min(stop, sample_s) : stop;
      const Stop why = solver.advance(target, t_s, y);
      if (why == Stop::failed) break;
      if (why == Stop::root) {
        for (const dynamics::ContactPair& pair : contacts.passed(y)) log_state(-1, pair);
        if (settle() || giving.any()) restart();
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
      record->branch = contacts.branch();
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
  if (const std::string why = dynamics::unsupported(scene); !why.empty()) return refusal("CVODE: " + why);
  if (!(t_end_s > 0) || samples < 1) return refusal("CVODE: nothing to run");
  Course course(scene, t_end_s, samples, options, observer, record);
  for (const std::string& why : {course.contacts.failure(), course.giving.failure()})
    if (!why.empty()) return refusal(why);
  if (course.equations.size() == 0) {  // nothing moves
    while (course.sampled <= samples) course.take_sample(course.y);
    return {};
  }
  course.begin();
  const auto from = std::chrono::steady_clock::now();
  Outcome outcome = course.go();
  if (busy != nullptr)
    *busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - from);
  return outcome;
}

}  // namespace atwood::cvode
