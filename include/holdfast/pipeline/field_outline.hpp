/// The outline of what an eye's panel shows, and whether a deflected picture still fills it.
///
/// Points along the panel's border, with the tangents t_E that they show (through the lens and its correction, every
/// colour that is bent differently) and the line fraction at which they light. Where the lens answers nothing at the
/// border, the outermost point towards the panel's middle stands for it. A continuous map takes an area within its
/// outline to an area within the outline's image: so a picture fills the view if it holds the outline.
/// Made once (it solves for the lens's domain); looking up allocates nothing. Bad input: an eye whose lens answers
/// nothing even in the panel's middle has no outline; points() is empty.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include <holdfast/deflection/composed_warp.hpp>

namespace holdfast {

class FieldOutline {
 public:
  struct Point {
    Vector2 t_E = Vector2::Zero();
    double line_fraction = 0.5;
  };

  FieldOutline() = default;
  FieldOutline(const EyeModel& eye, LensMode mode, const DisplayTiming& timing) {
    const Vector3 line = line_fraction_coefficients(timing);
    for (const Color color : {Color::green, Color::red, Color::blue}) {
      const bool is_green = color == Color::green;
      if (!is_green && !(color == Color::red ? eye.lens_red : eye.lens_blue)) continue;
      for (int i = 0; i < per_color; ++i) add(eye, mode, line, color, border_point(i));
    }
  }

  [[nodiscard]] std::span<const Point> points() const& { return {points_.data(), size_}; }
  std::span<const Point> points() const&& = delete;  // they would be gone with the outline

  /// The smallest field that holds the outline: what a picture that is never deflected must fill.
  [[nodiscard]] FieldTangents bounds() const {
    if (size_ == 0) return {0.0, 0.0, 0.0, 0.0};
    Vector2 low = points_[0].t_E, high = low;
    for (const Point& p : points()) {
      low = low.cwiseMin(p.t_E);
      high = high.cwiseMax(p.t_E);
    }
    return {low.x(), high.x(), low.y(), high.y()};
  }

  /// How far, as a difference of tangents, the deflected outline reaches beyond the picture's edges: zero or less when
  /// the picture fills the view, infinite when a part of the view is not ahead of the picture's eye at all.
  [[nodiscard]] double lacking(const FieldTangents& picture, const ScanHomography& H_SE) const {
    const double low_x = std::min(picture.left, picture.right), high_x = std::max(picture.left, picture.right);
    const double low_y = std::min(picture.down, picture.up), high_y = std::max(picture.down, picture.up);
    double most = -std::numeric_limits<double>::infinity();
    for (const Point& p : points()) {
      const std::optional<Vector2> t_S = H_SE.source_tangent(p.t_E, p.line_fraction);
      if (!t_S) return std::numeric_limits<double>::infinity();
      most = std::max({most, low_x - t_S->x(), t_S->x() - high_x, low_y - t_S->y(), t_S->y() - high_y});
    }
    return most;
  }

 private:
  static constexpr int per_side = 8;
  static constexpr int per_color = 4 * per_side;

  /// The i-th point of the panel's border, (0, 0) lower left to (1, 1) upper right, anticlockwise.
  [[nodiscard]] static Vector2 border_point(int i) {
    const double along = static_cast<double>(i % per_side) / per_side;
    switch (i / per_side) {
      case 0:
        return {along, 0.0};
      case 1:
        return {1.0, along};
      case 2:
        return {1.0 - along, 1.0};
      default:
        return {0.0, 1.0 - along};
    }
  }

  void add(const EyeModel& eye, LensMode mode, const Vector3& line, Color color, const Vector2& border) {
    const FieldTangents field = panel_tangents(eye);
    const auto shown = [&](const Vector2& uv) {
      const Vector2 panel(field.left + uv.x() * (field.right - field.left),
                          field.down + uv.y() * (field.up - field.down));
      return ideal_tangent_at_panel(eye.lens_of(color), mode, panel);
    };
    const Vector2 middle(0.5, 0.5);
    Vector2 uv = border;
    std::optional<Vector2> t_E = shown(uv);
    if (!t_E && shown(middle)) {
      double inside = 0.0, outside = 1.0;  // from the middle to the border
      for (int i = 0; i < 50; ++i) {
        const double half = 0.5 * (inside + outside);
        const Vector2 between = middle + half * (border - middle);
        (shown(between) ? inside : outside) = half;
      }
      uv = middle + inside * (border - middle);
      t_E = shown(uv);
    }
    if (!t_E || !t_E->allFinite()) return;
    points_[size_++] = {*t_E, line.x() * uv.x() + line.y() * uv.y() + line.z()};
  }

  std::array<Point, 3 * per_color> points_{};
  std::size_t size_ = 0;
};

}  // namespace holdfast
