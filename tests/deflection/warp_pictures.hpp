// Pictures, eyes and a slow reference in double precision for the tests of the CPU warp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <type_traits>
#include <vector>

#include <holdfast/deflection/cpu_warp.hpp>

#include "deflection/setups.hpp"

namespace holdfast::test {

template <typename Channel>
struct Picture {
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;
  std::vector<Channel> channels;

  Picture(int columns, int rows, int padding = 0)
      : width(columns),
        height(rows),
        stride(4 * columns + padding),
        channels(static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows)) {}

  [[nodiscard]] PictureSpan<Channel> span() { return {channels.data(), width, height, stride}; }
  [[nodiscard]] PictureSpan<const Channel> span() const { return {channels.data(), width, height, stride}; }
  [[nodiscard]] Channel at(int x, int y, int c) const {
    return channels[static_cast<std::size_t>(stride * y + 4 * x + c)];
  }
  // f(x, y, channel), x and y being the pixel's centre
  template <typename F>
  void fill(const F& f) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 4; ++c) {
          channels[static_cast<std::size_t>(stride * y + 4 * x + c)] = static_cast<Channel>(f(x + 0.5, y + 0.5, c));
        }
      }
    }
  }
};

// Noise: neighbours differ by up to the whole range, the hardest for a warp. `opaque`: alpha is full.
template <typename Channel>
Picture<Channel> noise(int width, int height, unsigned seed, bool opaque = false, int padding = 0) {
  Picture<Channel> picture(width, height, padding);
  std::mt19937 engine(seed);
  const double full = std::is_same_v<Channel, float> ? 1.0 : 255.0;
  const auto value = [&] {
    const auto byte = static_cast<double>(engine() & 255U);
    return std::is_same_v<Channel, float> ? byte / 255.0 : byte;
  };
  picture.fill([&](double, double, int c) { return opaque && c == 3 ? full : value(); });
  return picture;
}

// An eye without a lens whose panel has this many pixels of 1/1000 tangent.
inline EyeModel plain_eye(int width, int height) {
  EyeModel eye;
  eye.tangents = {-0.0005 * width, 0.0005 * width, -0.0004 * height, 0.0006 * height};
  eye.resolution = {width, height};
  return eye;
}

// A random eye of setups.hpp with a panel so small that the slow reference is quick.
inline EyeModel small_eye(Random& random) {
  EyeModel eye = random.eye();
  eye.resolution = {30 + random.index(200), 20 + random.index(150)};
  return eye;
}

// Neighbours and weights of one axis in double precision.
struct Taps {
  std::array<int, 4> at{};
  std::array<double, 4> weight{};
};

inline Taps taps(double texel, int size, WarpFilter filter) {
  const double base = std::floor(texel);
  const double f = texel - base;
  Taps t;
  for (int i = 0; i < 4; ++i) {
    t.at[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(base) + i - 1, 0, size - 1);
  }
  t.weight = {0.0, 1.0 - f, f, 0.0};
  if (filter == WarpFilter::bicubic) {
    // Catmull & Rom 1974 with tension 1/2, as the matrix of its textbook form.
    t.weight = {0.5 * (-f + 2 * f * f - f * f * f), 0.5 * (2 - 5 * f * f + 3 * f * f * f),
                0.5 * (f + 4 * f * f - 3 * f * f * f), 0.5 * (-f * f + f * f * f)};
  }
  return t;
}

template <typename Channel>
double sample_slowly(const Picture<Channel>& source, const Vector2& pixel, int c, WarpFilter filter) {
  const Taps tx = taps(pixel.x() - 0.5, source.width, filter);
  const Taps ty = taps(pixel.y() - 0.5, source.height, filter);
  double sum = 0.0;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      sum += tx.weight[i] * ty.weight[j] * static_cast<double>(source.at(tx.at[i], ty.at[j], c));
    }
  }
  return std::is_same_v<Channel, float> ? sum : std::clamp(sum, 0.0, 255.0);
}

// What the warp must draw at a target pixel; nothing where it must draw the border. `sure` is false within 0.005 px of
// the picture's edge, where rounding decides what is covered.
struct Expected {
  std::optional<std::array<double, 4>> colour;
  bool sure = true;
};

template <typename Channel>
Expected expected_at(const ComposedWarp& warp, const Picture<Channel>& source, int x, int y, WarpFilter filter) {
  Expected expected;
  std::array<double, 4> colour{};
  bool covered = true;
  for (int c = 0; c < 3; ++c) {
    const auto pixel = warp.source_pixel(Vector2(x + 0.5, y + 0.5), static_cast<Color>(c));
    if (!pixel) {
      covered = false;
      continue;
    }
    const double inside = std::min({pixel->x(), pixel->y(), source.width - pixel->x(), source.height - pixel->y()});
    expected.sure = expected.sure && std::abs(inside) > 0.005;
    covered = covered && inside >= 0.0;
    if (!covered) continue;
    colour[static_cast<std::size_t>(c)] = sample_slowly(source, *pixel, c, filter);
    if (c == 1) colour[3] = sample_slowly(source, *pixel, 3, filter);
  }
  if (covered) expected.colour = colour;
  return expected;
}

}  // namespace holdfast::test
