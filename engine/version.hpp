// The version of Atwood, the engine's own among others; CMakeLists.txt reads it from here. CHANGELOG.md begins with it.
#pragma once

namespace atwood {
inline constexpr const char* kVersion = "0.1.0";
}  // namespace atwood
