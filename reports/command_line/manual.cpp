#include "reports/command_line/manual.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

// The name of an option's value in help texts, by the option's long name. CLI11 names numbers.
const std::map<std::string, std::string>& value_names() {
  static const std::map<std::string, std::string> names{{"--scenario", "SCENE"},
                                                        {"--method", "METHOD"},
                                                        {"--as", "METHOD"},
                                                        {"--engine", "FILE"},
                                                        {"--metric", "METRIC"},
                                                        {"--at", "SECONDS"},
                                                        {"--steps", "COUNT"},
                                                        {"--samples", "COUNT"},
                                                        {"--out", "DIR"},
                                                        {"--output", "FORMAT:FILE"},
                                                        {"--junit", "FILE"},
                                                        {"--tolerances", "FILE"},
                                                        {"--baseline", "FILE"},
                                                        {"--against", "RUN|FILE"},
                                                        {"--goals", "FILE"},
                                                        {"--goal", "GOAL"},
                                                        {"--error", "ERROR"},
                                                        {"--budget", "TIME"},
                                                        {"--max", "METRIC=VALUE"},
                                                        {"--reason", "WORDS"},
                                                        {"--limit", "SECONDS"},
                                                        {"--memory", "GIB"},
                                                        {"--jobs", "COUNT"},
                                                        {"--hz", "HZ"},
                                                        {"--time", "SECONDS"},
                                                        {"--shard", "I/N"},
                                                        {"--costs", "FILE"},
                                                        {"--lease", "DIR"},
                                                        {"--lease-expiry", "SECONDS"},
                                                        {"--prune-keep", "N"},
                                                        {"--prune-older", "DAYS"},
                                                        {"--keep", "all|worst|none"},
                                                        {"--spacing", "METRES"},
                                                        {"--sound-speed", "M/S"},
                                                        {"--max-cells", "COUNT"},
                                                        {"--trials", "COUNT"},
                                                        {"--seed", "SEED"},
                                                        {"--class", "CLASS"},
                                                        {"--file", "FILE"}};
  return names;
}

std::string usage(const CLI::App& app) {
  std::string line = "atwood";
  if (app.get_parent() == nullptr) return line + " COMMAND [OPTIONS] ...";
  line += " " + app.get_name() + " [OPTIONS]";
  for (const OptionWords& option : options_of(app)) {
    if (!option.names.empty()) {
      if (option.required) line += fmt::format(" {} {}", option.names.back(), option.value);
      continue;
    }
    const std::string word = option.value + (option.many ? " ..." : "");
    line += option.required ? " " + word : " [" + word + "]";
  }
  return line;
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (text.find("  ") != std::string::npos) text.replace(text.find("  "), 2, " ");
  return text;
}

// A name on the left and its meaning on the right, or below where the name is long or the terminal narrow.
std::string entry(const std::string& name, const std::string& doc, std::size_t column, std::size_t width) {
  std::string text = wrapped(one_line(doc), column, width);
  if (name.size() + 4 > column || width < column + 24)
    return "  " + name + "\n" + wrapped(one_line(doc), width < column + 24 ? 6 : column, width);
  text.replace(2, name.size(), name);
  return text;
}

std::string words_of(const OptionWords& option) {
  const std::string names = fmt::format("{}", fmt::join(option.names, ", "));
  return names.empty() ? option.value : option.value.empty() ? names : names + " " + option.value;
}

std::string doc_of(const OptionWords& option) {
  return option.preset.empty() ? option.doc : option.doc + " (default: " + option.preset + ")";
}

}  // namespace

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); });
}

namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const OptionWords& option : options_of(app)) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::string out, line;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && indent + line.size() + 1 + word.size() > width) {
      out += std::string(indent, ' ') + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    at = end + 1;
  }
  return line.empty() ? out : out + std::string(indent, ' ') + line + "\n";
}

