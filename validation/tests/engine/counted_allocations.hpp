// operator new, counted: for tests of what must not allocate. Include it in one file of an executable.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace atwood::testing {
inline std::atomic<long> allocations{0};
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++atwood::testing::allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
// The form that throws nothing, of temporary buffers: without it a sanitizer's own would be paired with our delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++atwood::testing::allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
