// A tree of values is copied or refused when memory runs out, at whichever allocation.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <new>

#include "scene/value.hpp"

namespace {

long allocations_left = std::numeric_limits<long>::max();

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  if (allocations_left-- <= 0) throw std::bad_alloc();
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
// The form that throws nothing, of temporary buffers: without it a sanitizer's own would be paired with our delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocations_left-- <= 0 ? nullptr : std::malloc(size == 0 ? 1 : size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

TEST_CASE("a copy that runs out of memory leaves nothing half made") {
  using atwood::Value;
  const std::string long_text(100, 'x');
  const Value tree =
      atwood::table_of({{"a key that is longer than a small string", long_text},
                        {"list", Value::List{Value(1.5), Value(long_text), Value(Value::List{Value(long_text)})}},
                        {"table", atwood::table_of({{"inner", long_text}, {"flag", true}})}});
  int refused = 0;
  bool copied = false;
  Value assigned(long_text);
  while (!copied) {
    allocations_left = refused;
    try {
      const Value copy = tree;
      assigned = copy;
      copied = true;
    } catch (const std::bad_alloc&) {
      ++refused;
    }
    allocations_left = std::numeric_limits<long>::max();
  }
  CHECK(refused > 10);  // each allocation of the copies was refused once
  CHECK(atwood::to_json_text(assigned, false) == atwood::to_json_text(tree, false));
}
