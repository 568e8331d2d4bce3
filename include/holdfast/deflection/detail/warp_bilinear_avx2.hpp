/// The CPU warp's 8-bit bilinear filter with AVX2 and FMA, eight pixels at a time; warp_source.hpp is the definition.
///
/// Pixel loads come in pairs of neighbours: (left, right) of one row are one 64-bit word; they are loaded one by one,
/// as the gather instruction is no faster and on many processors far slower. The bilinear filter's weights are 14-bit
/// integers that sum to 1 exactly: a value is at most 0.1/255 from the exact one before it is rounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <holdfast/deflection/detail/warp_source.hpp>
#include <holdfast/deflection/detail/warp_vectors_avx2.hpp>

#if HOLDFAST_HAS_AVX2_CODE

namespace holdfast::detail {

/// Weights of eight pixels' 2x2 neighbours as 16-bit pairs (left, right); lower and upper row. Their sum is 2^14.
struct BilinearWeights {
  __m256i lower, upper;
};

HOLDFAST_AVX2_INLINE BilinearWeights bilinear_weights(__m256 fx, __m256 fy) {
  const __m256i right = _mm256_cvtps_epi32(_mm256_mul_ps(fx, _mm256_set1_ps(16384.0F)));
  // (2^14 - right) | right << 16
  const __m256i pair =
      _mm256_sub_epi32(_mm256_add_epi32(_mm256_slli_epi32(right, 16), load8(blend_constants.one)), right);
  const __m256i up = _mm256_cvttps_epi32(_mm256_mul_ps(fy, _mm256_set1_ps(32767.9F)));  // at most 2^15 - 1
  const __m256i up_twice = _mm256_or_si256(up, _mm256_slli_epi32(up, 16));
  const __m256i upper = _mm256_mulhrs_epi16(pair, up_twice);  // pair * fy, rounded
  return {_mm256_sub_epi16(pair, upper), upper};
}

/// Two pixel pairs (left, right) a 128-bit half: of pixels (0, 1 | 4, 5) and (2, 3 | 6, 7).
struct PixelPairs {
  __m256i even, odd;
};

/// Four times a channel of two pixels, as 32-bit numbers; `bytes` picks a pair of pixels, `Lane` their weights.
template <int Lane>
HOLDFAST_AVX2_INLINE __m256i blend2(__m256i lower, __m256i upper, __m256i bytes, const BilinearWeights& w) {
  const __m256i low = _mm256_madd_epi16(_mm256_shuffle_epi8(lower, bytes), _mm256_shuffle_epi32(w.lower, 0x55 * Lane));
  const __m256i up = _mm256_madd_epi16(_mm256_shuffle_epi8(upper, bytes), _mm256_shuffle_epi32(w.upper, 0x55 * Lane));
  return _mm256_srai_epi32(_mm256_add_epi32(load8(blend_constants.half), _mm256_add_epi32(low, up)), 14);
}

/// Blends eight pixels to 8 bits a channel.
HOLDFAST_AVX2_INLINE __m256i blend8(const PixelPairs& lower, const PixelPairs& upper, const BilinearWeights& w) {
  // The bytes of the first (second) pixel pair of a half as 16-bit pairs (left, right) of each channel.
  const __m256i first = _mm256_setr_epi8(0, -1, 4, -1, 1, -1, 5, -1, 2, -1, 6, -1, 3, -1, 7, -1,  //
                                         0, -1, 4, -1, 1, -1, 5, -1, 2, -1, 6, -1, 3, -1, 7, -1);
  const __m256i second = _mm256_setr_epi8(8, -1, 12, -1, 9, -1, 13, -1, 10, -1, 14, -1, 11, -1, 15, -1,  //
                                          8, -1, 12, -1, 9, -1, 13, -1, 10, -1, 14, -1, 11, -1, 15, -1);
  const __m256i p04 = blend2<0>(lower.even, upper.even, first, w);
  const __m256i p15 = blend2<1>(lower.even, upper.even, second, w);
  const __m256i p26 = blend2<2>(lower.odd, upper.odd, first, w);
  const __m256i p37 = blend2<3>(lower.odd, upper.odd, second, w);
  return _mm256_packus_epi16(_mm256_packs_epi32(p04, p15), _mm256_packs_epi32(p26, p37));
}

HOLDFAST_AVX2_INLINE __m128i load_two_pairs(const std::uint8_t* a, const std::uint8_t* b) {
  const __m128i first = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(a));
  return _mm_castps_si128(_mm_loadh_pi(_mm_castsi128_ps(first), reinterpret_cast<const __m64*>(b)));
}

/// The pairs at eight byte offsets.
HOLDFAST_AVX2_INLINE PixelPairs load_pairs(const std::uint8_t* data, const std::uint32_t* at) {
  const __m128i p01 = load_two_pairs(data + at[0], data + at[1]);
  const __m128i p45 = load_two_pairs(data + at[4], data + at[5]);
  const __m128i p23 = load_two_pairs(data + at[2], data + at[3]);
  const __m128i p67 = load_two_pairs(data + at[6], data + at[7]);
  return {_mm256_set_m128i(p45, p01), _mm256_set_m128i(p67, p23)};
}

