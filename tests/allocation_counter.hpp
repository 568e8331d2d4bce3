// How often this test program has asked for memory: operator new is replaced by one that counts (allocation_counter.cpp).
#pragma once

#include <cstddef>
#include <new>

namespace holdfast::test {

// On all threads together, since the program began.
std::size_t allocations();

// Whether the caller's requests are counted at all. Asked for by name: compilers may leave out a new-expression, and a
// container's memory, that nothing looks at.
inline bool counts_allocations() {
  const std::size_t before = allocations();
  ::operator delete(::operator new(1));
  return allocations() > before;
}

}  // namespace holdfast::test
