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
/// The definition that it approximates is ComposedWarp::source_pixel_seen, black beyond the panel's edge. Cells are
/// halved where t_E bends, and along the line where the lens folds over or its domain ends: there the mesh ends within
/// a smallest cell. Edges of cells are upright or level, so that cells of different size leave no gap.
/// Units: places 0 to 1 from the lower left, tangents of field angle. Bad input: what the lens cannot show is left out;
/// settings without cells are a programmer's error.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <holdfast/assert.hpp>
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

struct SeenMeshSettings {
  int cell_px = 16;             ///< side of the largest cells
  int halvings = 6;             ///< of a cell's side, at most: down to a quarter pixel
  double max_error_px = 0.005;  ///< of t_E between vertices, in pixels of the seen picture
  double max_line_px = 0.1;     ///< of the place on the panel, which gives the line
};

namespace detail {

/// Nothing when the lens cannot show a colour there.
[[nodiscard]] inline std::optional<SeenVertex> seen_vertex(const EyeModel& eye, LensMode mode, const Vector2& place) {
  const Vector2 size(eye.resolution.width, eye.resolution.height);
  const Vector2 seen = tangent_of_pixel(eye, place.cwiseProduct(size));
  SeenVertex vertex{static_cast<float>(place.x()), static_cast<float>(place.y())};
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    const auto c = static_cast<std::size_t>(color);
    const Lens& lens = eye.lens_of(color);
    if (color != Color::red && &lens == &eye.lens_of(Color::red)) {
      std::copy_n(vertex.tangent[0], 2, vertex.tangent[c]);
      std::copy_n(vertex.panel[0], 2, vertex.panel[c]);
      continue;
    }
    const std::optional<Vector2> panel = mode == LensMode::none ? seen : lens.undistort(seen);
    const std::optional<Vector2> ideal = panel ? ideal_tangent(lens, mode, seen) : std::nullopt;
    if (!ideal) return std::nullopt;
    const Vector2 at = pixel_of_tangent(eye, *panel).cwiseQuotient(size);
    for (const int axis : {0, 1}) {
      vertex.tangent[c][axis] = static_cast<float>((*ideal)[axis]);
      vertex.panel[c][axis] = static_cast<float>(at[axis]);
    }
  }
  return vertex;
}

/// Halves cells; places are counted in smallest cells.
class SeenMesher {
 public:
  SeenMesher(const EyeModel& eye, LensMode mode, const SeenMeshSettings& settings)
      : eye_(eye), mode_(mode), settings_(settings), side_(1 << settings.halvings) {
    const auto cells = [&](int pixels) { return (pixels + settings.cell_px - 1) / settings.cell_px; };
    columns_ = cells(eye.resolution.width);
    rows_ = cells(eye.resolution.height);
    mesh_.resolution = eye.resolution;
    mesh_.per_colour = mode != LensMode::none && (eye.lens_red || eye.lens_blue);
  }

  [[nodiscard]] SeenMesh run() {
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) add(x * side_, y * side_, side_);
    }
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t unused = 0xffffffff;
  struct Known {
    std::optional<SeenVertex> vertex;
    std::uint32_t number = unused;
  };

  [[nodiscard]] Known& at(int x, int y) {
    const auto key = static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint64_t>(x);
    const auto [entry, is_new] = known_.try_emplace(key);
    if (is_new) {
      const Vector2 place(double(x) / (columns_ * side_), double(y) / (rows_ * side_));
      entry->second.vertex = seen_vertex(eye_, mode_, place);
    }
    return entry->second;
  }

  void add(int x, int y, int side) {
    if (side == 1) return add_triangles(x, y, side);
    const int half = side / 2;
    bool all = true, any = false;
    for (const int dy : {0, half, side}) {
      for (const int dx : {0, half, side}) {
        const bool is_seen = at(x + dx, y + dy).vertex.has_value();
        all = all && is_seen;
        any = any || is_seen;
      }
    }
    if (!any) return;
    if (all && is_flat(x, y, side)) return add_triangles(x, y, side);
    for (const int dy : {0, half}) {
      for (const int dx : {0, half}) add(x + dx, y + dy, half);
    }
  }

  /// Whether the middle and the edges' middles lie where the two triangles have them.
  [[nodiscard]] bool is_flat(int x, int y, int side) {
    return is_between(x, y, side, side) && is_between(x, y, side, 0) && is_between(x, y, 0, side) &&
           is_between(x + side, y, 0, side) && is_between(x, y + side, side, 0);
  }
  [[nodiscard]] bool is_between(int x, int y, int dx, int dy) {
    const SeenVertex &a = *at(x, y).vertex, &b = *at(x + dx, y + dy).vertex, &m = *at(x + dx / 2, y + dy / 2).vertex;
    const Vector2 size(eye_.resolution.width, eye_.resolution.height), scale = pixels_per_tangent(eye_);
    for (int c = 0; c < 3; ++c) {
      for (int axis = 0; axis < 2; ++axis) {
        const double tangent = m.tangent[c][axis] - 0.5 * (double(a.tangent[c][axis]) + b.tangent[c][axis]);
        const double panel = m.panel[c][axis] - 0.5 * (double(a.panel[c][axis]) + b.panel[c][axis]);
        if (!(std::abs(tangent) * scale[axis] <= settings_.max_error_px)) return false;
        if (!(std::abs(panel) * size[axis] <= settings_.max_line_px)) return false;
      }
    }
    return true;
  }

  /// Those whose corners are seen.
  void add_triangles(int x, int y, int side) {
    const std::array corners{&at(x, y), &at(x + side, y), &at(x + side, y + side), &at(x, y + side)};
    for (const auto& t : {std::array{0u, 1u, 2u}, std::array{0u, 2u, 3u}}) {
      const auto is_seen = [&](std::size_t i) { return corners[i]->vertex.has_value(); };
      if (!std::all_of(t.begin(), t.end(), is_seen)) continue;
      for (const std::size_t i : t) {
        Known& corner = *corners[i];
        if (corner.number == unused) {
          corner.number = static_cast<std::uint32_t>(mesh_.vertices.size());
          mesh_.vertices.push_back(*corner.vertex);
        }
        mesh_.triangles.push_back(corner.number);
      }
    }
  }

  const EyeModel& eye_;
  LensMode mode_;
  SeenMeshSettings settings_;
  int side_, columns_ = 0, rows_ = 0;
  std::unordered_map<std::uint64_t, Known> known_;  // its values keep their place
  SeenMesh mesh_;
};

}  // namespace detail

/// Places beyond the panel are in it, and left black when it is drawn.
[[nodiscard]] inline SeenMesh seen_mesh(const EyeModel& eye, LensMode mode, const SeenMeshSettings& settings = {}) {
  HOLDFAST_ASSERT(settings.cell_px >= 1 && settings.halvings >= 0 && settings.halvings <= 12, "a mesh has cells");
  return detail::SeenMesher(eye, mode, settings).run();
}

}  // namespace holdfast::rendering
