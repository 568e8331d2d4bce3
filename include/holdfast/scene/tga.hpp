/// Decodes a Truevision TGA held in memory: true colour (24 or 32 bit) or grey (8 bit), plain or run-length coded.
///
/// Source: Truevision TGA File Format Specification 2.0. Errors: io::InputError naming the picture and what is wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <holdfast/io/image.hpp>
#include <holdfast/io/input_error.hpp>

namespace holdfast::scene {
namespace detail {

/// The header's 18 bytes, as far as they matter here.
struct TgaHeader {
  int kind = 0;  ///< 2 true colour, 3 grey; plus 8 when run-length coded
  int width = 0, height = 0, bits = 0;
  bool top_down = false;
  std::size_t pixels_at = 0;

  [[nodiscard]] bool is_known() const {
    const int plain = kind & ~8;
    return width > 0 && height > 0 && ((plain == 2 && (bits == 24 || bits == 32)) || (plain == 3 && bits == 8));
  }
};

[[nodiscard]] inline TgaHeader read_tga_header(std::span<const std::uint8_t> bytes) {
  TgaHeader h;
  if (bytes.size() < 18 || bytes[1] > 1) return h;
  h.kind = bytes[2];
  h.width = bytes[12] | (bytes[13] << 8);
  h.height = bytes[14] | (bytes[15] << 8);
  h.bits = bytes[16];
  h.top_down = (bytes[17] & 0x20) != 0;
  const std::size_t palette = static_cast<std::size_t>(bytes[5] | (bytes[6] << 8)) * ((bytes[7] + 7u) / 8u);
  h.pixels_at = 18u + bytes[0] + (bytes[1] == 1 ? palette : 0u);
  return h;
}

}  // namespace detail

[[nodiscard]] inline bool looks_like_tga(std::span<const std::uint8_t> bytes) {
  return detail::read_tga_header(bytes).is_known();
}

[[nodiscard]] inline io::Image decode_tga(std::span<const std::uint8_t> bytes, const std::string& source) {
  const detail::TgaHeader h = detail::read_tga_header(bytes);
  const auto fail = [&](const std::string& problem) {
    throw io::InputError({.file = source, .problem = "cannot decode the TGA: " + problem});
  };
  if (!h.is_known()) fail("only true colour with 24 or 32 bits and grey with 8 bits are read");
  const std::size_t size = static_cast<std::size_t>(h.bits) / 8;
  std::size_t at = h.pixels_at;
  const auto take_pixel = [&] {
    if (at + size > bytes.size()) fail("the file ends within the picture");
    io::Rgba c{bytes[at], bytes[at], bytes[at], 255};
    if (size >= 3) c = {bytes[at + 2], bytes[at + 1], bytes[at], size == 4 ? bytes[at + 3] : std::uint8_t{255}};
    at += size;
    return c;
  };
  io::Image image(h.width, h.height);
  const int count = h.width * h.height;
  for (int i = 0; i < count;) {
    int run = count;  // plain: one run of single pixels
    bool repeated = false;
    if ((h.kind & 8) != 0) {
      if (at >= bytes.size()) fail("the file ends within the picture");
      repeated = (bytes[at] & 0x80) != 0;
      run = (bytes[at++] & 0x7f) + 1;
    }
    io::Rgba colour{};
    for (int k = 0; k < run && i < count; ++k, ++i) {
      if (k == 0 || !repeated) colour = take_pixel();
      const int row = i / h.width;
      image.set(i % h.width, h.top_down ? h.height - 1 - row : row, colour);
    }
  }
  return image;
}

}  // namespace holdfast::scene
