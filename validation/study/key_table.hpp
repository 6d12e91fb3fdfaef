// A table by the keys of the store, of which there may be millions: open addressing with linear probing (Knuth, The Art
// of Computer Programming 3, 6.4, algorithms L and R), one block of memory. A key is represented by
// 127 bits of hash of its text.
#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "validation/study/content_hash.hpp"

namespace atwood {

// Two checksums of a key's text; never both 0. `first` is checksum(text).
struct KeySum {
  std::uint64_t first = 0, second = 0;
  bool operator==(const KeySum&) const = default;
};
inline KeySum key_sum(std::string_view text) { return {checksum(text), checksum(text, 1) | 1}; }

struct NoValue {};

template <class Value = NoValue> class KeyTable {
 public:
  std::size_t size() const { return size_; }
  bool contains(const KeySum& key) const { return find(key) != nullptr; }
  const Value* find(const KeySum& key) const {
    if (size_ == 0) return nullptr;
    const Slot& slot = slots_[place_of(key)];
    return slot.key == KeySum{} ? nullptr : &slot.value;
  }
  // The value of this key, and whether it is new. It is valid until the next insertion or erasure.
  std::pair<Value*, bool> insert(const KeySum& key, const Value& value = {}) {
    if (4 * (size_ + 1) > 3 * slots_.size()) grow();
    Slot& slot = slots_[place_of(key)];
    if (slot.key == key) return {&slot.value, false};
    slot = {key, value};
    ++size_;
    return {&slot.value, true};
  }
  bool erase(const KeySum& key) {
    if (!contains(key)) return false;
    std::size_t hole = place_of(key);
    // Every entry behind the hole that is found by probing over it moves into it.
    for (std::size_t i = next(hole); slots_[i].key != KeySum{}; i = next(i)) {
      const std::size_t home = home_of(slots_[i].key);
      if (((i - home) & mask()) < ((i - hole) & mask())) continue;
      slots_[hole] = slots_[i];
      hole = i;
    }
    slots_[hole] = {};
    --size_;
    return true;
  }

 private:
  struct Slot {
    KeySum key;
    [[no_unique_address]] Value value = {};
  };
  std::size_t mask() const { return slots_.size() - 1; }
  std::size_t home_of(const KeySum& key) const { return key.first & mask(); }
  std::size_t next(std::size_t i) const { return (i + 1) & mask(); }
  std::size_t place_of(const KeySum& key) const {  // of the key, or of the empty slot where it belongs
    std::size_t i = home_of(key);
    while (slots_[i].key != KeySum{} && slots_[i].key != key) i = next(i);
    return i;
  }
  void grow() {
    std::vector<Slot> before(slots_.empty() ? 16 : 2 * slots_.size());  // a power of 2
    before.swap(slots_);
    for (Slot& slot : before)
      if (slot.key != KeySum{}) slots_[place_of(slot.key)] = std::move(slot);
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

}  // namespace atwood
