/// The lens's mesh with the late correction in its vertices: what an engine draws that has no shader of ours.
///
/// Each vertex of a PredistortionMesh gets homogeneous source texture coordinates per colour, (u, v, w) = M(s) (t_E, 1)
/// with s the line fraction of the vertex. Draw the triangles at (panel_x, panel_y), let the hardware interpolate
/// (u, v, w) linearly, and look the source picture up at (u / w, v / w), nothing where w <= 0. On a global display this
/// adds no error to the mesh's own, however large its triangles: (u, v, w) is linear in the tangents. On a rolling one
/// s changes inside a triangle too: the error grows with the square of the triangles' size, and with the turn during
/// the scan; scan_error_px tells it, and a grid of 32 x 32 cells keeps it near 0.01 px at 200 deg/s. Zero motion gives
/// the mesh of no deflection, to the last bit. Nothing is allocated per frame. Bad input: an empty mesh stays empty.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include <holdfast/assert.hpp>
#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>

namespace holdfast {

struct DeflectedVertex {
  float panel_x = 0.0f, panel_y = 0.0f;  ///< 0 to 1 of the eye's panel picture, origin at the lower left
  float source[3][3] = {};               ///< homogeneous source coordinates (u, v, w) for red, green and blue

  friend bool operator==(const DeflectedVertex&, const DeflectedVertex&) = default;
};

/// The matrix of a vertex's line; M holds a SourceMatrices' begin, middle and end.
[[nodiscard]] inline Matrix3 source_matrix_at(const PredistortionVertex& vertex, const ScanHomography& M,
                                              const Vector3& line_coefficients) {
  return M.at(line_coefficients.dot(Vector3(double(vertex.panel_x), double(vertex.panel_y), 1.0)));
}

/// Fills `out` with one vertex for each of the mesh's; its triangles stay as they are. Precondition: equal lengths.
inline void deflect_mesh(const PredistortionMesh& mesh, const SourceMatrices& M, const DisplayTiming& timing,
                         std::span<DeflectedVertex> out) {
  HOLDFAST_ASSERT(out.size() == mesh.vertices.size(), "one deflected vertex for each of the mesh's");
  const Vector3 line = line_fraction_coefficients(timing);
  const ScanHomography source_of_tangent(M);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const PredistortionVertex& vertex = mesh.vertices[i];
    const Matrix3 M_line = source_matrix_at(vertex, source_of_tangent, line);
    out[i].panel_x = vertex.panel_x;
    out[i].panel_y = vertex.panel_y;
    for (int color = 0; color < 3; ++color) {
      const float* t = vertex.tangent[color];
      const Vector3 source = M_line * Vector3(double(t[0]), double(t[1]), 1.0);
      for (int k = 0; k < 3; ++k) out[i].source[color][k] = static_cast<float>(source[k]);
    }
  }
}

/// How far a rolling scan-out puts the deflected mesh off, in source pixels: the largest difference, at the middles of
/// the triangles' edges, between the interpolated coordinates and those of the middle's own line (for green).
[[nodiscard]] inline double scan_error_px(const PredistortionMesh& mesh, const SourceMatrices& M,
                                          const DisplayTiming& timing, const PixelSize& source) {
  const Vector3 line = line_fraction_coefficients(timing);
  const ScanHomography source_of_tangent(M);
  const auto source_of = [&](const PredistortionVertex& vertex) {
    const float* t = vertex.tangent[1];
    return Vector3(source_matrix_at(vertex, source_of_tangent, line) * Vector3(double(t[0]), double(t[1]), 1.0));
  };
  const auto pixel = [&](const Vector3& uvw) {
    return Vector2(uvw.x() / uvw.z() * source.width, uvw.y() / uvw.z() * source.height);
  };
  double worst = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const PredistortionVertex& a = mesh.vertices[mesh.triangles[i]];
    const PredistortionVertex& b = mesh.vertices[mesh.triangles[next]];
    PredistortionVertex middle;
    middle.panel_x = 0.5f * (a.panel_x + b.panel_x);
    middle.panel_y = 0.5f * (a.panel_y + b.panel_y);
    for (int k = 0; k < 2; ++k) middle.tangent[1][k] = 0.5f * (a.tangent[1][k] + b.tangent[1][k]);
    const Vector3 drawn = source_of(a) + source_of(b);
    const Vector3 exact = source_of(middle);
    if (drawn.z() > 0.0 && exact.z() > 0.0) worst = std::max(worst, (pixel(drawn) - pixel(exact)).norm());
  }
  return worst;
}

}  // namespace holdfast
