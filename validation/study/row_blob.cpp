#include "validation/study/row_blob.hpp"

#include <zstd.h>

#include <memory>
#include <new>
#include <stdexcept>

#include "validation/study/blob_bytes.hpp"

namespace atwood {
namespace {

constexpr int kLevel = 3;
constexpr unsigned long long kLargest = 1'000'000'000, kMaxExpansion = 32'768;
// Bits of the first byte of a row: which of the optional numbers it has.
constexpr std::uint8_t kTime = 1, kSpacing = 2, kSoundSpeed = 4;

void put_text(BlobWriter& writer, const std::string& text) {
  writer.put(static_cast<std::uint32_t>(text.size()));
  writer.bytes += text;
}

std::string get_text(BlobReader& reader) {
  const auto size = reader.get<std::uint32_t>();
  if (size > reader.bytes.size() - reader.at) throw BadBlob("a stored row ends too early");
  const std::string text(reader.bytes.substr(reader.at, size));
  reader.at += size;
  return text;
}

}  // namespace

std::string pack_rows(const std::vector<Row>& rows) {
  BlobWriter writer;
  writer.put(static_cast<std::uint64_t>(rows.size()));
  for (const Row& row : rows) {
    writer.put(static_cast<std::uint8_t>((row.t_s ? kTime : 0) | (row.spacing_m ? kSpacing : 0) |
                                         (row.sound_speed_m_per_s ? kSoundSpeed : 0)));
    for (const auto* number : {&row.t_s, &row.spacing_m, &row.sound_speed_m_per_s})
      if (*number) writer.put(**number);
    writer.put(row.value);
    writer.put(row.truth_bar);
    for (const std::string& text : {row.body, row.metric, row.unit, to_string(row.status), row.reason})
      put_text(writer, text);
  }
  return std::move(writer.bytes);
}

std::vector<Row> unpack_rows(std::string_view bytes) {
  BlobReader reader{bytes};
  constexpr std::size_t min_row = 1 + 2 * 8 + 5 * 4;
  std::vector<Row> rows(reader.count(min_row));
  for (Row& row : rows) {
    const auto has = reader.get<std::uint8_t>();
    if ((has & kTime) != 0) row.t_s = reader.get<double>();
    if ((has & kSpacing) != 0) row.spacing_m = reader.get<double>();
    if ((has & kSoundSpeed) != 0) row.sound_speed_m_per_s = reader.get<double>();
    row.value = reader.get<double>();
    row.truth_bar = reader.get<double>();
    row.body = get_text(reader), row.metric = get_text(reader), row.unit = get_text(reader);
    row.status = status_from_string(get_text(reader));
    row.reason = get_text(reader);
  }
  reader.end();
  return rows;
}

std::string pack_plan(const std::vector<PlannedCell>& cells) {
  PlanBytes plan(cells.size());
  for (const PlannedCell& cell : cells) plan.add(cell);
  return std::move(plan.bytes);
}

PlanBytes::PlanBytes(std::size_t cells) {
  BlobWriter writer;
  writer.put(static_cast<std::uint64_t>(cells));
  bytes = std::move(writer.bytes);
}

void PlanBytes::add(const PlannedCell& cell) {
  BlobWriter writer{std::move(bytes)};
  put_text(writer, cell.hash), put_text(writer, cell.name);
  bytes = std::move(writer.bytes);
}

std::vector<PlannedCell> unpack_plan(std::string_view bytes) {
  BlobReader reader{bytes};
  std::vector<PlannedCell> cells(reader.count(2 * 4));
  for (PlannedCell& cell : cells) cell.hash = get_text(reader), cell.name = get_text(reader);
  reader.end();
  return cells;
}

std::string compressed(std::string_view bytes) {
  if (bytes.empty()) return {};
  if (bytes.size() > kLargest) throw std::length_error("a blob of more than 1 GB");
  thread_local const std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  if (context == nullptr) throw std::bad_alloc();
  std::string frame(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compressCCtx(context.get(), frame.data(), frame.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  frame.resize(size);
  return frame;
}

std::string expanded(std::string_view frame) {
  if (frame.empty()) return {};
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  // A block of at least four bytes holds at most 128 KiB, so that a short frame cannot ask for much.
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > kLargest ||
      size / kMaxExpansion > frame.size())
    throw BadBlob("a stored blob is no Zstandard frame");
  thread_local const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (context == nullptr) throw std::bad_alloc();
  std::string bytes(static_cast<std::size_t>(size), '\0');
  const std::size_t got = ZSTD_decompressDCtx(context.get(), bytes.data(), bytes.size(), frame.data(), frame.size());
  if (ZSTD_isError(got) || got != bytes.size()) throw BadBlob("a stored blob cannot be expanded");
  return bytes;
}

}  // namespace atwood
