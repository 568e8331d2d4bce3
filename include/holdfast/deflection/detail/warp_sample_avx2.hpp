/// The CPU warp's filters with AVX2 and FMA, eight 8-bit pixels at a time; warp_source.hpp is the definition.
///
/// Only these functions are compiled for AVX2, by an attribute, and they call no function that is not: nothing here
/// changes what the rest of a program needs, and the caller asks the processor first (has_avx2). Weights of the 8-bit
/// bilinear filter are 14-bit integers that sum to 1 exactly: a value is at most 0.1/255 from the exact one before it is
/// rounded. Pixel loads come in pairs of neighbours: (left, right) of one row are one 64-bit word.
#pragma once

#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#define HOLDFAST_WARP_HAS_AVX2 1
#else
#define HOLDFAST_WARP_HAS_AVX2 0
#endif

#if HOLDFAST_WARP_HAS_AVX2

#include <immintrin.h>

#include <cstdint>
#include <cstring>

#include <holdfast/deflection/detail/warp_source.hpp>

#define HOLDFAST_AVX2 __attribute__((target("avx2,fma")))
#define HOLDFAST_AVX2_INLINE __attribute__((target("avx2,fma"), always_inline)) inline

namespace holdfast::detail {

[[nodiscard]] inline bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

/// Of eight positions: whether all have their 2x2 pixels (4x4 with a margin of 1) within the picture.
HOLDFAST_AVX2_INLINE bool all_inside(__m256 x, __m256 y, float margin, float width, float height) {
  const __m256 low = _mm256_set1_ps(margin);
  const __m256 in_x = _mm256_and_ps(_mm256_cmp_ps(x, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(x, _mm256_set1_ps(width - 1.0F - margin), _CMP_LT_OQ));
  const __m256 in_y = _mm256_and_ps(_mm256_cmp_ps(y, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(y, _mm256_set1_ps(height - 1.0F - margin), _CMP_LT_OQ));
  return _mm256_movemask_ps(_mm256_and_ps(in_x, in_y)) == 0xff;
}

/// All ones where a position is covered.
HOLDFAST_AVX2_INLINE __m256 covered_mask(__m256 x, __m256 y, float width, float height) {
  const __m256 low = _mm256_set1_ps(-0.5F);
  const __m256 in_x = _mm256_and_ps(_mm256_cmp_ps(x, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(x, _mm256_set1_ps(width - 0.5F), _CMP_LE_OQ));
  const __m256 in_y = _mm256_and_ps(_mm256_cmp_ps(y, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(y, _mm256_set1_ps(height - 0.5F), _CMP_LE_OQ));
  return _mm256_and_ps(in_x, in_y);
}

/// Weights of eight pixels' 2x2 neighbours as 16-bit pairs (left, right); lower and upper row. Their sum is 2^14.
struct BilinearWeights {
  __m256i lower, upper;
};

HOLDFAST_AVX2_INLINE BilinearWeights bilinear_weights(__m256 fx, __m256 fy) {
  const __m256i right = _mm256_cvtps_epi32(_mm256_mul_ps(fx, _mm256_set1_ps(16384.0F)));
  // (2^14 - right) | right << 16
  const __m256i pair = _mm256_sub_epi32(_mm256_add_epi32(_mm256_slli_epi32(right, 16), _mm256_set1_epi32(16384)), right);
  const __m256i up = _mm256_cvttps_epi32(_mm256_mul_ps(fy, _mm256_set1_ps(32767.9F)));  // at most 2^15 - 1
  const __m256i up_twice = _mm256_or_si256(up, _mm256_slli_epi32(up, 16));
  const __m256i upper = _mm256_mulhrs_epi16(pair, up_twice);  // pair * fy, rounded
  return {_mm256_sub_epi16(pair, upper), upper};
}

/// Two pixel pairs (left, right) a 128-bit half: of pixels (0, 1 | 4, 5) and (2, 3 | 6, 7).
struct PixelPairs {
  __m256i even, odd;
};

/// Blends eight pixels to 8 bits a channel.
HOLDFAST_AVX2_INLINE __m256i blend8(const PixelPairs& lower, const PixelPairs& upper, const BilinearWeights& w) {
  // The bytes of the first (second) pixel pair of a half as 16-bit pairs (left, right) of each channel.
  const __m256i first = _mm256_setr_epi8(0, -1, 4, -1, 1, -1, 5, -1, 2, -1, 6, -1, 3, -1, 7, -1,  //
                                         0, -1, 4, -1, 1, -1, 5, -1, 2, -1, 6, -1, 3, -1, 7, -1);
  const __m256i second = _mm256_setr_epi8(8, -1, 12, -1, 9, -1, 13, -1, 10, -1, 14, -1, 11, -1, 15, -1,  //
                                          8, -1, 12, -1, 9, -1, 13, -1, 10, -1, 14, -1, 11, -1, 15, -1);
  const __m256i half = _mm256_set1_epi32(1 << 13);
  const auto mix = [&](__m256i, __m256i) {};
  (void)mix;
#define HOLDFAST_MIX(PAIRS, BYTES, LANE)                                                                              \
  _mm256_srai_epi32(                                                                                                  \
      _mm256_add_epi32(                                                                                               \
          half, _mm256_add_epi32(_mm256_madd_epi16(_mm256_shuffle_epi8(lower.PAIRS, BYTES),                           \
                                                   _mm256_shuffle_epi32(w.lower, 0x55 * LANE)),                       \
                                 _mm256_madd_epi16(_mm256_shuffle_epi8(upper.PAIRS, BYTES),                           \
                                                   _mm256_shuffle_epi32(w.upper, 0x55 * LANE)))),                     \
      14)
  const __m256i p04 = HOLDFAST_MIX(even, first, 0);
  const __m256i p15 = HOLDFAST_MIX(even, second, 1);
  const __m256i p26 = HOLDFAST_MIX(odd, first, 2);
  const __m256i p37 = HOLDFAST_MIX(odd, second, 3);
#undef HOLDFAST_MIX
  return _mm256_packus_epi16(_mm256_packs_epi32(p04, p15), _mm256_packs_epi32(p26, p37));
}

}  // namespace holdfast::detail
#endif
