/// Compares two pictures: how far apart they are, and where.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <string>

#include <holdfast/io/image.hpp>

namespace holdfast::rendering {

struct ImageDifference {
  bool same_size = false;  ///< if not, what follows says nothing
  int max = 0;             ///< largest difference of a channel, 0 to 255
  double mean = 0.0;       ///< mean difference of all channels
  int x = 0, y = 0;        ///< pixel of the largest difference (row 0 = bottom); the first when there are several
  int channel = 0;         ///< 0 red, 1 green, 2 blue, 3 alpha
  int a = 0, b = 0;        ///< the two values there
  std::size_t differing_pixels = 0;

  [[nodiscard]] bool within(int tolerance) const { return same_size && max <= tolerance; }
};

[[nodiscard]] inline ImageDifference compare(const io::Image& a, const io::Image& b) {
  ImageDifference result;
  result.same_size = a.width == b.width && a.height == b.height && a.rgba.size() == b.rgba.size();
  if (!result.same_size) return result;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    bool differs = false;
    for (std::size_t c = 0; c < 4; ++c) {
      const int d = std::abs(int{a.rgba[i + c]} - int{b.rgba[i + c]});
      sum += d;
      differs = differs || d > 0;
      if (d <= result.max) continue;
      const auto pixel = static_cast<int>(i / 4);
      result.max = d;
      result.x = pixel % a.width;
      result.y = pixel / a.width;
      result.channel = static_cast<int>(c);
      result.a = a.rgba[i + c];
      result.b = b.rgba[i + c];
    }
    if (differs) ++result.differing_pixels;
  }
  if (!a.rgba.empty()) result.mean = sum / static_cast<double>(a.rgba.size());
  return result;
}

/// In words, for a test's message: "max difference 3 at pixel (12, 7) green: 128 against 131; mean 0.01; 5 pixels
/// differ".
[[nodiscard]] inline std::string describe(const ImageDifference& d) {
  if (!d.same_size) return "the pictures differ in size";
  if (d.max == 0) return "the pictures are identical";
  static constexpr const char* names[] = {"red", "green", "blue", "alpha"};
  return "max difference " + std::to_string(d.max) + " at pixel (" + std::to_string(d.x) + ", " + std::to_string(d.y) +
         ") " + names[d.channel] + ": " + std::to_string(d.a) + " against " + std::to_string(d.b) + "; mean " +
         std::to_string(d.mean) + "; " + std::to_string(d.differing_pixels) + " pixels differ";
}

}  // namespace holdfast::rendering
