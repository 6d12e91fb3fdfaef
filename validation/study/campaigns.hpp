// Which campaign the cells of each foreign worker belong to, and the keys of a cell's parts in the store.
//
// The code of some workers is not fully known (a script's imports), so no hash shows whether their cells are current.
// Such cells carry the id of a campaign: an interrupted run resumes its campaign, a completed run closes it, and the
// next run starts a new one. A run of a part of the study joins the latest campaign and measures its own cells again,
// so that the other cells stay visible. Reports read the latest campaign, complete or not.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {

class Campaigns {
 public:
  // For reading: the latest campaign of each series of these cells.
  static Campaigns latest(Store& store, const std::vector<Cell>& cells, const std::string& purpose);
  // For a run: a campaign that is resumed, reused (`reuse`), joined (`narrowed`) or new; stored as not complete.
  static Campaigns begin(Store& store, const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                         const StudyOptions& options);
  void complete(Store& store) const;

  // For a cell whose campaign does not exist: keys without an entry in the store.
  CellKeys keys(const Cell& cell) const;
  std::string accuracy_key(const Cell& cell) const;  // keys(cell).accuracy
  // For messages, how this run chose the campaign of the cell: "a new campaign", ...
  std::string origin(const Cell& cell) const;

 private:
  const std::string& id_of(const Cell& cell) const;  // empty: its campaign does not exist
  void forget_cells(Store& store, const std::vector<Cell>& cells, const std::string& campaign) const;
  std::map<std::string, Campaign> by_cells_;  // Cell::campaign -> its campaign
  std::map<std::string, std::string> origin_;
};

}  // namespace atwood
