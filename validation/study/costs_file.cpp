// The file of costs as JSON, written and read.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/shares.hpp"

namespace atwood {
namespace {

constexpr const char* kFormat = "atwood costs 1";

}  // namespace

std::string costs_to_json(const Costs& costs) {
  nlohmann::ordered_json ladders = nlohmann::ordered_json::object();
  for (const auto& [name, rungs] : costs.ladder_ns) {
    nlohmann::ordered_json& ladder = ladders[name] = nlohmann::ordered_json::array();
    for (const auto& [steps, ns] : rungs) ladder.push_back({steps, std::round(ns)});
  }
  const nlohmann::ordered_json file{{"format", kFormat}, {"wall_ns_by_steps", std::move(ladders)}};
  return file.dump(1) + "\n";
}

Costs read_costs(const std::string& path) {
  const std::string text = read_input_file(path, "a file of `atwood costs` (JSON)", largest::kFigures);
  require_shallow_json(text, path);
  Costs costs;
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    if (json.at("format") != kFormat) throw InputError(path + ": expected the format \"" + kFormat + "\"");
    for (const auto& [name, rungs] : json.at("wall_ns_by_steps").items()) {
      for (const auto& rung : rungs) {
        if (!rung.at(0).is_number_integer())
          throw InputError(path + ": `" + name + "`: expected whole numbers of steps");
        const auto steps = rung.at(0).get<std::int64_t>();
        const auto ns = rung.at(1).get<double>();
        if (steps < 1 || !(ns >= 0) || !std::isfinite(ns))
          throw InputError(path + ": `" + name + "`: expected pairs of a step count and nanoseconds");
        costs.ladder_ns[name][steps] = ns;
      }
    }
  } catch (const nlohmann::json::parse_error& error) {
    const std::string before = text.substr(0, error.byte > 0 ? error.byte - 1 : 0);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    throw InputError(path + ":" + std::to_string(line) + ":" + std::to_string(before.size() - before.rfind('\n')) +
                     ": not valid JSON; expected a file of `atwood costs`");
  } catch (const nlohmann::json::exception&) {
    throw InputError(path + ": found other JSON; expected a file of `atwood costs`");
  }
  costs.hash = content_hash(std::string_view(text));
  return costs;
}

}  // namespace atwood
