// 128-bit hashes of content, as 32 hexadecimal digits. Not for secrets: equal content, equal hash.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

namespace atwood {

std::string content_hash(std::string_view bytes);
// Of parts in order; ("ab", "c") and ("a", "bc") differ.
std::string content_hash(std::initializer_list<std::string_view> parts);
// Of a regular file's bytes, read in pieces; empty when it cannot be read or is no regular file.
std::string file_hash(const std::string& path);
// 64 bits of the same family: the checksum of an entry of the store.
std::uint64_t checksum(std::string_view bytes);

}  // namespace atwood
