// From the store back to rows: what `run` ends with and what `report` starts with are the same function.
#pragma once

#include "validation/study/campaigns.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// Where the rows of a cell stand in the store: its run, and what of its scenario they were judged by.
std::string measured_key(const Cell& cell, const std::string& accuracy_hash);

// Rows of these cells and of their ladders; `skipped` counts the cells that the store has. StoreDamage names the cell.
StudyResult collect_rows(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns);

}  // namespace atwood
