/// Cuts an eye's panel by bisection until every triangle, or every one of the pieces it will be drawn as, keeps to a
/// bound (predistortion_mesh.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/optics/detail/mesh_cut.hpp>
#include <holdfast/optics/detail/mesh_pieces.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>

namespace holdfast::detail {

/// How much larger than found the error may be between the points that were tried, and by the rounding to float.
inline constexpr double error_margin = 1.05;

class AdaptiveMesher {
 public:
  AdaptiveMesher(const PanelLooker& looker, const PixelSize& panel, const AdaptiveMeshOptions& options)
      : looker_(looker),
        options_(options),
        limit_(options.max_error_px / error_margin),
        coarsest_px_(std::max(panel.width, panel.height) / 8.0),
        lattice_(looker.map().is_simple() ? 8 : 1),
        bisection_(cells(panel.width, panel.height), cells(panel.height, panel.width)) {}

  /// False when the bound needs too many vertices.
  [[nodiscard]] bool refine() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t t = 0; t < bisection_.triangles().size(); ++t) open.push_back(t);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      if (error_px_.size() <= t) error_px_.resize(bisection_.triangles().size());
      error_px_[t] = 0.0;
      if (!is_too_coarse(t)) continue;
      bisection_.split(t, [&](std::uint32_t changed) { open.push_back(changed); });
      // Each of n triangles brings about pieces^2 / 2 vertices.
      const std::size_t pieces = lattice_.pieces();
      if (bisection_.triangles().size() * pieces * pieces / 2 > options_.max_vertices) return false;
    }
    return true;
  }

  [[nodiscard]] MeshDraft draft() const { return cut_into_pieces(bisection_, lattice_.pieces()); }
  [[nodiscard]] double worst_px() const { return *std::max_element(error_px_.begin(), error_px_.end()); }

 private:
  /// Edges shorter than this, in panel pixels, are not cut: nothing that is drawn would change.
  static constexpr double shortest_edge_px = 0.5;
  /// Along longer ones a border is not looked for with care.
  static constexpr double longest_border_edge_px = 32.0;

  /// First cells along a side: a power of two, so that a cell is at most sqrt(2) times as long one way as the other.
  [[nodiscard]] static std::uint32_t cells(double along, double across) {
    const double steps = std::clamp(std::round(std::log2(std::max(along / across, 1.0))), 0.0, 6.0);
    return 1u << static_cast<unsigned>(steps);
  }

  [[nodiscard]] bool is_too_coarse(std::uint32_t t) {
    const auto& v = bisection_.triangles()[t].v;
    const std::array<PanelPoint, 3> corner{bisection_.points()[v[0]], bisection_.points()[v[1]],
                                           bisection_.points()[v[2]]};
    const double length_px = looker_.pixels_between(corner[0], corner[1]).norm();
    if (looker_.map().is_bounded() && length_px > coarsest_px_) return true;
    if (lattice_.pieces() > 1) {
      const TriangleError error = error_of_pieces(looker_, corner, static_cast<int>(lattice_.pieces()));
      if (!error.hole) {
        error_px_[t] = error.px;
        return error.px > limit_ && length_px > shortest_edge_px * lattice_.pieces();
      }
    }
    std::vector<PanelPoint> node(lattice_.size());
    for (std::uint32_t j = 0; j <= lattice_.pieces(); ++j) {
      for (std::uint32_t i = 0; i + j <= lattice_.pieces(); ++i)
        node[lattice_.index(i, j)] = lattice_.point(corner, i, j);
    }
    bool too_coarse = false;
    lattice_.for_triangles([&](std::size_t a, std::size_t b, std::size_t c) {
      too_coarse = too_coarse || is_piece_too_coarse({node[a], node[b], node[c]}, error_px_[t]);
    });
    return too_coarse;
  }

  /// One small triangle, tried itself; its error joins `worst_px`.
  [[nodiscard]] bool is_piece_too_coarse(const std::array<PanelPoint, 3>& corner, double& worst_px) const {
    const double length_px = looker_.pixels_between(corner[0], corner[1]).norm();
    const bool may_split = length_px > shortest_edge_px;
    const CutTriangle shown =
        cut({looker_.look(corner[0]).inside, looker_.look(corner[1]).inside, looker_.look(corner[2]).inside});
    if (shown.count == 0) return may_split && error_of(looker_, corner, 0.0).shown;
    const bool is_cut = shown.count == 2 || shown.parts[0][1].is_on_border();
    if (is_cut && length_px > longest_border_edge_px) return true;
    bool too_coarse = false;
    for (std::size_t i = 0; i < shown.count && !too_coarse; ++i) {
      std::array<PanelPoint, 3> part;
      for (std::size_t k = 0; k < 3; ++k) part[k] = point_of(looker_, corner, shown.parts[i][k]);
      const TriangleError error = error_of(looker_, part, limit_);
      worst_px = std::max(worst_px, error.px);
      too_coarse = error.px > limit_ || (!is_cut && error.hole);
    }
    if (!is_cut || too_coarse) return may_split && too_coarse;
    const auto [from, to] = shown.chord();
    return may_split && !keeps_to_border(looker_, point_of(looker_, corner, from), point_of(looker_, corner, to),
                                         options_.border_error_px);
  }

  const PanelLooker& looker_;
  AdaptiveMeshOptions options_;
  double limit_, coarsest_px_;
  PieceLattice lattice_;
  Bisection bisection_;
  std::vector<double> error_px_;  ///< of each triangle, as it was last tried
};

}  // namespace holdfast::detail
