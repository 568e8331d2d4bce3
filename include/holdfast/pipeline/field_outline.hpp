/// The outline of what an eye's panel shows, and whether a deflected picture still fills it.
///
/// Points along the panel's border, with the tangents t_E that they show (through the lens and its correction, every
/// colour that is bent differently) and the line fraction at which they light. Where the lens answers nothing at the
/// border, the outermost point towards the panel's middle stands for it. A continuous map takes an area within its
/// outline to an area within the outline's image: so a picture fills the view if it holds the outline.
/// Between two points the outline may bulge outward. It is taken as a parabola through both and the point m half way:
/// that lies in the triangle of the two and c = 2 m - (a + b) / 2, so c is one of the points too. The border is halved
/// until c stands out by at most 1/4 px of the panel, which is as much as the outline is too large. A deflection that
/// changes from line to line bends it besides, between its at least 8 points a side by less than 0.1 px at 200 deg/s and
/// 11.1 ms.
/// Made once (it solves for the lens's domain); looking up allocates nothing. Bad input: an eye whose lens answers
/// nothing even in the panel's middle has no outline; points() is empty.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

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
    for (const Color color : {Color::green, Color::red, Color::blue}) {
      const bool is_green = color == Color::green;
      if (!is_green && !(color == Color::red ? eye.lens_red : eye.lens_blue)) continue;
      Tracer{eye, eye.lens_of(color), mode, line_fraction_coefficients(timing), points_}.trace();
    }
  }

  [[nodiscard]] std::span<const Point> points() const& { return points_; }
  std::span<const Point> points() const&& = delete;  // they would be gone with the outline

  /// The smallest field that holds the outline: what a picture that is never deflected must fill.
  [[nodiscard]] FieldTangents bounds() const {
    if (points_.empty()) return {0.0, 0.0, 0.0, 0.0};
    Vector2 low = points_[0].t_E, high = low;
    for (const Point& p : points_) {
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
    for (const Point& p : points_) {
      const std::optional<Vector2> t_S = H_SE.source_tangent(p.t_E, p.line_fraction);
      if (!t_S) return std::numeric_limits<double>::infinity();
      most = std::max({most, low_x - t_S->x(), t_S->x() - high_x, low_y - t_S->y(), t_S->y() - high_y});
    }
    return most;
  }

 private:
  static constexpr double most_bulge_px = 0.25;
  static constexpr int per_side = 8;
  static constexpr int most_halvings = 6;  // where the outline has a corner, or is torn

  /// Follows the outline of one colour.
  struct Tracer {
    const EyeModel& eye;
    const Lens& lens;
    LensMode mode;
    Vector3 line;
    std::vector<Point>& points;

    void trace() {
      const std::optional<Vector2> middle = shown({0.5, 0.5});
      if (!middle || !middle->allFinite()) return;
      std::optional<Point> before = at(0.0);
      for (int i = 1; i <= 4 * per_side; ++i) {
        const std::optional<Point> next = at(static_cast<double>(i) / per_side);
        if (before) points.push_back(*before);
        if (before && next) add_between(*before, (i - 1.0) / per_side, *next, double(i) / per_side, *middle, 0);
        before = next;
      }
    }

    /// Adds what stands out between two points at border coordinates u and v.
    void add_between(const Point& a, double u, const Point& b, double v, const Vector2& middle, int halvings) {
      const double half_way = 0.5 * (u + v);
      const std::optional<Point> m = at(half_way);
      if (!m) return;
      const Vector2 chord = b.t_E - a.t_E, bulge = m->t_E - 0.5 * (a.t_E + b.t_E);
      const auto cross = [](const Vector2& x, const Vector2& y) { return x.x() * y.y() - x.y() * y.x(); };
      if (cross(chord, bulge) * cross(chord, middle - a.t_E) >= 0.0) return;  // inward: the chord holds the outline
      const double bulge_px =
          std::abs(cross(chord, bulge)) / chord.norm() * pixels_per_tangent(eye).cwiseAbs().maxCoeff();
      if (!(bulge_px > 1e-6)) return;  // straight
      if (bulge_px > most_bulge_px && halvings < most_halvings) {
        add_between(a, u, *m, half_way, middle, halvings + 1);
        points.push_back(*m);
        add_between(*m, half_way, b, v, middle, halvings + 1);
      } else {
        points.push_back({m->t_E + bulge, m->line_fraction});
      }
    }

    /// What the panel shows at border coordinate u: 0 to 4 anticlockwise from the lower left corner.
    [[nodiscard]] std::optional<Point> at(double u) const {
      const double along = u - std::floor(u);
      const std::array<Vector2, 4> sides{Vector2(along, 0.0), Vector2(1.0, along), Vector2(1.0 - along, 1.0),
                                         Vector2(0.0, 1.0 - along)};
      const Vector2 border = sides[static_cast<std::size_t>(u) % 4], middle(0.5, 0.5);
      Vector2 uv = border;
      std::optional<Vector2> t_E = shown(uv);
      if (!t_E) {
        double inside = 0.0, outside = 1.0;  // from the middle to the border
        for (int i = 0; i < 50; ++i) {
          const double half = 0.5 * (inside + outside);
          (shown(middle + half * (border - middle)) ? inside : outside) = half;
        }
        uv = middle + inside * (border - middle);
        t_E = shown(uv);
      }
      if (!t_E || !t_E->allFinite()) return std::nullopt;
      return Point{*t_E, line.x() * uv.x() + line.y() * uv.y() + line.z()};
    }

    /// Tangent t_E that the panel shows at uv, (0, 0) lower left to (1, 1) upper right.
    [[nodiscard]] std::optional<Vector2> shown(const Vector2& uv) const {
      const FieldTangents field = panel_tangents(eye);
      return ideal_tangent_at_panel(
          lens, mode,
          Vector2(field.left + uv.x() * (field.right - field.left), field.down + uv.y() * (field.up - field.down)));
    }
  };

  std::vector<Point> points_;
};

}  // namespace holdfast
