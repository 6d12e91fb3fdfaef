// Completion for three shells. Commands and options are written into the script; ids of scenes, methods, metrics and
// studies are asked of the program that is being typed, when they are wanted (`atwood list KIND --names`).
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/manual.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

// What a value's name stands for: kinds of `atwood list`, words, and whether a file may stand there.
struct Source {
  std::vector<std::string> kinds, words;
  bool files = false;
};
const std::map<std::string, Source>& sources() {
  static const std::map<std::string, Source> known{
      {"SCENE", {{"scenarios"}, {}, true}},
      {"METHOD", {{"methods"}, {}, false}},
      {"METHODS", {{"methods"}, {}, false}},
      {"SCENE|METHOD|METRIC", {{"scenarios", "methods", "metrics"}, {}, true}},
      {"METRIC", {{"metrics"}, {"position", "velocity", "attitude", "body-rate", "state", "energy"}, false}},
      {"METRIC=VALUE", {{"metrics"}, {}, false}},
      {"STUDY", {{"studies"}, {}, true}},
      {"KIND", {{}, {"scenarios", "methods", "metrics", "gates", "studies"}, false}},
      {"COMMAND", {{"commands"}, {}, false}},
      {"SHELL", {{}, {"bash", "zsh", "fish"}, false}},
      {"SCHEMA", {{}, {"scenario", "rows"}, false}},
      {"FORMAT:FILE", {{}, {"html:", "csv:", "json:", "markdown:", "junit:"}, false}},
      {"FILE", {{}, {}, true}},
      {"RUN|FILE", {{}, {"last", "previous"}, true}},
      {"DIR", {{}, {}, true}},
      {"STORE", {{}, {}, true}},
      {"all|worst|none", {{}, {"all", "worst", "none"}, false}},
      {"RUN.CSV", {{}, {}, true}}};
  return known;
}

std::string command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : commands_of(app)) names.push_back(sub->get_name());
  return join(names, " ");
}

// "--scenario=SCENE ...", and the value of words without an option as "=STUDY".
std::string values_of(const CLI::App& command) {
  std::vector<std::string> values;
  for (const OptionWords& option : options_of(command)) {
    if (option.value.empty()) continue;
    if (option.names.empty()) values.push_back("=" + option.value);
    for (const std::string& name : option.names) values.push_back(name + "=" + option.value);
  }
  return join(values, " ");
}

