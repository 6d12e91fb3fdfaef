// bench: runs the benchmark executables and keeps their figures for the report.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

std::string capture(const std::vector<std::string>& words) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("pipe failed");
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    std::vector<char*> arguments;
    for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  if (child < 0) throw std::runtime_error("fork failed");
  std::string text;
  char buffer[65536];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error(fmt::format("{} failed", words[0]));
  return text;
}

namespace {

// Benchmarks of a catalogue step are named step/SCENARIO/METHOD/STEPS; METHOD contains one slash.
BenchFigure figure_of(const std::string& name, double median_ns, double p95_ns) {
  BenchFigure figure{"", "", 0, median_ns, p95_ns, name};
  std::vector<std::string> parts(1);
  for (const char c : name) {
    if (c == '/') parts.emplace_back();
    else parts.back() += c;
  }
  if (parts.size() >= 5 && parts[0] == "step") {
    figure.scenario = parts[1];
    figure.method = parts[2] + "/" + parts[3];
    figure.steps = std::strtoll(parts[4].c_str(), nullptr, 10);
  }
  return figure;
}

double quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const auto i = static_cast<std::size_t>(std::ceil(p * static_cast<double>(values.size()))) - 1;
  return values[std::min(i, values.size() - 1)];
}

// Repetitions of one name become a median and a 95th percentile.
void collect(const std::string& text, std::vector<BenchFigure>& figures) {
  const json document = json::parse(text);
  std::vector<std::pair<std::string, std::vector<double>>> runs;
  for (const auto& entry : document.at("benchmarks")) {
    if (entry.value("run_type", "") != "iteration" || entry.contains("error_occurred")) continue;
    std::string name = entry.at("run_name");
    for (const char* suffix : {"/manual_time", "/min_time:"})
      name = name.substr(0, name.find(suffix));  // how, not what
    double ns =
        entry.contains("ns_per_step") ? entry.at("ns_per_step").get<double>() : entry.at("cpu_time").get<double>();
    const std::string unit = entry.value("time_unit", "ns");
    if (!entry.contains("ns_per_step")) ns *= unit == "us" ? 1e3 : unit == "ms" ? 1e6 : unit == "s" ? 1e9 : 1;
    if (runs.empty() || runs.back().first != name) runs.push_back({name, {}});
    runs.back().second.push_back(ns);
  }
  for (const auto& [name, values] : runs)
    figures.push_back(figure_of(name, quantile(values, 0.5), quantile(values, 0.95)));
}

json read_document(const std::string& path) {
  const std::string text = read_bench_text(path);
  json document = text.empty() ? json::object() : json::parse(text, nullptr, false);
  return document.is_object() ? document : json::object();
}

}  // namespace

std::vector<BenchFigure> read_bench(const std::string& path) {
  std::vector<BenchFigure> figures;
  const json document = read_document(path);
  if (document.is_discarded() || !document.contains("figures")) return figures;
  for (const auto& f : document.at("figures")) {
    figures.push_back({f.value("scenario", ""), f.value("method", ""), f.value("steps", std::int64_t{0}),
                       f.value("ns_median", 0.0), f.value("ns_p95", 0.0), f.value("name", "")});
  }
  return figures;
}

namespace {

double real(const json& value) { return value.is_number() ? value.get<double>() : std::nan(""); }

json to_json(const GoalEntrant& e) {
  if (e.method.empty()) return nullptr;
  return {{"method", e.method},
          {"steps", e.steps},
          {"error", e.error},
          {"bar", e.bar},
          {"seconds", e.seconds},
          {"evaluations", e.evaluations},
          {"ns_per_step", e.ns_per_step},
          {"accurate", e.accurate}};  // numbers that are none become null
}

GoalEntrant entrant_from(const json& j) {
  if (!j.is_object()) return {};
  return {j.value("method", ""),  j.value("steps", std::int64_t{0}),
          real(j["error"]),       real(j["bar"]),
          real(j["seconds"]),     real(j["evaluations"]),
          real(j["ns_per_step"]), j.value("accurate", false)};
}

}  // namespace

std::vector<GoalResult> read_goal_results(const std::string& path) {
  std::vector<GoalResult> goals;
  json document = read_document(path);
  if (!document.contains("goals")) return goals;
  for (json& g : document["goals"]) {
    goals.push_back({g.value("id", ""),
                     g.value("title", ""),
                     g.value("scenario", ""),
                     g.value("metric", ""),
                     g.value("unit", ""),
                     real(g["wanted_error"]),
                     g.value("budget_kind", ""),
                     real(g["budget"]),
                     g.value("reached", false),
                     entrant_from(g["ours"]),
                     entrant_from(g["rival"]),
                     entrant_from(g["uncounted"]),
                     real(g["ratio"]),
                     real(g["ratio_low"]),
                     real(g["ratio_high"]),
                     g.value("why", ""),
                     g.value("wanted_ratio", 0.0),
                     entrant_from(g["same_rate"]),
                     entrant_from(g["library"]),
                     real(g["same_rate_ratio"]),
                     real(g["same_rate_low"]),
                     real(g["same_rate_high"])});
  }
  return goals;
}

