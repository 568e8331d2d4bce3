/// What the CPU warp's inner loops share: the source picture, a run of positions in it, and the filters pixel by pixel.
///
/// Positions are counted in texels: (0, 0) is the CENTRE of the source pixel at the lower left, so a position is the
/// source pixel minus one half. A position outside the picture's rectangle, or NaN, is not covered and gets the
/// border's colour; the half pixel inside the rectangle's edge repeats the edge, as GL_CLAMP_TO_EDGE does. The
/// functions here are the portable ones; warp_bilinear_avx2.hpp, warp_bicubic_avx2.hpp and warp_float_avx2.hpp hold the
/// same in vectors.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace holdfast {

/// How a picture is looked up between its pixels.
enum class WarpFilter {
  bilinear,  ///< as GL_LINEAR: exact for linear ramps
  bicubic,   ///< Catmull-Rom over 4x4 pixels: exact for quadratics, sharper; may overshoot at edges
};

namespace detail {

/// Target pixels of a row that are worked on together: a multiple of the lens cells' side and of the vectors' width.
inline constexpr int run_pixels = 256;

/// Positions of a run's pixels in the source, in texels.
struct WarpRun {
  alignas(32) float x[run_pixels];
  alignas(32) float y[run_pixels];
};

/// Where a run's pixels go.
template <typename Channel>
struct WarpRow {
  Channel* pixels = nullptr;
  int count = 0;
  bool stream = false;  ///< write past the caches, as the target is too large to be found there again
};

template <typename Channel>
struct WarpSource {
  const Channel* data = nullptr;
  std::ptrdiff_t stride = 0;  ///< channels
  int width = 0;
  int height = 0;
  std::array<Channel, 4> border{};
};

/// Catmull-Rom's weights of the pixels at -1, 0, 1, 2 for a point at f in [0, 1): exactly (0, 1, 0, 0) at f = 0.
inline std::array<float, 4> catmull_rom(float f) {
  const float f2 = f * f;
  const float f3 = f2 * f;
  return {f2 - 0.5F * (f3 + f), 1.5F * f3 - 2.5F * f2 + 1.0F, 2.0F * f2 - 1.5F * f3 + 0.5F * f, 0.5F * (f3 - f2)};
}

template <typename Channel>
Channel as_channel(float value) {
  if constexpr (std::is_same_v<Channel, float>) {
    return value;
  } else {
    return static_cast<Channel>(std::min(255.0F, std::max(0.0F, value)) + 0.5F);
  }
}

/// The largest whole number at or below a value in int's range; std::floor may be a slow function call.
inline int floor_of(float value) {
  const int towards_zero = static_cast<int>(value);
  return towards_zero - (value < static_cast<float>(towards_zero) ? 1 : 0);
}

template <typename Channel>
[[nodiscard]] bool is_covered(const WarpSource<Channel>& s, float x, float y) {
  return x >= -0.5F && y >= -0.5F && x <= static_cast<float>(s.width) - 0.5F &&
         y <= static_cast<float>(s.height) - 0.5F;
}

/// The 2x2 neighbours of a position, clamped to the picture, and how far it is from the lower left one.
template <typename Channel>
struct Neighbours {
  const Channel* pixel[4];  ///< lower left, lower right, upper left, upper right
  float fx, fy;

