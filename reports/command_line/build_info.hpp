// What the build knows of itself. Kept out of the workers: a commit must not change what they are.
#pragma once

namespace atwood::build_info {
extern const char* const commit;
extern const char* const compiler;
extern const char* const flags;
}  // namespace atwood::build_info
