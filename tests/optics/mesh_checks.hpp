// Checks of predistortion meshes, written from the definition: nothing here is shared with what builds them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/optics/predistortion_mesh.hpp>

namespace holdfast::test {

inline Vector2 panel_pixel(const EyeModel& eye, const PredistortionVertex& v) {
  return {static_cast<double>(v.panel_x) * eye.resolution.width,
          static_cast<double>(v.panel_y) * eye.resolution.height};
}
inline Vector2 tangent(const PredistortionVertex& v, std::size_t colour) {
  return {static_cast<double>(v.tangent[colour][0]), static_cast<double>(v.tangent[colour][1])};
}

/// Worst difference, in px of the source picture, between interpolation in the mesh and the exact lens: of each triangle
/// at `tries` random points and the middles of its edges, in every colour.
inline double dense_error_px(const EyeModel& eye, LensMode mode, const PredistortionMesh& mesh, int tries) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Vector2 px = pixels_per_tangent(eye).cwiseAbs();
  double worst = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const PredistortionVertex* corner[3];
    for (std::size_t k = 0; k < 3; ++k) corner[k] = &mesh.vertices[mesh.triangles[t + k]];
    for (int i = 0; i < tries + 3; ++i) {
      double a = i < 3 ? (i == 0 ? 0.0 : 0.5) : uniform(random);
      double b = i < 3 ? (i == 1 ? 0.0 : 0.5) : uniform(random);
      if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
      const double w[3] = {1.0 - a - b, a, b};
      Vector2 at = Vector2::Zero();
      for (std::size_t k = 0; k < 3; ++k) at += w[k] * panel_pixel(eye, *corner[k]);
      for (std::size_t c = 0; c < 3; ++c) {
        const auto exact = ideal_tangent_at_panel(eye.lens_of(static_cast<Color>(c)), mode, tangent_of_pixel(eye, at));
        if (!exact) continue;  // a chord of the border may pass outside by its tolerance
        Vector2 linear = Vector2::Zero();
        for (std::size_t k = 0; k < 3; ++k) linear += w[k] * tangent(*corner[k], c);
        worst = std::max(worst, (linear - *exact).cwiseProduct(px).norm());
      }
    }
  }
  return worst;
}

/// Twice the area of a triangle of the panel in units of 2^-48 of it: exact in whole numbers, positive when
/// counter-clockwise.
inline std::int64_t panel_area(const PredistortionMesh& mesh, std::size_t triangle) {
  std::int64_t x[3], y[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const PredistortionVertex& v = mesh.vertices[mesh.triangles[3 * triangle + k]];
    x[k] = std::llround(std::ldexp(static_cast<double>(v.panel_x), 24));
    y[k] = std::llround(std::ldexp(static_cast<double>(v.panel_y), 24));
  }
  return (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
}

/// Share of the panel that the mesh covers.
inline double covered(const PredistortionMesh& mesh) {
  std::int64_t area = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) area += panel_area(mesh, t);
  return std::ldexp(static_cast<double>(area), -49);
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// The edges that only one triangle has. Fails when an edge is used twice in one direction, or a triangle lies the wrong
/// way round: then the mesh would overlap itself.
inline std::vector<Edge> checked_outline(const PredistortionMesh& mesh) {
  std::map<Edge, int> uses;
  std::size_t wrong_way = 0, twice = 0, unused = 0;
  std::vector<bool> used(mesh.vertices.size(), false);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    wrong_way += panel_area(mesh, t) <= 0 ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[3 * t + k], b = mesh.triangles[3 * t + (k + 1) % 3];
      twice += uses[{a, b}]++ > 0 ? 1 : 0;
      used[a] = true;
    }
  }
  for (const bool is_used : used) unused += is_used ? 0 : 1;
  CHECK(wrong_way == 0);
  CHECK(twice == 0);
  CHECK(unused == 0);
  std::vector<Edge> outline;
  for (const auto& [edge, count] : uses) {
    if (!uses.contains({edge.second, edge.first})) outline.push_back(edge);
  }
  return outline;
}

/// Whether both ends lie on one edge of the panel.
inline bool is_on_rim(const PredistortionMesh& mesh, const Edge& edge) {
  const PredistortionVertex &a = mesh.vertices[edge.first], &b = mesh.vertices[edge.second];
  const auto same_end = [](float p, float q) { return p == q && (p == 0.0f || p == 1.0f); };
  return same_end(a.panel_x, b.panel_x) || same_end(a.panel_y, b.panel_y);
}

/// The outline's edges inside the panel, where the picture ends before the panel does.
inline std::vector<Edge> inner_outline(const PredistortionMesh& mesh) {
  std::vector<Edge> inner;
  for (const Edge& edge : checked_outline(mesh)) {
    if (!is_on_rim(mesh, edge)) inner.push_back(edge);
  }
  return inner;
}

/// Triangles whose picture is turned over.
inline std::size_t folds(const EyeModel& eye, const PredistortionMesh& mesh) {
  const FieldTangents t = panel_tangents(eye);
  const double upright = (t.right - t.left) * (t.up - t.down);
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector2 a = tangent(mesh.vertices[mesh.triangles[i]], c);
      const Vector2 p = tangent(mesh.vertices[mesh.triangles[i + 1]], c) - a;
      const Vector2 q = tangent(mesh.vertices[mesh.triangles[i + 2]], c) - a;
      // Slivers may lose their area to rounding: 2^-24 of a tangent along edges of some px.
      count += (p.x() * q.y() - p.y() * q.x()) * (upright > 0.0 ? 1.0 : -1.0) < -1e-9 ? 1 : 0;
    }
  }
  return count;
}

}  // namespace holdfast::test
