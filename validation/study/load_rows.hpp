// Rows from the store: `run` ends and `report` begins with this function.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "validation/study/campaigns.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// The key of a cell's rows in the store: its run, and the parts of its scenario by which metrics judge it.
std::string measured_key(const Cell& cell, const std::string& accuracy_hash);

// Rows of these cells and of their ladders; `skipped` counts the cells found in the store. StoreDamage names the cell.
StudyResult collect_rows(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns);
// The same with only the rows that are not ok, of cells whose run or timed pass did not end ok, and none of ladders:
// how the cells of a share ended. Of a store that is open for writing.
StudyResult collect_endings(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns);

// The same where all rows together are too many to hold: the cells of one scenario's method at a time, of methods with
// a tolerance those of all of a scenario's. `which`: their indices in `cells`; the result is that of collect_rows.
// Without a store nothing is visited, and all is missing.
using VisitLadder = std::function<void(const std::vector<std::size_t>& which, StudyResult& rows)>;
void visit_ladders(const std::string& store_path, const std::vector<Cell>& cells, const VisitLadder& visit,
                   const std::string& purpose = "run");

}  // namespace atwood
