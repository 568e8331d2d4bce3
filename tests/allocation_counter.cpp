#include "allocation_counter.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> count{0};  // some programs have threads
}

std::size_t holdfast::test::allocations() {
  return count;
}

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define HOLDFAST_THREAD_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)
#define HOLDFAST_THREAD_SANITIZER
#endif

#ifdef HOLDFAST_THREAD_SANITIZER
// ThreadSanitizer has an operator new of its own, and tells of each request.
extern "C" void __sanitizer_malloc_hook(const volatile void*, std::size_t) {
  ++count;
}
#else
// A file of their own: where a delete is inlined, g++ sees the free without this new, and warns.
void* operator new(std::size_t size) {
  ++count;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
// What std::stable_sort asks for its buffer with; it is freed by the delete below.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
#endif
