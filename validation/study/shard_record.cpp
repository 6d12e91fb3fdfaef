#include "validation/study/shard_record.hpp"

#include <algorithm>

#include "validation/study/content_hash.hpp"
#include "validation/study/row_blob.hpp"
#include "validation/study/shares.hpp"

namespace atwood {
namespace {

std::string put_plan(Store& store, const ShardOfPlan& shard, const Campaigns& campaigns) {
  const auto has_worker = [](const Cell& cell) { return cell.worker >= 0; };
  PlanBytes cells(static_cast<std::size_t>(std::count_if(shard.planned->begin(), shard.planned->end(), has_worker)));
  for (const Cell& cell : *shard.planned)
    if (has_worker(cell))
      cells.add({campaigns.accuracy_key(cell), ladder_name(cell) + ", " + std::to_string(cell.plan.steps) + " steps"});
  const std::string plan = content_hash(std::string_view(cells.bytes));
  if (!store.has_plan(plan)) store.put_plan(plan, shard.study, cells.bytes);
  return plan;
}

}  // namespace

ShardRecord begin_shard(Store& store, const ShardOfPlan& shard, const Campaigns& campaigns, const std::string& host) {
  std::string plan = shard.plan;
  if (plan.empty()) plan = put_plan(store, shard, campaigns);
  const std::string id = content_hash({"shard 1", plan, std::to_string(shard.number), std::to_string(shard.count)});
  ShardRecord record{id, plan, shard.number, shard.count, shard.costs, shard.source, host, false};
  store.put_shard(record);
  return record;
}

}  // namespace atwood
