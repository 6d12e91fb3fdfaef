// What every SUNDIALS solver needs, whichever of them a process links. No SUNDIALS header is needed by those who use
// it.
#pragma once

#include <string>

namespace atwood::sundials {

// Owns a SUNContext: `static_cast<SUNContext>(context.handle)`. The signature of its creation changed in SUNDIALS 7.
struct Context {
  Context();  // throws std::runtime_error
  ~Context();
  Context(const Context&) = delete;
  void* handle = nullptr;
};

// An error handler of SUNDIALS 6 (7 has a list in the context, which Context clears): the answer's flag says it all.
void ignore_messages(int, const char*, const char*, char*, void*);

std::string version();  // of the linked SUNDIALS

}  // namespace atwood::sundials
