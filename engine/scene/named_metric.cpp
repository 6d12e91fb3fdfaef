#include "scene/named_metric.hpp"

#include <filesystem>

#include "scene/input_file.hpp"
#include "scene/value.hpp"

namespace atwood {

std::string named_metric(const Scenario& scenario) {
  std::error_code error;
  if (scenario.path.empty() || !std::filesystem::is_regular_file(scenario.path, error)) return "";
  try {
    const std::string text = read_input_file(scenario.path, "a scenario file (TOML)", largest::kScenario);
    if (text.find("metric") == std::string::npos) return "";  // large files are not parsed a second time
    const Value document = parse_toml(text, scenario.path);
    const Value* metric = document.find("metric");
    return metric && metric->text() ? *metric->text() : "";
  } catch (const InputError&) {  // changed since the scenario was read
    return "";
  }
}

}  // namespace atwood
