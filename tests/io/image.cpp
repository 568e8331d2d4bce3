#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/image.hpp>
#include <holdfast/io/png.hpp>

using namespace holdfast::io;

namespace {

std::filesystem::path scratch(const std::string& name) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "holdfast_test_io_image";
  std::filesystem::create_directories(folder);
  return folder / name;
}

Image random_image(int width, int height) {
  std::mt19937 random(7);
  Image image(width, height);
  for (auto& byte : image.rgba) byte = static_cast<std::uint8_t>(random() & 0xff);
  return image;
}

}  // namespace

TEST_CASE("a picture survives PNG bit for bit, alpha too when asked") {
  const Image image = random_image(37, 21);
  write_png(scratch("alpha.png"), image, true);
  CHECK(read_png(scratch("alpha.png")) == image);

  Image opaque = image;
  for (std::size_t i = 3; i < opaque.rgba.size(); i += 4) opaque.rgba[i] = 255;
  write_png(scratch("opaque.png"), image);
  CHECK(read_png(scratch("opaque.png")) == opaque);
  CHECK(decode_png(encode_png(image, true), "memory") == image);
}

TEST_CASE("the file's first row is the picture's top row") {
  Image image(1, 2, {0, 0, 0, 255});
  image.set(0, 1, {255, 0, 0, 255});  // top
  const std::vector<std::uint8_t> bytes = encode_png(image);
  // libpng itself, reading top row first
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) != 0);
  png.format = PNG_FORMAT_RGBA;
  std::array<std::uint8_t, 8> rows{};
  REQUIRE(png_image_finish_read(&png, nullptr, rows.data(), 4, nullptr) != 0);
  CHECK(rows[0] == 255);
  CHECK(rows[4] == 0);
}

TEST_CASE("writing replaces a file whole and leaves no temporary behind") {
  const auto path = scratch("replaced.png");
  write_png(path, Image(4, 4));
  write_png(path, Image(2, 2, {255, 255, 255, 255}));
  CHECK(read_png(path) == Image(2, 2, {255, 255, 255, 255}));
  CHECK(!std::filesystem::exists(path.string() + ".part"));
}

TEST_CASE("bad files and places are named") {
  const auto text = scratch("text.png");
  std::ofstream(text) << "not a picture";
  CHECK_THROWS_WITH_AS(static_cast<void>(read_png(text)), doctest::Contains("text.png"), InputError);
  CHECK_THROWS_WITH_AS(static_cast<void>(read_png(scratch("absent.png"))), doctest::Contains("absent.png"), InputError);
  CHECK_THROWS_WITH_AS(write_png(scratch("no_such_folder/a.png"), Image(1, 1)), doctest::Contains("no_such_folder"),
                       InputError);
  CHECK_THROWS_AS(write_png(scratch("empty.png"), Image()), InputError);
  CHECK(!std::filesystem::exists(scratch("empty.png")));

  const auto cut = scratch("cut.png");
  write_png(cut, random_image(64, 64));
  std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
  CHECK_THROWS_WITH_AS(static_cast<void>(read_png(cut)), doctest::Contains("cut.png"), InputError);
}

TEST_CASE("a failed write keeps the old picture") {
  const auto folder = scratch("a_folder.png");  // the target is a folder: the rename fails
  std::filesystem::create_directories(folder);
  CHECK_THROWS_AS(write_png(folder, Image(1, 1)), InputError);
  CHECK(std::filesystem::is_directory(folder));
  CHECK(!std::filesystem::exists(folder.string() + ".part"));
}
