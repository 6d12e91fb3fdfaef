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
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
