/// Pictures made of two pictures: virtual over real as a see-through display shows it, and their difference. On the
/// CPU; both pictures must have one size, and `result` keeps its memory when it fits.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include <holdfast/assert.hpp>
#include <holdfast/io/image.hpp>

namespace holdfast::rendering {

namespace detail {

template <typename Combine>
void combine(const io::Image& a, const io::Image& b, io::Image& result, Combine&& channel) {
  HOLDFAST_ASSERT(a.width == b.width && a.height == b.height, "pictures of different size");
  result.width = a.width;
  result.height = a.height;
  result.rgba.resize(a.rgba.size());
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    result.rgba[i] = static_cast<std::uint8_t>(channel(int{a.rgba[i]}, int{b.rgba[i]}));
  for (std::size_t i = 3; i < result.rgba.size(); i += 4) result.rgba[i] = 255;
}

}  // namespace detail

/// Optical see-through: the display can only add light. Each channel is min(real + virtual, 255).
inline void overlay(const io::Image& real_picture, const io::Image& virtual_picture, io::Image& result) {
  detail::combine(real_picture, virtual_picture, result, [](int r, int v) { return std::min(r + v, 255); });
}
[[nodiscard]] inline io::Image overlay(const io::Image& real_picture, const io::Image& virtual_picture) {
  io::Image result;
  overlay(real_picture, virtual_picture, result);
  return result;
}

/// |a - b| per channel: black where the pictures agree.
inline void difference(const io::Image& a, const io::Image& b, io::Image& result) {
  detail::combine(a, b, result, [](int x, int y) { return std::abs(x - y); });
}
[[nodiscard]] inline io::Image difference(const io::Image& a, const io::Image& b) {
  io::Image result;
  difference(a, b, result);
  return result;
}

}  // namespace holdfast::rendering
