#include <cstdlib>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/scene/texture_image.hpp>

using namespace holdfast;
using namespace holdfast::scene;

namespace {

/// 2 x 2 pixels, bottom row red, green; top row blue, white (BGR order, from the bottom up).
std::vector<std::uint8_t> small_tga(bool coded) {
  std::vector<std::uint8_t> bytes(18, 0);
  bytes[2] = coded ? 10 : 2;
  bytes[12] = 2;
  bytes[14] = 2;
  bytes[16] = 24;
  const std::vector<std::uint8_t> pixels = {0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255};
  if (coded) bytes.push_back(3);  // four single pixels
  bytes.insert(bytes.end(), pixels.begin(), pixels.end());
  return bytes;
}

/// libjpeg's own encoder makes the picture that the decoder is given.
std::vector<std::uint8_t> encode_jpeg(int width, int height, io::Rgba bottom, io::Rgba top) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &memory, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {  // from the top
    const io::Rgba& c = y < height / 2 ? top : bottom;
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = c[i % 3];
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::vector<std::uint8_t> bytes(memory, memory + size);
  jpeg_destroy_compress(&jpeg);
  std::free(memory);
  return bytes;
}

}  // namespace

TEST_CASE("TGA, plain and run-length coded, bottom up and top down") {
  for (const bool coded : {false, true}) {
    std::vector<std::uint8_t> bytes = small_tga(coded);
    const io::Image image = decode_texture(bytes, "small.tga");
    CHECK(image.at(0, 0) == io::Rgba{255, 0, 0, 255});
    CHECK(image.at(1, 0) == io::Rgba{0, 255, 0, 255});
    CHECK(image.at(0, 1) == io::Rgba{0, 0, 255, 255});
    CHECK(image.at(1, 1) == io::Rgba{255, 255, 255, 255});
    bytes[17] |= 0x20;
    CHECK(decode_texture(bytes, "small.tga").at(0, 1) == io::Rgba{255, 0, 0, 255});
    bytes.pop_back();
    CHECK_THROWS_WITH_AS(static_cast<void>(decode_texture(bytes, "cut.tga")), doctest::Contains("cut.tga"),
                         io::InputError);
  }
  std::vector<std::uint8_t> run = small_tga(true);
  run.resize(18);
  for (const int byte : {0x83, 9, 8, 7}) run.push_back(static_cast<std::uint8_t>(byte));  // one pixel, four times
  CHECK(decode_texture(run, "run.tga") == io::Image(2, 2, {7, 8, 9, 255}));
}

TEST_CASE("JPEG keeps its place and colours; damage is an error that names the picture") {
  const std::vector<std::uint8_t> bytes = encode_jpeg(32, 16, {200, 30, 30, 255}, {30, 30, 200, 255});
  const io::Image image = decode_texture(bytes, "a.jpg");
  REQUIRE(image.width == 32);
  REQUIRE(image.height == 16);
  for (std::size_t c = 0; c < 3; ++c) {  // 95 % quality errs by a few levels
    CHECK(std::abs(image.at(5, 1)[c] - io::Rgba{200, 30, 30, 255}[c]) <= 6);
    CHECK(std::abs(image.at(5, 14)[c] - io::Rgba{30, 30, 200, 255}[c]) <= 6);
  }
  const std::vector<std::uint8_t> header_only(bytes.begin(), bytes.begin() + 30);
  CHECK_THROWS_WITH_AS(static_cast<void>(decode_texture(header_only, "cut.jpg")), doctest::Contains("cut.jpg"),
                       io::InputError);
}

TEST_CASE("PNG by its content; anything else is refused with what is read") {
  const io::Image image(3, 2, {5, 6, 7, 255});
  CHECK(decode_texture(io::encode_png(image), "a.dds") == image);
  const std::vector<std::uint8_t> other = {'D', 'D', 'S', ' ', 0, 0};
  CHECK_THROWS_WITH_AS(static_cast<void>(decode_texture(other, "a.dds")),
                       doctest::Contains("expected PNG, JPEG or TGA"), io::InputError);
  CHECK_THROWS_AS(static_cast<void>(decode_texture({}, "nothing")), io::InputError);
}
