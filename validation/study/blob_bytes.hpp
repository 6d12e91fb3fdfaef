// Values as bytes for the store, in order, little-endian, without padding; BadBlob where bytes are not what they should
// be.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "validation/study/recording_blob.hpp"

namespace atwood {

struct BlobWriter {
  std::string bytes;
  template <class T> void put(const T& value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
  }
};

struct BlobReader {
  std::string_view bytes;
  std::size_t at = 0;
  template <class T> T get() {
    if (bytes.size() - at < sizeof(T)) throw BadBlob("a stored recording ends too early");
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
  }
  // Reads a count of elements of at least `size` bytes each; at most as many as fit into the remaining bytes.
  std::size_t count(std::size_t size) {
    const auto n = get<std::uint64_t>();
    if (n > (bytes.size() - at) / size) throw BadBlob("a stored recording has an impossible count");
    return static_cast<std::size_t>(n);
  }
  void end() const {
    if (at != bytes.size()) throw BadBlob("a stored recording has bytes left over");
  }
};

}  // namespace atwood
