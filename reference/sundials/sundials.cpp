#include "sundials/sundials.hpp"

#include <sundials/sundials_context.h>
#include <sundials/sundials_types.h>
#include <sundials/sundials_version.h>

#include <stdexcept>

namespace atwood::sundials {

static_assert(sizeof(sunrealtype) == sizeof(double), "these adapters expect SUNDIALS in double");

Context::Context() {
  SUNContext made = nullptr;
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_Create(SUN_COMM_NULL, &made);
  if (made != nullptr) SUNContext_ClearErrHandlers(made);
#else
  SUNContext_Create(nullptr, &made);
#endif
  if (made == nullptr) throw std::runtime_error("SUNDIALS could not create its context");
  handle = made;
}

Context::~Context() {
  auto held = static_cast<SUNContext>(handle);
  SUNContext_Free(&held);
}

void ignore_messages(int, const char*, const char*, char*, void*) {}

std::string version() {
  char text[64] = "";
  SUNDIALSGetVersion(text, sizeof text);
  return text;
}

}  // namespace atwood::sundials
