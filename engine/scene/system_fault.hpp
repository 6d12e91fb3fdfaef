// Failures of the system, which are not the fault of the file or the worker in question.
#pragma once

#include <cerrno>

namespace atwood {

// Whether an errno tells of missing descriptors or memory, or of failed input/output.
inline bool is_system_fault(int error) { return error == EIO || error == EMFILE || error == ENFILE || error == ENOMEM; }

}  // namespace atwood
