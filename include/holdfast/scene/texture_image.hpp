/// Reads a texture's picture, whatever it is coded as: PNG, JPEG or TGA, told apart by content, not by name.
///
/// Errors: io::InputError naming the picture.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <holdfast/io/png.hpp>
#include <holdfast/scene/jpeg.hpp>
#include <holdfast/scene/tga.hpp>

namespace holdfast::scene {

[[nodiscard]] inline io::Image decode_texture(std::span<const std::uint8_t> bytes, const std::string& source) {
  constexpr std::array<std::uint8_t, 4> png{0x89, 'P', 'N', 'G'};
  if (bytes.size() >= 4 && std::memcmp(bytes.data(), png.data(), 4) == 0) return io::decode_png(bytes, source);
  if (bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff) return decode_jpeg(bytes, source);
  if (looks_like_tga(bytes)) return decode_tga(bytes, source);
  throw io::InputError({.file = source, .problem = "unknown picture format", .expected = "PNG, JPEG or TGA"});
}

[[nodiscard]] inline io::Image read_texture(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw io::InputError({.file = path.string(), .problem = "cannot open the texture"});
  const std::vector<char> text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return decode_texture({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, path.string());
}

}  // namespace holdfast::scene