void keep_bench(const std::string& path, const Provenance& provenance, const std::vector<BenchFigure>* figures,
                const std::vector<GoalResult>* goals) {
  json document = read_document(path);
  document.update({{"commit", provenance.commit},
                   {"compiler", provenance.compiler},
                   {"flags", provenance.flags},
                   {"cpu", provenance.cpu}});
  if (figures != nullptr) {
    document["figures"] = json::array();
    for (const auto& f : *figures) {
      document["figures"].push_back({{"name", f.name},
                                     {"scenario", f.scenario},
                                     {"method", f.method},
                                     {"steps", f.steps},
                                     {"ns_median", f.ns_per_step_median},
                                     {"ns_p95", f.ns_per_step_p95}});
    }
  }
  if (goals != nullptr) {
    document["goals"] = json::array();
    for (const auto& g : *goals) {
      document["goals"].push_back({{"id", g.id},
                                   {"title", g.title},
                                   {"scenario", g.scenario},
                                   {"metric", g.metric},
                                   {"unit", g.unit},
                                   {"wanted_error", g.wanted_error},
                                   {"budget_kind", g.budget_kind},
                                   {"budget", g.budget},
                                   {"reached", g.reached},
                                   {"ours", to_json(g.ours)},
                                   {"rival", to_json(g.rival)},
                                   {"uncounted", to_json(g.uncounted)},
                                   {"ratio", g.ratio},
                                   {"ratio_low", g.ratio_low},
                                   {"ratio_high", g.ratio_high},
                                   {"why", g.why},
                                   {"wanted_ratio", g.wanted_ratio},
                                   {"same_rate", to_json(g.same_rate)},
                                   {"library", to_json(g.library)},
                                   {"same_rate_ratio", g.same_rate_ratio},
                                   {"same_rate_low", g.same_rate_low},
                                   {"same_rate_high", g.same_rate_high}});
    }
  }
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  write_file(path, document.dump(1) + "\n");
}

std::vector<BenchFigure> run_benchmarks(const Place& place, const std::string& filter) {
  std::vector<std::string> executables;
  for (const auto& entry : fs::directory_iterator(place.bin_dir)) {
    if (entry.path().filename().string().rfind("atwood-bench-", 0) == 0) executables.push_back(entry.path().string());
  }
  std::sort(executables.begin(), executables.end());
  std::vector<BenchFigure> figures;
  for (const auto& executable : executables) {
    fmt::print(stderr, "atwood: {}\n", fs::path(executable).filename().string());
    std::vector<std::string> words{executable, "--benchmark_format=json", "--benchmark_repetitions=5",
                                   "--benchmark_min_time=0.02"};
    if (!filter.empty()) words.push_back("--benchmark_filter=" + filter);
    const auto text = capture(words);
    if (text.find('{') == std::string::npos) continue;  // the filter left nothing of this executable
    collect(text.substr(text.find('{')), figures);
  }
  return figures;
}

int command_bench(const Place& place, const Options& options) {
  if (options.input == "goals") return command_goals(place, options);
  if (options.input == "broad-phases") return command_broad_phases(place, options);
  if (options.input == "frame-budget") return command_frame_budget(place, options);
  const bool any = std::any_of(fs::directory_iterator(place.bin_dir), fs::directory_iterator(), [](const auto& entry) {
    return entry.path().filename().string().rfind("atwood-bench-", 0) == 0;
  });
  if (!any) throw InputError("no benchmarks are built; `./atwood bench` builds them");
  const std::vector<BenchFigure> figures = run_benchmarks(place, options.input);
  if (figures.empty()) throw InputError(fmt::format("no benchmark matches `{}`", options.input));
  keep_bench(options.out_dir + "/bench.json", place.provenance, &figures, nullptr);
  if (options.json) {
    fmt::print("{}\n", read_document(options.out_dir + "/bench.json").dump(2));
  } else {
    fmt::print("{:<64} {:>14} {:>14}\n", "benchmark", "median [ns]", "p95 [ns]");
    for (const auto& f : figures)
      fmt::print("{:<64} {:>14.1f} {:>14.1f}\n", f.name, f.ns_per_step_median, f.ns_per_step_p95);
    fmt::print("\n{}/bench.json; `atwood report` shows them\n", options.out_dir);
  }
  return exit_pass;
}

}  // namespace atwood
