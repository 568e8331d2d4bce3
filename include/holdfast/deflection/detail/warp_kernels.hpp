/// The CPU warp's inner loops, as chosen for this processor.
#pragma once

#include <cstdint>
#include <type_traits>

#include <holdfast/deflection/detail/avx2.hpp>
#include <holdfast/deflection/detail/warp_bicubic_avx2.hpp>
#include <holdfast/deflection/detail/warp_bilinear_avx2.hpp>
#include <holdfast/deflection/detail/warp_colors_avx2.hpp>
#include <holdfast/deflection/detail/warp_float_avx2.hpp>
#include <holdfast/deflection/detail/warp_positions.hpp>
#include <holdfast/deflection/detail/warp_positions_avx2.hpp>
#include <holdfast/deflection/detail/warp_source.hpp>

namespace holdfast::detail {

/// Of the lens and the matrices.
struct PositionKernels {
  void (*linear)(const LineMatrix&, float, const WarpPiece&) = &positions_linear;
  void (*cubic)(const LineMatrix&, const float*, float, float, const WarpPiece&) = &positions_cubic;
  void (*dense)(const LineMatrix&, const float*, const float*, const WarpPiece&) = &positions_dense;
};

template <typename Channel>
using SampleKernel = void (*)(const WarpSource<Channel>&, const WarpRun&, const WarpRow<Channel>&);

/// Three colours at once; null where there is none: then colours are sampled one after another.
template <typename Channel>
using SampleColorsKernel = void (*)(const WarpSource<Channel>&, const ColorRuns&, const WarpRow<Channel>&);

inline void finish_stores() {}

#if HOLDFAST_HAS_AVX2_CODE

[[nodiscard]] inline PositionKernels position_kernels(bool vectors) {
  if (!vectors) return {};
  return {&positions_linear_avx2, &positions_cubic_avx2, &positions_dense_avx2};
}

template <typename Channel>
[[nodiscard]] SampleKernel<Channel> sample_kernel(WarpFilter filter, bool vectors) {
  const bool bilinear = filter == WarpFilter::bilinear;
  if (!vectors) {
    return bilinear ? &sample_run<Channel, WarpFilter::bilinear> : &sample_run<Channel, WarpFilter::bicubic>;
  }
  if constexpr (std::is_same_v<Channel, float>) {
    return bilinear ? &sample_run_float_bilinear_avx2 : &sample_run_float_bicubic_avx2;
  } else {
    return bilinear ? &sample_run_bilinear_avx2 : &sample_run_bicubic_avx2;
  }
}

template <typename Channel>
[[nodiscard]] SampleColorsKernel<Channel> sample_colors_kernel(WarpFilter filter, bool vectors) {
  if constexpr (std::is_same_v<Channel, std::uint8_t>) {
    if (vectors && filter == WarpFilter::bilinear) return &sample_colors_bilinear_avx2;
  }
  return nullptr;
}

/// What makes a thread's stores visible to others.
[[nodiscard]] inline auto finish_kernel(bool vectors) -> void (*)() {
  return vectors ? &finish_stores_avx2 : &finish_stores;
}

#else

[[nodiscard]] inline PositionKernels position_kernels(bool) {
  return {};
}
template <typename Channel>
[[nodiscard]] SampleKernel<Channel> sample_kernel(WarpFilter filter, bool) {
  return filter == WarpFilter::bilinear ? &sample_run<Channel, WarpFilter::bilinear>
                                        : &sample_run<Channel, WarpFilter::bicubic>;
}
template <typename Channel>
[[nodiscard]] SampleColorsKernel<Channel> sample_colors_kernel(WarpFilter, bool) {
  return nullptr;
}
[[nodiscard]] inline auto finish_kernel(bool) -> void (*)() {
  return &finish_stores;
}

#endif

}  // namespace holdfast::detail
