// tune ENGINE --class C: searches a tuned preset and keeps it in a file.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "reports/command_line/tune.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"
#include "validation/study/worker_client.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

std::string text_of_file(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

int command_tune(const Place& place, const Options& options) {
  const auto scene_class = rivals::scene_class_of(options.scene_class);
  if (!scene_class) {
    std::string names;
    for (const auto each : rivals::all_scene_classes()) names += (names.empty() ? "" : ", ") + rivals::to_string(each);
    throw InputError(
        fmt::format("--class {}: no such class of scenes; expected one of {}", options.scene_class, names));
  }
  const TuneRanges ranges = tune_ranges(options.input, *scene_class);
  const std::vector<Worker> workers = require_workers(place, options);
  for (const Worker& worker : workers) {
    const std::string name = std::filesystem::path(worker.path).filename().string();
    if (name == "atwood-" + (options.input == "atwood" ? std::string("engine") : options.input) &&
        worker.status != Status::ok)
      throw InputError(fmt::format("tune {}: {}: {}", options.input, to_string(worker.status), worker.reason));
  }
  std::vector<Scenario> catalogue = read_catalogue(place);
  if (!options.scenarios.empty()) {
    std::erase_if(catalogue, [&](const Scenario& scenario) {
      return std::none_of(options.scenarios.begin(), options.scenarios.end(),
                          [&](const std::string& pattern) { return glob_match(pattern, scenario.id); });
    });
    if (catalogue.empty()) throw InputError("--scenario: no scenario of the catalogue has one of these names");
  }
  make_out_dir(options.out_dir);
  TuneResult result;
  try {
    result = tune(place, options, workers, ranges, *scene_class, std::move(catalogue));
  } catch (const Interrupted&) {
    return 128 + std::max(interrupt_signal(), 2);
  }
  const std::string path = options.tuned_file.empty() ? options.out_dir + "/tuned.json" : options.tuned_file;
  const std::string entry = tuned_file_with("", result);
  write_file(path, tuned_file_with(text_of_file(path), result));
  if (options.json) {
    fmt::print("{}", entry);
  } else {
    fmt::print("{} on {}: {} trials, {} of which failed, {} tried on scenes held out, seed {}\n  {}\n", result.engine,
               result.scene_class, result.trials, result.failed, result.tried_held_out, result.seed, result.verdict);
    for (const TuneEvidence& e : result.evidence)
      fmt::print("    {:<9} {:<22} {:<20} default {:>9.3g}  tuned {:>9.3g}  +/- {:.1g}, {:.2f} x the time{}\n",
                 e.held_out ? "held out" : "training", e.scenario, e.metric, e.of_default, e.of_tuned, e.interval,
                 e.time_ratio, e.worse() ? "  WORSE" : "");
    fmt::print("{}\n", path);
  }
  return exit_pass;
}

}  // namespace atwood
