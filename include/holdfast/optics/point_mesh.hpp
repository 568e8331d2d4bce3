/// A lens given by samples: pairs of a panel point and the direction in which it is seen, joined to triangles.
///
/// OSVR's unstructured meshes (mono_point_samples, rgb_point_samples: [[screen], [canonical]]) and ray-traced lenses
/// come like this. The panel points are joined by a Delaunay triangulation, and each triangle is mapped linearly: a
/// point has its value from the triangle round it, never from the three nearest samples (which tears the picture). The
/// map is kept one-to-one: triangles that are mirrored or flat on the seen side (folds), pieces cut off by them, and
/// those that then still overlap others there, are left out and reported. Slivers along the convex hull, flatter than 1:500, are rounding of
/// the samples and are left out silently. Unit: any, the same on both sides. Bad input: PointMeshResult names it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/geometry/delaunay.hpp>
#include <holdfast/geometry/triangle_grid.hpp>
#include <holdfast/geometry/triangle_overlap.hpp>
#include <holdfast/geometry/types.hpp>

namespace holdfast {

struct PointMeshSample {
  Vector2 panel;  ///< OSVR: screen
  Vector2 seen;   ///< OSVR: canonical

  friend bool operator==(const PointMeshSample&, const PointMeshSample&) = default;
};

/// A triangle of samples that is left out.
struct PointMeshFold {
  std::array<int, 3> samples{};
  double area_ratio =
      0.0;  ///< seen area over panel area; not positive: folded, else cut off by folds or overlapping others
};

enum class PointMeshProblem {
  none,
  too_few_samples,
  not_finite,
  duplicate_panel_point,
  collinear,
  folded,  ///< less than a twentieth remains: mirrored, flat, or in disorder
};

[[nodiscard]] constexpr std::string_view describe(PointMeshProblem problem) {
  switch (problem) {
    case PointMeshProblem::none:
      return "the samples make a mesh";
    case PointMeshProblem::too_few_samples:
      return "fewer than three samples";
    case PointMeshProblem::not_finite:
      return "a sample is not finite, or beyond 1e6";
    case PointMeshProblem::duplicate_panel_point:
      return "two samples have the same panel point";
    case PointMeshProblem::collinear:
      return "all panel points lie on one line";
    case PointMeshProblem::folded:
      return "the samples fold over or mirror nearly everywhere";
  }
  return "unknown problem";
}

/// The prepared mesh, which lenses share.
struct PointMesh {
  std::vector<PointMeshSample> samples;
  std::vector<std::array<int, 3>> triangles;  ///< those kept
  std::vector<Matrix2> jacobians;             ///< d seen / d panel of each
  std::vector<PointMeshFold> folds;           ///< those left out
  TriangleGrid panel_grid;
  TriangleGrid seen_grid;
  double panel_radius = 0.0;  ///< largest disc round the origin inside the triangles; 0: the origin is outside
  double seen_radius = 0.0;   ///< largest disc round the origin inside their images
};

struct PointMeshResult {
  std::shared_ptr<const PointMesh> mesh;
  PointMeshProblem problem = PointMeshProblem::none;
  std::size_t sample = 0;        ///< the sample that is the problem
  std::size_t other_sample = 0;  ///< the one that it duplicates

  [[nodiscard]] bool ok() const { return problem == PointMeshProblem::none; }
};

namespace detail {

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

class PointMeshBuilder {
 public:
  PointMeshBuilder(const Triangulation& panel, const std::vector<Vector2>& seen)
      : panel_(panel), seen_(seen), kept_(panel.triangles.size(), true) {}

  void build(PointMesh& mesh) {
    leave_out_border_slivers();
    leave_out_folds(mesh);
    leave_out_islands(mesh);
    leave_out_overlaps(mesh);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (!kept_[i]) continue;
      mesh.triangles.push_back(panel_.triangles[i]);
      mesh.jacobians.push_back(jacobian(panel_.triangles[i]));
    }
    if (kept_share() < 0.05) mesh.triangles.clear();
    if (mesh.triangles.empty()) return;
    mesh.panel_grid = TriangleGrid(panel_.points, mesh.triangles);
    mesh.seen_grid = TriangleGrid(seen_, mesh.triangles);
    mesh.panel_radius = radius(panel_.points, mesh.panel_grid);
    mesh.seen_radius = radius(seen_, mesh.seen_grid);
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

