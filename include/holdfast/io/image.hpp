/// A picture in memory: 8-bit RGBA, rows from the bottom up, as OpenGL reads it back and as screen space is counted
/// here (pixels, origin at the lower left, the centre of pixel (0, 0) at (0.5, 0.5)).
///
/// Values are the numbers the renderer wrote: no colour conversion is done anywhere, so 128 beside 255 means half
/// covered. This header needs nothing but the standard library; reading and writing PNG is io/png.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/assert.hpp>

namespace holdfast::io {

using Rgba = std::array<std::uint8_t, 4>;

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< 4 * width * height bytes; row 0 is the BOTTOM row

  Image() = default;
  Image(int columns, int rows, Rgba colour = {0, 0, 0, 255}) : width(columns), height(rows) {
    HOLDFAST_ASSERT(columns >= 0 && rows >= 0, "an image has no negative size");
    rgba.resize(4 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = colour[i % 4];
  }

  [[nodiscard]] bool empty() const { return rgba.empty(); }

  /// Index of the red byte of the pixel in column x, row y (0 = bottom).
  [[nodiscard]] std::size_t offset(int x, int y) const {
    HOLDFAST_ASSERT(x >= 0 && x < width && y >= 0 && y < height, "pixel outside the image");
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  [[nodiscard]] Rgba at(int x, int y) const {
    const std::size_t i = offset(x, y);
    return {rgba[i], rgba[i + 1], rgba[i + 2], rgba[i + 3]};
  }
  void set(int x, int y, Rgba colour) {
    const std::size_t i = offset(x, y);
    for (std::size_t c = 0; c < 4; ++c) rgba[i + c] = colour[c];
  }

  friend bool operator==(const Image&, const Image&) = default;
};

}  // namespace holdfast::io
