#include "validation/study/keep_recordings.hpp"

#include <algorithm>
#include <map>

#include "validation/study/shares.hpp"

namespace atwood {
namespace {

// The error by which the worst cell of a ladder is chosen: the largest of the rows that say error of a whole run.
double largest_error(const std::vector<Row>& rows) {
  double largest = -1;
  for (const Row& row : rows)
    if (row.metric.starts_with("error-") && row.status == Status::ok) largest = std::max(largest, row.value);
  return largest;
}

}  // namespace

void keep_worst(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns) {
  struct Worst {
    const Cell* cell;
    double error;
  };
  std::map<std::string, Worst> worst;
  for (const bool dropping : {false, true}) {
    for (const Cell& cell : cells) {
      if (cell.worker < 0 || cell.probe != Probe::none) continue;
      const CellKeys keys = campaigns.keys(cell);
      const auto run = store.run(keys.accuracy);
      if (!run || run->outcome.status != Status::ok) continue;
      const auto known = worst.find(ladder_name(cell));
      if (dropping) {
        if (known->second.cell != &cell) store.drop_recording(keys);
        continue;
      }
      const auto measured = store.measured(keys.measured, true, false);
      const double error = measured ? largest_error(measured->rows) : -1;
      if (known == worst.end()) worst.emplace(ladder_name(cell), Worst{&cell, error});
      else if (error > known->second.error) known->second = {&cell, error};
    }
  }
}

}  // namespace atwood
