/// warp_positions.hpp with AVX2 and FMA: eight pixels at a time.
#pragma once

#include <holdfast/deflection/detail/avx2.hpp>
#include <holdfast/deflection/detail/warp_positions.hpp>

#if HOLDFAST_HAS_AVX2_CODE

namespace holdfast::detail {

/// Element k of the matrices of eight columns from x.
template <bool ByColumn>
HOLDFAST_AVX2_INLINE __m256 element8(const LineMatrix& m, int k, int x) {
  if constexpr (ByColumn) {
    return _mm256_loadu_ps(m.elements + m.pitch * k + x);
  } else {
    return _mm256_broadcast_ss(m.elements + k);
  }
}

/// One homogeneous coordinate, from element k on.
template <bool ByColumn>
HOLDFAST_AVX2_INLINE __m256 line8(const LineMatrix& m, int k, int x, __m256 a, __m256 b) {
  const __m256 rest = _mm256_fmadd_ps(element8<ByColumn>(m, k + 1, x), b, element8<ByColumn>(m, k + 2, x));
  return _mm256_fmadd_ps(element8<ByColumn>(m, k, x), a, rest);
}

template <bool ByColumn>
HOLDFAST_AVX2_INLINE void project8(const LineMatrix& m, const WarpPiece& piece, int i, __m256 a, __m256 b) {
  const int x = piece.x + i;
  const __m256 w = line8<ByColumn>(m, 6, x, a, b);
  // All bits set is a NaN, and stays one.
  const __m256 behind = _mm256_cmp_ps(w, _mm256_setzero_ps(), _CMP_NGT_UQ);
  const __m256 scale = _mm256_or_ps(_mm256_div_ps(_mm256_set1_ps(1.0F), w), behind);
  _mm256_store_ps(piece.out_x + i, _mm256_mul_ps(line8<ByColumn>(m, 0, x, a, b), scale));
  _mm256_store_ps(piece.out_y + i, _mm256_mul_ps(line8<ByColumn>(m, 3, x, a, b), scale));
}

template <bool ByColumn>
HOLDFAST_AVX2_INLINE void linear8(const LineMatrix& m, float y, const WarpPiece& piece) {
  const __m256 lanes = _mm256_setr_ps(0.5F, 1.5F, 2.5F, 3.5F, 4.5F, 5.5F, 6.5F, 7.5F);
  const __m256 b = _mm256_set1_ps(y);
  for (int i = 0; i < piece.count; i += 8) {
    const __m256 a = _mm256_add_ps(_mm256_set1_ps(static_cast<float>(piece.x + i)), lanes);
    project8<ByColumn>(m, piece, i, a, b);
  }
}

HOLDFAST_AVX2_INLINE __m256 cubic8(const float* c, __m256 d) {
  __m256 sum = _mm256_broadcast_ss(c + 3);
  sum = _mm256_fmadd_ps(sum, d, _mm256_broadcast_ss(c + 2));
  sum = _mm256_fmadd_ps(sum, d, _mm256_broadcast_ss(c + 1));
  return _mm256_fmadd_ps(sum, d, _mm256_broadcast_ss(c));
}

template <bool ByColumn>
HOLDFAST_AVX2_INLINE void cell8(const LineMatrix& m, const float* cubic, float dx, float dy, const WarpPiece& piece) {
  const __m256 y = _mm256_set1_ps(dy);
  __m256 row = _mm256_loadu_ps(cubic + 24);
  row = _mm256_fmadd_ps(row, y, _mm256_loadu_ps(cubic + 16));
  row = _mm256_fmadd_ps(row, y, _mm256_loadu_ps(cubic + 8));
  row = _mm256_fmadd_ps(row, y, _mm256_loadu_ps(cubic));
  alignas(32) float c[8];
  _mm256_store_ps(c, row);
  __m256 d = _mm256_add_ps(_mm256_set1_ps(dx), _mm256_setr_ps(0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F));
  for (int i = 0; i < piece.count; i += 8) {
    project8<ByColumn>(m, piece, i, cubic8(c, d), cubic8(c + 4, d));
    d = _mm256_add_ps(d, _mm256_set1_ps(8.0F));
  }
}

template <bool ByColumn>
HOLDFAST_AVX2_INLINE void dense8(const LineMatrix& m, const float* t_x, const float* t_y, const WarpPiece& piece) {
  for (int i = 0; i < piece.count; i += 8) {
    project8<ByColumn>(m, piece, i, _mm256_loadu_ps(t_x + i), _mm256_loadu_ps(t_y + i));
  }
}

HOLDFAST_AVX2 inline void positions_linear_avx2(const LineMatrix& m, float y, const WarpPiece& piece) {
  m.pitch == 0 ? linear8<false>(m, y, piece) : linear8<true>(m, y, piece);
}

HOLDFAST_AVX2 inline void positions_cubic_avx2(const LineMatrix& m, const float* cubic, float dx, float dy,
                                               const WarpPiece& piece) {
  m.pitch == 0 ? cell8<false>(m, cubic, dx, dy, piece) : cell8<true>(m, cubic, dx, dy, piece);
}

HOLDFAST_AVX2 inline void positions_dense_avx2(const LineMatrix& m, const float* t_x, const float* t_y,
                                               const WarpPiece& piece) {
  m.pitch == 0 ? dense8<false>(m, t_x, t_y, piece) : dense8<true>(m, t_x, t_y, piece);
}

}  // namespace holdfast::detail
#endif
