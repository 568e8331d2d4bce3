/// What the CPU warp's AVX2 filters share: tests of eight positions, offsets, constants and stores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <holdfast/deflection/detail/avx2.hpp>
#include <holdfast/deflection/detail/warp_source.hpp>

#if HOLDFAST_HAS_AVX2_CODE

namespace holdfast::detail {

/// Constants in memory, as compilers would build them anew in every round of a loop.
struct BlendConstants {
  alignas(32) std::int32_t one[8] = {1 << 14, 1 << 14, 1 << 14, 1 << 14, 1 << 14, 1 << 14, 1 << 14, 1 << 14};
  alignas(32) std::int32_t half[8] = {1 << 13, 1 << 13, 1 << 13, 1 << 13, 1 << 13, 1 << 13, 1 << 13, 1 << 13};
};
inline constexpr BlendConstants blend_constants;

HOLDFAST_AVX2_INLINE __m256i load8(const std::int32_t* numbers) {
  return _mm256_load_si256(reinterpret_cast<const __m256i*>(numbers));
}

/// The source's size as numbers to compare positions with.
struct SourceSize {
  float width, height;

  SourceSize(int columns, int rows) : width(static_cast<float>(columns)), height(static_cast<float>(rows)) {}
};

/// Of eight positions: whether all have their 2x2 pixels (4x4 with a margin of 1) within the picture.
HOLDFAST_AVX2_INLINE bool all_inside(__m256 x, __m256 y, float margin, const SourceSize& size) {
  const __m256 low = _mm256_set1_ps(margin);
  const __m256 in_x = _mm256_and_ps(_mm256_cmp_ps(x, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(x, _mm256_set1_ps(size.width - 1.0F - margin), _CMP_LT_OQ));
  const __m256 in_y = _mm256_and_ps(_mm256_cmp_ps(y, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(y, _mm256_set1_ps(size.height - 1.0F - margin), _CMP_LT_OQ));
  return _mm256_movemask_ps(_mm256_and_ps(in_x, in_y)) == 0xff;
}

/// All ones where a position is covered.
HOLDFAST_AVX2_INLINE __m256 covered_mask(__m256 x, __m256 y, const SourceSize& size) {
  const __m256 low = _mm256_set1_ps(-0.5F);
  const __m256 in_x =
      _mm256_and_ps(_mm256_cmp_ps(x, low, _CMP_GE_OQ), _mm256_cmp_ps(x, _mm256_set1_ps(size.width - 0.5F), _CMP_LE_OQ));
  const __m256 in_y = _mm256_and_ps(_mm256_cmp_ps(y, low, _CMP_GE_OQ),
                                    _mm256_cmp_ps(y, _mm256_set1_ps(size.height - 0.5F), _CMP_LE_OQ));
  return _mm256_and_ps(in_x, in_y);
}

/// Channels from the picture's first to those of eight pixels.
HOLDFAST_AVX2_INLINE void store_offsets(std::uint32_t (&at)[8], __m256i x, __m256i y, std::ptrdiff_t stride) {
  const __m256i row = _mm256_mullo_epi32(y, _mm256_set1_epi32(static_cast<int>(stride)));
  _mm256_store_si256(reinterpret_cast<__m256i*>(at), _mm256_add_epi32(row, _mm256_slli_epi32(x, 2)));
  // Keep compilers from taking the numbers out of the vector one by one: loading them from memory is quicker.
  asm("" : "+m"(at));
}

/// Asks for what is so many bytes on, which target rows to come will want: processors see a row's beginning too late by
/// themselves. There need be nothing there.
HOLDFAST_AVX2_INLINE void prefetch_ahead(const std::uint8_t* pixel, std::ptrdiff_t bytes) {
  const std::uintptr_t there = reinterpret_cast<std::uintptr_t>(pixel) + static_cast<std::uintptr_t>(bytes);
  _mm_prefetch(reinterpret_cast<const char*>(there), _MM_HINT_T0);
}

HOLDFAST_AVX2_INLINE bool is_aligned(const void* p, std::size_t bytes) {
  return (reinterpret_cast<std::uintptr_t>(p) & (bytes - 1)) == 0;
}

/// Writes the pixels i to i + 7 of a row, or as many as there are.
HOLDFAST_AVX2_INLINE void store_pixels8(const WarpRow<std::uint8_t>& row, int i, __m256i colour) {
  std::uint8_t* out = row.pixels + 4 * static_cast<std::ptrdiff_t>(i);
  if (i + 8 > row.count) {
    alignas(32) std::uint8_t last[32];
    _mm256_store_si256(reinterpret_cast<__m256i*>(last), colour);
    std::memcpy(out, last, 4 * static_cast<std::size_t>(row.count - i));
  } else if (row.stream && is_aligned(out, 32)) {
    _mm256_stream_si256(reinterpret_cast<__m256i*>(out), colour);
  } else {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), colour);
  }
}

HOLDFAST_AVX2_INLINE void store_pixel(const WarpRow<float>& row, int i, __m128 colour) {
  float* out = row.pixels + 4 * static_cast<std::ptrdiff_t>(i);
  if (row.stream && is_aligned(out, 16)) {
    _mm_stream_ps(out, colour);
  } else {
    _mm_storeu_ps(out, colour);
  }
}

/// Waits until what was streamed can be seen by other threads.
HOLDFAST_AVX2 inline void finish_stores_avx2() {
  _mm_sfence();
}

}  // namespace holdfast::detail
#endif
