/// A mesh of rings and spokes for lenses that are functions of the radius round one centre (predistortion_mesh.hpp).
///
/// lens_rings.hpp says where the rings stand. Where an arc of a ring lies beyond an edge of the panel, its nodes are not
/// even placed; what else reaches beyond the panel is cut off at its edges. Where an edge is cut depends on its two ends
/// alone, so that both triangles at it get the same point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include <holdfast/optics/detail/lens_rings.hpp>
#include <holdfast/optics/detail/mesh_cut.hpp>
#include <holdfast/optics/detail/mesh_pieces.hpp>
#include <holdfast/optics/detail/radial_bend.hpp>
#include <holdfast/optics/detail/triangle_error.hpp>
#include <holdfast/optics/predistortion_mesh_types.hpp>

namespace holdfast::detail {

class PolarMesher {
 public:
  /// Whether the lens's centre is on the panel, and no point of its rings too far beyond.
  [[nodiscard]] static bool suits(const PanelLooker& looker, const RadialBend::Group& bend) {
    const Vector2 centre = looker.units_at(bend.place.centre);
    const Vector2 unit = (looker.units_at(bend.place.centre + bend.place.scale) - centre).cwiseAbs();
    return centre.minCoeff() >= 0.0 && centre.maxCoeff() <= panel_units &&
           unit.maxCoeff() * bend.widest < far_units / 4.0;
  }

  /// Precondition: suits(looker, bend).
  PolarMesher(const PanelLooker& looker, const RadialBend::Group& bend, const AdaptiveMeshOptions& options)
      : looker_(looker), bend_(bend), rings_(bend, options), max_vertices_(options.max_vertices) {
    origin_ = looker.units_at(bend.place.centre);
    unit_ = (looker.units_at(bend.place.centre + bend.place.scale) - origin_).cwiseAbs();
  }

  /// False when the bound needs too many vertices.
  [[nodiscard]] bool build() {
    const std::vector<LensRing> rings = rings_.chosen();
    std::size_t count = 0;
    for (const LensRing& ring : rings) count += ring.sectors + 1;
    count = std::min(count, max_vertices_);
    draft_.points.reserve(count);
    draft_.triangles.reserve(6 * count);
    Nodes inner{node_at(whole(origin_.x()), whole(origin_.y()))}, outer;
    for (std::size_t i = 1; i < rings.size(); ++i) {
      find_stretches(rings[i - 1], rings[i].sectors);
      place(rings[i], outer);
      if (draft_.points.size() > max_vertices_) return false;
      note_error(rings[i - 1], rings[i]);
      for (const Stretch& stretch : stretches_) join(stretch, inner, outer);
      std::swap(inner, outer);
    }
    return true;
  }

  [[nodiscard]] MeshDraft draft() && { return std::move(draft_); }
  [[nodiscard]] double worst_px() const { return worst_px_; }

 private:
  static constexpr std::uint32_t none = 0xffffffff;
  static constexpr double far_units = 16.0 * panel_units;

  /// A point in units of the panel's lattice, on the panel or beyond.
  struct Node {
    std::int32_t x = 0, y = 0;
    std::uint32_t index = none;  ///< among the draft's points, of those on the panel
    std::uint32_t beyond = 0;    ///< which of the panel's edges
  };

  /// Of a ring: counter-clockwise on the panel, the first one again at the end.
  using Nodes = std::vector<Node>;

  /// To the nearest: what is converted is positive.
  [[nodiscard]] static std::int32_t whole(double x) {
    return static_cast<std::int32_t>(x + (far_units + 0.5)) - static_cast<std::int32_t>(far_units);
  }

  [[nodiscard]] Node node_at(std::int32_t x, std::int32_t y) {
    Node node{x, y};
    constexpr auto end = static_cast<std::int32_t>(panel_units);
    node.beyond = (x < 0 ? 1u : 0u) | (x > end ? 2u : 0u) | (y < 0 ? 4u : 0u) | (y > end ? 8u : 0u);
    if (node.beyond == 0) node.index = add_point(node);
    return node;
  }

  [[nodiscard]] std::uint32_t add_point(const Node& node) {
    draft_.points.push_back({static_cast<std::uint32_t>(node.x), static_cast<std::uint32_t>(node.y)});
    return static_cast<std::uint32_t>(draft_.points.size() - 1);
  }

  /// Nodes first to last of a ring.
  struct Arc {
    std::size_t first = 0, last = 0;
  };
  /// Of two neighbouring rings: nodes whose triangles may reach the panel.
  struct Stretch {
    Arc inner, outer;
  };

