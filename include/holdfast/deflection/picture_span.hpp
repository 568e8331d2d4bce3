/// A view of a picture in someone else's memory: RGBA, four channels a pixel, 8 bits or float each.
///
/// Rows from the bottom up, as everywhere here: pixels, origin at the lower left, the centre of pixel (0, 0) at (0.5,
/// 0.5). `stride` is the distance between the starts of neighbouring rows, counted in channels; it may exceed 4 * width
/// (a part of a larger picture). Values are numbers: no colour conversion is done anywhere. A span owns nothing and is
/// as cheap to pass as a pointer. A `PictureSpan<T>` becomes a `PictureSpan<const T>` by itself. Bad input: problem_of
/// names it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <type_traits>

namespace holdfast {

template <typename Channel>
struct PictureSpan {
  using Value = std::remove_const_t<Channel>;
  static_assert(std::is_same_v<Value, std::uint8_t> || std::is_same_v<Value, float>, "channels are 8 bits or float");

  Channel* data = nullptr;    ///< the red channel of the pixel at the lower left
  int width = 0;              ///< pixels
  int height = 0;             ///< rows
  std::ptrdiff_t stride = 0;  ///< channels from a row to the one above it, at least 4 * width

  PictureSpan() = default;
  PictureSpan(Channel* channels, int columns, int rows)
      : data(channels), width(columns), height(rows), stride(4 * static_cast<std::ptrdiff_t>(columns)) {}
  PictureSpan(Channel* channels, int columns, int rows, std::ptrdiff_t channels_per_row)
      : data(channels), width(columns), height(rows), stride(channels_per_row) {}
  /// From writable to read-only.
  template <typename Other>
  requires(std::is_same_v<const Other, Channel> && !std::is_same_v<Other, Channel>)
      PictureSpan(const PictureSpan<Other>& other)
      : data(other.data), width(other.width), height(other.height), stride(other.stride) {}

  [[nodiscard]] Channel* row(int y) const { return data + stride * y; }
  [[nodiscard]] Channel* pixel(int x, int y) const { return row(y) + 4 * static_cast<std::ptrdiff_t>(x); }
  /// One past the last channel of the top row.
  [[nodiscard]] Channel* end() const { return row(height - 1) + 4 * static_cast<std::ptrdiff_t>(width); }
};

enum class PictureProblem {
  none,
  null,       ///< no memory
  empty,      ///< a side is zero or negative
  stride,     ///< rows overlap: the stride is below four times the width
  too_large,  ///< a side above 32768 pixels, or 2^31 bytes and more: beyond the warp's numbers
};

template <typename Channel>
[[nodiscard]] PictureProblem problem_of(const PictureSpan<Channel>& picture) {
  if (picture.data == nullptr) return PictureProblem::null;
  if (picture.width <= 0 || picture.height <= 0) return PictureProblem::empty;
  if (picture.stride < 4 * static_cast<std::ptrdiff_t>(picture.width)) return PictureProblem::stride;
  constexpr std::ptrdiff_t most_channels = (std::ptrdiff_t{1} << 31) / static_cast<std::ptrdiff_t>(sizeof(Channel));
  constexpr int most_pixels = 32768;
  if (picture.width > most_pixels || picture.height > most_pixels || picture.stride >= most_channels / picture.height) {
    return PictureProblem::too_large;
  }
  return PictureProblem::none;
}

/// Whether two sound pictures lie in common memory. Two parts of one larger picture may, even though no pixel is
/// shared.
template <typename A, typename B>
[[nodiscard]] bool overlap(const PictureSpan<A>& a, const PictureSpan<B>& b) {
  const std::less<const void*> before;  // a total order, also between different arrays
  return before(a.data, b.end()) && before(b.data, a.end());
}

}  // namespace holdfast
