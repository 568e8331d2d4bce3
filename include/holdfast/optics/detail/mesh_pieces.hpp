/// A conforming triangulation with each triangle cut into pieces x pieces equal ones; it conforms too.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/optics/detail/bisection.hpp>

namespace holdfast::detail {

/// Points and triangles on the panel, before a border cuts them.
struct MeshDraft {
  std::vector<PanelPoint> points;
  std::vector<std::uint32_t> triangles;  ///< three points each, counter-clockwise
};

/// Node (i, j) of a triangle is i/pieces towards corner 1 and j/pieces towards corner 2.
class PieceLattice {
 public:
  explicit PieceLattice(std::uint32_t pieces) : pieces_(pieces) {}

  [[nodiscard]] std::uint32_t pieces() const { return pieces_; }
  [[nodiscard]] std::size_t size() const { return (pieces_ + 1) * (pieces_ + 2) / 2; }
  [[nodiscard]] std::size_t index(std::uint32_t i, std::uint32_t j) const {
    return j * (pieces_ + 1) - j * (j - 1) / 2 + i;
  }
  /// Node k/pieces from corner `from` to the next corner.
  [[nodiscard]] std::size_t on_edge(std::size_t from, std::uint32_t k) const {
    return from == 0 ? index(k, 0) : from == 1 ? index(pieces_ - k, k) : index(0, pieces_ - k);
  }
  [[nodiscard]] PanelPoint point(const std::array<PanelPoint, 3>& corner, std::uint32_t i, std::uint32_t j) const {
    const auto along = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      return (a * (pieces_ - i - j) + b * i + c * j) / pieces_;  // below 2^24 * pieces, and it divides
    };
    return {along(corner[0].x, corner[1].x, corner[2].x), along(corner[0].y, corner[1].y, corner[2].y)};
  }
  /// Calls visit(a, b, c) with the nodes of every small triangle, counter-clockwise like the large one, the first two on
  /// its longest edge when corners 0 and 1 are.
  template <typename Visit>
  void for_triangles(const Visit& visit) const {
    for (std::uint32_t j = 0; j < pieces_; ++j) {
      for (std::uint32_t i = 0; i + j < pieces_; ++i) {
        visit(index(i, j), index(i + 1, j), index(i, j + 1));
        if (i + j + 1 < pieces_) visit(index(i + 1, j + 1), index(i, j + 1), index(i + 1, j));
      }
    }
  }

 private:
  std::uint32_t pieces_;
};

[[nodiscard]] inline MeshDraft cut_into_pieces(const Bisection& coarse, std::uint32_t pieces) {
  MeshDraft draft;
  draft.points = coarse.points();
  const auto& triangles = coarse.triangles();
  draft.triangles.reserve(3 * triangles.size() * pieces * pieces);
  if (pieces == 1) {
    for (const auto& t : triangles) draft.triangles.insert(draft.triangles.end(), t.v.begin(), t.v.end());
    return draft;
  }
  const PieceLattice lattice(pieces);
  std::vector<std::size_t> of_piece;  // nodes of every small triangle
  lattice.for_triangles([&](std::size_t a, std::size_t b, std::size_t c) {
    of_piece.insert(of_piece.end(), {a, b, c});
  });
  const std::uint32_t between = pieces - 1;  // nodes inside an edge
  draft.points.reserve(draft.points.size() + triangles.size() * pieces * pieces / 2 + triangles.size() * 2);
  std::vector<std::array<std::uint32_t, 3>> first_on_edge(triangles.size());  // edge from corner 0, 1, 2 to the next
  std::vector<std::uint32_t> node(lattice.size());
  // pieces steps of `step` from p; steps that are not whole wrap around.
  const auto along = [](const PanelPoint& p, const PanelPoint& step, std::uint32_t k) {
    return PanelPoint{p.x + k * step.x, p.y + k * step.y};
  };
  const auto step = [&](const PanelPoint& p, const PanelPoint& q) {
    const auto one = [&](std::uint32_t a, std::uint32_t b) {
      return static_cast<std::uint32_t>((static_cast<std::int32_t>(b) - static_cast<std::int32_t>(a)) /
                                        static_cast<std::int32_t>(pieces));  // it divides
    };
    return PanelPoint{one(p.x, q.x), one(p.y, q.y)};
  };
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Bisection::Triangle& triangle = triangles[t];
    std::array<PanelPoint, 3> corner;
    for (std::size_t c = 0; c < 3; ++c) {
      corner[c] = draft.points[triangle.v[c]];
      node[lattice.on_edge(c, 0)] = triangle.v[c];
    }
    for (std::size_t from = 0; from < 3; ++from) {
      const std::uint32_t neighbour = triangle.across[(from + 2) % 3];
      const bool is_known = neighbour < t;
      std::uint32_t first = static_cast<std::uint32_t>(draft.points.size());
      if (is_known) {
        const auto& back = triangles[neighbour].across;
        const std::size_t opposite = back[0] == t ? 0 : back[1] == t ? 1 : 2;
        first = first_on_edge[neighbour][(opposite + 1) % 3];
      }
      first_on_edge[t][from] = first;
      const PanelPoint edge_step = step(corner[from], corner[(from + 1) % 3]);
      for (std::uint32_t k = 1; k < pieces; ++k) {
        node[lattice.on_edge(from, k)] = is_known ? first + between - k : first + k - 1;
        if (!is_known) draft.points.push_back(along(corner[from], edge_step, k));
      }
    }
    const PanelPoint right = step(corner[0], corner[1]), up = step(corner[0], corner[2]);
    for (std::uint32_t j = 1; j < pieces; ++j) {
      const PanelPoint row = along(corner[0], up, j);
      for (std::uint32_t i = 1; i + j < pieces; ++i) {
        node[lattice.index(i, j)] = static_cast<std::uint32_t>(draft.points.size());
        draft.points.push_back(along(row, right, i));
      }
    }
    for (const std::size_t n : of_piece) draft.triangles.push_back(node[n]);
  }
  return draft;
}

}  // namespace holdfast::detail
