// Writes files completely or not at all.
#pragma once

#include <string>

namespace atwood {

// Writes to a temporary beside the target, fsyncs, renames: a full disk leaves no partial file. Throws
// std::runtime_error with the system's message.
void write_file(const std::string& path, const std::string& content);

}  // namespace atwood
