/// How far linear interpolation over a triangle of the panel is from the exact lens, px of the source picture.
///
/// e(p), linear interpolation minus lens, vanishes at the corners. One triangle: its values at the thirds of the edges
/// and at the centroid fix it when it is a cubic; the edges' middles follow as 9/16 (e(1/3) + e(2/3)). A triangle that
/// will be drawn as many equal ones: second differences d over a lattice of four steps an edge give the lens's second
/// derivatives; along an edge of the small triangles e = -d / 8 at its middle, and at their centroids 4/9 of the three
/// edges' sum. Second derivatives of a cubic are linear, so they follow at the outermost small triangles too.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include <holdfast/optics/detail/bisection.hpp>
#include <holdfast/optics/detail/panel_map.hpp>

namespace holdfast::detail {

struct TriangleError {
  double px = 0.0;     ///< as far as it could be tried
  bool hole = false;   ///< some of the tried points show nothing
  bool shown = false;  ///< some show something
};

/// Looks through an eye's lens at points of the panel's lattice.
class PanelLooker {
 public:
  PanelLooker(const EyeModel& eye, LensMode mode, const std::optional<FieldTangents>& field)
      : map_(eye, mode, field),
        tangents_(eye.tangents),
        origin_(eye.tangents.left, eye.tangents.down),
        per_unit_((eye.tangents.right - eye.tangents.left) / panel_units,
                  (eye.tangents.up - eye.tangents.down) / panel_units),
        px_per_tangent_(pixels_per_tangent(eye).cwiseAbs()),
        px_per_unit_(static_cast<double>(eye.resolution.width) / panel_units,
                     static_cast<double>(eye.resolution.height) / panel_units) {}

  [[nodiscard]] const PanelMap& map() const { return map_; }
  [[nodiscard]] std::size_t colours() const { return static_cast<std::size_t>(map_.colours()); }
  [[nodiscard]] const Vector2& px_per_tangent() const { return px_per_tangent_; }

  /// Tangent of a point, given in lattice units that need not be whole.
  [[nodiscard]] Vector2 tangent_at(double x, double y) const {
    return {origin_.x() + per_unit_.x() * x, origin_.y() + per_unit_.y() * y};
  }
  [[nodiscard]] Vector2 tangent_at(const PanelPoint& p) const { return tangent_at(p.x, p.y); }
  /// Its inverse, on the panel or beyond.
  [[nodiscard]] Vector2 units_at(const Vector2& tangent) const { return (tangent - origin_).cwiseQuotient(per_unit_); }
  [[nodiscard]] PanelLook look(const PanelPoint& p) const { return map_.look(tangent_at(p)); }
  [[nodiscard]] bool shows(const PanelPoint& p) const { return map_.shows(tangent_at(p)); }

  /// Vector from p to q in panel pixels.
  [[nodiscard]] Vector2 pixels_between(const PanelPoint& p, const PanelPoint& q) const {
    return {(static_cast<double>(q.x) - p.x) * px_per_unit_.x(), (static_cast<double>(q.y) - p.y) * px_per_unit_.y()};
  }

  /// Whether the panel point at `pixels` from p shows something; outside the panel nothing does.
  [[nodiscard]] bool shows(const PanelPoint& p, const Vector2& pixels) const {
    const double x = p.x + pixels.x() / px_per_unit_.x(), y = p.y + pixels.y() / px_per_unit_.y();
    if (!(std::min(x, y) >= 0.0) || !(std::max(x, y) <= panel_units)) return false;
    return map_.shows(tangent_at(x, y));
  }

  /// Whether the eye sees the triangle a b c turned over: only a sliver at a border, near a fold, can be.
  [[nodiscard]] bool is_turned_over(const PanelPoint& a, const PanelPoint& b, const PanelPoint& c) const {
    const PanelLook at_a = look(a), at_b = look(b), at_c = look(c);
    for (std::size_t colour = 0; colour < colours(); ++colour) {
      const Vector2 p = at_b.ideal[colour] - at_a.ideal[colour];
      const Vector2 q = at_c.ideal[colour] - at_a.ideal[colour];
      if (!((p.x() * q.y() - p.y() * q.x()) * per_unit_.x() * per_unit_.y() > 0.0)) return true;
    }
    return false;
  }

  /// What is known of radial lenses; of others nothing.
  [[nodiscard]] std::optional<RadialBend> bend() const {
    if (!map_.is_radial()) return std::nullopt;
    return RadialBend(map_.lenses(), tangents_, px_per_tangent_);
  }

