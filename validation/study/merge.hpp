// Joins the stores of shards, or of any runs, into one. Entries are joined by their keys, which are hashes of content.
#pragma once

#include <string>
#include <vector>

namespace atwood {

struct Merged {
  std::size_t cells = 0;               // in the new store
  std::size_t twice = 0;               // cells that several stores had, with the same outcome, samples and rows
  std::size_t ended_differently = 0;   // ... of which some timed out or were killed and others were not, or all were
  std::size_t other_host = 0;          // timed passes left out, because another host's of the same cell was taken
  std::vector<std::string> absent;     // cells of the shards' plans that no store has
  std::vector<std::string> conflicts;  // what differs, both values; not empty: no store was written
};
// Writes `out`, which must not exist, completely or not at all. Time limits and run ids are those of the first store
// that has the cell, its times those of the first timed pass that succeeded. A cell that ended in one store and
// timed out or was killed in another is taken from the former; rows whose truth was solved are taken before rows whose
// truth could not be. The same cell with another outcome, other samples or other rows is a conflict: its code is not
// deterministic, or its hash does not cover all of it. InputError: files that are not stores, shards with different
// files of costs, cells measured against different truths or by different metrics. StoreDamage: an entry differs from
// its checksum.
Merged merge_stores(const std::vector<std::string>& stores, const std::string& out);

}  // namespace atwood
