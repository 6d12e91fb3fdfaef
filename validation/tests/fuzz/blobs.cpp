// What the store keeps as bytes. The first byte chooses the reader.
#include <map>
#include <stdexcept>
#include <utility>

#include "validation/study/recording_blob.hpp"
#include "validation/study/row_blob.hpp"
#include "validation/tests/fuzz/target.hpp"

namespace atwood::fuzz {

namespace {

// What was accepted, written and read again, is written the same. Bytes of a second, longer form (numbers that a double
// holds in 16 bytes) are accepted too, so that the first writing may differ from them.
template <class Unpack, class Pack> void read_and_write(std::string_view bytes, Unpack unpack, Pack pack) {
  const auto first = read_or_refuse<BadBlob>([&] { return unpack(bytes); });
  if (!first) return;
  const std::string packed = pack(*first);
  require(pack(unpack(packed)) == packed, "what was packed unpacks to the same");
}

}  // namespace

void read_recording_blob(std::string_view bytes) {
  if (bytes.empty()) return;
  const char kind = bytes.front();
  bytes.remove_prefix(1);
  if (kind == 's')
    read_and_write(bytes, unpack_samples, [](const SampleSeries& samples) { return pack_samples(samples); });
  if (kind == 'e') read_and_write(bytes, unpack_events, pack_events);
  if (kind == 'r') read_and_write(bytes, unpack_reals, pack_reals);
  if (kind == 'x') read_and_write(bytes, unpack_series, pack_series);
  if (kind == 't')
    read_and_write(
        bytes,
        [](std::string_view packed) {
          Recording both;
          unpack_beside_samples(packed, both);
          return both;
        },
        [](const auto& both) { return pack_beside_samples(both, both.outcome.solvers); });
  if (kind == 'p')
    read_and_write(
        bytes,
        [](std::string_view packed) {
          std::pair<Series, FluidPicture> both;
          both.first = unpack_series_and_picture(packed, both.second);
          return both;
        },
        [](const auto& both) { return pack_series_and_picture(both.first, both.second); });
}

void read_row_blob(std::string_view bytes) {
  if (bytes.empty()) return;
  const char kind = bytes.front();
  bytes.remove_prefix(1);
  constexpr std::size_t kLongestFrame = 1024;  // expands to 32 MB at most
  if (kind == 'z' && bytes.size() <= kLongestFrame)
    read_and_write(bytes, expanded, [](const std::string& text) { return compressed(text); });
  if (kind == 'p') read_and_write(bytes, unpack_plan, pack_plan);
  if (kind == 'r')
    read_or_refuse<std::invalid_argument>([&] {  // an unknown status
      read_and_write(bytes, unpack_rows, pack_rows);
      return 0;
    });
}

}  // namespace atwood::fuzz
