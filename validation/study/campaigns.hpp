// Which campaign each foreign worker's cells belong to, and where a cell's parts then stand in the store.
//
// A worker whose code is not all known from outside (a script's imports) has cells that no hash can call current. They
// carry the id of a campaign: an interrupted run resumes its campaign, a completed run closes it, and the next run
// starts a new one. A run of a part of the study joins the latest one instead and measures its own cells anew in it, so
// that it hides none of the others. Reading takes the latest, complete or not.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

class Campaigns {
 public:
  // Of reading: the latest of each series of these cells.
  static Campaigns latest(Store& store, const std::vector<Cell>& cells, const std::string& purpose);
  // Of a run: resumed, taken again (`reuse`), joined (`narrowed`) or new; kept in the store as not complete.
  static Campaigns begin(Store& store, const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                         const StudyOptions& options);
  void complete(Store& store) const;

  // A cell whose campaign does not exist has keys that nothing stands under.
  CellKeys keys(const Cell& cell) const;
  // What this run did about the campaign of these cells: "a new campaign", ...
  std::string told(const Cell& cell) const;

 private:
  void forget_cells(Store& store, const std::vector<Cell>& cells, const std::string& campaign) const;
  std::map<std::string, Campaign> by_cells_;  // Cell::campaign -> its campaign
  std::map<std::string, std::string> told_;
};

}  // namespace atwood
