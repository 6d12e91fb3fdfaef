// atwood-truth-fuzz: solves random scenes by the truths and compares them with independent solutions in 60 digits. An
// error above the truth's bar is a breach; none is allowed.
//
//   atwood-truth-fuzz --list
//   atwood-truth-fuzz --pair 'closed-form/*' --answered 10000 --log fuzz.tsv
//
// The log holds one line per scene (pair, seed, index, outcome, largest error in bars, build, reason); a campaign with
// the same seed and build continues where its log ends. The build is a hash of the program, which holds the truths:
// scenes of another build are solved again, and a new commit that changes no truth goes on. Exit code: 0; 1 when a bar
// was breached or more scenes were refused than the pair allows; 2 for usage; 3 when a pair ended incomplete, with
// fewer answered scenes than asked (unless --may-be-incomplete).
#include <fmt/core.h>
#include <fnmatch.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "kinds.hpp"
#include "scene/files.hpp"
#include "truth/truth.hpp"

using namespace atwood;
using namespace atwood::fuzz;

namespace {

struct Settings {
  std::string pair = "*", log;
  std::uint64_t seed = 1784;
  int answered = 100;
  double most_seconds = 1e9;  // per pair
  bool may_be_incomplete = false;
  std::int64_t show = -1;
  std::string build;  // a hash of this program
};

enum class Result { held, breach, refused, unchecked };
const char* const kResults[] = {"held", "breach", "refused", "unchecked"};

struct Judged {
  Result result = Result::held;
  double worst = 0;
  std::string reason;
};

// The largest error in bars. A value is left out if the checker's own error exceeds a tenth of the truth's bar, unless
// the truth breaches its bar by more than the checker's error.
struct Comparison {
  Judged made;
  double unsharp = 0;

