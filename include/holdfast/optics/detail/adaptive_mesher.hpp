/// Cuts an eye's panel by bisection until every triangle, or every one of the pieces it will be drawn as, keeps to a
/// bound (predistortion_mesh.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <holdfast/optics/detail/mesh_cut.hpp>
#include <holdfast/optics/detail/mesh_pieces.hpp>
#include <holdfast/optics/predistortion_mesh_types.hpp>

namespace holdfast::detail {

class AdaptiveMesher {
 public:
  AdaptiveMesher(const PanelLooker& looker, const PixelSize& panel, const AdaptiveMeshOptions& options)
      : looker_(looker),
        options_(options),
        limit_(options.max_error_px),
        coarsest_px_(looker.map().has_end() ? std::max(panel.width, panel.height) / 8.0
                                            : std::numeric_limits<double>::infinity()),
        bend_(looker.bend()),
        lattice_(pieces(looker.map(), options.max_error_px)),
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

  /// Circles along which the draft has still to be cut.
  [[nodiscard]] std::vector<LensCircle> kinks() const { return bend_ ? bend_->kinks() : std::vector<LensCircle>(); }

 private:
  static constexpr double smooth_margin = 1.05;
  static constexpr double bend_margin = 1.02;  ///< for a table's steps, and rounding to float
  /// Edges shorter than this, in panel pixels, are not cut. Kinks that are met by chance may need shorter ones.
  [[nodiscard]] double shortest_edge_px() const { return bend_ || looker_.map().is_smooth() ? 0.25 : 0.0625; }
  /// Along longer ones a border is not looked for with care.
  static constexpr double longest_border_edge_px = 32.0;

  /// Fewer pieces follow the lens and a field's corners more closely, more of them are found faster.
  [[nodiscard]] static std::uint32_t pieces(const PanelMap& map, double max_error_px) {
    if (map.is_radial()) return map.has_field() ? 4 : max_error_px < 0.2 ? 8 : 4;
    if (!map.is_simple()) return 1;
    return max_error_px < 0.1 ? 8 : max_error_px < 0.5 ? 4 : 1;
  }

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
    if (length_px > coarsest_px_) return true;
    if (bend_) return is_bent_too_much(corner, length_px, error_px_[t]);
    if (lattice_.pieces() > 1) {
      const TriangleError error = error_of_pieces(looker_, corner, static_cast<int>(lattice_.pieces()));
      if (!error.hole) {
        error_px_[t] = smooth_margin * error.px;
        return error_px_[t] > limit_ && length_px > shortest_edge_px() * lattice_.pieces();
      }
    }
    return is_a_piece_too_coarse(corner, error_px_[t]);
  }

  /// Through radial lenses.
  [[nodiscard]] bool is_bent_too_much(const std::array<PanelPoint, 3>& corner, double length_px, double& error_px) {
    const BendError bent =
        bend_->error({looker_.tangent_at(corner[0]), looker_.tangent_at(corner[1]), looker_.tangent_at(corner[2])},
                     lattice_.pieces());
    error_px = bend_margin * bent.px;
    if (error_px > limit_ || bent.border_px > options_.border_error_px) {
      return length_px > shortest_edge_px() * lattice_.pieces();
    }
    return !bent.dark && looker_.map().has_field() && is_field_border_too_coarse(corner);
  }

  /// Whether a border of the field, which no formula tells, is missed by a piece.
  [[nodiscard]] bool is_field_border_too_coarse(const std::array<PanelPoint, 3>& corner) {
    look_at_nodes(corner);
    return is_any_piece([&](const std::array<PanelPoint, 3>& piece, const CutTriangle& shown, double length_px) {
      const bool is_bad = shown.is_cut() && !keeps_to_border(piece, shown, length_px);
      return is_bad && length_px > shortest_edge_px();
    });
  }

