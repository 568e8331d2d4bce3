/// What every lens model offers, and the one that does nothing.
///
/// A lens maps the point of the panel to where it is seen: seen = distort(panel). A model does so in a unit of its own,
/// measured from its own origin (usually the optical axis); the class Lens places it among an eye's tangents. Formulas
/// that runtimes print as "screen to texture" are distort. A model answers nothing outside its domain, where it is not
/// known to be one-to-one:
///
///     undistort(distort(p)) = p     for p in the domain, which holds the disc of valid_radius round the origin
///     distort(undistort(v)) = v     for v in its image, which holds the disc of valid_image_radius
///
/// distort_jacobian is d distort / d p (2x2) inside the domain; undistort_jacobian the same of the inverse, nothing
/// outside and where it is infinite. All are const, allocate nothing and do not throw.
#pragma once

#include <concepts>
#include <limits>
#include <optional>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

template <typename L>
concept LensModel = requires(const L& lens, const Vector2& point) {
  { lens.distort(point) } -> std::same_as<std::optional<Vector2>>;
  { lens.undistort(point) } -> std::same_as<std::optional<Vector2>>;
  { lens.distort_jacobian(point) } -> std::same_as<Matrix2>;
  { lens.undistort_jacobian(point) } -> std::same_as<std::optional<Matrix2>>;
  { lens.valid_radius() } -> std::same_as<double>;
  { lens.valid_image_radius() } -> std::same_as<double>;
};

/// A display seen directly, or through optics without distortion.
struct NoLens {
  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const { return p; }
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const { return v; }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2&) const { return Matrix2::Identity(); }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2&) const { return Matrix2::Identity(); }
  [[nodiscard]] double valid_radius() const { return std::numeric_limits<double>::infinity(); }
  [[nodiscard]] double valid_image_radius() const { return std::numeric_limits<double>::infinity(); }

  friend bool operator==(const NoLens&, const NoLens&) = default;
};

/// The inverse's Jacobian by inverting distort's where `v` came from: what most models answer.
template <typename L>
[[nodiscard]] std::optional<Matrix2> inverted_jacobian(const L& lens, const Vector2& v) {
  const std::optional<Vector2> p = lens.undistort(v);
  if (!p) return std::nullopt;
  const Matrix2 J = lens.distort_jacobian(*p);
  if (!(J.determinant() > 0.0)) return std::nullopt;
  return Matrix2(J.inverse());
}

}  // namespace holdfast