/// The pairs at the edge: left and right are looked up apart.
HOLDFAST_AVX2_INLINE PixelPairs gather_pairs(const std::uint8_t* data, __m256i left, __m256i right) {
  const __m256i l = _mm256_i32gather_epi32(reinterpret_cast<const int*>(data), left, 1);
  const __m256i r = _mm256_i32gather_epi32(reinterpret_cast<const int*>(data), right, 1);
  return {_mm256_unpacklo_epi32(l, r), _mm256_unpackhi_epi32(l, r)};
}

/// What eight pixels are blended from.
struct Neighbours8 {
  PixelPairs lower, upper;
  BilinearWeights weights;
};

/// All neighbours are within the picture.
HOLDFAST_AVX2_INLINE Neighbours8 neighbours_inside(const WarpSource<std::uint8_t>& s, __m256 x, __m256 y) {
  const __m256i x0 = _mm256_cvttps_epi32(x);
  const __m256i y0 = _mm256_cvttps_epi32(y);
  alignas(32) std::uint32_t at[8];
  store_offsets(at, x0, y0, s.stride);
  prefetch_ahead(s.data + at[4], 4 * s.stride);
  return {load_pairs(s.data, at), load_pairs(s.data + s.stride, at),
          bilinear_weights(_mm256_sub_ps(x, _mm256_cvtepi32_ps(x0)), _mm256_sub_ps(y, _mm256_cvtepi32_ps(y0)))};
}

/// Neighbours are clamped to the picture; pixels that are not covered look at (0, 0).
HOLDFAST_AVX2_INLINE Neighbours8 neighbours_at_edge(const WarpSource<std::uint8_t>& s, __m256 x, __m256 y,
                                                    __m256 covered) {
  const __m256 cx = _mm256_and_ps(x, covered);
  const __m256 cy = _mm256_and_ps(y, covered);
  const __m256 floor_x = _mm256_floor_ps(cx);
  const __m256 floor_y = _mm256_floor_ps(cy);
  const __m256i x0 = _mm256_cvtps_epi32(floor_x);
  const __m256i y0 = _mm256_cvtps_epi32(floor_y);
  const __m256i zero = _mm256_setzero_si256();
  const __m256i one = _mm256_set1_epi32(1);
  const __m256i x1 = _mm256_min_epi32(_mm256_add_epi32(x0, one), _mm256_set1_epi32(s.width - 1));
  const __m256i y1 = _mm256_min_epi32(_mm256_add_epi32(y0, one), _mm256_set1_epi32(s.height - 1));
  const __m256i stride = _mm256_set1_epi32(static_cast<int>(s.stride));
  const __m256i left = _mm256_slli_epi32(_mm256_max_epi32(x0, zero), 2);
  const __m256i right = _mm256_slli_epi32(x1, 2);
  const __m256i lower = _mm256_mullo_epi32(_mm256_max_epi32(y0, zero), stride);
  const __m256i upper = _mm256_mullo_epi32(y1, stride);
  return {gather_pairs(s.data, _mm256_add_epi32(lower, left), _mm256_add_epi32(lower, right)),
          gather_pairs(s.data, _mm256_add_epi32(upper, left), _mm256_add_epi32(upper, right)),
          bilinear_weights(_mm256_sub_ps(cx, floor_x), _mm256_sub_ps(cy, floor_y))};
}

HOLDFAST_AVX2_INLINE __m256i border8(const WarpSource<std::uint8_t>& s) {
  std::int32_t bits = 0;
  std::memcpy(&bits, s.border.data(), 4);
  return _mm256_set1_epi32(bits);
}

HOLDFAST_AVX2 inline void sample_run_bilinear_avx2(const WarpSource<std::uint8_t>& s, const WarpRun& run,
                                                   const WarpRow<std::uint8_t>& row) {
  const SourceSize size(s.width, s.height);
  const __m256i border = border8(s);
  for (int i = 0; i < row.count; i += 8) {
    const __m256 x = _mm256_load_ps(run.x + i);
    const __m256 y = _mm256_load_ps(run.y + i);
    __m256i colour = border;
    if (all_inside(x, y, 0.0F, size)) {
      const Neighbours8 n = neighbours_inside(s, x, y);
      colour = blend8(n.lower, n.upper, n.weights);
    } else {
      const __m256 covered = covered_mask(x, y, size);
      if (_mm256_movemask_ps(covered) != 0) {
        const Neighbours8 n = neighbours_at_edge(s, x, y, covered);
        colour = _mm256_blendv_epi8(border, blend8(n.lower, n.upper, n.weights), _mm256_castps_si256(covered));
      }
    }
    store_pixels8(row, i, colour);
  }
}

}  // namespace holdfast::detail
#endif
