/// The CPU warp's 8-bit bicubic filter with AVX2; warp_source.hpp is the definition.
///
/// A row of four neighbours is one load of 16 bytes. Rows are blended with 14-bit integer weights that sum to 1
/// exactly, then the four rows with float weights: at most 0.1/255 from the exact value before it is rounded.
#pragma once

#include <cstddef>
#include <cstdint>

#include <holdfast/deflection/detail/warp_source.hpp>
#include <holdfast/deflection/detail/warp_vectors_avx2.hpp>

#if HOLDFAST_HAS_AVX2_CODE

namespace holdfast::detail {

struct CubicWeights {
  __m256 at[4];
};

/// catmull_rom of eight fractions.
HOLDFAST_AVX2_INLINE CubicWeights catmull_rom8(__m256 f) {
  const __m256 half = _mm256_set1_ps(0.5F);
  const __m256 f2 = _mm256_mul_ps(f, f);
  const __m256 f3 = _mm256_mul_ps(f2, f);
  const __m256 w0 = _mm256_fnmadd_ps(half, _mm256_add_ps(f3, f), f2);
  const __m256 w1 = _mm256_add_ps(_mm256_fmadd_ps(_mm256_set1_ps(-2.5F), f2, _mm256_mul_ps(_mm256_set1_ps(1.5F), f3)),
                                  _mm256_set1_ps(1.0F));
  const __m256 w2 = _mm256_fmadd_ps(half, f, _mm256_fnmadd_ps(_mm256_set1_ps(1.5F), f3, _mm256_add_ps(f2, f2)));
  const __m256 w3 = _mm256_mul_ps(half, _mm256_sub_ps(f3, f2));
  return {{w0, w1, w2, w3}};
}

/// What the pixels of a block of eight need.
struct CubicBlock8 {
  alignas(32) std::uint32_t at[8];  ///< offset of the lower left of the 4x4 pixels
  alignas(32) std::int32_t x01[8];  ///< 16-bit pairs of weights along the row
  alignas(32) std::int32_t x23[8];
  alignas(32) float y[4][8];  ///< weights of the rows, over 2^14
};

HOLDFAST_AVX2_INLINE __m256i weight14(__m256 w) {
  return _mm256_cvtps_epi32(_mm256_mul_ps(w, _mm256_set1_ps(16384.0F)));
}

HOLDFAST_AVX2_INLINE void prepare(CubicBlock8& block, const WarpSource<std::uint8_t>& s, __m256 x, __m256 y) {
  const __m256i one = _mm256_set1_epi32(1);
  const __m256i x0 = _mm256_cvttps_epi32(x);
  const __m256i y0 = _mm256_cvttps_epi32(y);
  store_offsets(block.at, _mm256_sub_epi32(x0, one), _mm256_sub_epi32(y0, one), s.stride);
  const CubicWeights wx = catmull_rom8(_mm256_sub_ps(x, _mm256_cvtepi32_ps(x0)));
  const CubicWeights wy = catmull_rom8(_mm256_sub_ps(y, _mm256_cvtepi32_ps(y0)));
  const __m256i w0 = weight14(wx.at[0]);
  const __m256i w2 = weight14(wx.at[2]);
  const __m256i w3 = weight14(wx.at[3]);
  const __m256i rest = _mm256_add_epi32(w0, _mm256_add_epi32(w2, w3));
  const __m256i w1 = _mm256_sub_epi32(load8(blend_constants.one), rest);
  const __m256i low = _mm256_set1_epi32(0xffff);
  _mm256_store_si256(reinterpret_cast<__m256i*>(block.x01),
                     _mm256_or_si256(_mm256_and_si256(w0, low), _mm256_slli_epi32(w1, 16)));
  _mm256_store_si256(reinterpret_cast<__m256i*>(block.x23),
                     _mm256_or_si256(_mm256_and_si256(w2, low), _mm256_slli_epi32(w3, 16)));
  for (int j = 0; j < 4; ++j) {
    _mm256_store_ps(block.y[j], _mm256_mul_ps(wy.at[j], _mm256_set1_ps(1.0F / 16384.0F)));
  }
}

/// Two rows of four pixels, blended along the row: the channels of each row, times 2^14.
HOLDFAST_AVX2_INLINE __m256 blend_rows(const std::uint8_t* row, std::ptrdiff_t stride, __m256i x01, __m256i x23) {
  const __m256i first = _mm256_setr_epi8(0, -1, 4, -1, 1, -1, 5, -1, 2, -1, 6, -1, 3, -1, 7, -1,  //
                                         0, -1, 4, -1, 1, -1, 5, -1, 2, -1, 6, -1, 3, -1, 7, -1);
  const __m256i second = _mm256_setr_epi8(8, -1, 12, -1, 9, -1, 13, -1, 10, -1, 14, -1, 11, -1, 15, -1,  //
                                          8, -1, 12, -1, 9, -1, 13, -1, 10, -1, 14, -1, 11, -1, 15, -1);
  const __m256i pixels = _mm256_set_m128i(_mm_loadu_si128(reinterpret_cast<const __m128i*>(row + stride)),
                                          _mm_loadu_si128(reinterpret_cast<const __m128i*>(row)));
  const __m256i left = _mm256_madd_epi16(_mm256_shuffle_epi8(pixels, first), x01);
  const __m256i right = _mm256_madd_epi16(_mm256_shuffle_epi8(pixels, second), x23);
  return _mm256_cvtepi32_ps(_mm256_add_epi32(left, right));
}

/// Pixel k of a block: its four channels, rounded.
HOLDFAST_AVX2_INLINE __m128i bicubic_pixel(const WarpSource<std::uint8_t>& s, const CubicBlock8& block, int k) {
  const std::uint8_t* row = s.data + block.at[k];
  const __m256i x01 = _mm256_set1_epi32(block.x01[k]);
  const __m256i x23 = _mm256_set1_epi32(block.x23[k]);
  const __m256 y01 = _mm256_set_m128(_mm_broadcast_ss(&block.y[1][k]), _mm_broadcast_ss(&block.y[0][k]));
  const __m256 y23 = _mm256_set_m128(_mm_broadcast_ss(&block.y[3][k]), _mm_broadcast_ss(&block.y[2][k]));
  const __m256 sum = _mm256_fmadd_ps(blend_rows(row, s.stride, x01, x23), y01,
                                     _mm256_mul_ps(blend_rows(row + 2 * s.stride, s.stride, x01, x23), y23));
  return _mm_cvtps_epi32(_mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1)));
}

