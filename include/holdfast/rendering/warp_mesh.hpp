/// A mesh of an eye in GPU memory, for LateWarpPass and DepthWarpPass: over the panel's picture (PredistortionMesh) or
/// over the picture that the eye sees (SeenMesh).
///
/// Upload it once; a frame changes matrices only. A display that lights line by line bends the warp within a triangle,
/// of which interpolation knows nothing: edges longer than `longest_edge` of the panel are therefore halved, on both
/// sides alike, so that no gap opens. At 1/32, a turn of 200 deg/s during 11.1 ms leaves about 0.01 px of 1280
/// (scan_error_px in deflection/deflected_mesh.hpp tells it). Bad input: an empty mesh, or one that names vertices it
/// has not, or whose vertices are not finite or not on the panel, throws RenderingError.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <holdfast/optics/predistortion_mesh.hpp>
#include <holdfast/rendering/seen_mesh.hpp>
#include <holdfast/rendering/triangle_buffers.hpp>

namespace holdfast::rendering {

namespace detail {

[[nodiscard]] inline PredistortionVertex middle_of(const PredistortionVertex& a, const PredistortionVertex& b) {
  PredistortionVertex m;
  m.panel_x = 0.5f * (a.panel_x + b.panel_x);
  m.panel_y = 0.5f * (a.panel_y + b.panel_y);
  for (int c = 0; c < 3; ++c) {
    for (int axis = 0; axis < 2; ++axis) m.tangent[c][axis] = 0.5f * (a.tangent[c][axis] + b.tangent[c][axis]);
  }
  return m;
}

/// Halves all edges that are longer than `longest` in x or y, over and over: the same surface in smaller triangles.
inline void split_long_edges(std::vector<PredistortionVertex>& vertices, std::vector<std::uint32_t>& triangles,
                             float longest) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto is_long = [&](std::uint32_t a, std::uint32_t b) {
    return std::max(std::abs(vertices[a].panel_x - vertices[b].panel_x),
                    std::abs(vertices[a].panel_y - vertices[b].panel_y)) > longest;
  };
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [known, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices.size()));
    if (is_new) vertices.push_back(middle_of(vertices[a], vertices[b]));
    return known->second;
  };
  std::vector<std::uint32_t> done;
  std::vector<std::array<std::uint32_t, 3>> open;
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
    open.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
  while (!open.empty()) {
    auto t = open.back();
    open.pop_back();
    // Turned so that long edges come first: a-b, then b-c, then c-a.
    const auto count = int{is_long(t[0], t[1])} + int{is_long(t[1], t[2])} + int{is_long(t[2], t[0])};
    if (count == 0) {
      done.insert(done.end(), t.begin(), t.end());
      continue;
    }
    while (!is_long(t[0], t[1]) || (count == 2 && !is_long(t[1], t[2]))) std::rotate(t.begin(), t.begin() + 1, t.end());
    const auto [a, b, c] = t;
    const std::uint32_t ab = middle(a, b);
    if (count == 1) {
      open.insert(open.end(), {{a, ab, c}, {ab, b, c}});
      continue;
    }
    const std::uint32_t bc = middle(b, c);
    if (count == 2) {
      open.insert(open.end(), {{ab, b, bc}, {a, ab, bc}, {a, bc, c}});
      continue;
    }
    const std::uint32_t ca = middle(c, a);
    open.insert(open.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  triangles = std::move(done);
}

inline void require_triangles(std::size_t vertices, std::span<const std::uint32_t> triangles, PixelSize resolution) {
  if (vertices == 0 || triangles.empty()) throw RenderingError("a warp mesh without triangles");
  if (triangles.size() % 3 != 0)
    throw RenderingError("a warp mesh with " + std::to_string(triangles.size()) +
                         " indices; expected three a triangle");
  const std::uint32_t last = *std::max_element(triangles.begin(), triangles.end());
  if (last >= vertices)
    throw RenderingError("a warp mesh names vertex " + std::to_string(last) + " of " + std::to_string(vertices));
  if (resolution.width < 1 || resolution.height < 1)
    throw RenderingError("a warp mesh for a picture of " + std::to_string(resolution.width) + " x " +
                         std::to_string(resolution.height) + " pixels");
}

[[nodiscard]] inline bool is_finite(float x, float y, const float (&pairs)[3][2]) {
  bool finite = std::isfinite(x) && std::isfinite(y);
  for (const auto& pair : pairs) finite = finite && std::isfinite(pair[0]) && std::isfinite(pair[1]);
  return finite;
}

/// Halving edges comes to an end only for vertices on the panel.
inline void require_on_panel(std::span<const PredistortionVertex> vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const PredistortionVertex& v = vertices[i];
    const bool on_panel = v.panel_x >= 0.0f && v.panel_x <= 1.0f && v.panel_y >= 0.0f && v.panel_y <= 1.0f;
    if (!on_panel || !is_finite(v.panel_x, v.panel_y, v.tangent))
      throw RenderingError("vertex " + std::to_string(i) + " of a warp mesh is not finite, or not on the panel");
  }
}