void name_values(CLI::App& app) {
  for (CLI::App* sub : app.get_subcommands([](CLI::App*) { return true; })) {
    const bool one_file = sub->get_name() == "merge" || sub->get_name() == "costs" || sub->get_name() == "import";
    for (CLI::Option* option : sub->get_options([](CLI::Option*) { return true; })) {
      if (option->get_items_expected_max() == 0) continue;  // a flag
      for (const std::string& name : option->get_lnames()) {
        if (const auto known = value_names().find("--" + name); known != value_names().end())
          option->type_name(name == "output" && one_file ? "FILE" : known->second);
      }
    }
  }
}

std::vector<OptionWords> options_of(const CLI::App& app) {
  std::vector<OptionWords> found;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    OptionWords words;
    for (const std::string& name : option->get_snames()) words.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) words.names.push_back("--" + name);
    if (option->get_positional() && words.names.empty()) words.value = option->get_name(true);
    else if (option->get_items_expected_max() > 0)
      words.value = option->get_type_name().substr(
          0, option->get_type_name().starts_with("FORMAT") ? std::string::npos : option->get_type_name().find(':'));
    words.doc = option->get_description();
    words.preset = option->get_default_str();
    words.required = option->get_required();
    words.many = option->get_expected_max() > 1;
    found.push_back(words);
  }
  return found;
}

std::string help_text(const CLI::App& app, int columns) {
  const auto width = static_cast<std::size_t>(std::clamp(columns, 40, 110));
  std::string text = app.get_description() + "\n";
  text = wrapped(app.get_description(), 0, width) + "\n" + wrapped("Usage: " + usage(app), 0, width) + "\n";
  const auto section = [&](const char* title, bool positional, std::size_t column) {
    std::string lines;
    for (const OptionWords& option : options_of(app)) {
      if (option.names.empty() == positional) lines += entry(words_of(option), doc_of(option), column, width);
    }
    if (!lines.empty()) text += title + lines + "\n";
  };
  if (app.get_parent() == nullptr) {
    text += "Commands:\n";
    for (const CLI::App* sub : commands_of(app)) text += entry(sub->get_name(), sub->get_description(), 14, width);
    text += "\n";
  }
  section("Arguments:\n", true, 26);
  section("Options:\n", false, 26);
  if (app.get_parent() == nullptr)
    text += wrapped("`atwood help COMMAND` shows a command's options, `atwood help --man` the manual page.", 0, width);
  const CLI::App& root = app.get_parent() ? *app.get_parent() : app;
  return text + wrapped(one_line(root.get_footer()), 0, width);
}

