/// Newest-vertex bisection of a rectangle into right triangles without T-junctions.
///
/// Each triangle (v0, v1, apex) is counter-clockwise; v0 v1 is its longest edge. split() halves it from the apex to the
/// middle of that edge, together with the triangle across, which is split before as often as needed to have the same
/// longest edge. So the triangulation conforms after every split. Source: W. F. Mitchell, "A comparison of adaptive
/// refinement techniques for elliptic problems", ACM TOMS 15 (1989). Points are on a lattice of 2^24 units a side, in
/// which all middles are exact.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/assert.hpp>

namespace holdfast::detail {

/// A point of the panel, in units of 2^-24 of its width and height, from its lower left.
struct PanelPoint {
  std::uint32_t x = 0, y = 0;

  friend bool operator==(const PanelPoint&, const PanelPoint&) = default;
};

inline constexpr std::uint32_t panel_units = 1u << 24;

class Bisection {
 public:
  static constexpr std::uint32_t outside = 0xffffffff;

  struct Triangle {
    std::array<std::uint32_t, 3> v;       ///< v[2] is the apex
    std::array<std::uint32_t, 3> across;  ///< the triangle across the edge that v[i] is not on, or outside
  };

  /// columns x rows cells (powers of two), each cut into four triangles round its middle.
  Bisection(std::uint32_t columns, std::uint32_t rows) {
    for (std::uint32_t y = 0; y <= rows; ++y) {
      for (std::uint32_t x = 0; x <= columns; ++x) {
        points_.push_back({x * (panel_units / columns), y * (panel_units / rows)});
      }
    }
    for (std::uint32_t y = 0; y < rows; ++y) {
      for (std::uint32_t x = 0; x < columns; ++x) add_cell(x, y, columns, rows);
    }
  }

  [[nodiscard]] const std::vector<PanelPoint>& points() const { return points_; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Halves triangle t and what has to be halved with it. Calls changed(i) for every triangle that is now another.
  template <typename Changed>
  void split(std::uint32_t t, const Changed& changed) {
    std::uint32_t other = triangles_[t].across[2];
    while (other != outside && triangles_[other].across[2] != t) {
      split(other, changed);
      other = triangles_[t].across[2];
    }
    const Triangle parent = triangles_[t];
    const std::uint32_t middle = add_middle(parent.v[0], parent.v[1]);
    const std::uint32_t second = halve(t, middle);
    changed(t);
    changed(second);
    if (other == outside) return;
    const std::uint32_t other_second = halve(other, middle);
    changed(other);
    changed(other_second);
    // Across the halves of the common edge.
    triangles_[t].across[0] = other_second;
    triangles_[other_second].across[1] = t;
    triangles_[second].across[1] = other;
    triangles_[other].across[0] = second;
  }

 private:
  void add_cell(std::uint32_t x, std::uint32_t y, std::uint32_t columns, std::uint32_t rows) {
    const std::uint32_t sw = y * (columns + 1) + x, nw = sw + columns + 1;
    const std::array<std::uint32_t, 4> corner{sw, sw + 1, nw + 1, nw};
    const auto middle = static_cast<std::uint32_t>(points_.size());
    const std::uint32_t half_x = panel_units / columns / 2, half_y = panel_units / rows / 2;
    points_.push_back({points_[sw].x + half_x, points_[sw].y + half_y});
    const std::uint32_t first = 4 * (y * columns + x);
    // Below, to the right, above, to the left: that cell's opposite triangle.
    const std::array<std::uint32_t, 4> across{
        y > 0 ? first - 4 * columns + 2 : outside, x + 1 < columns ? first + 4 + 3 : outside,
        y + 1 < rows ? first + 4 * columns : outside, x > 0 ? first - 4 + 1 : outside};
    for (std::uint32_t i = 0; i < 4; ++i) {
      triangles_.push_back(
          {{corner[i], corner[(i + 1) % 4], middle}, {first + (i + 1) % 4, first + (i + 3) % 4, across[i]}});
    }
  }

  [[nodiscard]] std::uint32_t add_middle(std::uint32_t a, std::uint32_t b) {
    const PanelPoint p = points_[a], q = points_[b];
    HOLDFAST_ASSERT((p.x + q.x) % 2 == 0 && (p.y + q.y) % 2 == 0, "the lattice is too coarse");
    points_.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2});
    return static_cast<std::uint32_t>(points_.size() - 1);
  }

  /// (v0, v1, apex) becomes (apex, v0, middle) in its place and (v1, apex, middle) at the end, whose index is returned.
  [[nodiscard]] std::uint32_t halve(std::uint32_t t, std::uint32_t middle) {
    const Triangle parent = triangles_[t];
    const auto second = static_cast<std::uint32_t>(triangles_.size());
    triangles_[t] = {{parent.v[2], parent.v[0], middle}, {outside, second, parent.across[1]}};
    triangles_.push_back({{parent.v[1], parent.v[2], middle}, {t, outside, parent.across[0]}});
    if (parent.across[0] != outside) {
      for (std::uint32_t& back : triangles_[parent.across[0]].across) {
        if (back == t) back = second;
      }
    }
    return second;
  }

  std::vector<PanelPoint> points_;
  std::vector<Triangle> triangles_;
};

}  // namespace holdfast::detail
