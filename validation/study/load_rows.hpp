// Rows from the store: `run` ends and `report` begins with this function.
#pragma once

#include "validation/study/campaigns.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// The key of a cell's rows in the store: its run, and the parts of its scenario by which metrics judge it.
std::string measured_key(const Cell& cell, const std::string& accuracy_hash);

// Rows of these cells and of their ladders; `skipped` counts the cells found in the store. StoreDamage names the cell.
StudyResult collect_rows(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns);
// The same with only the rows that are not ok, and none of ladders: how the cells of a share ended.
StudyResult collect_endings(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns);

}  // namespace atwood
