/// Shared by the tests of the warp passes: eyes, source pictures with their views, and the definition as a picture.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/cpu_warp.hpp>
#include <holdfast/deflection/deflect.hpp>
#include <holdfast/rendering/late_warp_pass.hpp>

#include "pictures.hpp"

namespace warps {

using namespace holdfast;
using namespace holdfast::rendering;

/// The eye that a source picture is drawn for: no lens, its own field and size.
[[nodiscard]] inline EyeModel source_eye(const EyeModel& eye, double wider = 1.0, PixelSize size = {}) {
  EyeModel source = eye;
  source.lens = Lens();
  source.lens_red.reset();
  source.lens_blue.reset();
  source.upside_down = false;
  FieldTangents& t = source.tangents;
  t = {t.left * wider, t.right * wider, t.down * wider, t.up * wider};
  if (size.width > 0) source.resolution = size;
  return source;
}

[[nodiscard]] inline RenderedView view_of(const EyeModel& source, const Rigid& X_WS) {
  return {X_WS, source.tangents, source.resolution, HostTime{}};
}

/// A lens that bends red less and blue more, as glass does.
[[nodiscard]] inline EyeModel with_chromatic_lens(EyeModel eye) {
  const double k = 0.1933;
  eye.lens_red = Lens(RadialLens{k * 0.95}, eye.lens.placement());
  eye.lens_blue = Lens(RadialLens{k * 1.05}, eye.lens.placement());
  return eye;
}

/// Bilinear, clamped to the edge, as a texture is read.
[[nodiscard]] inline double look_up(const io::Image& image, const Vector2& pixel, int channel) {
  const double x = std::clamp(pixel.x() - 0.5, 0.0, image.width - 1.0);
  const double y = std::clamp(pixel.y() - 0.5, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.width - 2)), x1 = std::min(x0 + 1, image.width - 1);
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.height - 2)), y1 = std::min(y0 + 1, image.height - 1);
  const auto at = [&](int i, int j) {
    return static_cast<double>(image.rgba[image.offset(i, j) + static_cast<std::size_t>(channel)]);
  };
  const double fx = x - x0, fy = y - y0;
  return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x1, y0)) + fy * ((1 - fx) * at(x0, y1) + fx * at(x1, y1));
}

/// Differences of a warped picture to a definition place(pixel, color) -> optional source pixel.
struct Disagreement {
  double rms = 0.0;          ///< of colour channels, in steps of 8 bits, where both are covered
  double mask_pct = 0.0;     ///< of pixels where one is covered and the other is not
  double covered_pct = 0.0;  ///< by the definition
};

template <typename Place>
[[nodiscard]] Disagreement disagreement(const io::Image& warped, const io::Image& source, const Place& place) {
  Disagreement d;
  double squares = 0.0, channels = 0.0, pixels = 0.0;
  for (int y = 0; y < warped.height; ++y) {
    for (int x = 0; x < warped.width; ++x, pixels += 1.0) {
      std::optional<Vector2> from[3];
      bool covered = true;
      for (int c = 0; c < 3; ++c) {
        from[c] = place(Vector2(x + 0.5, y + 0.5), static_cast<Color>(c));
        covered = covered && from[c] && from[c]->minCoeff() >= 0.0 && from[c]->x() <= source.width &&
                  from[c]->y() <= source.height;
      }
      const io::Rgba shown = warped.at(x, y);
      d.covered_pct += covered ? 1.0 : 0.0;
      if (covered != (shown[3] == 255)) d.mask_pct += 1.0;
      if (!covered || shown[3] != 255) continue;
      for (std::size_t c = 0; c < 3; ++c, channels += 1.0)
        squares += std::pow(shown[c] - look_up(source, *from[c], static_cast<int>(c)), 2);
    }
  }
  d.rms = std::sqrt(squares / std::max(1.0, channels));
  d.mask_pct *= 100.0 / pixels;
  d.covered_pct *= 100.0 / pixels;
  return d;
}

