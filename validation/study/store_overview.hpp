// What a store has, from one pass over its tables: which of a million cells are left to run is decided in seconds.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <utility>

#include "protocol/sample.hpp"

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

  const Run* run(const std::string& cell_hash) const;
  bool measured_from(const std::string& key, const std::string& basis) const;

  void add_run(const std::string& cell_hash, Run run);
  void add_measured(const std::string& key, const std::string& basis);

 private:
  using Key = std::pair<std::uint64_t, std::uint64_t>;  // of the key's text: two checksums
  struct Hash {
    std::size_t operator()(const Key& key) const { return key.first; }
  };
  static Key key_of(const std::string& text);
  std::unordered_map<Key, Run, Hash> runs_;
  std::unordered_map<Key, std::uint64_t, Hash> measured_;  // a checksum of their basis
};

}  // namespace atwood
