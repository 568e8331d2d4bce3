/// PNG in and out, by libpng's simplified interface.
///
/// A failure of write_png leaves what was there before (whole_file.hpp). Files hold rows from the top down; io::Image
/// from the bottom up: turned here, nowhere else. Errors: InputError naming the file and what libpng or the system
/// said.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <png.h>

#include <holdfast/io/image.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/whole_file.hpp>

namespace holdfast::io {
namespace detail {

[[nodiscard]] inline InputError image_error(const std::string& file, const std::string& problem) {
  return InputError({.file = file, .problem = problem});
}

/// Frees what libpng holds, however the scope is left.
struct PngImage {
  png_image header{};
  PngImage() { header.version = PNG_IMAGE_VERSION; }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
  ~PngImage() { png_image_free(&header); }
};

/// After png_image_begin_read_*: the pixels as RGBA, bottom row first.
[[nodiscard]] inline Image finish_png_read(PngImage& png, const std::string& source) {
  constexpr png_uint_32 largest = 1u << 15;  // 32768 pixels a side: more is a damaged or hostile file
  if (png.header.width > largest || png.header.height > largest)
    throw detail::image_error(source, "PNG of " + std::to_string(png.header.width) + " x " +
                                          std::to_string(png.header.height) + " pixels; expected at most 32768 a side");
  png.header.format = PNG_FORMAT_RGBA;
  Image image(static_cast<int>(png.header.width), static_cast<int>(png.header.height));
  // A negative stride: libpng's first row goes to the end of the buffer.
  const auto stride = -static_cast<png_int_32>(PNG_IMAGE_ROW_STRIDE(png.header));
  if (png_image_finish_read(&png.header, nullptr, image.rgba.data(), stride, nullptr) == 0)
    throw detail::image_error(source, std::string("cannot decode the PNG: ") + png.header.message);
  return image;
}

}  // namespace detail

/// Decodes a PNG held in memory; `source` names it in errors.
[[nodiscard]] inline Image decode_png(std::span<const std::uint8_t> bytes, const std::string& source) {
  detail::PngImage png;
  if (png_image_begin_read_from_memory(&png.header, bytes.data(), bytes.size()) == 0)
    throw detail::image_error(source, std::string("not a PNG: ") + png.header.message);
  return detail::finish_png_read(png, source);
}

[[nodiscard]] inline Image read_png(const std::filesystem::path& path) {
  detail::PngImage png;
  if (png_image_begin_read_from_file(&png.header, path.c_str()) == 0)
    throw detail::image_error(path.string(), std::string("cannot read the PNG: ") + png.header.message);
  return detail::finish_png_read(png, path.string());
}

/// The picture as the bytes of a PNG file (to embed in a report).
[[nodiscard]] inline std::vector<std::uint8_t> encode_png(const Image& image, bool with_alpha = false) {
  if (image.empty()) throw detail::image_error("PNG in memory", "the picture is empty; expected at least one pixel");
  detail::PngImage png;
  png.header.width = static_cast<png_uint_32>(image.width);
  png.header.height = static_cast<png_uint_32>(image.height);
  png.header.format = with_alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  // Rows are turned, and alpha is dropped unless wanted: a viewer would show a half-covered pixel as half transparent.
  const std::size_t channels = with_alpha ? 4 : 3;
  const std::size_t width = static_cast<std::size_t>(image.width);
  const std::size_t height = static_cast<std::size_t>(image.height);
  std::vector<std::uint8_t> pixels(channels * width * height);
  std::size_t to = 0;
  for (std::size_t y = height; y-- > 0;)
    for (std::size_t x = 0; x < width; ++x)
      for (std::size_t c = 0; c < channels; ++c) pixels[to++] = image.rgba[4 * (y * width + x) + c];
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png.header);
  std::vector<std::uint8_t> bytes(size);
  if (png_image_write_to_memory(&png.header, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    throw detail::image_error("PNG in memory", std::string("cannot encode: ") + png.header.message);
  bytes.resize(size);
  return bytes;
}

/// Writes the picture, replacing `path` at once or not at all.
inline void write_png(const std::filesystem::path& path, const Image& image, bool with_alpha = false) {
  if (image.empty()) throw detail::image_error(path.string(), "the picture is empty; expected at least one pixel");
  const std::vector<std::uint8_t> bytes = encode_png(image, with_alpha);
  write_whole_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace holdfast::io
