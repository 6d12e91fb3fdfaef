// Checks of the values of options: numbers are finite and within their range, switches have no value, other options
// have one. Messages say what was found and what was expected.
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <map>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "reports/command_line/manual.hpp"

namespace atwood {
namespace {

struct NumberRange {
  bool whole = false;
  double low = 0, high = 0;  // both ends are allowed
  std::string what;          // " of seconds"; empty: a number without unit
};

// Every option that takes a number, by its long name. Step counts have the range of `steps` in scene files.
const std::map<std::string, NumberRange>& number_ranges() {
  static const std::map<std::string, NumberRange> ranges{{"limit", {false, 0.01, 1e6, " of seconds"}},
                                                         {"lease-expiry", {false, 1, 1e6, " of seconds"}},
                                                         {"time", {false, 0, 1e6, " of seconds"}},
                                                         {"hz", {false, 1e-9, 1e12, " of steps per second"}},
                                                         {"steps", {true, 1, 1e12, " of steps"}},
                                                         {"samples", {true, 1, 1e12, " of samples"}},
                                                         {"jobs", {true, 1, 1024, " of workers"}},
                                                         {"prune-keep", {true, 1, 1e9, " of runs"}},
                                                         {"prune-older", {false, 0.01, 36500, " of days"}},
                                                         {"trials", {true, 1, 10000, " of trials"}},
                                                         {"seed", {true, 0, 1e15, ""}},
                                                         {"max-cells", {true, 1, 1e15, " of cells"}},
                                                         {"spacing", {false, 1e-12, 1e9, " of metres"}},
                                                         {"sound-speed", {false, 1e-12, 1e9, " of metres per second"}}};
  return ranges;
}

// What is wrong with the text; empty where it is a number within the range.
std::string number_fault(const NumberRange& range, const std::string& text) {
  char* end = nullptr;
  errno = 0;
  const double value = std::strtod(text.c_str(), &end);
  const bool plain =
      text.find_first_not_of("0123456789+-.eE") == std::string::npos;  // no nan, inf, blanks, hexadecimals
  const bool number = plain && !text.empty() && end == text.c_str() + text.size() && std::isfinite(value);
  const bool whole = text.find_first_not_of("0123456789+-") == std::string::npos;
  if (number && (whole || !range.whole) && value >= range.low && value <= range.high) return "";
  return fmt::format("found `{}`; expected a {}number{} from {:g} to {:g}", text, range.whole ? "whole " : "",
                     range.what, range.low, range.high);
}

}  // namespace

void check_values(CLI::App& app) {
  for (CLI::App* sub : app.get_subcommands([](CLI::App*) { return true; })) {
    for (CLI::Option* option : sub->get_options([](CLI::Option*) { return true; })) {
      for (const std::string& name : option->get_lnames()) {
        const auto range = number_ranges().find(name);
        if (range == number_ranges().end()) continue;
        option->check([range](const std::string& text) { return number_fault(range->second, text); });
      }
    }
  }
}

std::string value_words(const CLI::App& app, const CLI::ParseError& error) {
  for (const CLI::App* sub : app.get_subcommands()) {
    for (const CLI::Option* option : sub->get_options()) {
      const bool flag = option->get_items_expected_max() == 0;
      const std::string name = option->get_name();
      const bool about = std::string(error.what()).find(name) != std::string::npos;
      if (error.get_name() == "ArgumentMismatch" && about) {
        if (!flag && option->get_multi_option_policy() == CLI::MultiOptionPolicy::Throw &&
            static_cast<int>(option->count()) > option->get_items_expected_max())
          return fmt::format("{}: found {} times; expected once", name, option->count());
        if (!flag && option->count() == 0) return fmt::format("{}: found no value; expected one", name);
      }
      const bool conversion = error.get_name() == "ConversionError" || error.get_name() == "InvalidError" ||
                              error.get_name() == "ArgumentMismatch";
      if (conversion && about && flag) return fmt::format("{}: found a value; expected none (it is a switch)", name);
    }
  }
  return "";
}

}  // namespace atwood
