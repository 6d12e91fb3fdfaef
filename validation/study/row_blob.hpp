// Rows as bytes for the store, and the compression of its blobs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "validation/row.hpp"
#include "validation/study/store.hpp"

namespace atwood {

// What a cell's rows have of their own: body, t_s, metric, unit, value, truth_bar, status, reason, spacing_m,
// sound_speed_m_per_s; the rest belongs to the cell. Lossless; also NaN.
std::string pack_rows(const std::vector<Row>& rows);
std::vector<Row> unpack_rows(std::string_view bytes);  // BadBlob; std::invalid_argument for an unknown status

std::string pack_plan(const std::vector<PlannedCell>& cells);
// The same of cells that are added one after the other.
struct PlanBytes {
  explicit PlanBytes(std::size_t cells);
  void add(const PlannedCell& cell);
  std::string bytes;
};
std::vector<PlannedCell> unpack_plan(std::string_view bytes);  // BadBlob

// A Zstandard frame (RFC 8878) of these bytes, and back; empty stays empty. BadBlob where it is not one, or would
// expand to more than the store can keep (1 GB).
std::string compressed(std::string_view bytes);
std::string expanded(std::string_view frame);

}  // namespace atwood
