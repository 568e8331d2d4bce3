/// Overfill (overfill.hpp) of what an eye's panel shows through its lens, and of a display that scans.
///
/// What the panel shows is no rectangle: the overfill of its outline is smaller than that of the rectangle round it.
/// A rolling display deflects the lines that light last the farthest; each line then asks only for its own budget.
/// Both are as true as the mesh: to its max_error_px. Bad input: a mesh without vertices has no width.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <holdfast/optics/overfill.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

namespace detail {

/// Corners of the convex hull (Andrew's monotone chain): what is linear is largest at one of them.
[[nodiscard]] inline std::vector<Vector2> convex_hull(std::vector<Vector2> points) {
  const auto before = [](const Vector2& a, const Vector2& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), before);
  if (points.size() < 3) return points;
  std::vector<Vector2> hull;
  const auto add = [&](const Vector2& p, std::size_t kept) {
    const auto turns_left = [&] {
      const Vector2 a = hull[hull.size() - 1] - hull[hull.size() - 2], b = p - hull[hull.size() - 2];
      return a.x() * b.y() - a.y() * b.x() > 0.0;
    };
    while (hull.size() > kept && !turns_left()) hull.pop_back();
    hull.push_back(p);
  };
  for (const Vector2& p : points) add(p, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();
  return hull;
}

/// The tangents that a mesh's vertices show, in bands of the line fraction at which they light.
[[nodiscard]] inline std::vector<std::vector<Vector2>> shown_in_bands(const PredistortionMesh& mesh,
                                                                      ScanDirection direction, std::size_t bands) {
  std::vector<std::vector<Vector2>> shown(bands);
  for (const PredistortionVertex& v : mesh.vertices) {
    const Vector2 at(static_cast<double>(v.panel_x), static_cast<double>(v.panel_y));
    const double line = line_fraction_of_pixel(direction, at, Vector2(1.0, 1.0));
    const auto band = static_cast<std::size_t>(std::clamp(line, 0.0, 1.0) * static_cast<double>(bands));
    for (std::size_t c = mesh.per_color ? 0 : 1; c < (mesh.per_color ? 3u : 2u); ++c) {
      shown[std::min(band, bands - 1)].emplace_back(static_cast<double>(v.tangent[c][0]),
                                                    static_cast<double>(v.tangent[c][1]));
    }
  }
  for (auto& points : shown) points = convex_hull(std::move(points));
  return shown;
}

[[nodiscard]] inline DeflectionBudget larger_within(const DeflectionBudget& first, const DeflectionBudget& last,
                                                    double begin, double end) {
  const auto larger = [&](double a, double b) { return std::max(a + (b - a) * begin, a + (b - a) * end); };
  const auto angle = [&](Angle a, Angle b) { return radians(larger(a.radians(), b.radians())); };
  return {angle(first.yaw, last.yaw), angle(first.pitch, last.pitch), angle(first.roll, last.roll),
          larger(first.translation_m, last.translation_m), std::min(first.nearest_m, last.nearest_m)};
}

}  // namespace detail

/// The smallest field that holds what the panel shows, in all colours.
[[nodiscard]] inline FieldResult shown_field(const PredistortionMesh& mesh) {
  return overfilled_points(detail::shown_in_bands(mesh, ScanDirection::top_to_bottom, 1).front(), {});
}

/// The smallest field that holds what the panel shows wherever the budget takes it.
[[nodiscard]] inline FieldResult overfilled(const PredistortionMesh& mesh, const DeflectionBudget& budget) {
  return overfilled_points(detail::shown_in_bands(mesh, ScanDirection::top_to_bottom, 1).front(), budget);
}

/// The same for a rolling display, whose budget goes from `first` to `last` along its lines. Taken in 64 bands of
/// lines, each with the larger of the budgets at its two ends.
[[nodiscard]] inline FieldResult overfilled(const PredistortionMesh& mesh, const DeflectionBudget& first,
                                            const DeflectionBudget& last, ScanDirection direction) {
  constexpr std::size_t bands = 64;
  FieldResult all{{}, FieldProblem::zero_width};
  const auto shown = detail::shown_in_bands(mesh, direction, bands);
  for (std::size_t i = 0; i < bands; ++i) {
    if (shown[i].empty()) continue;
    const double begin = static_cast<double>(i) / bands, end = static_cast<double>(i + 1) / bands;
    const FieldResult band = overfilled_points(shown[i], detail::larger_within(first, last, begin, end));
    if (!band.ok()) return band;
    const FieldTangents &a = all.tangents, &b = band.tangents;
    all = all.ok() ? FieldResult{{std::min(a.left, b.left), std::max(a.right, b.right), std::min(a.down, b.down),
                                  std::max(a.up, b.up)}}
                   : band;
  }
  return all;
}

}  // namespace holdfast