  /// What is placed of the inner ring, but for its hidden arcs.
  void find_stretches(const LensRing& inner, std::size_t outer_sectors) {
    const std::size_t n = inner.sectors, m = outer_sectors;
    stretches_.clear();
    if (n == 0) return stretches_.push_back({{0, 0}, {0, m}});
    const std::array<Arc, 5> hidden = hidden_arcs(inner);
    const auto add = [&](std::size_t first, std::size_t last) {
      if (first < last) stretches_.push_back({{first, last}, {first * m / n, (last * m + n - 1) / n}});
    };
    for (const Arc& placed : placed_) {
      std::size_t first = placed.first;
      for (const Arc& arc : hidden) {
        if (arc.last <= first) continue;
        add(first, std::min(arc.first, placed.last));
        first = std::max(first, arc.last);
      }
      add(first, placed.last);
    }
  }

  /// The outer nodes of the stretches.
  void place(const LensRing& ring, Nodes& nodes) {
    nodes.resize(ring.sectors + 1);
    placed_.clear();
    for (const Stretch& stretch : stretches_) {
      const bool overlaps = !placed_.empty() && stretch.outer.first <= placed_.back().last;
      if (!overlaps) placed_.push_back(stretch.outer);
      placed_.back().last = stretch.outer.last;
    }
    for (const Arc& arc : placed_) place(ring, arc.first, std::min(arc.last + 1, ring.sectors), nodes);
    if (placed_.empty() || placed_.back().last < ring.sectors) return;
    if (placed_.front().first > 0) place(ring, 0, 1, nodes);
    nodes.back() = nodes.front();
  }

  /// Nodes first to end - 1, a few at once.
  void place(const LensRing& ring, std::size_t first, std::size_t end, Nodes& nodes) {
    constexpr std::size_t together = 4;
    const double turn = 2.0 * std::numbers::pi / static_cast<double>(ring.sectors);
    const double c = std::cos(together * turn), s = std::sin(together * turn);
    std::array<double, together> x, y;
    for (std::size_t k = 0; k < together; ++k) {
      x[k] = ring.radius * std::cos(static_cast<double>(first + k) * turn);
      y[k] = ring.radius * std::sin(static_cast<double>(first + k) * turn);
    }
    for (std::size_t i = first; i < end; i += together) {
      std::array<std::int32_t, together> px, py;
      for (std::size_t k = 0; k < together; ++k) {
        px[k] = whole(origin_.x() + unit_.x() * x[k]);
        py[k] = whole(origin_.y() + unit_.y() * y[k]);
        const double turned = c * x[k] - s * y[k];
        y[k] = s * x[k] + c * y[k];
        x[k] = turned;
      }
      const std::size_t count = std::min(together, end - i);
      for (std::size_t k = 0; k < count; ++k) nodes[i + k] = node_at(px[k], py[k]);
    }
  }

  void join(const Stretch& stretch, const Nodes& in, const Nodes& out) {
    const std::size_t n = in.size() - 1, m = out.size() - 1;
    for (std::size_t i = stretch.inner.first, j = stretch.outer.first;;) {
      // On goes the ring whose next vertex comes first: (i + 1) / n against (j + 1) / m.
      if (i < stretch.inner.last && (j == stretch.outer.last || (i + 1) * m < (j + 1) * n)) {
        add(in[i], out[j], in[i + 1]);
        ++i;
      } else {
        if (j == stretch.outer.last) break;
        add(in[i], out[j], out[j + 1]);
        ++j;
      }
    }
  }

  /// Near a pole, where the table is coarse, what is found halfway between the rings is more.
  void note_error(const LensRing& inner, const LensRing& outer) {
    std::array<Vector2, 3> at;
    const double step = std::min(outer.radius, bend_.widest) - inner.radius;  // what is beyond the panel is cut off
    for (std::size_t i = 0; i < 3; ++i) {
      const double radius = inner.radius + 0.5 * static_cast<double>(i) * step;
      at[i] = bend_.place.centre + Vector2(bend_.place.scale.x() * radius, 0.0);
    }
    std::array<PanelLook, 3> seen;
    looker_.map().look(at, seen.data());
    double found = 0.0;
    for (std::size_t c = 0; seen[2].inside && c < looker_.colours(); ++c) {
      const Vector2 off = (seen[0].ideal[c] + seen[2].ideal[c]) / 2.0 - seen[1].ideal[c];
      found = std::max(found, off.cwiseProduct(looker_.px_per_tangent()).norm());
    }
    worst_px_ = std::max(worst_px_, LensRings::margin * std::max(rings_.missed_px(inner, outer), found));
  }