  void hold(Wide value, Wide bar, const Long& is, const Long& own, const std::string& what) {
    const Long off = abs(widened(value) - is), allowed = widened(bar);
    if (!(off <= allowed + own)) {
      const double ratio = allowed > 0 && off == off ? static_cast<double>(off / allowed) : HUGE_VAL;
      if (made.result != Result::breach || ratio > made.worst)
        made = {Result::breach, ratio,
                fmt::format("{} is off by {:.2e} with a bar of {:.2e}", what, static_cast<double>(off),
                            static_cast<double>(allowed))};
      return;
    }
    if (allowed == 0 && own < Long(1e-36) * (1 + abs(is))) return;  // both are exact, as for a body that never moves
    if (own > allowed / 10) unsharp = std::max(unsharp, allowed > 0 ? static_cast<double>(own / allowed) : HUGE_VAL);
    if (made.result != Result::breach && allowed > 0)
      made.worst = std::max(made.worst, static_cast<double>(off / allowed));
  }
  void hold_body(const BodySample& value, const BodySample& bar, const LongBody& is, const LongBody& own,
                 const std::string& at) {
    for (int c = 0; c < 3; ++c) {
      hold(value.p_m[c], bar.p_m[c], is.p[c], own.p[c], "position" + at);
      hold(value.v_m_per_s[c], bar.v_m_per_s[c], is.v[c], own.v[c], "velocity" + at);
      hold(value.w_rad_per_s[c], bar.w_rad_per_s[c], is.w[c], own.w[c], "body rate" + at);
    }
    for (int c = 0; c < 4; ++c) hold(value.q_wxyz[c], bar.q_wxyz[c], is.q[c], own.q[c], "orientation" + at);
  }
  // A component of a reaction is judged unless both the truth and the checker report none.
  void hold_reaction(const std::array<Wide, 3>& value, const std::array<Wide, 3>& bar, const Long3& is,
                     const Long3& own, const std::string& what) {
    for (int c = 0; c < 3; ++c)
      if (value[c] == value[c] || is[c] == is[c]) hold(value[c], bar[c], is[c], own[c], what);
  }
  void hold_joint(const JointSample& value, const JointSample& bar, const LongJoint& is, const LongJoint& own,
                  bool reactions, const std::string& at) {
    for (int c = 0; c < 4; ++c) hold(value.q[c], bar.q[c], is.q[c], own.q[c], "coordinate" + at);
    for (int c = 0; c < 3; ++c) hold(value.u[c], bar.u[c], is.u[c], own.u[c], "rate" + at);
    if (!reactions) return;
    hold_reaction(value.force_N, bar.force_N, is.force, own.force, "force" + at);
    hold_reaction(value.torque_N_m, bar.torque_N_m, is.torque, own.torque, "torque" + at);
  }
  void hold_rope(const RopeSample& value, const RopeSample& bar, const LongRope& is, const LongRope& own,
                 const std::string& at) {
    if (value.pulley_angle_rad.size() != is.angles.size()) {
      made = {Result::breach, HUGE_VAL, "another number of pulleys" + at};
      return;
    }
    hold(value.tension_N, bar.tension_N, is.tension, own.tension, "tension" + at);
    for (std::size_t p = 0; p < is.angles.size(); ++p)
      hold(value.pulley_angle_rad[p], bar.pulley_angle_rad[p], is.angles[p], own.angles[p], "pulley" + at);
  }
};

void hold_events(const Truth& truth, const Checked& exact, const Long& t_end_s, Comparison& compared) {
  // An event whose bar holds the end may be there or not.
  const std::size_t count = truth.events.size();
  for (std::size_t e = 0; e < std::min(count, exact.event_s.size()); ++e)
    compared.hold(truth.events[e].t_s, truth.event_bar_s[e], exact.event_s[e], exact.event_own_s[e],
                  fmt::format("time of event {}", e));
  const auto inside = [&](const Long& t) { return t < t_end_s * (1 - Long(1e-15)); };
  if ((count < exact.event_s.size() && inside(exact.event_s[count])) ||
      (count > exact.event_s.size() && inside(widened(truth.events[exact.event_s.size()].t_s))))
    compared.made = {Result::breach, HUGE_VAL, fmt::format("{} events instead of {}", count, exact.event_s.size())};
}

Judged judge(const Truth& truth, const Checked& exact, double t_end_s) {
  Comparison compared;
  if (truth.values.size() != exact.values.size()) return {Result::unchecked, 0, "another number of samples"};
  for (std::size_t k = 1; k < truth.values.size(); ++k) {
    const Sample &value = truth.values[k], &bar = truth.bars[k];
    const auto at = [&](const char* what, std::size_t i) { return fmt::format(" of {} {} at sample {}", what, i, k); };
    for (std::size_t i = 0; i < value.bodies.size(); ++i)
      compared.hold_body(value.bodies[i], bar.bodies[i], exact.values[k][i], exact.own[k][i], at("body", i));
    if ((!exact.joints.empty() && value.joints.size() != exact.joints[k].size()) ||
        (!exact.ropes.empty() && value.ropes.size() != exact.ropes[k].size()))
      return {Result::breach, HUGE_VAL, fmt::format("another number of joints or ropes at sample {}", k)};
    if (!exact.joints.empty())
      for (std::size_t j = 0; j < value.joints.size(); ++j)
        compared.hold_joint(value.joints[j], bar.joints[j], exact.joints[k][j], exact.joints_own[k][j], exact.reactions,
                            at("joint", j));
    if (!exact.ropes.empty())
      for (std::size_t r = 0; r < value.ropes.size(); ++r)
        compared.hold_rope(value.ropes[r], bar.ropes[r], exact.ropes[k][r], exact.ropes_own[k][r], at("rope", r));
  }
  if (exact.has_events) hold_events(truth, exact, t_end_s, compared);
  if (compared.made.result == Result::held && compared.unsharp > 0)
    return {Result::unchecked, compared.made.worst,
            fmt::format("the checker's own bar is {:.1e} of the truth's", compared.unsharp)};
  return compared.made;
}

// FNV-1a, 64 bits, of the running program.
std::string hash_of_program() {
  std::ifstream in("/proc/self/exe", std::ios::binary);
  std::uint64_t hash = 14695981039346656037ull;
  std::vector<char> block(1 << 16);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())), in.gcount() > 0)
    for (std::streamsize k = 0; k < in.gcount(); ++k)
      hash = (hash ^ static_cast<unsigned char>(block[static_cast<std::size_t>(k)])) * 1099511628211ull;
  return fmt::format("{:016x}", hash);
}

Scenario scene_of(const Kind& kind, const Settings& settings, std::uint64_t index) {
  Random random(settings.seed, index);
  Scenario scenario = kind.scene(random, index % 2 == 1);
  return scenario;
}

Judged try_scene(const Kind& kind, const Scenario& scenario) {
  const Truth truth = solve_truth(scenario, scenario.samples);
  if (truth.outcome.status != Status::ok) return {Result::refused, 0, truth.outcome.reason};
  const Checked exact = kind.check(scenario, scenario.samples);
  if (!exact.refused.empty()) return {Result::unchecked, 0, exact.refused};
  return judge(truth, exact, scenario.t_end_s);
}

struct Tally {
  std::uint64_t next = 0;
  int count[4]{};
  double worst = 0;
  void add(Result result, double ratio) {
    ++count[static_cast<int>(result)];
    if (result == Result::held) worst = std::max(worst, ratio);
    ++next;
  }
  int answered() const { return count[0] + count[1]; }
  int all() const { return count[0] + count[1] + count[2] + count[3]; }
};

