// Motion as whole numbers of 16 bits, laid out so that deflate makes it small.
//
// A list is stored as its second differences modulo 2^16, low bytes first, then high bytes: smooth motion sampled often
// has second differences near 0. The page adds them up twice and gets the same 16 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace atwood {

class MotionBlob {
 public:
  // Each returns the offset [bytes] of the list in bytes().
  std::size_t add_words(std::span<const std::uint16_t> values);
  std::size_t add_bytes(std::span<const std::uint8_t> values);  // as first differences modulo 2^8
  std::size_t add_floats(std::span<const float> values);        // little-endian
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// value ~ low + step * word; words fill 0..65535 where the range is not empty. Not finite: the word of the last finite
// one.
struct QuantisedList {
  double low = 0, step = 0;
  std::vector<std::uint16_t> words;
};
QuantisedList quantised(std::span<const double> values);
// value ~ step * (word - 32768), for values around 0.
QuantisedList quantised_about_zero(std::span<const double> values, double largest);

}  // namespace atwood
