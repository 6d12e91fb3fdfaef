// 128-bit hashes of content, as 32 hexadecimal digits. Not cryptographic.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

namespace atwood {

std::string content_hash(std::string_view bytes);
// The hash of the parts in order; ("ab", "c") and ("a", "bc") differ.
std::string content_hash(std::initializer_list<std::string_view> parts);
// The hash of a regular file's bytes; empty where it cannot be read or is not a regular file.
std::string file_hash(const std::string& path);
// A content hash, or its first digits, held in the object itself: for what is kept a million times.
template <std::size_t Digits> class HashDigits {
 public:
  HashDigits() = default;  // none: empty
  HashDigits(std::string_view text) { text.copy(digits_.data(), Digits); }
  operator std::string_view() const { return {digits_.data(), empty() ? 0 : Digits}; }
  operator std::string() const { return std::string(std::string_view(*this)); }
  bool empty() const { return digits_[0] == 0; }
  bool operator==(const HashDigits&) const = default;

 private:
  std::array<char, Digits> digits_ = {};
};
using ContentHash = HashDigits<32>;

// A 64-bit hash of the same family: the checksum of an entry of the store. Different seeds give independent hashes;
// seed 0 gives that without a seed.
std::uint64_t checksum(std::string_view bytes);
std::uint64_t checksum(std::string_view bytes, std::uint64_t seed);

}  // namespace atwood
