/// The lenses an eye may have behind one interface, and what application and lens do together.
///
/// Every lens maps the tangent (of field angle) at which a point of the panel would be seen without a lens to the one
/// at which it is seen: seen = distort(panel). A LensModel also inverts that exactly, tells its Jacobian and where it
/// is one-to-one; a new model joins by satisfying the concept and entering the variant Lens. An application draws an
/// ideal picture and corrects it for the lens in one of four ways (LensMode). seen_tangent says where the eye then sees
/// the ideal point; ideal_tangent, its inverse, says which ideal point the eye sees in a direction. Source: Robinett &
/// Holloway 1994 (course 11), 7.9. Bad input: a point outside a lens's domain is answered with nothing.
#pragma once

#include <concepts>
#include <limits>
#include <optional>
#include <variant>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/radial_lens.hpp>

namespace holdfast {

template <typename L>
concept LensModel = requires(const L& lens, const Vector2& tangent) {
  { lens.distort(tangent) } -> std::same_as<std::optional<Vector2>>;
  { lens.undistort(tangent) } -> std::same_as<std::optional<Vector2>>;
  { lens.distort_jacobian(tangent) } -> std::same_as<Matrix2>;
  { lens.undistort_jacobian(tangent) } -> std::same_as<std::optional<Matrix2>>;
  { lens.valid_radius() } -> std::same_as<double>;
  { lens.valid_image_radius() } -> std::same_as<double>;
  { lens.cubic_inverse() } -> std::same_as<RadialLens>;
};

/// A display seen directly, or through optics without distortion.
struct NoLens {
  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const { return p; }
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const { return v; }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2&) const { return Matrix2::Identity(); }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2&) const { return Matrix2::Identity(); }
  [[nodiscard]] double valid_radius() const { return std::numeric_limits<double>::infinity(); }
  [[nodiscard]] double valid_image_radius() const { return std::numeric_limits<double>::infinity(); }
  [[nodiscard]] RadialLens cubic_inverse() const { return {}; }
};

static_assert(LensModel<NoLens> && LensModel<RadialLens> && LensModel<PolynomialLens>);

using Lens = std::variant<NoLens, RadialLens, PolynomialLens>;

/// Where the panel point of tangent `panel` is seen.
[[nodiscard]] inline std::optional<Vector2> distort(const Lens& lens, const Vector2& panel) {
  return std::visit([&](const auto& l) { return l.distort(panel); }, lens);
}
/// The panel point that is seen at tangent `seen`.
[[nodiscard]] inline std::optional<Vector2> undistort(const Lens& lens, const Vector2& seen) {
  return std::visit([&](const auto& l) { return l.undistort(seen); }, lens);
}
[[nodiscard]] inline Matrix2 distort_jacobian(const Lens& lens, const Vector2& panel) {
  return std::visit([&](const auto& l) { return l.distort_jacobian(panel); }, lens);
}
[[nodiscard]] inline std::optional<Matrix2> undistort_jacobian(const Lens& lens, const Vector2& seen) {
  return std::visit([&](const auto& l) { return l.undistort_jacobian(seen); }, lens);
}
[[nodiscard]] inline double valid_radius(const Lens& lens) {
  return std::visit([](const auto& l) { return l.valid_radius(); }, lens);
}
[[nodiscard]] inline double valid_image_radius(const Lens& lens) {
  return std::visit([](const auto& l) { return l.valid_image_radius(); }, lens);
}
[[nodiscard]] inline RadialLens cubic_inverse(const Lens& lens) {
  return std::visit([](const auto& l) { return l.cubic_inverse(); }, lens);
}

/// How an application deals with the lens.
enum class LensMode {
  none,         ///< no lens is there, whatever the descriptor says
  exact,        ///< the picture is predistorted with the lens's exact inverse
  cubic,        ///< the picture is predistorted with the paper's cubic r + k_pd r^3
  uncorrected,  ///< the lens is there and the application ignores it
};

/// The panel tangent at which the application draws the ideal point.
[[nodiscard]] inline std::optional<Vector2> drawn_tangent(const Lens& lens, LensMode mode, const Vector2& ideal) {
  switch (mode) {
    case LensMode::exact:
      return undistort(lens, ideal);
    case LensMode::cubic:
      return cubic_inverse(lens).distort(ideal);
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
  return drawn ? distort(lens, *drawn) : std::nullopt;
}

/// The ideal point that a panel tangent shows: the inverse of drawn_tangent, which a warp looks up for each panel
/// pixel.
[[nodiscard]] inline std::optional<Vector2> ideal_tangent_at_panel(const Lens& lens, LensMode mode,
                                                                   const Vector2& panel) {
  switch (mode) {
    case LensMode::exact:
      return distort(lens, panel);
    case LensMode::cubic:
      return cubic_inverse(lens).undistort(panel);
    case LensMode::none:
    case LensMode::uncorrected:
      break;
  }
  return panel;
}

/// The ideal point that the eye sees at tangent `seen`: the inverse of seen_tangent.
[[nodiscard]] inline std::optional<Vector2> ideal_tangent(const Lens& lens, LensMode mode, const Vector2& seen) {
  if (mode == LensMode::none) return seen;
  const std::optional<Vector2> panel = undistort(lens, seen);
  return panel ? ideal_tangent_at_panel(lens, mode, *panel) : std::nullopt;
}

}  // namespace holdfast
