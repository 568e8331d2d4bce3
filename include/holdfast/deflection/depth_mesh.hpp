/// Depth deflection forward: the depth image as a mesh, each vertex drawn where the late eye sees it.
///
/// A vertex per pixel of the depth image (those of the border moved out to the picture's edges). Its point, at its
/// own distance, is seen by the displayed eye on the line on which it lights, and drawn through the lens at a panel
/// point: ComposedWarp::panel_pixel with a depth. Two triangles per four vertices. Where the surface goes on they are
/// solid; where an edge cuts it (DepthSurface) they bridge from the nearer thing to the farther: such a triangle shows
/// right colours as long as it keeps its size, and is stretched over what was hidden when things come apart. Draw all
/// with a depth test that lets the greater `nearness` win; bridges that turned their back are hidden by what moved over
/// them, and are left out. Source coordinates are homogeneous: interpolate linearly, divide per fragment.
/// Sources: Mark, McMillan & Bishop 1997. Memory is taken when made or when the depth image grows, not per frame.
/// Bad input: vertices that the panel cannot show (behind the eye, outside the lens's domain) leave their triangles out.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/deflection/composed_warp.hpp>

namespace holdfast {

struct DepthVertex {
  float panel_x = 0.0f, panel_y = 0.0f;  ///< 0 to 1 of the eye's panel picture, origin at the lower left
  float nearness = 0.0f;                 ///< inverse distance from the displayed eye along -Z_E, 1/m; 0: infinitely far
  float source[3] = {};                  ///< homogeneous source coordinates (u, v, w); w > 0, and 0: not drawn
};

class DepthMesh {
 public:
  /// A bridge counts as stretched when it covers more than this many times the tangent area that it has in the source.
  explicit DepthMesh(double stretch_limit = 2.0) : stretch_limit_(stretch_limit) {}

  /// Draws the warp's depth surface for one colour. Precondition: the warp is by depth.
  void update(const ComposedWarp& warp, Color color = Color::green) {
    HOLDFAST_ASSERT(warp.depth() != nullptr, "a depth mesh needs a warp by depth");
    const DepthSurface& surface = warp.depth()->surface();
    size_ = surface.size();
    const std::size_t count = static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height);
    vertices_.resize(count);
    tangents_.resize(count);
    solid_.reserve(6 * count);
    bridges_.reserve(6 * count);
    disoccluded_.reserve(6 * count);
    for (std::vector<std::uint32_t>* list : {&solid_, &bridges_, &disoccluded_}) list->clear();
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) place_vertex(warp, surface, x, y, color);
    }
    for (int y = 0; y + 1 < size_.height; ++y) {
      for (int x = 0; x + 1 < size_.width; ++x) add_cell(surface, x, y);
    }
  }

  [[nodiscard]] const std::vector<DepthVertex>& vertices() const { return vertices_; }
  /// Indices of three vertices each, counter-clockwise on a panel mounted upright.
  [[nodiscard]] const std::vector<std::uint32_t>& solid() const { return solid_; }
  [[nodiscard]] const std::vector<std::uint32_t>& bridges() const { return bridges_; }  ///< over edges, not stretched
  [[nodiscard]] const std::vector<std::uint32_t>& disoccluded() const {
    return disoccluded_;
  }  ///< stretched over edges

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
  }

  /// Coordinate of the i-th of n vertices: pixel centres, the outermost moved out to the edges.
  [[nodiscard]] static double place(int i, int n) { return i == 0 ? 0.0 : i == n - 1 ? double(n) : i + 0.5; }

  void place_vertex(const ComposedWarp& warp, const DepthSurface& surface, int x, int y, Color color) {
    const Vector2 depth_pixel(place(x, size_.width), place(y, size_.height));
    const Vector2 t_S = surface.tangent_of_pixel(depth_pixel);
    DepthVertex& vertex = vertices_[index(x, y)] = {};
    const std::optional<Vector2> panel = warp.panel_pixel(source_pixel_of_tangent(warp.view(), t_S), color);
    if (!panel) return;
    const double w = surface.w_at(t_S);
    const Rigid X_SE = warp.depth()->X_SE().at(warp.line_fraction(*panel));
    const Vector3 from_E = DepthSearch::seen_from_E(X_SE, t_S, w);  // w times the position, when w > 0
    const double ahead = -from_E.z();
    if (!(ahead > 0.0)) return;
    tangents_[index(x, y)] = {Vector2(from_E.x() / ahead, from_E.y() / ahead), t_S};
    vertex.panel_x = static_cast<float>(panel->x() / warp.eye().resolution.width);
    vertex.panel_y = static_cast<float>(panel->y() / warp.eye().resolution.height);
    vertex.nearness = static_cast<float>(w / ahead);
    vertex.source[0] = static_cast<float>(depth_pixel.x() / size_.width / ahead);
    vertex.source[1] = static_cast<float>(depth_pixel.y() / size_.height / ahead);
    vertex.source[2] = static_cast<float>(1.0 / ahead);
  }

  void add_cell(const DepthSurface& surface, int x, int y) {
    const bool bottom = surface.linked_right(x, y), top = surface.linked_right(x, y + 1);
    const bool left = surface.linked_up(x, y), right = surface.linked_up(x + 1, y);
    const std::uint32_t a = id(x, y), b = id(x + 1, y), c = id(x + 1, y + 1), d = id(x, y + 1);
    // The diagonal is drawn so that a single corner that is cut off takes no more than its own triangle with it.
    if ((bottom && right) || (left && top)) {
      add({a, b, c}, bottom && right);
      add({a, c, d}, left && top);
    } else {
      add({a, b, d}, bottom && left);
      add({b, c, d}, right && top);
    }
  }
  [[nodiscard]] std::uint32_t id(int x, int y) const { return static_cast<std::uint32_t>(index(x, y)); }

  void add(const std::array<std::uint32_t, 3>& corners, bool solid) {
    for (const std::uint32_t corner : corners) {
      if (!(vertices_[corner].source[2] > 0.0f)) return;
    }
    if (solid) {
      solid_.insert(solid_.end(), corners.begin(), corners.end());
      return;
    }
    const double stretch = area(corners, &Tangents::t_E) / area(corners, &Tangents::t_S);
    if (!(stretch > 0.0)) return;  // folded over: what moved in front hides it
    std::vector<std::uint32_t>& list = stretch > stretch_limit_ ? disoccluded_ : bridges_;
    list.insert(list.end(), corners.begin(), corners.end());
  }

  /// Where a vertex is seen by the displayed eye, and by the source eye.
  struct Tangents {
    Vector2 t_E, t_S;
  };

  /// Twice the signed area of a triangle, in tangents.
  [[nodiscard]] double area(const std::array<std::uint32_t, 3>& corners, Vector2 Tangents::*t) const {
    const Vector2 a = tangents_[corners[0]].*t;
    const Vector2 u = tangents_[corners[1]].*t - a, v = tangents_[corners[2]].*t - a;
    return u.x() * v.y() - u.y() * v.x();
  }

  double stretch_limit_;
  PixelSize size_;
  std::vector<DepthVertex> vertices_;
  std::vector<Tangents> tangents_;
  std::vector<std::uint32_t> solid_, bridges_, disoccluded_;
};

}  // namespace holdfast
