// What a store says of the plan and the shard that it was written for; `merge` reads it.
#pragma once

#include "validation/study/campaigns.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// Records a shard that is not complete. The same with `complete` set replaces it (Store::put_shard).
ShardRecord begin_shard(Store& store, const ShardOfPlan& shard, const Campaigns& campaigns, const std::string& host);

}  // namespace atwood
