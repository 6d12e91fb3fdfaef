// The file of costs: learned from a store, written and read as JSON.
#include <cmath>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "scene/files.hpp"
#include "validation/study/campaigns.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/shares.hpp"

namespace atwood {
namespace {

constexpr const char* kFormat = "atwood costs 1";
constexpr std::size_t kLargestFile = std::size_t{1} << 30;

}  // namespace

Costs learn_costs(const std::string& store_path, const std::vector<Cell>& cells) {
  Costs costs;
  if (!store_exists(store_path)) throw InputError(store_path + ": no store is there; `atwood run` makes one");
  Store store(store_path, Store::Mode::read);
  if (store.empty()) throw InputError(store_path + ": the store is empty");
  const Campaigns campaigns = Campaigns::latest(store, cells, "run");
  for (const Cell& cell : cells) {
    if (cell.worker < 0) continue;
    const CellKeys keys = campaigns.keys(cell);
    const auto run = store.run(keys.accuracy);
    if (!run || run->killed_from_outside) continue;
    double ns = static_cast<double>(run->wall_ns);
    if (const auto timing = store.timing(keys.timing))
      for (const std::int64_t busy : timing->outcome.busy_ns) ns += static_cast<double>(busy);
    costs.ladder_ns[ladder_name(cell)][cell.plan.steps] = ns;
  }
  if (costs.ladder_ns.empty())
    throw InputError(store_path + ": it has none of these cells, so their costs are unknown");
  return costs;
}

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
  std::ifstream file(path, std::ios::binary);
  std::string text;
  char block[1 << 16];
  while (file.read(block, sizeof block) || file.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kLargestFile) throw InputError(path + ": more than 1 GB; expected a file of `atwood costs`");
  }
  if (text.empty()) throw InputError(path + ": cannot be read, or is empty; expected a file of `atwood costs`");
  Costs costs;
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    if (json.at("format") != kFormat) throw InputError(path + ": expected the format \"" + kFormat + "\"");
    for (const auto& [name, rungs] : json.at("wall_ns_by_steps").items()) {
      for (const auto& rung : rungs) {
        const auto steps = rung.at(0).get<std::int64_t>();
        const auto ns = rung.at(1).get<double>();
        if (steps < 1 || !(ns >= 0) || !std::isfinite(ns))
          throw InputError(path + ": `" + name + "`: expected pairs of a step count and nanoseconds");
        costs.ladder_ns[name][steps] = ns;
      }
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path + ": expected a file of `atwood costs`: " + error.what());
  }
  costs.hash = content_hash(std::string_view(text));
  return costs;
}

}  // namespace atwood