HOLDFAST_AVX2_INLINE __m128i bicubic4(const WarpSource<std::uint8_t>& s, const CubicBlock8& block, int k) {
  return _mm_packus_epi16(_mm_packs_epi32(bicubic_pixel(s, block, k), bicubic_pixel(s, block, k + 1)),
                          _mm_packs_epi32(bicubic_pixel(s, block, k + 2), bicubic_pixel(s, block, k + 3)));
}

HOLDFAST_AVX2 inline void sample_run_bicubic_avx2(const WarpSource<std::uint8_t>& s, const WarpRun& run,
                                                  const WarpRow<std::uint8_t>& row) {
  const SourceSize size(s.width, s.height);
  CubicBlock8 block;
  for (int i = 0; i < row.count; i += 8) {
    const __m256 x = _mm256_load_ps(run.x + i);
    const __m256 y = _mm256_load_ps(run.y + i);
    if (all_inside(x, y, 1.0F, size)) {
      prepare(block, s, x, y);
      const __m128i lower = bicubic4(s, block, 0);
      store_pixels8(row, i, _mm256_set_m128i(bicubic4(s, block, 4), lower));
    } else {
      for (int k = i; k < i + 8 && k < row.count; ++k) {
        sample<std::uint8_t, WarpFilter::bicubic>(s, run.x[k], run.y[k],
                                                  row.pixels + 4 * static_cast<std::ptrdiff_t>(k));
      }
    }
  }
}

}  // namespace holdfast::detail
#endif
