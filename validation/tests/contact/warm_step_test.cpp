// A step that changes no contact allocates nothing: runs twice as long ask for as much memory.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>

#include "recorded.hpp"

namespace {
std::atomic<long> allocations{0};

void* counted(std::size_t size) {
  ++allocations;
  if (void* found = std::malloc(size > 0 ? size : 1)) return found;
  throw std::bad_alloc();
}
void* counted(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto a = static_cast<std::size_t>(alignment);
  if (void* found = std::aligned_alloc(a, (size + a - 1) / a * a)) return found;
  throw std::bad_alloc();
}
}  // namespace

// Not inlined: valgrind puts its own in their place, all or none.
[[gnu::noinline]] void* operator new(std::size_t size) { return counted(size); }
[[gnu::noinline]] void* operator new[](std::size_t size) { return counted(size); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) { return counted(size, alignment); }
[[gnu::noinline]] void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted(size, alignment);
}
// Of temporary buffers: without it a sanitizer's own would be paired with our delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size > 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

using namespace atwood;
using namespace atwood::recorded;

namespace {

long allocations_of(const char* method, const Scene& scene, double t_end_s) {
  const Observer no_observer;
  const long before = allocations;
  const Outcome outcome =
      run_with_contacts(parse_method_id(method), scene,
                        {t_end_s, static_cast<std::int64_t>(std::lround(t_end_s * 120)), 1}, no_observer, 0);
  REQUIRE(outcome.status == Status::ok);
  return allocations - before;
}

Scene ground(double restitution, double friction) {
  Scene scene = world({0, 0, -9.81}, restitution, friction);
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0})};
  return scene;
}

}  // namespace

TEST_CASE("the counter of allocations counts an allocation") {
  const long before = allocations;
  const std::vector<double> some(100);
  CHECK(some.size() == 100);
  CHECK(allocations > before);
}

TEST_CASE("no allocation in a warm step of +event and of +impulse") {
  for (const char* method : {"atwood/rk4+event", "atwood/dopri5+event", "atwood/symplectic-euler+impulse"}) {
    INFO(method);
    Scene bounces = ground(1, 0);
    bounces.bodies.push_back(ball("ball", 1, 0.1, {0, 0, 0.3}));
    allocations_of(method, bounces, 0.5);  // what is made once a program
    const long two_s_of_bounces = allocations_of(method, bounces, 2);
    CHECK(allocations_of(method, bounces, 4) == two_s_of_bounces);
    Scene lasts = ground(0, 0.3);
    lasts.bodies.push_back(ball("rolls", 1, 0.1, {0, 0, 0.1}, {1, 0, 0}, {0, 10, 0}));
    lasts.bodies.push_back(box("stands", 1, {0.1, 0.1, 0.1}, {0, 3, 0.1}));
    lasts.bodies.push_back(box("slides", 1, {0.1, 0.1, 0.02}, {0, -3, 0.02}, {20, 1, 0}));
    allocations_of(method, lasts, 0.5);  // once a program, here too
    const long two_s_of_contact = allocations_of(method, lasts, 2);
    CHECK(allocations_of(method, lasts, 4) == two_s_of_contact);
  }
}
