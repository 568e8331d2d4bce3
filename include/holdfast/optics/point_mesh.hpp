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
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/geometry/delaunay.hpp>
#include <holdfast/geometry/triangle_grid.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/detail/one_to_one_triangles.hpp>

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

/// d seen / d panel on the triangle t.
[[nodiscard]] inline Matrix2 triangle_jacobian(const std::vector<Vector2>& panel, const std::vector<Vector2>& seen,
                                               const std::array<int, 3>& t) {
  const auto edges = [&](const std::vector<Vector2>& p) {
    const Vector2& a = p[static_cast<std::size_t>(t[0])];
    Matrix2 m;
    m.col(0) = p[static_cast<std::size_t>(t[1])] - a;
    m.col(1) = p[static_cast<std::size_t>(t[2])] - a;
    return m;
  };
  return edges(seen) * Matrix2(edges(panel).inverse());
}

/// Fills in all but the samples.
inline void fill_point_mesh(PointMesh& mesh, const Triangulation& joined, const std::vector<Vector2>& seen) {
  const OneToOneTriangles triangles(joined, seen);
  for (const std::size_t i : triangles.folds()) {
    const std::array<int, 3>& t = joined.triangles[i];
    mesh.folds.push_back({t, twice_area(seen, t) / twice_area(joined.points, t)});
  }
  constexpr double least_share = 0.05;  // a map in disorder keeps a little by chance
  if (triangles.kept_share() < least_share) return;
  for (std::size_t i = 0; i < joined.triangles.size(); ++i) {
    if (!triangles.kept()[i]) continue;
    mesh.triangles.push_back(joined.triangles[i]);
    mesh.jacobians.push_back(triangle_jacobian(joined.points, seen, joined.triangles[i]));
  }
  mesh.panel_grid = TriangleGrid(joined.points, mesh.triangles);
  mesh.seen_grid = TriangleGrid(seen, mesh.triangles);
  if (mesh.panel_grid.find(Vector2::Zero())) mesh.panel_radius = triangles.radius(joined.points);
  if (mesh.seen_grid.find(Vector2::Zero())) mesh.seen_radius = triangles.radius(seen);
}

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
  detail::fill_point_mesh(*mesh, joined.mesh, seen);
  if (mesh->triangles.empty()) {
    result.problem = PointMeshProblem::folded;
  } else {
    result.mesh = std::move(mesh);
  }
  return result;
}

}  // namespace holdfast
