/// The CPU warp's float filters with AVX2 and FMA, a pixel at a time, a row of 2x2 pixels a vector; warp_source.hpp is
/// the definition. At whole texels the result is the source's pixel to the last bit.
#pragma once

#include <cstddef>
#include <cstdint>

#include <holdfast/deflection/detail/warp_bicubic_avx2.hpp>
#include <holdfast/deflection/detail/warp_source.hpp>
#include <holdfast/deflection/detail/warp_vectors_avx2.hpp>

#if HOLDFAST_HAS_AVX2_CODE

namespace holdfast::detail {

HOLDFAST_AVX2_INLINE __m128 bilinear_pixel(const float* lower, std::ptrdiff_t stride, float fx, float fy) {
  const __m256 below = _mm256_loadu_ps(lower);
  const __m256 sides =
      _mm256_fmadd_ps(_mm256_set1_ps(fy), _mm256_sub_ps(_mm256_loadu_ps(lower + stride), below), below);
  const __m128 left = _mm256_castps256_ps128(sides);
  return _mm_fmadd_ps(_mm_set1_ps(fx), _mm_sub_ps(_mm256_extractf128_ps(sides, 1), left), left);
}

HOLDFAST_AVX2 inline void sample_run_float_bilinear_avx2(const WarpSource<float>& s, const WarpRun& run,
                                                         const WarpRow<float>& row) {
  const SourceSize size(s.width, s.height);
  alignas(32) std::uint32_t at[8];
  alignas(32) float fx[8];
  alignas(32) float fy[8];
  for (int i = 0; i < row.count; i += 8) {
    const int end = i + 8 < row.count ? 8 : row.count - i;
    const __m256 x = _mm256_load_ps(run.x + i);
    const __m256 y = _mm256_load_ps(run.y + i);
    if (all_inside(x, y, 0.0F, size)) {
      const __m256i x0 = _mm256_cvttps_epi32(x);
      const __m256i y0 = _mm256_cvttps_epi32(y);
      store_offsets(at, x0, y0, s.stride);
      _mm256_store_ps(fx, _mm256_sub_ps(x, _mm256_cvtepi32_ps(x0)));
      _mm256_store_ps(fy, _mm256_sub_ps(y, _mm256_cvtepi32_ps(y0)));
      for (int k = 0; k < end; ++k) store_pixel(row, i + k, bilinear_pixel(s.data + at[k], s.stride, fx[k], fy[k]));
    } else {
      for (int k = i; k < i + end; ++k) {
        sample<float, WarpFilter::bilinear>(s, run.x[k], run.y[k], row.pixels + 4 * static_cast<std::ptrdiff_t>(k));
      }
    }
  }
}

/// Weights of a block of eight pixels along one axis, as pixels read them.
struct FloatWeights8 {
  alignas(32) float at[4][8];
};

HOLDFAST_AVX2_INLINE void store_weights(FloatWeights8& weights, __m256 fraction) {
  const CubicWeights w = catmull_rom8(fraction);
  for (int j = 0; j < 4; ++j) _mm256_store_ps(weights.at[j], w.at[j]);
}

/// Twice the channels of two pixels.
HOLDFAST_AVX2_INLINE __m256 pair_of(float left, float right) {
  return _mm256_set_m128(_mm_set1_ps(right), _mm_set1_ps(left));
}

HOLDFAST_AVX2_INLINE __m128 bicubic_pixel(const float* corner, std::ptrdiff_t stride, const FloatWeights8& wx,
                                          const FloatWeights8& wy, int k) {
  __m256 left = _mm256_setzero_ps();
  __m256 right = _mm256_setzero_ps();
  for (int j = 0; j < 4; ++j) {
    const __m256 w = _mm256_broadcast_ss(&wy.at[j][k]);
    left = _mm256_fmadd_ps(_mm256_loadu_ps(corner + j * stride), w, left);
    right = _mm256_fmadd_ps(_mm256_loadu_ps(corner + j * stride + 8), w, right);
  }
  const __m256 sum =
      _mm256_fmadd_ps(left, pair_of(wx.at[0][k], wx.at[1][k]), _mm256_mul_ps(right, pair_of(wx.at[2][k], wx.at[3][k])));
  return _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1));
}

HOLDFAST_AVX2 inline void sample_run_float_bicubic_avx2(const WarpSource<float>& s, const WarpRun& run,
                                                        const WarpRow<float>& row) {
  const SourceSize size(s.width, s.height);
  const __m256i one = _mm256_set1_epi32(1);
  alignas(32) std::uint32_t at[8];
  FloatWeights8 wx;
  FloatWeights8 wy;
  for (int i = 0; i < row.count; i += 8) {
    const int end = i + 8 < row.count ? 8 : row.count - i;
    const __m256 x = _mm256_load_ps(run.x + i);
    const __m256 y = _mm256_load_ps(run.y + i);
    if (all_inside(x, y, 1.0F, size)) {
      const __m256i x0 = _mm256_cvttps_epi32(x);
      const __m256i y0 = _mm256_cvttps_epi32(y);
      store_offsets(at, _mm256_sub_epi32(x0, one), _mm256_sub_epi32(y0, one), s.stride);
      store_weights(wx, _mm256_sub_ps(x, _mm256_cvtepi32_ps(x0)));
      store_weights(wy, _mm256_sub_ps(y, _mm256_cvtepi32_ps(y0)));
      for (int k = 0; k < end; ++k) store_pixel(row, i + k, bicubic_pixel(s.data + at[k], s.stride, wx, wy, k));
    } else {
      for (int k = i; k < i + end; ++k) {
        sample<float, WarpFilter::bicubic>(s, run.x[k], run.y[k], row.pixels + 4 * static_cast<std::ptrdiff_t>(k));
      }
    }
  }
}

}  // namespace holdfast::detail
#endif
