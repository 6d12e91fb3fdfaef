#include "validation/study/content_hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "scene/system_fault.hpp"

namespace atwood {

namespace {

std::string as_text(const XXH128_hash_t& hash) {
  std::string text(32, '0');
  for (int i = 0; i < 16; ++i) {
    const int bits = 60 - 4 * i;
    text[static_cast<std::size_t>(i)] = "0123456789abcdef"[hash.high64 >> bits & 15];
    text[static_cast<std::size_t>(16 + i)] = "0123456789abcdef"[hash.low64 >> bits & 15];
  }
  return text;
}

}  // namespace

std::string content_hash(std::string_view bytes) { return as_text(XXH3_128bits(bytes.data(), bytes.size())); }

std::string content_hash(std::initializer_list<std::string_view> parts) {
  std::size_t size = 0;
  for (const std::string_view part : parts) size += part.size() + 8;
  std::string all;
  all.reserve(size);
  for (const std::string_view part : parts) {
    all += std::to_string(part.size());
    all += ':';
    all += part;
  }
  return content_hash(std::string_view(all));
}

std::string file_hash(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);  // opening a FIFO would wait for its writer
  const auto refuse_system_fault = [&](int error) {  // which is not to be taken for a file that cannot be read
    if (is_system_fault(error)) throw std::runtime_error(path + ": cannot be read (" + std::strerror(error) + ")");
  };
  if (file < 0) refuse_system_fault(errno);
  if (file < 0) return "";
  struct stat info {};
  const bool regular = fstat(file, &info) == 0 && S_ISREG(info.st_mode);
  std::vector<char> block(regular ? std::size_t{1} << 18 : 0);
  alignas(64) XXH3_state_t state;
  XXH3_128bits_reset(&state);
  ssize_t size = regular ? 1 : -1;
  while (size > 0 || (regular && size < 0 && errno == EINTR)) {
    size = read(file, block.data(), block.size());
    if (size > 0) XXH3_128bits_update(&state, block.data(), static_cast<std::size_t>(size));
  }
  const int error = size < 0 && regular ? errno : 0;
  close(file);
  refuse_system_fault(error);
  return size < 0 ? "" : as_text(XXH3_128bits_digest(&state));
}

std::uint64_t checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }
std::uint64_t checksum(std::string_view bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

}  // namespace atwood