  /// Of the area of all triangles.
  [[nodiscard]] double kept_share() const {
    double all = 0.0, kept = 0.0;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const double area = twice_area(panel_.points, panel_.triangles[i]);
      all += area;
      if (kept_[i]) kept += area;
    }
    return kept / all;
  }

  void leave_out(std::size_t i, PointMesh& mesh) {
    const std::array<int, 3>& t = panel_.triangles[i];
    kept_[i] = false;
    mesh.folds.push_back({t, twice_area(seen_, t) / twice_area(panel_.points, t)});
  }

  void leave_out_folds(PointMesh& mesh) {
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const std::array<int, 3>& t = panel_.triangles[i];
      const bool good = flatness(seen_, t) > flat && flatness(panel_.points, t) > flat;
      if (kept_[i] && !good) leave_out(i, mesh);
    }
  }

  /// Beyond a fold the map may turn round again: only the piece that holds the origin is kept, or else the largest.
  void leave_out_islands(PointMesh& mesh) {
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
      if (kept_[i] && piece[i] != best) leave_out(i, mesh);
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
  void leave_out_overlaps(PointMesh& mesh) {
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
    for (const std::size_t i : fewest_to_remove(pairs, triangles.size())) leave_out(number[i], mesh);
  }

  [[nodiscard]] Matrix2 jacobian(const std::array<int, 3>& t) const {
    const auto edges = [&](const std::vector<Vector2>& p) {
      const Vector2& a = p[static_cast<std::size_t>(t[0])];
      Matrix2 m;
      m.col(0) = p[static_cast<std::size_t>(t[1])] - a;
      m.col(1) = p[static_cast<std::size_t>(t[2])] - a;
      return m;
    };
    return edges(seen_) * Matrix2(edges(panel_.points).inverse());
  }

  /// Distance of the origin from the border of the kept triangles, whose corners are `p`.
  [[nodiscard]] double radius(const std::vector<Vector2>& p, const TriangleGrid& grid) const {
    if (!grid.find(Vector2::Zero())) return 0.0;
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

  const Triangulation& panel_;
  const std::vector<Vector2>& seen_;
  std::vector<bool> kept_;
};

[[nodiscard]] inline PointMeshProblem problem_of(DelaunayProblem problem) {
  switch (problem) {
    case DelaunayProblem::too_few_points:
      return PointMeshProblem::too_few_samples;
    case DelaunayProblem::duplicate_point:
      return PointMeshProblem::duplicate_panel_point;
    case DelaunayProblem::collinear:
      return PointMeshProblem::collinear;
    case DelaunayProblem::not_finite:
    case DelaunayProblem::none:
      break;
  }
  return PointMeshProblem::not_finite;
}

}  // namespace detail

[[nodiscard]] inline PointMeshResult make_point_mesh(std::vector<PointMeshSample> samples) {
  PointMeshResult result;
  std::vector<Vector2> panel, seen;
  for (const PointMeshSample& s : samples) {
    const double largest =
        std::max({std::abs(s.panel.x()), std::abs(s.panel.y()), std::abs(s.seen.x()), std::abs(s.seen.y())});
    if (!(largest <= 1e6) || !s.panel.allFinite() || !s.seen.allFinite()) {
      result.problem = PointMeshProblem::not_finite;
      result.sample = panel.size();
      return result;
    }
    panel.push_back(s.panel);
    seen.push_back(s.seen);
  }
  const DelaunayResult joined = delaunay(panel);
  if (!joined.ok()) {
    result.problem = detail::problem_of(joined.problem);
    result.sample = joined.point;
    result.other_sample = joined.other_point;
    return result;
  }
  auto mesh = std::make_shared<PointMesh>();
  mesh->samples = std::move(samples);
  detail::PointMeshBuilder(joined.mesh, seen).build(*mesh);
  if (mesh->triangles.empty()) {
    result.problem = PointMeshProblem::folded;
  } else {
    result.mesh = std::move(mesh);
  }
  return result;
}

}  // namespace holdfast
