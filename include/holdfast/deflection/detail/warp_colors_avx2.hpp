/// The CPU warp's 8-bit bilinear filter with AVX2 where each colour comes from a place of its own.
#pragma once

#include <cstdint>

#include <holdfast/deflection/detail/warp_bilinear_avx2.hpp>
#include <holdfast/deflection/detail/warp_source.hpp>
#include <holdfast/deflection/detail/warp_vectors_avx2.hpp>

#if HOLDFAST_HAS_AVX2_CODE

namespace holdfast::detail {

/// The bytes of channel C as 16-bit pairs (left, right), pixels 0 to 7 in order.
template <int C>
HOLDFAST_AVX2_INLINE __m256i channel_pairs(const PixelPairs& pairs) {
  constexpr char no = -128;  // becomes 0
  const __m256i even = _mm256_setr_epi8(C, no, 4 + C, no, 8 + C, no, 12 + C, no, no, no, no, no, no, no, no, no,  //
                                        C, no, 4 + C, no, 8 + C, no, 12 + C, no, no, no, no, no, no, no, no, no);
  const __m256i odd = _mm256_setr_epi8(no, no, no, no, no, no, no, no, C, no, 4 + C, no, 8 + C, no, 12 + C, no,  //
                                       no, no, no, no, no, no, no, no, C, no, 4 + C, no, 8 + C, no, 12 + C, no);
  return _mm256_or_si256(_mm256_shuffle_epi8(pairs.even, even), _mm256_shuffle_epi8(pairs.odd, odd));
}

/// Channel C of eight pixels as 32-bit numbers.
template <int C>
HOLDFAST_AVX2_INLINE __m256i blend_channel(const Neighbours8& n) {
  const __m256i low = _mm256_madd_epi16(channel_pairs<C>(n.lower), n.weights.lower);
  const __m256i up = _mm256_madd_epi16(channel_pairs<C>(n.upper), n.weights.upper);
  return _mm256_srli_epi32(_mm256_add_epi32(load8(blend_constants.half), _mm256_add_epi32(low, up)), 14);
}

struct Positions8 {
  __m256 x, y;
};

HOLDFAST_AVX2_INLINE Positions8 positions8(const WarpRun& run, int i) {
  return {_mm256_load_ps(run.x + i), _mm256_load_ps(run.y + i)};
}

/// Eight pixels; `covered` null: all are well inside.
HOLDFAST_AVX2_INLINE __m256i blend_colors(const WarpSource<std::uint8_t>& s, const Positions8 (&p)[3],
                                          const __m256* covered) {
  const Neighbours8 red =
      covered == nullptr ? neighbours_inside(s, p[0].x, p[0].y) : neighbours_at_edge(s, p[0].x, p[0].y, *covered);
  const __m256i r = blend_channel<0>(red);
  const Neighbours8 green =
      covered == nullptr ? neighbours_inside(s, p[1].x, p[1].y) : neighbours_at_edge(s, p[1].x, p[1].y, *covered);
  const __m256i g = blend_channel<1>(green);
  const __m256i a = blend_channel<3>(green);
  const Neighbours8 blue =
      covered == nullptr ? neighbours_inside(s, p[2].x, p[2].y) : neighbours_at_edge(s, p[2].x, p[2].y, *covered);
  const __m256i b = blend_channel<2>(blue);
  return _mm256_or_si256(_mm256_or_si256(r, _mm256_slli_epi32(g, 8)),
                         _mm256_or_si256(_mm256_slli_epi32(b, 16), _mm256_slli_epi32(a, 24)));
}

/// Covered is what is covered in every colour.
HOLDFAST_AVX2 inline void sample_colors_bilinear_avx2(const WarpSource<std::uint8_t>& s, const ColorRuns& runs,
                                                      const WarpRow<std::uint8_t>& row) {
  const SourceSize size(s.width, s.height);
  const __m256i border = border8(s);
  for (int i = 0; i < row.count; i += 8) {
    const Positions8 p[3] = {positions8(runs.of[0], i), positions8(runs.of[1], i), positions8(runs.of[2], i)};
    __m256i colour = border;
    if (all_inside(p[0].x, p[0].y, 0.0F, size) && all_inside(p[1].x, p[1].y, 0.0F, size) &&
        all_inside(p[2].x, p[2].y, 0.0F, size)) {
      colour = blend_colors(s, p, nullptr);
    } else {
      const __m256 green_and_blue =
          _mm256_and_ps(covered_mask(p[1].x, p[1].y, size), covered_mask(p[2].x, p[2].y, size));
      const __m256 covered = _mm256_and_ps(covered_mask(p[0].x, p[0].y, size), green_and_blue);
      if (_mm256_movemask_ps(covered) != 0) {
        colour = _mm256_blendv_epi8(border, blend_colors(s, p, &covered), _mm256_castps_si256(covered));
      }
    }
    store_pixels8(row, i, colour);
  }
}

}  // namespace holdfast::detail
#endif
