/// Lines of a predistortion mesh: where its tangents have a value, its outline, its edges.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include <holdfast/optics/predistortion_mesh.hpp>

namespace swimlab {

/// A point of the mesh: on the panel, 0 to 1, and the tangent that a colour shows there.
struct MeshPoint {
  holdfast::Vector2 panel, tangent;
};
[[nodiscard]] MeshPoint mesh_point(const holdfast::PredistortionVertex& vertex, std::size_t colour);
[[nodiscard]] MeshPoint between(const MeshPoint& a, const MeshPoint& b, double t);

/// Where the mesh's tangents along `axis` (0 or 1) are `value`.
[[nodiscard]] std::vector<std::vector<MeshPoint>> contour(const holdfast::PredistortionMesh& mesh, std::size_t colour,
                                                          std::size_t axis, double value);

/// The mesh's outline as closed rings of vertices.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> outline(const holdfast::PredistortionMesh& mesh);

/// Two vertices.
using MeshEdge = std::pair<std::uint32_t, std::uint32_t>;

/// Each edge once, its smaller vertex first.
[[nodiscard]] std::set<MeshEdge> edges_of(const holdfast::PredistortionMesh& mesh);

/// All edges, which edges_of told, as lines of few breaks.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> trails(std::set<MeshEdge> edges, std::size_t vertices);

}  // namespace swimlab
