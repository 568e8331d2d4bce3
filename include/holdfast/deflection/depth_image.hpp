/// The distances that a picture shows: what a depth deflection needs besides the picture.
///
/// One number a pixel: the distance along -Z_S in metres (not along the ray), infinite where nothing was drawn. Row 0
/// is the bottom row, as glReadPixels gives it. The image spans the same tangents as its picture, but may have another
/// size. From the depth buffer of any graphics interface by distances_of_depth_buffer. Bad input: problem_of names a
/// size that does not fit; single numbers that are no distance are taken for "nothing drawn" and counted (DepthSurface).
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/optics/projection.hpp>

namespace holdfast {

struct DepthImage {
  PixelSize size;
  std::vector<float> distance_m;  ///< along -Z_S; row by row from the bottom; infinite: nothing drawn

  [[nodiscard]] float at(int x, int y) const {
    return distance_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)];
  }
};

enum class DepthProblem {
  none,
  no_pixels,      ///< width or height is not positive
  size_mismatch,  ///< the number of distances is not width times height
  no_field,       ///< the view's tangents are not finite, or leave it no width or height
};

[[nodiscard]] constexpr std::string_view describe(DepthProblem problem) {
  switch (problem) {
    case DepthProblem::none:
      return "the depth image is usable";
    case DepthProblem::no_pixels:
      return "the depth image's width and height must be positive";
    case DepthProblem::size_mismatch:
      return "the depth image must hold width times height distances";
    case DepthProblem::no_field:
      return "the view's tangents are not finite, or leave it no width or no height";
  }
  return "unknown problem";
}

[[nodiscard]] inline DepthProblem problem_of(const DepthImage& depth) {
  if (depth.size.width <= 0 || depth.size.height <= 0) return DepthProblem::no_pixels;
  const std::size_t pixels = static_cast<std::size_t>(depth.size.width) * static_cast<std::size_t>(depth.size.height);
  return depth.distance_m.size() == pixels ? DepthProblem::none : DepthProblem::size_mismatch;
}

/// Distance along -Z of a value (0 to 1) of a depth buffer that was drawn with `projection` (any of projection_matrix,
/// with `range` the one it was made for); infinite for the value that the buffer is cleared to, and for what is no
/// depth.
[[nodiscard]] inline double distance_of_depth(float depth, const Matrix4& projection, DepthRange range) {
  constexpr double nothing = std::numeric_limits<double>::infinity();
  if (depth == (range == DepthRange::one_to_zero ? 0.0f : 1.0f)) return nothing;
  const double z_ndc = range == DepthRange::minus_one_to_one ? 2.0 * double(depth) - 1.0 : double(depth);
  const double distance = projection(2, 3) / (z_ndc + projection(2, 2));
  return distance > 0.0 ? distance : nothing;
}

/// Turns a whole depth buffer into distances, row by row as they come. Precondition: equal lengths.
inline void distances_of_depth_buffer(std::span<const float> buffer, const Matrix4& projection, DepthRange range,
                                      std::span<float> distance_m) {
  HOLDFAST_ASSERT(buffer.size() == distance_m.size(), "depth buffer and distances differ in length");
  for (std::size_t i = 0; i < buffer.size(); ++i) {
    distance_m[i] = static_cast<float>(distance_of_depth(buffer[i], projection, range));
  }
}

}  // namespace holdfast
