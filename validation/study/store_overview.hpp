// What a store has, from one pass over its tables: which of a million cells are left to run is decided in seconds.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/sample.hpp"
#include "validation/study/key_table.hpp"

namespace atwood {

class StoreOverview {
 public:
  struct Run {
    Status status = Status::ok;
    bool killed_from_outside = false;
    double limit_s = 0;
  };
  // Every checksum is right, every entry is found by its key, and every cell has all its parts. Where this is false,
  // the cells must be looked at one by one.
  bool whole = true;

  const Run* run(const std::string& cell_hash) const { return runs_.find(key_sum(cell_hash)); }
  bool measured_from(const std::string& key, const std::string& basis) const;

  void add_run(const std::string& cell_hash, const Run& run) { *runs_.insert(key_sum(cell_hash)).first = run; }
  void add_measured(const std::string& key, const std::string& basis) {
    *measured_.insert(key_sum(key)).first = checksum(basis);
  }

 private:
  KeyTable<Run> runs_;
  KeyTable<std::uint64_t> measured_;  // a checksum of their basis
};

}  // namespace atwood