Tally read_log(const Settings& settings, const std::string& pair) {
  Tally tally;
  std::ifstream in(settings.log);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string of, result, build;
    std::uint64_t seed = 0, index = 0;
    double worst = 0;
    if (!(words >> of >> seed >> index >> result >> worst >> build) || of != pair || seed != settings.seed ||
        build != settings.build)
      continue;
    for (int k = 0; k < 4; ++k)
      if (result == kResults[k] && index == tally.next) tally.add(static_cast<Result>(k), worst);
  }
  return tally;
}

enum class Ended { well, incomplete, failed };  // the worst of several is the largest

Ended campaign(const Kind& kind, const Settings& settings) {
  const std::string pair = kind.truth + "/" + kind.name;
  Tally tally = settings.log.empty() ? Tally{} : read_log(settings, pair);
  std::ofstream log;
  if (!settings.log.empty()) log.open(settings.log, std::ios::app);
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  // Ends at four times the count, because a kind whose scenes are nearly all refused would never end.
  while (tally.answered() < settings.answered && tally.all() < 4 * settings.answered &&
         seconds() < settings.most_seconds) {
    const std::uint64_t index = tally.next;
    const Judged judged = try_scene(kind, scene_of(kind, settings, index));
    tally.add(judged.result, judged.worst);
    if (log.is_open())
      log << fmt::format("{}\t{}\t{}\t{}\t{:.3g}\t{}\t{}\n", pair, settings.seed, index,
                         kResults[static_cast<int>(judged.result)], judged.worst, settings.build, judged.reason)
          << std::flush;
    if (judged.result == Result::breach)
      fmt::print("BREACH {} --seed {} --show {}: {} ({:.3g} bars)\n", pair, settings.seed, index, judged.reason,
                 judged.worst);
  }
  const int all = tally.all(), left = all - tally.answered();
  // The share is judged where chance alone would not exceed it: two standard deviations, and one scene.
  const double share = kind.most_refused, allowed = all * share + 2 * std::sqrt(all * share * (1 - share)) + 1;
  const bool many = left > allowed, incomplete = tally.answered() < settings.answered;
  fmt::print("{:36} {:6} answered, {} breached, worst {:.2g} bars; {} refused, {} not checked{}{}\n", pair,
             tally.answered(), tally.count[1], tally.worst, tally.count[2], tally.count[3],
             many ? fmt::format(": more than {:.3g} %", 100 * share) : "",
             incomplete ? fmt::format("; INCOMPLETE, {} asked", settings.answered) : "");
  if (tally.count[1] > 0 || many) return Ended::failed;
  return incomplete && !settings.may_be_incomplete ? Ended::incomplete : Ended::well;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  Settings settings;
  bool list = false;
  CLI::App app("Random scenes solved by the truths and judged by checkers of 60 digits.");
  app.add_flag("--list", list, "print the pairs of truth and kind of scene");
  app.add_option("--pair", settings.pair, "glob of pairs");
  app.add_option("--answered", settings.answered, "scenes a pair that must be answered")->check(CLI::PositiveNumber);
  app.add_option("--seed", settings.seed, "of the scenes");
  app.add_option("--log", settings.log, "file of outcomes; a campaign of the same build goes on where it ends");
  app.add_option("--most-seconds", settings.most_seconds, "a pair; it then ends with fewer scenes")
      ->check(CLI::PositiveNumber);
  app.add_flag("--may-be-incomplete", settings.may_be_incomplete, "a pair that --most-seconds ended is no failure");
  app.add_option("--show", settings.show, "print one scene as JSON, and its judgement");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  settings.build = hash_of_program();
  Ended ended = Ended::well;
  bool any = false;
  for (const Kind& kind : kinds()) {
    const std::string pair = kind.truth + "/" + kind.name;
    if (fnmatch(settings.pair.c_str(), pair.c_str(), 0) != 0) continue;
    any = true;
    if (list) {
      fmt::print("{}\n", pair);
    } else if (settings.show >= 0) {
      const Scenario scenario = scene_of(kind, settings, static_cast<std::uint64_t>(settings.show));
      const Judged judged = try_scene(kind, scenario);
      fmt::print("{}\n{}: {} ({:.3g} bars) {}\n", scenario_to_json(scenario), pair,
                 kResults[static_cast<int>(judged.result)], judged.worst, judged.reason);
      if (judged.result == Result::breach) ended = Ended::failed;
    } else {
      ended = std::max(ended, campaign(kind, settings));
    }
  }
  if (!any) fmt::print(stderr, "no pair `{}`; --list names them\n", settings.pair);
  if (!any) return 2;
  return ended == Ended::failed ? 1 : ended == Ended::incomplete ? 3 : 0;
}
