#include "motion_blob.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace atwood {

std::size_t MotionBlob::add_words(std::span<const std::uint16_t> values) {
  const std::size_t at = bytes_.size();
  std::string high;
  high.reserve(values.size());
  std::uint16_t last = 0, last_difference = 0;
  for (const std::uint16_t value : values) {
    const auto difference = static_cast<std::uint16_t>(value - last);
    const auto second = static_cast<std::uint16_t>(difference - last_difference);
    last = value, last_difference = difference;
    bytes_ += static_cast<char>(second & 0xff);
    high += static_cast<char>(second >> 8);
  }
  bytes_ += high;
  return at;
}

std::size_t MotionBlob::add_bytes(std::span<const std::uint8_t> values) {
  const std::size_t at = bytes_.size();
  std::uint8_t last = 0;
  for (const std::uint8_t value : values) {
    bytes_ += static_cast<char>(static_cast<std::uint8_t>(value - last));
    last = value;
  }
  return at;
}

std::size_t MotionBlob::add_floats(std::span<const float> values) {
  const std::size_t at = bytes_.size();
  for (const float value : values)
    for (const std::uint32_t bits = std::bit_cast<std::uint32_t>(value); const unsigned shift : {0U, 8U, 16U, 24U})
      bytes_ += static_cast<char>(bits >> shift & 0xff);
  return at;
}

QuantisedList quantised(std::span<const double> values) {
  QuantisedList list;
  double high = 0;
  bool any = false;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    list.low = any ? std::min(list.low, value) : value;
    high = any ? std::max(high, value) : value;
    any = true;
  }
  list.step = high / 65535 - list.low / 65535;  // the range itself may overflow
  std::uint16_t last = 0;
  for (const double value : values) {
    if (std::isfinite(value) && list.step > 0)
      last = static_cast<std::uint16_t>(std::clamp(std::round(value / list.step - list.low / list.step), 0.0, 65535.0));
    list.words.push_back(last);
  }
  return list;
}

QuantisedList quantised_about_zero(std::span<const double> values, double largest) {
  QuantisedList list;
  list.step = largest / 32767;
  std::uint16_t last = 32768;
  for (const double value : values) {
    if (std::isfinite(value))
      last = list.step > 0
                 ? static_cast<std::uint16_t>(32768 + std::clamp(std::round(value / list.step), -32767.0, 32767.0))
                 : 32768;
    list.words.push_back(last);
  }
  return list;
}

}  // namespace atwood
