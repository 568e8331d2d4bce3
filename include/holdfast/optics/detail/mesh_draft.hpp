/// Vertices of a predistortion mesh while it is made: what each shows, the error of a triangle, and the cut at a border.
///
/// Error: e(p), linear interpolation minus exact lens, vanishes at a triangle's corners. Its values at the thirds of the
/// edges and at the centroid fix it when it is a cubic; the edges' middles follow as 9/16 (e(1/3) + e(2/3)).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <holdfast/optics/detail/bisection.hpp>
#include <holdfast/optics/detail/panel_map.hpp>

namespace holdfast::detail {

/// A corner of a triangle that may have been cut: where it is and what it shows.
struct MeshCorner {
  PanelPoint point;
  Vector2 panel;  ///< tangent
  PanelLook look;
};

struct TriangleError {
  double px = 0.0;     ///< of the source picture; of the points that could be tried
  bool hole = false;   ///< some of the tried points show nothing
  bool shown = false;  ///< some show something
};

class MeshDraft {
 public:
  MeshDraft(const EyeModel& eye, LensMode mode, const std::optional<FieldTangents>& field)
      : map_(eye, mode, field),
        field_(eye.tangents),
        resolution_(eye.resolution),
        px_per_tangent_(pixels_per_tangent(eye).cwiseAbs()) {}

  [[nodiscard]] const PanelMap& map() const { return map_; }
  [[nodiscard]] std::size_t size() const { return corners_.size(); }
  [[nodiscard]] const MeshCorner& corner(std::uint32_t v) const { return corners_[v]; }
  [[nodiscard]] bool is_inside(std::uint32_t v) const { return corners_[v].look.inside; }

  /// Looks at the points that have been added since.
  void add(std::span<const PanelPoint> points) {
    for (std::size_t i = corners_.size(); i < points.size(); ++i) corners_.push_back(corner_at(points[i]));
  }

  [[nodiscard]] MeshCorner corner_at(const PanelPoint& p) const {
    const Vector2 panel = tangent_at(p);
    return {p, panel, map_.look(panel)};
  }

  /// Vector from p to q in panel pixels.
  [[nodiscard]] Vector2 pixels_between(const PanelPoint& p, const PanelPoint& q) const {
    return {(static_cast<double>(q.x) - p.x) * resolution_.width / panel_units,
            (static_cast<double>(q.y) - p.y) * resolution_.height / panel_units};
  }

  /// Whether the panel point at `pixels` from p shows something; outside the panel nothing does.
  [[nodiscard]] bool shows(const PanelPoint& p, const Vector2& pixels) const {
    const Vector2 at(p.x + pixels.x() * panel_units / resolution_.width,
                     p.y + pixels.y() * panel_units / resolution_.height);
    if (!(at.minCoeff() >= 0.0) || !(at.maxCoeff() <= panel_units)) return false;
    return map_
        .look(Vector2(field_.left + at.x() / panel_units * (field_.right - field_.left),
                      field_.down + at.y() / panel_units * (field_.up - field_.down)))
        .inside;
  }