  void look_at_nodes(const std::array<PanelPoint, 3>& corner) {
    node_.resize(lattice_.size());
    inside_.resize(lattice_.size());
    for (std::uint32_t j = 0; j <= lattice_.pieces(); ++j) {
      for (std::uint32_t i = 0; i + j <= lattice_.pieces(); ++i) {
        const std::size_t k = lattice_.index(i, j);
        node_[k] = lattice_.point(corner, i, j);
        inside_[k] = looker_.shows(node_[k]);
      }
    }
  }

  /// Whether is_bad(corners, shown, length_px) is true of a piece between the nodes.
  template <typename IsBad>
  [[nodiscard]] bool is_any_piece(const IsBad& is_bad) const {
    bool any = false;
    lattice_.for_triangles([&](std::size_t a, std::size_t b, std::size_t c) {
      if (any) return;
      const std::array<PanelPoint, 3> piece{node_[a], node_[b], node_[c]};
      const CutTriangle shown = cut({inside_[a] != 0, inside_[b] != 0, inside_[c] != 0});
      any = is_bad(piece, shown, looker_.pixels_between(piece[0], piece[1]).norm());
    });
    return any;
  }

  /// Tries every small triangle itself; the errors join `worst_px`.
  [[nodiscard]] bool is_a_piece_too_coarse(const std::array<PanelPoint, 3>& corner, double& worst_px) {
    look_at_nodes(corner);
    return is_any_piece([&](const std::array<PanelPoint, 3>& piece, const CutTriangle& shown, double length_px) {
      const bool is_bad = shown.is_cut() ? is_bad_at_border(piece, shown, length_px, worst_px)
                                         : is_bad_inside(piece, shown.count == 0, worst_px);
      return is_bad && length_px > shortest_edge_px();
    });
  }

  /// A piece whose corners all show something, or none does.
  [[nodiscard]] bool is_bad_inside(const std::array<PanelPoint, 3>& piece, bool is_dark, double& worst_px) const {
    const double margin = error_margin(looker_, piece);
    const TriangleError error = error_of(looker_, piece, limit_ / margin);
    if (is_dark) return error.shown;
    worst_px = std::max(worst_px, margin * error.px);
    return margin * error.px > limit_ || error.hole;
  }

  [[nodiscard]] bool is_bad_at_border(const std::array<PanelPoint, 3>& piece, const CutTriangle& shown,
                                      double length_px, double& worst_px) const {
    if (!keeps_to_border(piece, shown, length_px)) return true;
    const double margin = error_margin(looker_, piece);
    double worst_part_px = 0.0;
    for (std::size_t i = 0; i < shown.count; ++i) {
      const std::array<PanelPoint, 3> part = points_of(looker_, piece, shown.parts[i]);
      worst_part_px = std::max(worst_part_px, margin * error_of(looker_, part, limit_ / margin).px);
    }
    worst_px = std::max(worst_px, worst_part_px);
    return worst_part_px > limit_;
  }

  /// Whether the border's chord in the piece is near enough to the border.
  [[nodiscard]] bool keeps_to_border(const std::array<PanelPoint, 3>& piece, const CutTriangle& shown,
                                     double length_px) const {
    if (length_px > longest_border_edge_px) return false;
    // From the one to the other end of the border's chord, what shows something is on the left.
    const bool one = shown.count == 1;
    const CutCorner& from = one ? shown.parts[0][1] : shown.parts[1][2];
    const CutCorner& to = one ? shown.parts[0][2] : shown.parts[0][0];
    return detail::keeps_to_border(looker_, border_between(looker_, piece[from.in], piece[from.out]),
                                   border_between(looker_, piece[to.in], piece[to.out]), options_.border_error_px);
  }

  const PanelLooker& looker_;
  AdaptiveMeshOptions options_;
  double limit_;
  double coarsest_px_;  ///< larger triangles are cut unseen: an end of what is shown may hide in them
  std::optional<RadialBend> bend_;
  PieceLattice lattice_;
  Bisection bisection_;
  std::vector<double> error_px_;  ///< of each triangle as it was last tried, with its margin
  std::vector<PanelPoint> node_;  ///< of the triangle that is tried
  std::vector<std::uint8_t> inside_;
};

}  // namespace holdfast::detail
