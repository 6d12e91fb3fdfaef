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

#include "judgement.hpp"
#include "kinds.hpp"
#include "scene/files.hpp"
#include "truth/truth.hpp"

using namespace atwood;
using namespace atwood::fuzz;

namespace {

const char* const kResults[] = {"held", "breach", "refused", "unchecked"};  // as in Result

struct Settings {
  std::string pair = "*", log;
  std::uint64_t seed = 1784;
  int answered = 100;
  double most_seconds = 1e9;  // per pair
  bool may_be_incomplete = false;
  std::int64_t show = -1;
  std::string build;  // a hash of this program
};

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

// The largest bar of a position at the end, over the largest distance from the origin.
double widest_bar(const Truth& truth) {
  double widest = 0, size = 0;
  for (const SampleView value : truth.values)
    for (const BodySample& body : value.bodies)
      for (const Wide x : body.p_m) size = std::max(size, std::fabs(static_cast<double>(x)));
  for (const BodySample& body : truth.bars.back().bodies)
    for (const Wide x : body.p_m) widest = std::max(widest, static_cast<double>(x));
  return size > 0 ? widest / size : widest;
}

Judged try_scene(const Kind& kind, const Scenario& scenario, std::int64_t samples) {
  const Truth truth = solve_truth(scenario, samples);
  if (truth.outcome.status != Status::ok) return {Result::refused, 0, truth.outcome.reason};
  const Checked exact = kind.check(scenario, samples);
  if (!exact.refused.empty()) return {Result::unchecked, 0, exact.refused};
  Judged made = judge(truth, exact, scenario.t_end_s);
  if (made.result == Result::held && !kind.counts.empty())
    if (const double widest = widest_bar(truth); widest > 1e-9)
      return {Result::refused, made.worst, fmt::format("a bar of {:.1e} of the size", widest)};
  return made;
}

// The worst of the answers with each number of samples.
Judged try_scene(const Kind& kind, const Scenario& scenario) {
  if (kind.counts.empty()) return try_scene(kind, scenario, scenario.samples);
  const auto rank = [](Result result) { return result == Result::breach ? 3 : result == Result::held ? 0 : 1; };
  Judged worst;
  for (const std::int64_t samples : kind.counts) {
    Judged now = try_scene(kind, scenario, samples);
    now.reason += fmt::format(" ({} samples)", samples);
    if (rank(now.result) > rank(worst.result) || (rank(now.result) == rank(worst.result) && now.worst > worst.worst))
      worst = now;
  }
  return worst;
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