  /// Those beyond one edge of the panel, as are the nodes between them of all rings farther out. In order; that at
  /// node 0 is the first and the last one.
  [[nodiscard]] std::array<Arc, 5> hidden_arcs(const LensRing& ring) const {
    std::array<Arc, 5> arcs;
    if (ring.sectors == 0) return arcs;
    const std::size_t n = ring.sectors;
    const Vector2 low = origin_.cwiseQuotient(unit_),
                  high = Vector2(panel_units - origin_.x(), panel_units - origin_.y()).cwiseQuotient(unit_);
    const std::array<double, 4> edge{high.x(), high.y(), low.x(), low.y()};
    for (std::size_t side = 0; side < 4; ++side) {
      if (!(edge[side] < ring.radius)) continue;
      // Without a node at either end, for rounding.
      const double half = std::acos(edge[side] / ring.radius) / (2.0 * std::numbers::pi) * static_cast<double>(n);
      const double middle = static_cast<double>(side) / 4.0 * static_cast<double>(n);
      const double first = std::max(std::ceil(middle - half) + 1.0, 0.0), last = std::floor(middle + half) - 1.0;
      if (first < last) arcs[side] = {static_cast<std::size_t>(first), static_cast<std::size_t>(last)};
    }
    if (arcs[0].last > 0) arcs[4] = {n - arcs[0].last, n};
    return arcs;
  }

  void add(const Node& a, const Node& b, const Node& c) {
    if ((a.beyond | b.beyond | c.beyond) == 0) {
      add_triangle(a.index, b.index, c.index);
    } else if ((a.beyond & b.beyond & c.beyond) == 0) {
      add_cut(a, b, c);
    }
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    draft_.triangles.push_back(a);
    draft_.triangles.push_back(b);
    draft_.triangles.push_back(c);
  }

  /// The part that is on the panel (Sutherland & Hodgman 1974).
  void add_cut(const Node& a, const Node& b, const Node& c) {
    polygon_ = {a, b, c};
    constexpr auto end = static_cast<std::int32_t>(panel_units);
    cut_by(&Node::x, &Node::y, 0, 1);
    cut_by(&Node::x, &Node::y, end, -1);
    cut_by(&Node::y, &Node::x, 0, 1);
    cut_by(&Node::y, &Node::x, end, -1);
    for (Node& node : polygon_) {
      if (node.index != none) continue;
      const std::uint64_t key =
          (static_cast<std::uint64_t>(static_cast<std::uint32_t>(node.x)) << 32) | static_cast<std::uint32_t>(node.y);
      const auto [entry, is_new] = on_edge_.try_emplace(key);
      if (is_new) entry->second = add_point(node);
      node.index = entry->second;
    }
    for (std::size_t i = 2; i < polygon_.size(); ++i) {
      const std::uint32_t p = polygon_[0].index, q = polygon_[i - 1].index, r = polygon_[i].index;
      if (!has_area(draft_.points[p], draft_.points[q], draft_.points[r])) continue;
      add_triangle(p, q, r);
    }
  }

  /// Keeps the polygon's part with (along - edge) * inward >= 0.
  void cut_by(std::int32_t Node::*along, std::int32_t Node::*across, std::int32_t edge, std::int32_t inward) {
    cut_.clear();
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      const Node &p = polygon_[i], &q = polygon_[(i + 1) % polygon_.size()];
      const std::int64_t hp = (static_cast<std::int64_t>(p.*along) - edge) * inward;
      const std::int64_t hq = (static_cast<std::int64_t>(q.*along) - edge) * inward;
      if (hp >= 0) cut_.push_back(p);
      if ((hp > 0 && hq < 0) || (hp < 0 && hq > 0)) {
        // From the end inside, whichever triangle asks.
        const Node &in = hp > 0 ? p : q, &out = hp > 0 ? q : p;
        const std::int64_t h = hp > 0 ? hp : hq, whole = std::abs(hp) + std::abs(hq);
        Node crossing;
        crossing.*along = edge;
        const double share = static_cast<double>(h) / static_cast<double>(whole);
        const double way = share * (static_cast<double>(out.*across) - in.*across);
        crossing.*across = in.*across + static_cast<std::int32_t>(std::floor(way + 0.5));
        cut_.push_back(crossing);
      }
    }
    std::swap(polygon_, cut_);
  }

  const PanelLooker& looker_;
  const RadialBend::Group& bend_;
  LensRings rings_;
  std::size_t max_vertices_;
  Vector2 origin_, unit_;  ///< the lens's centre and unit, in units of the panel's lattice
  MeshDraft draft_;
  double worst_px_ = 0.0;
  std::vector<Stretch> stretches_;
  std::vector<Arc> placed_;  ///< of the last ring
  std::unordered_map<std::uint64_t, std::uint32_t> on_edge_;
  std::vector<Node> polygon_, cut_;
};

}  // namespace holdfast::detail
