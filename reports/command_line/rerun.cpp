// Commands that do a part of this call again, in any folder: words first, a shell's line where they are printed.
#include <filesystem>

#include <fmt/format.h>

#include "reports/command_line/verdicts.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

// A path that means the same file in any other folder. Links are left as they are.
std::string absolute_words(const std::string& path) {
  if (path.empty()) return path;
  fs::path whole;
  for (const fs::path& part : fs::absolute(path))
    if (part != ".") whole /= part;
  return whole.string();
}

// Of a word that may also be an id or a glob.
std::string absolute_if_file(const std::string& word) {
  std::error_code error;
  return fs::is_regular_file(word, error) ? absolute_words(word) : word;
}

}  // namespace

// The command that reruns a verdict's cell must bring along what the catalogue does not have: a scene's file, an
// engine, gates.
std::vector<std::string> with_own_files(const Place& place, const Options& options, const Selection& selection,
                                        const std::string& scenario_id, std::vector<std::string> words) {
  if (words.empty()) return words;
  if (!options.words.empty()) words[0] = options.words[0];
  for (const auto& scenario : selection.scenarios) {
    if (scenario.id != scenario_id || own_file(place, scenario).empty()) continue;
    for (std::size_t i = 1; i < words.size(); ++i)
      if (words[i - 1] == "--scenario" && words[i] == scenario.id) words[i] = absolute_words(scenario.path);
  }
  if (!options.study.empty() && words.size() > 1 && words[1] == "run")
    words.insert(words.begin() + 2, absolute_if_file(options.study));
  const auto add = [&](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  for (const auto& engine : options.engines) add("--engine", absolute_if_file(engine));
  if (options.no_sandbox) words.push_back("--no-sandbox");
  if (options.memory_GiB != Options{}.memory_GiB) add("--memory", fmt::format("{:g}", options.memory_GiB));
  add("--tolerances", absolute_words(options.tolerances));
  add("--baseline", absolute_words(options.baseline));
  if (options.limit_given) add("--limit", fmt::format("{}", options.cell_limit_s));
  add("--out", absolute_words(options.out_dir));
  return words;
}

std::vector<std::string> filter_words(const Options& options) {
  std::vector<std::string> words;
  const auto add = [&](const char* flag, const std::string& value) { words.insert(words.end(), {flag, value}); };
  for (const std::string& scenario : options.scenarios) add("--scenario", scenario);
  for (const std::string& method : options.methods) add("--method", method);
  if (options.hz.empty())
    for (const std::int64_t steps : options.steps) add("--steps", std::to_string(steps));
  for (const double hz : options.hz) add("--hz", fmt::format("{}", hz));
  for (const double spacing : options.spacings) add("--spacing", fmt::format("{}", spacing));
  for (const double speed : options.sound_speeds) add("--sound-speed", fmt::format("{}", speed));
  return words;
}

std::vector<std::string> same_call_words(const Options& options, const std::string& command,
                                         const std::string& baseline) {
  std::vector<std::string> words{options.words.empty() ? "atwood" : options.words.front(), command};
  const auto add = [&](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  if (!options.study.empty()) words.push_back(absolute_if_file(options.study));
  const std::vector<std::string> filters = filter_words(options);
  for (std::size_t i = 0; i + 1 < filters.size(); i += 2)
    add(filters[i].c_str(), filters[i] == "--scenario" ? absolute_if_file(filters[i + 1]) : filters[i + 1]);
  for (const std::string& engine : options.engines) add("--engine", absolute_if_file(engine));
  if (options.no_sandbox) words.push_back("--no-sandbox");
  if (command == "run" && options.memory_GiB != Options{}.memory_GiB)
    add("--memory", fmt::format("{:g}", options.memory_GiB));
  if (command == "run") add("--tolerances", absolute_words(options.tolerances));
  if (command == "run" && options.limit_given) add("--limit", fmt::format("{}", options.cell_limit_s));
  if (command == "bless") {
    add("--reason", "TEXT");
    add("--baseline", absolute_words(baseline));
  }
  add("--out", absolute_words(options.out_dir));
  return words;
}

std::string same_call(const Options& options, const std::string& command, const std::string& baseline) {
  return shell_line(same_call_words(options, command, baseline));
}

}  // namespace atwood
