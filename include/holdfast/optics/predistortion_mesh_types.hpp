/// What a predistortion mesh is made of, and what is asked of it (predistortion_mesh.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <holdfast/optics/eye.hpp>

namespace holdfast {

struct PredistortionVertex {
  float panel_x = 0.0f, panel_y = 0.0f;  ///< 0 to 1 of the eye's panel picture, origin at the lower left
  float tangent[3][2] = {};              ///< ideal tangent (x, y) that red, green and blue show here

  friend bool operator==(const PredistortionVertex&, const PredistortionVertex&) = default;
};

enum class MeshProblem {
  none,
  no_pixels,                 ///< width or height of the panel is not positive
  impossible_field,          ///< the eye's tangents, or those of the field asked for
  error_bound_out_of_range,  ///< max_error_px is below 0.005 or not finite, or border_error_px not in 0.01 to 100
  no_cells,                  ///< columns or rows of a grid not in 1 to 4096
  nothing_visible,           ///< the lens's domain lies outside the panel, or the field outside what the panel shows
  too_many_vertices,         ///< the bound would need more than max_vertices
};

[[nodiscard]] constexpr std::string_view describe(MeshProblem problem) {
  switch (problem) {
    case MeshProblem::none:
      return "the mesh is usable";
    case MeshProblem::no_pixels:
      return "the panel has no pixels: width and height must be positive";
    case MeshProblem::impossible_field:
      return "the field of view is impossible: tangents must be finite and enclose an area";
    case MeshProblem::error_bound_out_of_range:
      return "the error bound is out of range: expected 0.005 px or more, and a border's of 0.01 to 100 px";
    case MeshProblem::no_cells:
      return "a grid needs 1 to 4096 columns and rows";
    case MeshProblem::nothing_visible:
      return "the panel shows nothing of the field: the lens has no domain there";
    case MeshProblem::too_many_vertices:
      return "the error bound needs more vertices than allowed";
  }
  return "unknown problem";
}

struct PredistortionMesh {
  std::vector<PredistortionVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices each, counter-clockwise on the panel
  bool per_color = false;                ///< red or blue differ from green somewhere
  double max_error_px = 0.0;             ///< largest difference from the exact lens, px of the source picture
  PixelSize resolution;                  ///< of the eye's panel
  MeshProblem problem = MeshProblem::none;

  [[nodiscard]] bool ok() const { return problem == MeshProblem::none; }
  [[nodiscard]] std::size_t triangle_count() const { return triangles.size() / 3; }
};

struct EyeMeshes {
  PredistortionMesh left, right;
};

struct AdaptiveMeshOptions {
  double max_error_px = 0.05;
  double border_error_px = 0.1;  ///< how far the drawn border may be from the true one, panel px
  std::optional<FieldTangents> field =
      std::nullopt;  ///< what the source picture holds; nothing: all that the panel shows
  std::size_t max_vertices = 2'000'000;
};

}  // namespace holdfast