  /// Error of the triangle a b c (a b its longest edge); once it is above `enough` the rest is not tried.
  [[nodiscard]] TriangleError error_of(const MeshCorner& a, const MeshCorner& b, const MeshCorner& c,
                                       double enough) const {
    TriangleError error;
    Vector2 at[4];
    PanelLook look[4];
    // The longest edge and the centroid first: they decide most triangles that are to be split.
    for (const std::span<const Node> part :
         {std::span<const Node>(nodes).first(3), std::span<const Node>(nodes).last(4)}) {
      for (std::size_t i = 0; i < part.size(); ++i) at[i] = mixed(part[i], a.panel, b.panel, c.panel);
      map_.look(std::span(at, part.size()), look);
      double worst2 = 0.0;
      for (std::size_t colour = 0; colour < static_cast<std::size_t>(map_.colours()); ++colour) {
        Vector2 e[4];
        for (std::size_t i = 0; i < part.size(); ++i) {
          if (!look[i].inside) continue;
          const Vector2 linear = mixed(part[i], a.look.ideal[colour], b.look.ideal[colour], c.look.ideal[colour]);
          e[i] = (linear - look[i].ideal[colour]).cwiseProduct(px_per_tangent_);
          worst2 = std::max(worst2, e[i].squaredNorm());
        }
        for (std::size_t i = part.size() == 3 ? 1 : 0; i + 1 < part.size(); i += 2) {
          if (!look[i].inside || !look[i + 1].inside) continue;
          worst2 = std::max(worst2, (9.0 / 16.0 * 9.0 / 16.0) * (e[i] + e[i + 1]).squaredNorm());
        }
      }
      for (std::size_t i = 0; i < part.size(); ++i) (look[i].inside ? error.shown : error.hole) = true;
      error.px = std::max(error.px, std::sqrt(worst2));
      if (error.px > enough) return error;
    }
    return error;
  }

  /// Whether a b c shows the picture turned over somewhere: only a sliver at a border, near a fold, can.
  [[nodiscard]] bool is_turned_over(const MeshCorner& a, const MeshCorner& b, const MeshCorner& c) const {
    const double upright = (field_.right - field_.left) * (field_.up - field_.down);
    for (std::size_t colour = 0; colour < static_cast<std::size_t>(map_.colours()); ++colour) {
      const Vector2 p = b.look.ideal[colour] - a.look.ideal[colour];
      const Vector2 q = c.look.ideal[colour] - a.look.ideal[colour];
      if (!((p.x() * q.y() - p.y() * q.x()) * upright > 0.0)) return true;
    }
    return false;
  }

  /// The last point towards `out` that still shows something, in steps of 1/1024 of the edge. All triangles at the edge
  /// get the same one, and it lies exactly on the edge where the lattice divides that finely.
  [[nodiscard]] MeshCorner border_between(std::uint32_t in, std::uint32_t out) const {
    const MeshCorner& from = corners_[in];
    const PanelPoint& to = corners_[out].point;
    constexpr std::int64_t steps = 1024;
    const auto at = [&](std::int64_t k) {
      const auto along = [k](std::uint32_t p, std::uint32_t q) {
        return static_cast<std::uint32_t>(p + (static_cast<std::int64_t>(q) - p) * k / steps);
      };
      return corner_at({along(from.point.x, to.x), along(from.point.y, to.y)});
    };
    MeshCorner last = from;
    std::int64_t low = 0, high = steps;
    while (high - low > 1) {
      const std::int64_t middle = (low + high) / 2;
      const MeshCorner tried = at(middle);
      if (tried.look.inside) last = tried;
      (tried.look.inside ? low : high) = middle;
    }
    return last;
  }

 private:
  using Node = std::array<double, 3>;
  static constexpr double third = 1.0 / 3.0;
  static constexpr std::array<Node, 7> nodes{{{third, third, third},
                                              {2 * third, third, 0},
                                              {third, 2 * third, 0},
                                              {0, 2 * third, third},
                                              {0, third, 2 * third},
                                              {third, 0, 2 * third},
                                              {2 * third, 0, third}}};

  [[nodiscard]] static Vector2 mixed(const Node& w, const Vector2& a, const Vector2& b, const Vector2& c) {
    return {w[0] * a.x() + w[1] * b.x() + w[2] * c.x(), w[0] * a.y() + w[1] * b.y() + w[2] * c.y()};
  }

  [[nodiscard]] Vector2 tangent_at(const PanelPoint& p) const {
    return {field_.left + (field_.right - field_.left) * (p.x * (1.0 / panel_units)),
            field_.down + (field_.up - field_.down) * (p.y * (1.0 / panel_units))};
  }

  PanelMap map_;
  FieldTangents field_;
  PixelSize resolution_;
  Vector2 px_per_tangent_;
  std::vector<MeshCorner> corners_;
};

}  // namespace holdfast::detail
