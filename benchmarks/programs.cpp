#include "benchmarks/programs.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "benchmarks/bench_file.hpp"
#include "benchmarks/stopwatch.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

// Benchmarks of a catalogue step are named step/SCENARIO/METHOD/STEPS; METHOD contains one slash.
BenchFigure figure_of(const std::string& name, const std::vector<double>& ns) {
  BenchFigure figure;
  figure.ns_per_step = metrics::median_interval(ns);
  figure.ns_per_step_p95 = ns.size() < metrics::kMinForP95 ? std::nan("") : metrics::nearest_rank(ns, 0.95);
  figure.name = name;
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

// Repetitions of one name become a median with its interval.
void collect(const std::string& text, std::vector<BenchFigure>& figures) {
  const json document = json::parse(text);
  std::vector<std::pair<std::string, std::vector<double>>> runs;
  for (const auto& entry : document.at("benchmarks")) {
    if (entry.value("run_type", "") != "iteration" || entry.contains("error_occurred")) continue;
    std::string name = entry.at("run_name");
    for (const char* suffix : {"/manual_time", "/min_time:"})
      name = name.substr(0, name.find(suffix));  // suffixes that say how it was timed
    double ns =
        entry.contains("ns_per_step") ? entry.at("ns_per_step").get<double>() : entry.at("cpu_time").get<double>();
    const std::string unit = entry.value("time_unit", "ns");
    if (!entry.contains("ns_per_step")) ns *= unit == "us" ? 1e3 : unit == "ms" ? 1e6 : unit == "s" ? 1e9 : 1;
    if (runs.empty() || runs.back().first != name) runs.push_back({name, {}});
    runs.back().second.push_back(ns);
  }
  for (const auto& [name, values] : runs) figures.push_back(figure_of(name, values));
}

}  // namespace

std::vector<std::string> benchmark_programs(const std::string& bin_dir) {
  std::vector<std::string> programs;
  for (const auto& entry : fs::directory_iterator(bin_dir)) {
    if (entry.path().filename().string().rfind("atwood-bench-", 0) == 0) programs.push_back(entry.path().string());
  }
  std::sort(programs.begin(), programs.end());
  return programs;
}

std::vector<std::string> benchmark_programs(const std::string& bin_dir, const std::string& filter) {
  // As Google Benchmark reads it. A program without a match would say so on standard error, so it is not run.
  const std::regex pattern(filter, std::regex::extended | std::regex::nosubs);
  std::vector<std::string> programs = benchmark_programs(bin_dir);
  std::erase_if(programs, [&](const std::string& program) {
    std::istringstream names(capture({program, "--benchmark_list_tests"}));
    for (std::string name; std::getline(names, name);)
      if (std::regex_search(name, pattern)) return false;
    return true;
  });
  return programs;
}

std::vector<BenchFigure> run_benchmarks(const std::vector<std::string>& programs, const std::string& filter,
                                        const std::function<void(const std::string&)>& notice) {
  std::vector<BenchFigure> figures;
  for (const std::string& program : programs) {
    notice(fs::path(program).filename().string());
    std::vector<std::string> words{program, "--benchmark_format=json", "--benchmark_repetitions=5",
                                   fmt::format("--benchmark_min_time={}", kTimingS)};
    if (!filter.empty()) words.push_back("--benchmark_filter=" + filter);
    const auto text = capture(words);
    collect(text.substr(text.find('{')), figures);
  }
  return figures;
}

Measured<std::vector<BenchFigure>> calmest_benchmarks(const std::string& bin_dir, const std::string& filter) {
  const std::vector<std::string> programs = benchmark_programs(bin_dir, filter);
  return calmest([&] {
    const auto ended = [] {
      rusage used{};
      getrusage(RUSAGE_CHILDREN, &used);
      return used;
    };
    const auto seconds = [](const rusage& used) {
      return static_cast<double>(used.ru_utime.tv_sec) + 1e-6 * static_cast<double>(used.ru_utime.tv_usec);
    };
    Measured<std::vector<BenchFigure>> measured;
    const rusage before = ended();
    const double ghz = clock_rate_ghz();
    measured.figures = run_benchmarks(programs, filter, [](const std::string&) {});
    const double ghz_after = clock_rate_ghz();
    const rusage after = ended();
    MachineState& machine = measured.machine;
    machine.timings = std::llround((seconds(after) - seconds(before)) / kTimingS);
    const std::int64_t of_starts = 2 * std::ssize(programs);  // a program's start and end count as two
    machine.interrupted = std::clamp<std::int64_t>(after.ru_nivcsw - before.ru_nivcsw - of_starts, 0, machine.timings);
    machine.ghz_low = std::min(ghz, ghz_after), machine.ghz_high = std::max(ghz, ghz_after);
    return measured;
  });
}

std::vector<BenchTable> measure_broad_phases(const std::string& bin_dir) {
  const std::string program = bin_dir + "/atwood-broad-phases";
  if (!fs::exists(program))
    throw InputError("the comparison of broad phases is not here; `./atwood bench` in the project's folder builds it");
  return bench_tables_from(capture({program}));
}

}  // namespace atwood