inline void require_finite(std::span<const SeenVertex> vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const SeenVertex& v = vertices[i];
    if (!is_finite(v.seen_x, v.seen_y, v.tangent) || !is_finite(0.0f, 0.0f, v.panel))
      throw RenderingError("vertex " + std::to_string(i) + " of a warp mesh is not finite");
  }
}

}  // namespace detail

class WarpMesh {
 public:
  enum class Kind { panel, seen };

  WarpMesh(Context& context, const PredistortionMesh& mesh, double longest_edge = 1.0 / 32.0)
      : kind_(Kind::panel),
        per_colour_(mesh.per_color),
        resolution_(mesh.resolution),
        buffers_(uploaded(context, mesh, longest_edge)) {
    buffers_.attribute(0, 2, offsetof(PredistortionVertex, panel_x));
    for (GLuint c = 0; c < 3; ++c) {
      buffers_.attribute(1 + c, 2, offsetof(PredistortionVertex, tangent) + c * sizeof(float[2]));
      buffers_.attribute(4 + c, 2, offsetof(PredistortionVertex, panel_x));
    }
    throw_gl_error(context.gl(), "uploading a predistortion mesh");
  }
  WarpMesh(Context& context, const SeenMesh& mesh)
      : kind_(Kind::seen),
        per_colour_(mesh.per_colour),
        resolution_(mesh.resolution),
        buffers_(uploaded(context, mesh)) {
    buffers_.attribute(0, 2, offsetof(SeenVertex, seen_x));
    for (GLuint c = 0; c < 3; ++c) {
      buffers_.attribute(1 + c, 2, offsetof(SeenVertex, tangent) + c * sizeof(float[2]));
      buffers_.attribute(4 + c, 2, offsetof(SeenVertex, panel) + c * sizeof(float[2]));
    }
    throw_gl_error(context.gl(), "uploading a mesh of what the eye sees");
  }

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] bool is_per_colour() const { return per_colour_; }
  [[nodiscard]] PixelSize resolution() const { return resolution_; }  ///< of the picture that it lies over
  [[nodiscard]] std::size_t vertex_count() const { return buffers_.vertex_count(); }
  [[nodiscard]] std::size_t triangle_count() const { return buffers_.triangle_count(); }

  void draw() const { buffers_.draw(); }

 private:
  [[nodiscard]] static TriangleBuffers uploaded(Context& context, const PredistortionMesh& mesh, double longest_edge) {
    if (!mesh.ok()) throw RenderingError("no predistortion mesh: " + std::string(describe(mesh.problem)));
    detail::require_triangles(mesh.vertices.size(), mesh.triangles, mesh.resolution);
    detail::require_on_panel(mesh.vertices);
    HOLDFAST_ASSERT(longest_edge > 0.0, "edges have a length");
    std::vector<PredistortionVertex> vertices = mesh.vertices;
    std::vector<std::uint32_t> triangles = mesh.triangles;
    detail::split_long_edges(vertices, triangles, static_cast<float>(longest_edge));
    return {context, std::as_bytes(std::span(vertices)), sizeof(PredistortionVertex), triangles};
  }
  [[nodiscard]] static TriangleBuffers uploaded(Context& context, const SeenMesh& mesh) {
    detail::require_triangles(mesh.vertices.size(), mesh.triangles, mesh.resolution);
    detail::require_finite(mesh.vertices);
    return {context, std::as_bytes(std::span(mesh.vertices)), sizeof(SeenVertex), mesh.triangles};
  }

  Kind kind_;
  bool per_colour_;
  PixelSize resolution_;
  TriangleBuffers buffers_;
};

}  // namespace holdfast::rendering
