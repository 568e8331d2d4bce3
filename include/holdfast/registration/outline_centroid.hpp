/// Centroid of what a smooth closed curve encloses: where an evenly bright shape of that outline is measured in a picture.
///
/// By Green's theorem, with the outline p(a) = (x, y), a from 0 to 2 pi:
///     A = 1/2 int (x y' - y x') da,   A c_x = 1/2 int x^2 y' da,   A c_y = -1/2 int y^2 x' da.
/// The curve is taken at evenly spaced a; derivatives are those of the trigonometric polynomial through the points
/// (Trefethen 2000, Spectral Methods in MATLAB, chapter 3), so that the result is exact up to rounding for an ellipse,
/// and nearly so for its image under any smooth map: a lens, a homography, a rolling scan-out. Any unit. Bad input: a
/// curve with a point missing, or without area, has no centroid: nothing.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

namespace detail {

inline constexpr std::size_t outline_points = 24;

/// What the curve is taken at, and the derivative's weights: p'_j = sum_k weight[(j - k) mod n] p_k.
struct OutlineRule {
  std::array<double, outline_points> cosine{}, sine{}, weight{};

  OutlineRule() {
    for (std::size_t i = 0; i < outline_points; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / outline_points;
      cosine[i] = std::cos(angle);
      sine[i] = std::sin(angle);
      if (i > 0) weight[i] = (i % 2 == 0 ? 0.5 : -0.5) / std::tan(0.5 * angle);
    }
  }
};

[[nodiscard]] inline const OutlineRule& outline_rule() {
  static const OutlineRule rule;
  return rule;
}

}  // namespace detail

/// `curve(cos a, sin a)` is the outline's point as an optional Vector2.
template <typename Curve>
[[nodiscard]] std::optional<Vector2> outline_centroid(const Curve& curve) {
  constexpr std::size_t n = detail::outline_points;
  const detail::OutlineRule& rule = detail::outline_rule();
  std::array<Vector2, n> p;
  Vector2 origin = Vector2::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const std::optional<Vector2> point = curve(rule.cosine[i], rule.sine[i]);
    if (!point) return std::nullopt;
    p[i] = *point;
    origin += *point / static_cast<double>(n);
  }
  for (Vector2& point : p) point -= origin;  // moments about the middle keep their digits
  double area = 0.0;
  Vector2 moment = Vector2::Zero();
  for (std::size_t j = 0; j < n; ++j) {
    Vector2 d = Vector2::Zero();
    for (std::size_t k = 0; k < n; ++k) d += rule.weight[j >= k ? j - k : j + n - k] * p[k];
    area += p[j].x() * d.y() - p[j].y() * d.x();
    moment += Vector2(p[j].x() * p[j].x() * d.y(), -p[j].y() * p[j].y() * d.x());
  }
  if (!(std::abs(area) > 0.0)) return std::nullopt;
  return Vector2(origin + moment / area);
}

}  // namespace holdfast
