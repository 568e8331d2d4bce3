/// A mesh over the picture that the eye sees through the lens: for experiments, which compare what is seen with the
/// real world.
///
/// Where PredistortionMesh lies over the panel, this lies over the seen picture (an ideal picture of the eye, its own
/// field and resolution). Each vertex knows, per colour, the place of the panel that is seen there, which gives the
/// line that lights it, and the tangent t_E of the ideal point that this place shows in the given LensMode. Both are
/// fixed for an eye and a mode: make it once. The matrices of a frame (SourceMatrices) do the rest, as for the panel:
///
///     const WarpMesh seen(context, seen_mesh(eye, mode));     // once per eye and mode
///     late_warp_pass.draw(picture, seen, H_SE, timing, result);  // each frame; `result` is what the eye sees
///
/// The definition that it approximates is ComposedWarp::source_pixel_seen, black beyond the panel's edge.
/// Units: places 0 to 1 from the lower left, tangents of field angle. Bad input: a cell with a corner that the lens
/// cannot show is left out; fewer than 1 x 1 cells is a programmer's error.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <holdfast/optics/eye.hpp>

namespace holdfast::rendering {

struct SeenVertex {
  float seen_x = 0, seen_y = 0;
  float tangent[3][2] = {};  ///< t_E shown there in red, green, blue
  float panel[3][2] = {};    ///< where on the panel red, green, blue come from; off the panel beyond 0 to 1
};

struct SeenMesh {
  std::vector<SeenVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices each
  bool per_colour = false;               ///< red or blue are bent otherwise than green
  PixelSize resolution;                  ///< of the seen picture
};

namespace detail {

/// Nothing when the lens cannot show a colour there.
[[nodiscard]] inline std::optional<SeenVertex> seen_vertex(const EyeModel& eye, LensMode mode, const Vector2& place) {
  const Vector2 size(eye.resolution.width, eye.resolution.height);
  const Vector2 seen = tangent_of_pixel(eye, place.cwiseProduct(size));
  SeenVertex vertex{static_cast<float>(place.x()), static_cast<float>(place.y())};
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    const Lens& lens = eye.lens_of(color);
    const std::optional<Vector2> panel = mode == LensMode::none ? seen : lens.undistort(seen);
    const std::optional<Vector2> ideal = panel ? ideal_tangent(lens, mode, seen) : std::nullopt;
    if (!ideal) return std::nullopt;
    const Vector2 at = pixel_of_tangent(eye, *panel).cwiseQuotient(size);
    const auto c = static_cast<std::size_t>(color);
    for (const int axis : {0, 1}) {
      vertex.tangent[c][axis] = static_cast<float>((*ideal)[axis]);
      vertex.panel[c][axis] = static_cast<float>(at[axis]);
    }
  }
  return vertex;
}

}  // namespace detail

/// Cells of equal size; places beyond the panel are in it, and left black when it is drawn.
[[nodiscard]] inline SeenMesh seen_mesh(const EyeModel& eye, LensMode mode, int columns, int rows) {
  HOLDFAST_ASSERT(columns >= 1 && rows >= 1, "a mesh has at least one cell");
  constexpr std::uint32_t none = 0xffffffff;
  SeenMesh mesh;
  mesh.resolution = eye.resolution;
  mesh.per_colour = mode != LensMode::none && (eye.lens_red || eye.lens_blue);
  std::vector<std::uint32_t> number;
  for (int y = 0; y <= rows; ++y) {
    for (int x = 0; x <= columns; ++x) {
      const auto vertex = detail::seen_vertex(eye, mode, Vector2(double(x) / columns, double(y) / rows));
      number.push_back(vertex ? static_cast<std::uint32_t>(mesh.vertices.size()) : none);
      if (vertex) mesh.vertices.push_back(*vertex);
    }
  }
  const auto stride = static_cast<std::size_t>(columns) + 1;
  for (std::size_t y = 0; y < static_cast<std::size_t>(rows); ++y) {
    for (std::size_t x = 0; x + 1 < stride; ++x) {
      const std::size_t at = y * stride + x;
      const std::array corners{number[at], number[at + 1], number[at + stride + 1], number[at + stride]};
      for (const auto& t : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
        const std::array triangle{corners[std::size_t(t[0])], corners[std::size_t(t[1])], corners[std::size_t(t[2])]};
        if (triangle[0] == none || triangle[1] == none || triangle[2] == none) continue;
        mesh.triangles.insert(mesh.triangles.end(), triangle.begin(), triangle.end());
      }
    }
  }
  return mesh;
}

/// Without a lens or with exact correction t_E is the tangent seen, which cells of 16 pixels give exactly, and the lines
/// to 1e-4 of their number; else t_E bends, and cells are of 4 pixels, which costs time to draw.
[[nodiscard]] inline SeenMesh seen_mesh(const EyeModel& eye, LensMode mode) {
  const int cell_px = mode == LensMode::none || mode == LensMode::exact ? 16 : 4;
  const auto cells = [&](int pixels) { return (pixels + cell_px - 1) / cell_px; };
  return seen_mesh(eye, mode, cells(eye.resolution.width), cells(eye.resolution.height));
}

}  // namespace holdfast::rendering