 private:
  PanelMap map_;
  FieldTangents tangents_;
  Vector2 origin_, per_unit_, px_per_tangent_, px_per_unit_;
};

/// How much larger than found the error of a triangle may be between the points that are tried, and by rounding to
/// float: of a kink at least 0.44 is found, of the bends between the pieces of a spline three quarters.
[[nodiscard]] inline double error_margin(const PanelLooker& looker, const std::array<PanelPoint, 3>& corner) {
  if (looker.map().is_smooth()) return 1.05;
  const bool kink =
      looker.map().may_kink(looker.tangent_at(corner[0]), looker.tangent_at(corner[1]), looker.tangent_at(corner[2]));
  return kink ? 2.3 : 1.35;
}

/// Weights of a triangle's corners.
using Barycentric = std::array<double, 3>;

[[nodiscard]] inline Vector2 mixed(const Barycentric& w, const Vector2& a, const Vector2& b, const Vector2& c) {
  return {w[0] * a.x() + w[1] * b.x() + w[2] * c.x(), w[0] * a.y() + w[1] * b.y() + w[2] * c.y()};
}

/// Error of one triangle whose corners all show something; once it is above `enough`, the rest is not tried. Of corners
/// that do not: only whether anything is shown.
[[nodiscard]] inline TriangleError error_of(const PanelLooker& looker, const std::array<PanelPoint, 3>& corner,
                                            double enough) {
  constexpr double third = 1.0 / 3.0;
  constexpr std::array<Barycentric, 7> nodes{{{third, third, third},
                                              {2 * third, third, 0},
                                              {third, 2 * third, 0},
                                              {0, 2 * third, third},
                                              {0, third, 2 * third},
                                              {third, 0, 2 * third},
                                              {2 * third, 0, third}}};
  std::array<Vector2, 3> panel;
  std::array<PanelLook, 3> at_corner;
  for (std::size_t i = 0; i < 3; ++i) panel[i] = looker.tangent_at(corner[i]);
  looker.map().look(panel, at_corner.data());
  const bool has_corners = at_corner[0].inside && at_corner[1].inside && at_corner[2].inside;
  TriangleError error;
  // The longest edge and the centroid first: they decide most triangles that are to be split.
  for (const std::span<const Barycentric> part :
       {std::span<const Barycentric>(nodes).first(3), std::span<const Barycentric>(nodes).last(4)}) {
    std::array<Vector2, 4> at;
    std::array<PanelLook, 4> seen;
    for (std::size_t i = 0; i < part.size(); ++i) at[i] = mixed(part[i], panel[0], panel[1], panel[2]);
    looker.map().look(std::span(at).first(part.size()), seen.data());
    for (std::size_t i = 0; i < part.size(); ++i) (seen[i].inside ? error.shown : error.hole) = true;
    if (!has_corners) continue;
    double worst2 = 0.0;
    for (std::size_t c = 0; c < looker.colours(); ++c) {
      std::array<Vector2, 4> e;
      for (std::size_t i = 0; i < part.size(); ++i) {
        if (!seen[i].inside) continue;
        const Vector2 linear = mixed(part[i], at_corner[0].ideal[c], at_corner[1].ideal[c], at_corner[2].ideal[c]);
        e[i] = (linear - seen[i].ideal[c]).cwiseProduct(looker.px_per_tangent());
        worst2 = std::max(worst2, e[i].squaredNorm());
      }
      for (std::size_t i = part.size() == 3 ? 1 : 0; i + 1 < part.size(); i += 2) {
        if (!seen[i].inside || !seen[i + 1].inside) continue;
        worst2 = std::max(worst2, (9.0 / 16.0 * 9.0 / 16.0) * (e[i] + e[i + 1]).squaredNorm());
      }
    }
    error.px = std::max(error.px, std::sqrt(worst2));
    if (error.px > enough) return error;
  }
  return error;
}

/// Error of the equal triangles that the triangle `corner` is cut into, `pieces` along each edge. With a hole among the
/// points that are tried, no error is told.
[[nodiscard]] inline TriangleError error_of_pieces(const PanelLooker& looker, const std::array<PanelPoint, 3>& corner,
                                                   int pieces) {
  // Node (i, j) is i/4 towards corner 1 and j/4 towards corner 2; row j begins at row[j].
  constexpr std::array<std::size_t, 5> row{0, 5, 9, 12, 14};
  std::array<Vector2, 15> at;
  std::array<PanelLook, 15> seen;
  const std::array<Vector2, 3> p{looker.tangent_at(corner[0]), looker.tangent_at(corner[1]),
                                 looker.tangent_at(corner[2])};
  const Vector2 right = (p[1] - p[0]) / 4.0, up = (p[2] - p[0]) / 4.0;
  for (std::size_t j = 0; j <= 4; ++j) {
    for (std::size_t i = 0; i + j <= 4; ++i)
      at[row[j] + i] = p[0] + static_cast<double>(i) * right + static_cast<double>(j) * up;
  }
  looker.map().look(at, seen.data());
  TriangleError error;
  for (const PanelLook& one : seen) (one.inside ? error.shown : error.hole) = true;
  if (error.hole) return error;
  constexpr std::array<std::size_t, 3> inner_node{row[1] + 1, row[1] + 2, row[2] + 1};  // towards corner 0, 1, 2
  double worst2 = 0.0, deviation2 = 0.0;
  for (std::size_t c = 0; c < looker.colours(); ++c) {
    const auto f = [&](std::size_t i, std::size_t j) -> const Vector2& { return seen[row[j] + i].ideal[c]; };
    // Second differences along the edges 01, 02 and 12, at the three inner nodes.
    std::array<std::array<Vector2, 3>, 3> d;
    for (std::size_t n = 0; n < 3; ++n) {
      const std::size_t j = n == 2 ? 2 : 1, i = n == 1 ? 2 : 1;
      const Vector2 twice = 2.0 * seen[inner_node[n]].ideal[c];
      d[0][n] = f(i - 1, j) - twice + f(i + 1, j);
      d[1][n] = f(i, j - 1) - twice + f(i, j + 1);
      d[2][n] = f(i + 1, j - 1) - twice + f(i - 1, j + 1);
    }
    const auto take = [&](const Vector2& v) {
      worst2 = std::max(worst2, v.cwiseProduct(looker.px_per_tangent()).squaredNorm());
    };
    // Linear in the inner nodes: at the middles of the outermost small edges, and at the outermost small centroids.
    const double m = pieces;
    for (std::size_t along = 0; along < 3; ++along) {
      // The two corners on this edge, and the one off it.
      const std::size_t off = 2 - along, one = along == 2 ? 1 : 0, two = along == 0 ? 1 : 2;
      const Vector2 &p1 = d[along][one], &p2 = d[along][two], &p3 = d[along][off];
      take((3.0 - 2.0 / m) * p1 + (2.0 / m - 1.0) * p2 - p3);
      take((3.0 - 2.0 / m) * p2 + (2.0 / m - 1.0) * p1 - p3);
      take((3.0 - 4.0 / m) * p3 + (2.0 / m - 1.0) * (p1 + p2));
    }
    for (std::size_t n = 0; n < 3; ++n) {
      const auto sum = [&](std::size_t k) { return Vector2(d[0][k] + d[1][k] + d[2][k]); };
      take((4.0 / 9.0) *
           ((3.0 - 8.0 / (3.0 * m)) * sum(n) + (4.0 / (3.0 * m) - 1.0) * (sum((n + 1) % 3) + sum((n + 2) % 3))));
    }
    // On the large edges, where the lattice reaches farther out: what is not linear there grows outward,
    // and is added three times.
    const auto add = [&](const Vector2& difference, const std::array<Vector2, 3>& inner, double w0, double w1,
                         double w2) {
      const Vector2 off = difference - (w0 * inner[0] + w1 * inner[1] + w2 * inner[2]);
      deviation2 = std::max(deviation2, off.cwiseProduct(looker.px_per_tangent()).squaredNorm());
    };
    for (std::size_t i = 1; i < 4; ++i) {
      const double near = 3.0 - static_cast<double>(i), far = static_cast<double>(i) - 1.0;
      add(f(i - 1, 0) - 2.0 * f(i, 0) + f(i + 1, 0), d[0], near, far, -1.0);
      add(f(0, i - 1) - 2.0 * f(0, i) + f(0, i + 1), d[1], near, -1.0, far);
      add(f(5 - i, i - 1) - 2.0 * f(4 - i, i) + f(3 - i, i + 1), d[2], -1.0, near, far);
    }
  }
  const double of_lattice = 4.0 / pieces;
  error.px = (std::sqrt(worst2) + 3.0 * std::sqrt(deviation2)) / 8.0 * of_lattice * of_lattice;
  return error;
}

}  // namespace holdfast::detail
