// Bytes made small and made printable: raw deflate (RFC 1951), which browsers undo by DecompressionStream, and base64.
#pragma once

#include <string>
#include <string_view>

namespace atwood {

std::string deflated(std::string_view bytes);  // throws std::runtime_error when memory runs out
std::string base64(std::string_view bytes);    // RFC 4648, with padding

}  // namespace atwood
