#include "mesh_lines.hpp"

#include <array>
#include <map>
#include <unordered_map>

namespace swimlab {

using namespace holdfast;

namespace {

MeshEdge sorted(const MeshEdge& edge) {
  return std::minmax(edge.first, edge.second);
}

/// The edge after corner i of the list of triangles, as it runs round its triangle.
MeshEdge edge_after(const PredistortionMesh& mesh, std::size_t i) {
  return {mesh.triangles[i], mesh.triangles[i % 3 == 2 ? i - 2 : i + 1]};
}

/// The pieces of lines that triangles hold, joined where they meet on the mesh's edges.
class Contour {
 public:
  void add(const std::array<MeshEdge, 2>& edges, const std::array<MeshPoint, 2>& points) {
    for (const MeshEdge& edge : edges) at_edge_.emplace(edge, pieces_.size());
    pieces_.push_back({edges, points, false});
  }
  [[nodiscard]] std::vector<std::vector<MeshPoint>> lines() && {
    std::vector<std::vector<MeshPoint>> lines;
    for (const bool closed : {false, true}) {  // first the lines that begin at the mesh's border
      for (std::size_t i = 0; i < pieces_.size(); ++i) {
        for (std::size_t end = 0; end < 2; ++end) {
          if (pieces_[i].used || (!closed && at_edge_.count(pieces_[i].edges[end]) > 1)) continue;
          lines.push_back(line_from(i, end));
        }
      }
    }
    return lines;
  }

 private:
  struct Piece {
    std::array<MeshEdge, 2> edges;
    std::array<MeshPoint, 2> points;
    bool used;
  };

  std::vector<MeshPoint> line_from(std::size_t i, std::size_t end) {
    std::vector<MeshPoint> line{pieces_[i].points[end]};
    while (!pieces_[i].used) {
      pieces_[i].used = true;
      line.push_back(pieces_[i].points[1 - end]);
      const MeshEdge edge = pieces_[i].edges[1 - end];
      const auto [first, last] = at_edge_.equal_range(edge);
      for (auto next = first; next != last; ++next) {
        if (pieces_[next->second].used) continue;
        i = next->second;
        end = pieces_[i].edges[0] == edge ? 0 : 1;
        break;
      }
    }
    return line;
  }

  std::vector<Piece> pieces_;
  std::multimap<MeshEdge, std::size_t> at_edge_;
};

}  // namespace

MeshPoint mesh_point(const PredistortionVertex& v, std::size_t c) {
  return {Vector2(static_cast<double>(v.panel_x), static_cast<double>(v.panel_y)),
          Vector2(static_cast<double>(v.tangent[c][0]), static_cast<double>(v.tangent[c][1]))};
}

MeshPoint between(const MeshPoint& a, const MeshPoint& b, double t) {
  return {a.panel + t * (b.panel - a.panel), a.tangent + t * (b.tangent - a.tangent)};
}

std::vector<std::vector<MeshPoint>> contour(const PredistortionMesh& mesh, std::size_t colour, std::size_t axis,
                                            double value) {
  Contour contour;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    std::array<MeshEdge, 2> edges;
    std::array<MeshPoint, 2> points;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const MeshEdge edge = sorted(edge_after(mesh, t + k));
      const double a = static_cast<double>(mesh.vertices[edge.first].tangent[colour][axis]) - value;
      const double b = static_cast<double>(mesh.vertices[edge.second].tangent[colour][axis]) - value;
      if ((a < 0.0) == (b < 0.0)) continue;
      edges[count] = edge;
      points[count++] = between(mesh_point(mesh.vertices[edge.first], colour),
                                mesh_point(mesh.vertices[edge.second], colour), a / (a - b));
    }
    if (count == 2) contour.add(edges, points);
  }
  return std::move(contour).lines();
}

std::vector<std::vector<std::uint32_t>> outline(const PredistortionMesh& mesh) {
  std::set<MeshEdge> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b] = edge_after(mesh, i);
    if (edges.erase({b, a}) == 0) edges.insert({a, b});
  }
  std::unordered_multimap<std::uint32_t, std::uint32_t> next;  // several where rings touch
  for (const auto& [a, b] : edges) next.emplace(a, b);
  std::vector<std::vector<std::uint32_t>> rings;
  while (!next.empty()) {
    std::vector<std::uint32_t>& ring = rings.emplace_back();
    for (auto at = next.begin(); at != next.end();) {
      ring.push_back(at->first);
      const std::uint32_t to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  return rings;
}

std::set<MeshEdge> edges_of(const PredistortionMesh& mesh) {
  std::set<MeshEdge> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) edges.insert(sorted(edge_after(mesh, i)));
  return edges;
}

std::vector<std::vector<std::uint32_t>> trails(std::set<MeshEdge> edges, std::size_t vertices) {
  std::vector<std::vector<std::uint32_t>> neighbours(vertices), trails;
  for (const auto& [a, b] : edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  while (!edges.empty()) {
    std::vector<std::uint32_t>& trail = trails.emplace_back(1, edges.begin()->first);
    for (std::uint32_t at = trail.front(); !neighbours[at].empty();) {
      const std::uint32_t next = neighbours[at].back();
      neighbours[at].pop_back();
      if (edges.erase(sorted({at, next})) == 0) continue;
      trail.push_back(next);
      at = next;
    }
  }
  return trails;
}

}  // namespace swimlab