/// The same warp by CpuWarp, or, as seen, by the definition pixel for pixel.
[[nodiscard]] inline io::Image warped_on_cpu(const ComposedWarp& warp, const io::Image& source, bool seen) {
  const PixelSize size = warp.eye().resolution;
  io::Image warped(size.width, size.height, {0, 0, 0, 0});
  if (!seen) {
    CpuWarp cpu({.threads = 1});
    const WarpLattice lattice(warp.eye(), warp.mode());
    const auto problem = cpu.draw(lattice, warp, PictureSpan(source.rgba.data(), source.width, source.height),
                                  PictureSpan(warped.rgba.data(), size.width, size.height));
    REQUIRE(problem == CpuWarpProblem::none);
    return warped;
  }
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      io::Rgba shown{0, 0, 0, 255};
      for (std::size_t c = 0; c < 3; ++c) {
        const SourceSample from = warp.sample_seen(Vector2(x + 0.5, y + 0.5), static_cast<Color>(c));
        if (from.state != SourceState::covered) shown[3] = 0;
        if (from.state == SourceState::covered)
          shown[c] = static_cast<std::uint8_t>(std::lround(look_up(source, from.pixel, static_cast<int>(c))));
      }
      warped.set(x, y, shown);
    }
  }
  return warped;
}

/// Of two warped pictures: the colours' RMS difference where both are covered, and where only one is.
struct Likeness {
  double rms = 0.0;
  double mask_pct = 0.0;
};

[[nodiscard]] inline Likeness compare_covered(const io::Image& a, const io::Image& b) {
  Likeness result;
  double squares = 0.0, channels = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    if (a.rgba[i + 3] != b.rgba[i + 3]) result.mask_pct += 1.0;
    if (a.rgba[i + 3] != 255 || b.rgba[i + 3] != 255) continue;
    for (std::size_t c = 0; c < 3; ++c, channels += 1.0) squares += std::pow(a.rgba[i + c] - b.rgba[i + c], 2);
  }
  result.rms = std::sqrt(squares / std::max(1.0, channels));
  result.mask_pct *= 400.0 / static_cast<double>(a.rgba.size());
  return result;
}

/// RMS distance (px) of the discs' centroids in two pictures.
struct CentroidRms {
  double px = 0.0;
  int discs = 0;
};

/// Measured alike in both, near where map(pixel) takes the disc's pixel of the picture that `source` draws at X_WS.
/// Discs that are not wholly inside, or not alone, are left out.
template <typename Map>
[[nodiscard]] CentroidRms centroid_rms(const io::Image& a, const io::Image& b, const EyeModel& source,
                                       const Rigid& X_WS, const RegistrationScene& scene, const Map& map) {
  struct Spot {
    Vector2 expected, half_extent;
  };
  std::vector<Spot> spots;
  for (const Disc& disc : scene.discs) {
    const auto e = project_disc(source, X_WS, disc);
    const auto expected = e && e->is_inside(source.resolution, 3.0) ? centroid_through(*e, map) : std::nullopt;
    if (expected) spots.push_back({*expected, 1.25 * e->half_extent_px});
  }
  CentroidRms result;
  for (const Spot& spot : spots) {
    const auto crowds = [&](const Spot& other) {
      const Vector2 gap = (spot.expected - other.expected).cwiseAbs() - spot.half_extent - other.half_extent;
      return &spot != &other && gap.maxCoeff() < 6.0;
    };
    if (std::any_of(spots.begin(), spots.end(), crowds)) continue;
    const PixelWindow window = window_around(spot.expected, spot.half_extent);
    const auto in_a = picture_centroid(pictures::look_at(a), window),
               in_b = picture_centroid(pictures::look_at(b), window);
    if (!in_a || !in_b) continue;
    result.px += (in_a->centroid - in_b->centroid).squaredNorm();
    ++result.discs;
  }
  result.px = std::sqrt(result.px / std::max(1, result.discs));
  return result;
}

}  // namespace warps