  /// Precondition: is_covered.
  Neighbours(const WarpSource<Channel>& s, float x, float y) {
    const int x0 = floor_of(x);
    const int y0 = floor_of(y);
    fx = x - static_cast<float>(x0);
    fy = y - static_cast<float>(y0);
    const std::ptrdiff_t left = 4 * static_cast<std::ptrdiff_t>(std::max(x0, 0));
    const std::ptrdiff_t right = 4 * static_cast<std::ptrdiff_t>(std::min(x0 + 1, s.width - 1));
    const Channel* lower = s.data + s.stride * std::max(y0, 0);
    const Channel* upper = s.data + s.stride * std::min(y0 + 1, s.height - 1);
    pixel[0] = lower + left;
    pixel[1] = lower + right;
    pixel[2] = upper + left;
    pixel[3] = upper + right;
  }
};

inline void blend(const Neighbours<float>& n, float* out) {
  for (int c = 0; c < 4; ++c) {
    const float left = n.pixel[0][c] + n.fy * (n.pixel[2][c] - n.pixel[0][c]);
    const float right = n.pixel[1][c] + n.fy * (n.pixel[3][c] - n.pixel[1][c]);
    out[c] = left + n.fx * (right - left);
  }
}

/// With integer weights that sum to 2^14 exactly, two channels in the halves of a 64-bit number.
inline void blend(const Neighbours<std::uint8_t>& n, std::uint8_t* out) {
  const auto right = static_cast<std::uint32_t>(n.fx * 16384.0F + 0.5F);
  const auto up = static_cast<std::uint32_t>(n.fy * 32767.9F);
  const std::uint32_t upper_left = ((16384U - right) * up + 16384U) >> 15;
  const std::uint32_t upper_right = (right * up + 16384U) >> 15;
  const std::uint32_t weight[4] = {16384U - right - upper_left, right - upper_right, upper_left, upper_right};
  constexpr std::uint64_t low_bytes = 0x000000ff000000ffU;
  const auto spread = [](std::uint32_t v) { return (v | (std::uint64_t{v} << 16)) & low_bytes; };
  std::uint64_t even = 8192U * 0x0000000100000001U;
  std::uint64_t odd = even;
  for (int i = 0; i < 4; ++i) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, n.pixel[i], 4);
    even += weight[i] * spread(bits);
    odd += weight[i] * spread(bits >> 8);
  }
  const auto collect = [](std::uint64_t v) {
    const std::uint64_t bytes = (v >> 14) & low_bytes;
    return static_cast<std::uint32_t>(bytes | (bytes >> 16));
  };
  const std::uint32_t bits = collect(even) | (collect(odd) << 8);
  std::memcpy(out, &bits, 4);
}

/// Precondition: is_covered.
template <typename Channel>
void sample_bicubic(const WarpSource<Channel>& s, float x, float y, Channel* out) {
  const int x0 = floor_of(x);
  const int y0 = floor_of(y);
  const std::array<float, 4> wx = catmull_rom(x - static_cast<float>(x0));
  const std::array<float, 4> wy = catmull_rom(y - static_cast<float>(y0));
  std::array<float, 4> sum{};
  for (int j = 0; j < 4; ++j) {
    const Channel* row = s.data + s.stride * std::clamp(y0 + j - 1, 0, s.height - 1);
    for (int i = 0; i < 4; ++i) {
      const Channel* pixel = row + 4 * std::clamp(x0 + i - 1, 0, s.width - 1);
      const float weight = wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)];
      for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * static_cast<float>(pixel[c]);
    }
  }
  for (std::size_t c = 0; c < 4; ++c) out[c] = as_channel<Channel>(sum[c]);
}

/// One pixel, covered or not.
template <typename Channel, WarpFilter Filter>
void sample(const WarpSource<Channel>& s, float x, float y, Channel* out) {
  if (!is_covered(s, x, y)) {
    std::copy(s.border.begin(), s.border.end(), out);
  } else if constexpr (Filter == WarpFilter::bilinear) {
    blend(Neighbours<Channel>(s, x, y), out);
  } else {
    sample_bicubic(s, x, y, out);
  }
}

/// The first `count` positions of a run, into a row of the target.
template <typename Channel, WarpFilter Filter>
void sample_run(const WarpSource<Channel>& s, const WarpRun& run, const WarpRow<Channel>& row) {
  for (int i = 0; i < row.count; ++i) {
    sample<Channel, Filter>(s, run.x[i], run.y[i], row.pixels + 4 * static_cast<std::ptrdiff_t>(i));
  }
}

/// Positions of red, green and blue.
struct ColorRuns {
  WarpRun of[3];
};

/// What is not covered in every colour becomes a NaN in all.
template <typename Channel>
void cover_together(const WarpSource<Channel>& s, ColorRuns& runs, int count) {
  auto& [red, green, blue] = runs.of;
  for (int i = 0; i < count; ++i) {
    const bool covered = is_covered(s, red.x[i], red.y[i]) && is_covered(s, green.x[i], green.y[i]) &&
                         is_covered(s, blue.x[i], blue.y[i]);
    if (covered) continue;
    red.x[i] = green.x[i] = blue.x[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace detail
}  // namespace holdfast
