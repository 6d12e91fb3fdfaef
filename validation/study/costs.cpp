// Costs of cells, learned from a store.
#include "scene/files.hpp"
#include "validation/study/campaigns.hpp"
#include "validation/study/shares.hpp"

namespace atwood {

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

}  // namespace atwood
