// How often this test program has asked for memory: operator new is replaced by one that counts (allocation_counter.cpp).
#pragma once

#include <cstddef>

namespace holdfast::test {

// On all threads together, since the program began.
std::size_t allocations();

}  // namespace holdfast::test
