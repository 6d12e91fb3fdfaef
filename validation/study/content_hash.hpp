// 128-bit hashes of content, as 32 hexadecimal digits. Not for secrets: equal content, equal hash.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace atwood {

std::string content_hash(std::string_view bytes);
// Of parts in order; ("ab", "c") and ("a", "bc") differ.
std::string content_hash(std::initializer_list<std::string_view> parts);
// Of a file's bytes; empty when it cannot be read.
std::string file_hash(const std::string& path);

}  // namespace atwood
