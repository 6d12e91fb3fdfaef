// Recordings that a run does not keep (StudyOptions::keep).
#pragma once

#include "validation/study/campaigns.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// Drops the recordings of these cells but for the worst of each ladder and those that did not end ok.
void keep_worst(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns);

}  // namespace atwood