// ---- the man page -------------------------------------------------------------------------------------------------
namespace {

std::string roff(const std::string& text) {
  std::string out;
  for (const char c : one_line(text)) {
    if (c == '\\') out += "\\e";
    else if (c == '-') out += "\\-";
    else out += c;
  }
  while (!out.empty() && out.front() == ' ') out.erase(0, 1);
  if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out = "\\&" + out;
  return out;
}

std::string roff_options(const CLI::App& app) {
  std::string text;
  for (const OptionWords& option : options_of(app)) {
    std::string names;
    for (const std::string& name : option.names) names += (names.empty() ? "\\fB" : ", \\fB") + roff(name) + "\\fR";
    if (!option.value.empty()) names += (names.empty() ? "\\fI" : " \\fI") + roff(option.value) + "\\fR";
    text += ".TP\n" + names + "\n" + roff(doc_of(option)) + "\n";
  }
  return text;
}

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string text = fmt::format(".TH ATWOOD 1 \"\" \"{}\" \"User Commands\"\n", roff(app.version()));
  text += ".SH NAME\natwood \\- verifies and benchmarks the numerical accuracy of physics engines\n";
  text += ".SH SYNOPSIS\n.B atwood\n.I COMMAND\n[\\fIOPTIONS\\fR] ...\n";
  text += ".SH DESCRIPTION\n" + roff(app.get_description()) + "\n";
  text +=
      ".PP\nA scene is an id of the catalogue or a file. A method is written \\fIengine\\fR/\\fIscheme\\fR"
      "[:\\fIrtol\\fR[,\\fIatol\\fR]][+\\fIresponse\\fR][@\\fIscalar\\fR][{\\fIsetting\\fR=\\fIvalue\\fR}].\n";
  text += ".SH COMMANDS\n";
  for (const CLI::App* sub : commands_of(app)) {
    text += fmt::format(".SS {}\n{}\n.PP\n.B {}\n{}", roff(sub->get_name()), roff(sub->get_description()),
                        roff(usage(*sub)), roff_options(*sub));
  }
  text += ".SH \"EXIT STATUS\"\n" + roff(app.get_footer()) + "\n";
  text +=
      ".SH FILES\n.TP\n.I atwood\\-out/store.db\nEvery cell that was run.\n"
      ".TP\n.I atwood\\-out/report.html\nThe newest report of the widest study.\n"
      ".TP\n.I atwood\\-out/index.html\nAll reports and runs.\n"
      ".TP\n.I atwood\\-out/history.db\nWhat each run measured.\n";
  return text +
         ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nWhere it is set and not empty, nothing is printed in colour.\n"
         ".TP\n.B ATWOOD_ROOT\nThe folder of the catalogue, in place of the project's own or share/atwood beside the program.\n";
}

// ---- words that mean nothing --------------------------------------------------------------------------------------
namespace {

std::string unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* sub : commands_of(app)) names.push_back(sub->get_name());
  return fmt::format("no command `{}`{}; `atwood help` lists the commands", word, nearest_hint(word, names, 1));
}

std::string unknown_option(const CLI::App& app, const CLI::App* command, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  const std::string who = command ? "atwood " + command->get_name() : "atwood";
  std::vector<std::string> owners;
  for (const CLI::App* sub : commands_of(app)) {
    const std::vector<std::string> names = option_names(*sub);
    if (std::find(names.begin(), names.end(), name) != names.end()) owners.push_back("`" + sub->get_name() + "`");
  }
  std::string text = fmt::format("{}: no option `{}`", who, name);
  if (command == nullptr && !owners.empty()) return text + " before the command; write it after the command's name";
  text += nearest_hint(name, option_names(command ? *command : app), 1);
  if (!owners.empty()) text += fmt::format("; {} {} it", fmt::join(owners, ", "), owners.size() == 1 ? "has" : "have");
  return text + fmt::format("; `atwood help{}` shows all", command ? " " + command->get_name() : "");
}

}  // namespace

const CLI::App& command_of(const CLI::App& app, const std::string& name) {
  for (const CLI::App* sub : commands_of(app)) {
    if (sub->get_name() == name) return *sub;
  }
  throw InputError(unknown_command(app, name));
}

std::string unknown_words(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* command = nullptr;
  if (const auto parsed = app.get_subcommands(); !parsed.empty()) command = parsed.front();
  const auto is_option = [](const std::string& word) { return word.size() > 1 && word[0] == '-' && word != "--"; };
  for (const std::string& word : app.remaining()) {
    if (is_option(word)) return unknown_option(app, nullptr, word);
  }
  for (const std::string& word : app.remaining(true)) {
    if (is_option(word)) return unknown_option(app, command, word);
  }
  if (command == nullptr) {
    const auto found =
        std::find_if(words.begin(), words.end(), [](const auto& word) { return word.rfind("-", 0) != 0; });
    if (found == words.end()) return "expected a command; `atwood help` lists the commands";
    return unknown_command(app, *found);
  }
  const auto left = app.remaining(true);
  if (left.empty()) return "";
  return fmt::format("atwood {}: found one word too many, `{}`; usage: {}", command->get_name(), left.back(),
                     usage(*command));
}

}  // namespace atwood
