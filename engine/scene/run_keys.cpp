// The keys of [run] and their checks: the end of the run, its ladder of steps, its samples, recorded frames.
#include <algorithm>
#include <cmath>

#include "scene/scenario_keys.hpp"

namespace atwood {
namespace {

std::int64_t whole(Reading& r, const Value& table, const char* name, std::int64_t low, std::int64_t high) {
  const Value* v = table.find(name);
  if (!v)
    fail(r, table.location,
         std::string("missing key `") + name + "` in `steps` of " + r.where + "; expected { from, rungs, ratio }");
  std::int64_t out = 0;
  r.key = name;
  integer(low, high).read(r, *v, out);
  r.key = "steps";
  return out;
}

// { from, rungs, ratio }: from ratio^k; whether samples divide each rung is checked with the rest of [run].
std::vector<std::int64_t> geometric_ladder(Reading& r, const Value& v) {
  const std::vector<std::string> names = {"from", "rungs", "ratio"};
  for (const Member& member : *v.table())
    if (std::find(names.begin(), names.end(), member.key) == names.end())
      fail(r, member.location,
           "unknown key `" + member.key + "` in `steps` of " + r.where + "; expected one of " + listed(names) +
               did_you_mean(member.key, names));
  const std::int64_t from = whole(r, v, "from", 1, kMaxSteps), rungs = whole(r, v, "rungs", 1, kMaxRungs);
  double ratio = 2;
  if (const Value* given = v.find("ratio")) {
    r.key = "ratio";
    Range above_one = positive();
    above_one.low = 1, above_one.expected = "a number above 1";
    ratio = read_number(r, *given, above_one);
    r.key = "steps";
  }
  std::vector<std::int64_t> steps;
  for (std::int64_t k = 0; k < rungs; ++k) {
    const double rung = std::round(static_cast<double>(from) * std::pow(ratio, static_cast<double>(k)));
    if (!(rung <= static_cast<double>(kMaxSteps)))
      fail(r, v.location,
           "`steps` in " + r.where + " grows past " + std::to_string(kMaxSteps) +
               "; expected fewer rungs or a smaller ratio");
    steps.push_back(static_cast<std::int64_t>(rung));
  }
  return steps;
}

Key<Scenario> steps_key() {
  const auto rung = integer(1, kMaxSteps);
  const auto list = list_of(rung, kMaxRungs);
  auto k = required(
      key<Scenario>("steps", &Scenario::steps, list, "the ladder: a list of step counts, or { from, rungs, ratio }"));
  Value ladder = object_schema(table_of({{"from", rung.schema},
                                         {"rungs", integer(1, kMaxRungs).schema},
                                         {"ratio", table_of({{"type", "number"}, {"exclusiveMinimum", 1}})}}),
                               {Value("from"), Value("rungs")});
  k.resolved_schema = list.schema;
  k.schema = table_of({{"oneOf", Value::List{list.schema, std::move(ladder)}}});
  k.read = [list](Reading& r, const Value& v, Scenario& out) {
    if (v.table() && r.form == Form::file) out.steps = geometric_ladder(r, v);
    else list.read(r, v, out.steps);
  };
  return k;
}

// Left out where there is none.
Key<Scenario> frames_key() {
  auto k = key<Scenario>("frame_ends_s", &Scenario::frame_ends_s, list_of(number(positive()), kMaxFrames),
                         "when each recorded frame ended, growing, the last at t_end_s [s]: steps of unequal length");
  const auto write = k.write;
  k.write = [write](const Scene& s, const Scenario& from) {
    return from.frame_ends_s.empty() ? Value() : write(s, from);
  };
  return k;
}

void check_frames(Reading& r, const Value& run, const Scenario& scenario) {
  const std::vector<double>& ends = scenario.frame_ends_s;
  if (ends.empty()) return;
  const SourceLocation location = run.find("frame_ends_s")->location;
  for (std::size_t i = 1; i < ends.size(); ++i)
    if (!(ends[i] > ends[i - 1]))
      fail(r, location,
           "`frame_ends_s` in [run] has " + describe(Value(ends[i])) + " after " + describe(Value(ends[i - 1])) +
               "; expected growing times");
  if (ends.back() != scenario.t_end_s)
    fail(r, location,
         "`frame_ends_s` in [run] ends at " + describe(Value(ends.back())) + "; expected t_end_s, " +
             describe(Value(scenario.t_end_s)));
  if (scenario.samples != 1)
    fail(r, run.find("samples")->location,
         "`samples` in [run] is " + std::to_string(scenario.samples) +
             "; expected 1 with recorded frames: the start and the end");
  for (const std::int64_t steps : scenario.steps)
    if (steps % static_cast<std::int64_t>(ends.size()) != 0)
      fail(r, run.find("steps")->location,
           "`steps` in [run] has " + std::to_string(steps) + "; expected a multiple of the " +
               std::to_string(ends.size()) + " frames");
}

// Of scenes with fluids; left out where there is none.
Key<Scenario> ladder_key(std::string name, std::vector<double> Scenario::*member, std::string doc) {
  auto k = key<Scenario>(std::move(name), member, list_of(number(positive()), kMaxRungs), std::move(doc));
  const auto write = k.write;
  k.write = [write, member](const Scene& s, const Scenario& from) {
    return (from.*member).empty() ? Value() : write(s, from);
  };
  return k;
}

}  // namespace

const Keys<Scenario>& run_keys() {
  static const Keys<Scenario> keys = {
      required(key<Scenario>("t_end_s", &Scenario::t_end_s, number(positive()), "end of the run [s]")),
      steps_key(),
      required(key<Scenario>("samples", &Scenario::samples, integer(1, kMaxSamples),
                             "samples at t_end_s k / samples; divides every step count")),
      frames_key(),
      ladder_key("spacings_m", &Scenario::spacings_m,
                 "fluids: the ladder of the particles' spacing, from the coarsest to the finest [m]; `steps` are those "
                 "of the first, others take as many more as their spacing is smaller"),
      ladder_key("sound_speeds_m_per_s", &Scenario::sound_speeds_m_per_s,
                 "fluids: the ladder of the sound speed, growing [m/s]; `steps` are those of the first, others take as "
                 "many more as their speed is larger"),
  };
  return keys;
}

void check_run(Reading& r, const Value& run, const Scenario& scenario) {
  check_frames(r, run, scenario);
  const SourceLocation steps = run.find("steps")->location;
  if (scenario.steps.empty()) fail(r, steps, "`steps` in [run] is an empty list; expected at least one step count");
  for (std::size_t i = 0; i < scenario.steps.size(); ++i) {
    if (i > 0 && scenario.steps[i] <= scenario.steps[i - 1])
      fail(r, steps,
           "`steps` in [run] has " + std::to_string(scenario.steps[i]) + " after " +
               std::to_string(scenario.steps[i - 1]) + "; expected growing step counts");
    if (scenario.steps[i] % scenario.samples != 0)
      fail(r, run.find("samples")->location,
           "`samples` in [run] is " + std::to_string(scenario.samples) + ", which does not divide the step count " +
               std::to_string(scenario.steps[i]) + "; expected a divisor of every step count");
  }
}

}  // namespace atwood
