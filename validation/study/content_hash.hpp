// 128-bit hashes of content, as 32 hexadecimal digits. Not cryptographic.
#pragma once

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
// A 64-bit hash of the same family: the checksum of an entry of the store.
std::uint64_t checksum(std::string_view bytes);

}  // namespace atwood
