// What a store says of the plan and the shard that it was written for; `merge` reads it.
#pragma once

#include "validation/study/campaigns.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

void record_shard(Store& store, const ShardOfPlan& shard, const Campaigns& campaigns, const std::string& host,
                  bool complete);

}  // namespace atwood
