/// Triangles in GPU memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <holdfast/geometry/types.hpp>
#include <holdfast/rendering/triangle_buffers.hpp>

namespace holdfast::rendering {

/// As lit.vert reads it, in the mesh's own frame.
struct MeshVertex {
  std::array<float, 3> position{};
  std::array<float, 3> normal{};  ///< unit length
  std::array<float, 2> uv{};      ///< origin lower left of the texture
  std::array<float, 4> colour{1, 1, 1, 1};
};

class Mesh {
 public:
  /// indices: three per triangle, each below vertices.size().
  Mesh(Context& context, std::span<const MeshVertex> vertices, std::span<const std::uint32_t> indices)
      : buffers_(context, std::as_bytes(vertices), sizeof(MeshVertex), indices) {
    buffers_.attribute(0, 3, offsetof(MeshVertex, position));
    buffers_.attribute(1, 3, offsetof(MeshVertex, normal));
    buffers_.attribute(2, 2, offsetof(MeshVertex, uv));
    buffers_.attribute(3, 4, offsetof(MeshVertex, colour));
    throw_gl_error(context.gl(), "uploading a mesh");
  }

  [[nodiscard]] std::size_t triangle_count() const { return buffers_.triangle_count(); }

  void draw() const { buffers_.draw(); }

 private:
  TriangleBuffers buffers_;
};

/// The box between two opposite corners, its faces' normals outward.
[[nodiscard]] inline Mesh make_box(Context& context, const Vector3& low, const Vector3& high) {
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, 1}) {
      const auto first = static_cast<std::uint32_t>(vertices.size());
      for (int corner = 0; corner < 4; ++corner) {
        // Counter-clockwise seen from outside: the second direction turns over with the side.
        const bool u = corner == 1 || corner == 2;
        const bool v = corner >= 2;
        Vector3 p;
        p[axis] = side == 1 ? high[axis] : low[axis];
        p[(axis + 1) % 3] = (side == 1 ? u : v) ? high[(axis + 1) % 3] : low[(axis + 1) % 3];
        p[(axis + 2) % 3] = (side == 1 ? v : u) ? high[(axis + 2) % 3] : low[(axis + 2) % 3];
        MeshVertex vertex;
        for (std::size_t i = 0; i < 3; ++i) vertex.position[i] = static_cast<float>(p[static_cast<Eigen::Index>(i)]);
        vertex.normal[static_cast<std::size_t>(axis)] = side == 1 ? 1.0f : -1.0f;
        vertex.uv = {u ? 1.0f : 0.0f, v ? 1.0f : 0.0f};
        vertices.push_back(vertex);
      }
      for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + i);
    }
  }
  return Mesh(context, vertices, indices);
}

}  // namespace holdfast::rendering
