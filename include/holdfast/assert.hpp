/// Assertion for programmer errors (a broken precondition inside the library or by its caller).
///
/// Define HOLDFAST_ASSERT(condition, message) before the first include to route it to your engine's own handler. Without it,
/// a debug build prints and aborts, an NDEBUG build compiles to nothing. Bad *input* is never reported this way: it gets
/// std::optional, a result type, or (files and options) an exception.
#pragma once

#ifndef HOLDFAST_ASSERT
#ifdef NDEBUG
#define HOLDFAST_ASSERT(condition, message) static_cast<void>(0)
#else
#include <cstdio>
#include <cstdlib>
#define HOLDFAST_ASSERT(condition, message)                                                                      \
  ((condition) ? static_cast<void>(0)                                                                            \
               : (std::fprintf(stderr, "%s:%d: holdfast: %s (%s)\n", __FILE__, __LINE__, message, #condition), \
                  std::abort()))
#endif
#endif
