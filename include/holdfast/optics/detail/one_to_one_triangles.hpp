/// Of triangles that map a panel, those on which the map is one-to-one. See point_mesh.hpp, which uses it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include <holdfast/geometry/delaunay.hpp>
#include <holdfast/geometry/predicates.hpp>
#include <holdfast/geometry/triangle_overlap.hpp>
#include <holdfast/geometry/types.hpp>

namespace holdfast::detail {

[[nodiscard]] inline double twice_area(const std::vector<Vector2>& p, const std::array<int, 3>& t) {
  const Vector2& a = p[static_cast<std::size_t>(t[0])];
  const Vector2 b = p[static_cast<std::size_t>(t[1])] - a;
  const Vector2 c = p[static_cast<std::size_t>(t[2])] - a;
  return b.x() * c.y() - b.y() * c.x();
}

/// Height over longest edge, signed: negative when clockwise.
[[nodiscard]] inline double flatness(const std::vector<Vector2>& p, const std::array<int, 3>& t) {
  double longest2 = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2 edge = p[static_cast<std::size_t>(t[(i + 1) % 3])] - p[static_cast<std::size_t>(t[i])];
    longest2 = std::max(longest2, edge.squaredNorm());
  }
  return longest2 > 0.0 ? twice_area(p, t) / longest2 : 0.0;
}

class OneToOneTriangles {
 public:
  /// Both must outlive this.
  OneToOneTriangles(const Triangulation& panel, const std::vector<Vector2>& seen)
      : panel_(panel), seen_(seen), kept_(panel.triangles.size(), true) {
    leave_out_border_slivers();
    leave_out_folds();
    leave_out_islands();
    leave_out_overlaps();
  }

  /// Whether each triangle of the panel is kept.
  [[nodiscard]] const std::vector<bool>& kept() const { return kept_; }
  /// Those left out because of folds, not the border's slivers.
  [[nodiscard]] const std::vector<std::size_t>& folds() const { return folds_; }

  /// Of the panel area of all triangles.
  [[nodiscard]] double kept_share() const {
    double all = 0.0, kept = 0.0;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const double area = twice_area(panel_.points, panel_.triangles[i]);
      all += area;
      if (kept_[i]) kept += area;
    }
    return kept / all;
  }

  /// Distance of the origin from the border of the kept triangles, whose corners are `p`.
  [[nodiscard]] double radius(const std::vector<Vector2>& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      for (std::size_t e = 0; kept_[i] && e < 3; ++e) {
        if (!is_border(i, e)) continue;
        const Vector2& a = p[static_cast<std::size_t>(panel_.triangles[i][(e + 1) % 3])];
        const Vector2& b = p[static_cast<std::size_t>(panel_.triangles[i][(e + 2) % 3])];
        const Vector2 along = b - a;
        const double s = std::clamp(-a.dot(along) / along.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (a + s * along).norm());
      }
    }
    return nearest;
  }

 private:
  static constexpr double sliver = 1.0 / 500.0;
  static constexpr double flat = 1e-6;  ///< flatter triangles have no inverse worth the name

  [[nodiscard]] bool is_border(std::size_t triangle, std::size_t edge) const {
    const int n = panel_.neighbours[triangle][edge];
    return n < 0 || !kept_[static_cast<std::size_t>(n)];
  }

  /// Peels the hull: leaving a sliver out may lay the next one bare.
  void leave_out_border_slivers() {
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < kept_.size(); ++i) candidates.push_back(i);
    while (!candidates.empty()) {
      const std::size_t i = candidates.back();
      candidates.pop_back();
      const bool at_border = is_border(i, 0) || is_border(i, 1) || is_border(i, 2);
      if (!kept_[i] || !at_border || flatness(panel_.points, panel_.triangles[i]) >= sliver) continue;
      kept_[i] = false;
      for (const int n : panel_.neighbours[i]) {
        if (n >= 0) candidates.push_back(static_cast<std::size_t>(n));
      }
    }
  }

  void leave_out(std::size_t i) {
    kept_[i] = false;
    folds_.push_back(i);
  }

  void leave_out_folds() {
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const std::array<int, 3>& t = panel_.triangles[i];
      const bool good = flatness(seen_, t) > flat && flatness(panel_.points, t) > flat;
      if (kept_[i] && !good) leave_out(i);
    }
  }

  /// Beyond a fold the map may turn round again: only the piece that holds the origin is kept, or else the largest.
  void leave_out_islands() {
    std::vector<std::size_t> piece(kept_.size(), 0);  // 0: none yet
    std::size_t pieces = 0, best = 0;
    double best_area = 0.0;
    for (std::size_t seed = 0; seed < kept_.size(); ++seed) {
      if (!kept_[seed] || piece[seed] != 0) continue;
      const double area = fill(seed, ++pieces, piece);
      if (area > best_area) {
        best_area = area;
        best = pieces;
      }
    }
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (kept_[i] && piece[i] != best) leave_out(i);
    }
  }

  /// Numbers the triangles that hang together with `seed`; their area, infinite when the origin is among them.
  double fill(std::size_t seed, std::size_t number, std::vector<std::size_t>& piece) const {
    double area = 0.0;
    std::vector<std::size_t> open{seed};
    piece[seed] = number;
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      area += holds_origin(panel_.triangles[i]) ? std::numeric_limits<double>::infinity()
                                                : twice_area(panel_.points, panel_.triangles[i]);
      for (const int n : panel_.neighbours[i]) {
        const auto k = static_cast<std::size_t>(n);
        if (n < 0 || !kept_[k] || piece[k] != 0) continue;
        piece[k] = number;
        open.push_back(k);
      }
    }
    return area;
  }

  [[nodiscard]] bool holds_origin(const std::array<int, 3>& t) const {
    const auto corner = [&](std::size_t i) { return panel_.points[static_cast<std::size_t>(t[i])]; };
    const Vector2 origin = Vector2::Zero();
    return orientation(corner(0), corner(1), origin) >= 0 && orientation(corner(1), corner(2), origin) >= 0 &&
           orientation(corner(2), corner(0), origin) >= 0;
  }

  /// Of triangles that overlap on the seen side, those with the most overlaps go first: a single wild sample stretches
  /// its own triangles over many good ones.
  void leave_out_overlaps() {
    std::vector<std::array<int, 3>> triangles;
    std::vector<std::size_t> number;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (!kept_[i]) continue;
      triangles.push_back(panel_.triangles[i]);
      number.push_back(i);
    }
    const std::size_t hopeless = 1000 + 50 * triangles.size();  // then the map folds everywhere, not here and there
    const auto pairs = overlapping_pairs(seen_, triangles, hopeless);
    if (pairs.size() >= hopeless) {
      kept_.assign(kept_.size(), false);
      return;
    }
    for (const std::size_t i : fewest_to_remove(pairs, triangles.size())) leave_out(number[i]);
  }

  const Triangulation& panel_;
  const std::vector<Vector2>& seen_;
  std::vector<bool> kept_;
  std::vector<std::size_t> folds_;
};

}  // namespace holdfast::detail
