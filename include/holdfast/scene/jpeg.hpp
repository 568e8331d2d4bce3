/// Decodes a JPEG held in memory, by libjpeg: for the textures of models.
///
/// Errors: io::InputError naming the picture and what libjpeg said.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
// libjpeg's header uses FILE and size_t without including them.
#include <csetjmp>
#include <span>
#include <string>
#include <vector>

#include <jpeglib.h>

#include <holdfast/io/image.hpp>
#include <holdfast/io/input_error.hpp>

namespace holdfast::scene {
namespace detail {

/// libjpeg reports a fatal error by a call that must not return: it jumps back to where decoding began.
struct JpegFailure {
  jpeg_error_mgr manager{};  // first, so that libjpeg's pointer to it is ours too
  std::jmp_buf back;
  char message[JMSG_LENGTH_MAX] = {};
};

/// Rows from the top down, 3 bytes a pixel, into `pixels`; false with a message when the data are bad. No object with a
/// destructor lives across the jump.
[[nodiscard]] inline bool decode_jpeg_rows(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& pixels,
                                           int& width, int& height, JpegFailure& failure) {
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&failure.manager);
  failure.manager.error_exit = [](j_common_ptr info) {
    auto* where = reinterpret_cast<JpegFailure*>(info->err);
    info->err->format_message(info, where->message);
    std::longjmp(where->back, 1);
  };
  failure.manager.emit_message = [](j_common_ptr, int) {};  // warnings: the picture is still usable
  if (setjmp(failure.back) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, bytes.data(), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&jpeg);
  width = static_cast<int>(jpeg.output_width);
  height = static_cast<int>(jpeg.output_height);
  const std::size_t stride = 3 * static_cast<std::size_t>(jpeg.output_width);
  pixels.resize(stride * jpeg.output_height);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = pixels.data() + stride * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return true;
}

}  // namespace detail

[[nodiscard]] inline io::Image decode_jpeg(std::span<const std::uint8_t> bytes, const std::string& source) {
  std::vector<std::uint8_t> pixels;
  int width = 0, height = 0;
  detail::JpegFailure failure;
  if (!detail::decode_jpeg_rows(bytes, pixels, width, height, failure)) {
    throw io::InputError({.file = source, .problem = std::string("cannot decode the JPEG: ") + failure.message});
  }
  io::Image image(width, height);
  const std::uint8_t* from = pixels.data();
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x, from += 3) image.set(x, y, {from[0], from[1], from[2], 255});
  }
  return image;
}

}  // namespace holdfast::scene
