/// What functions for AVX2 and FMA need: an attribute for each of them, and the question whether the processor has
/// both.
///
/// Only functions with the attribute are compiled for AVX2, and each has a name of its own, so that a program built for
/// any x86-64 processor may hold them; they call only one another and intrinsics. (A lambda or a template of the
/// standard library inside them would not inherit the attribute.) On other processors and compilers
/// HOLDFAST_HAS_AVX2_CODE is 0 and there is nothing here but the answer "no".
#pragma once

#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#define HOLDFAST_HAS_AVX2_CODE 1
#include <immintrin.h>
#define HOLDFAST_AVX2 __attribute__((target("avx2,fma")))
#define HOLDFAST_AVX2_INLINE __attribute__((target("avx2,fma"), always_inline)) inline
#else
#define HOLDFAST_HAS_AVX2_CODE 0
#endif

namespace holdfast::detail {

/// Whether this processor, and its operating system, can run functions for AVX2 and FMA.
[[nodiscard]] inline bool has_avx2() {
#if HOLDFAST_HAS_AVX2_CODE
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

}  // namespace holdfast::detail
