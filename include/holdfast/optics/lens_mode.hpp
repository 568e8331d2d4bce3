/// What an application does about the lens, and what the eye then sees.
///
/// An application draws an ideal picture and corrects it for the lens in one of four ways. seen_tangent says where the
/// eye then sees the ideal point; ideal_tangent, its inverse, which ideal point the eye sees in a direction. Source:
/// Robinett & Holloway 1994 (course 11), 7.9. Bad input: a point outside the lens's domain is answered with nothing.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens.hpp>

namespace holdfast {

/// How an application deals with the lens.
enum class LensMode {
  none,         ///< no lens is there, whatever the descriptor says
  exact,        ///< the picture is predistorted with the lens's exact inverse
  cubic,        ///< the picture is predistorted with the paper's cubic r + k_pd r^3
  uncorrected,  ///< the lens is there and the application ignores it
};

[[nodiscard]] constexpr std::string_view name_of(LensMode mode) {
  constexpr std::string_view names[] = {"none", "exact", "cubic", "uncorrected"};
  return names[static_cast<std::size_t>(mode)];
}

/// The panel tangent at which the application draws the ideal point.
[[nodiscard]] inline std::optional<Vector2> drawn_tangent(const Lens& lens, LensMode mode, const Vector2& ideal) {
  switch (mode) {
    case LensMode::exact:
      return lens.undistort(ideal);
    case LensMode::cubic:
      return lens.cubic_inverse().distort(ideal);
    case LensMode::none:
    case LensMode::uncorrected:
      break;
  }
  return ideal;
}

/// Where the eye sees the ideal point: drawn by the application, then distorted by the lens.
[[nodiscard]] inline std::optional<Vector2> seen_tangent(const Lens& lens, LensMode mode, const Vector2& ideal) {
  if (mode == LensMode::none) return ideal;
  const std::optional<Vector2> drawn = drawn_tangent(lens, mode, ideal);
  return drawn ? lens.distort(*drawn) : std::nullopt;
}

/// The ideal point that a panel tangent shows: the inverse of drawn_tangent, which a warp looks up for each panel
/// pixel.
[[nodiscard]] inline std::optional<Vector2> ideal_tangent_at_panel(const Lens& lens, LensMode mode,
                                                                   const Vector2& panel) {
  switch (mode) {
    case LensMode::exact:
      return lens.distort(panel);
    case LensMode::cubic:
      return lens.cubic_inverse().undistort(panel);
    case LensMode::none:
    case LensMode::uncorrected:
      break;
  }
  return panel;
}

/// The ideal point that the eye sees at tangent `seen`: the inverse of seen_tangent.
[[nodiscard]] inline std::optional<Vector2> ideal_tangent(const Lens& lens, LensMode mode, const Vector2& seen) {
  if (mode == LensMode::none) return seen;
  const std::optional<Vector2> panel = lens.undistort(seen);
  return panel ? ideal_tangent_at_panel(lens, mode, *panel) : std::nullopt;
}

}  // namespace holdfast
