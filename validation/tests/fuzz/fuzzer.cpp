// The entry of libFuzzer: one program a target, chosen when it is compiled.
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "validation/tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const atwood::fuzz::Target* const target = [] {
    for (const atwood::fuzz::Target& each : atwood::fuzz::all_targets())
      if (std::strcmp(each.name, ATWOOD_FUZZ_TARGET) == 0) return &each;
    atwood::fuzz::require(false, "there is such a target");
    return static_cast<const atwood::fuzz::Target*>(nullptr);
  }();
  target->read({reinterpret_cast<const char*>(data), size});
  return 0;
}