std::string option_words(const CLI::App& command) {
  std::vector<std::string> words;
  for (const OptionWords& option : options_of(command))
    words.insert(words.end(), option.names.begin(), option.names.end());
  return join(words, " ");
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

// The same two tables in bash and zsh: what a command takes, and where a value's words come from.
std::string command_cases(const CLI::App& app) {
  std::string text;
  for (const CLI::App* sub : commands_of(app))
    text += fmt::format("    {}) options='{}' values='{}' ;;\n", sub->get_name(), option_words(*sub), values_of(*sub));
  return text;
}

std::string source_cases(const CLI::App& app) {
  std::string text;
  for (const auto& [name, source] : sources()) {
    std::vector<std::string> words = source.words;
    std::string asked;
    for (const std::string& kind : source.kinds) {
      if (kind == "commands") words.push_back(command_names(app));
      else asked += fmt::format(" $(\"$program\" list {} --names 2>/dev/null)", kind);
    }
    text +=
        fmt::format("    '{}') candidates=\"{}{}\" files={} ;;\n", name, join(words, " "), asked, source.files ? 1 : 0);
  }
  return text;
}

constexpr const char* kBash = R"bash(# bash completion of atwood; to use it: source <(atwood completion bash)
_atwood() {
  local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} previous='' command='' options='' values='' kind=''
  local candidates='' files=0 word i pair
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [[ ${COMP_WORDS[i]} == -* ]] || { command=${COMP_WORDS[i]}; break; }
  done
  if [[ -z $command ]]; then
    COMPREPLY=($(compgen -W '@COMMANDS@ --help --version' -- "$current"))
    return
  fi
  case $command in
@COMMAND_CASES@  esac
  # bash splits words at `=` and `:`; --option=value arrives as three words.
  previous=${COMP_WORDS[COMP_CWORD - 1]}
  [[ $current == '=' ]] && current=''
  [[ $previous == '=' ]] && previous=${COMP_WORDS[COMP_CWORD - 2]}
  if [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$current"))
    return
  fi
  for pair in $values; do [[ ${pair%%=*} == "$previous" ]] && kind=${pair#*=}; done
  [[ -n $kind ]] || for pair in $values; do [[ -z ${pair%%=*} ]] && kind=${pair#*=}; done
  case $kind in
@SOURCE_CASES@  esac
  COMPREPLY=($(compgen -W "$candidates" -- "$current"))
  if [[ $files == 1 ]]; then COMPREPLY+=($(compgen -f -- "$current")) && compopt -o filenames 2>/dev/null; fi
  [[ ${COMPREPLY[0]} == *: ]] && compopt -o nospace 2>/dev/null
  return 0
}
complete -F _atwood atwood ./atwood
)bash";

constexpr const char* kZsh = R"zsh(#compdef atwood
# zsh completion of atwood; to use it: source <(atwood completion zsh), after compinit
_atwood() {
  local program=${words[1]} current=${words[CURRENT]} previous=${words[CURRENT-1]} command='' options='' values='' kind=''
  local candidates='' files=0 pair i
  for ((i = 2; i < CURRENT; ++i)); do
    [[ ${words[i]} == -* ]] || { command=${words[i]}; break; }
  done
  if [[ -z $command ]]; then
    compadd -- @COMMANDS@ --help --version
    return
  fi
  case $command in
@COMMAND_CASES@  esac
  if [[ $current == --*=* ]]; then
    previous=${current%%=*}
    compset -P '*='
  elif [[ $current == -* ]]; then
    compadd -- ${=options}
    return
  fi
  for pair in ${=values}; do [[ ${pair%%=*} == "$previous" ]] && kind=${pair#*=}; done
  [[ -n $kind ]] || for pair in ${=values}; do [[ -z ${pair%%=*} ]] && kind=${pair#*=}; done
  case $kind in
@SOURCE_CASES@  esac
  compadd -- ${=candidates}
  [[ $files == 1 ]] && _files
  return 0
}
compdef _atwood atwood
)zsh";

// A word in single quotes, as fish reads it.
std::string in_fish(const std::string& text) { return "'" + replaced(replaced(text, "\\", "\\\\"), "'", "\\'") + "'"; }

std::string fish_values(const std::string& name, const CLI::App& app) {
  const auto known = sources().find(name);
  if (known == sources().end()) return "-x";
  std::vector<std::string> words = known->second.words;
  for (const std::string& kind : known->second.kinds)
    words.push_back(kind == "commands" ? command_names(app) : fmt::format("(__atwood_list {})", kind));
  const std::string given = words.empty() ? "" : " -a " + in_fish(join(words, " "));
  return (known->second.files ? "-r -F" : "-x") + given;
}

std::string fish_script(const CLI::App& app) {
  std::string text =
      "# fish completion of atwood; to use it: atwood completion fish | source\n"
      "function __atwood_list\n    set -l words (commandline -opc)\n    $words[1] list $argv[1] --names 2>/dev/null\nend\n"
      "complete -c atwood -f\n";
  for (const CLI::App* sub : commands_of(app))
    text += fmt::format("complete -c atwood -n __fish_use_subcommand -a {} -d {}\n", sub->get_name(),
                        in_fish(sub->get_description()));
  for (const CLI::App* sub : commands_of(app)) {
    const std::string here = fmt::format("complete -c atwood -n '__fish_seen_subcommand_from {}'", sub->get_name());
    for (const OptionWords& option : options_of(*sub)) {
      std::string names;
      for (const std::string& name : option.names)
        names += name.rfind("--", 0) == 0 ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (names.empty()) {
        const std::string values = fish_values(option.value, app);
        if (values != "-x") text += fmt::format("{} {}\n", here, values.substr(3));  // without -r or -x
        continue;
      }
      text +=
          fmt::format("{}{}{} -d {}\n", here, names, option.value.empty() ? "" : " " + fish_values(option.value, app),
                      in_fish(option.doc.substr(0, option.doc.find('\n'))));
    }
  }
  return text;
}

}  // namespace

std::string completion_script(const CLI::App& app, const std::string& shell) {
  if (shell == "fish") return fish_script(app);
  if (shell != "bash" && shell != "zsh")
    throw InputError(fmt::format("completion: found `{}`; expected bash, zsh or fish", shell));
  std::string text = shell == "bash" ? kBash : kZsh;
  text = replaced(text, "@COMMANDS@", command_names(app));
  text = replaced(text, "@COMMAND_CASES@", command_cases(app));
  return replaced(text, "@SOURCE_CASES@", source_cases(app));
}

}  // namespace atwood
