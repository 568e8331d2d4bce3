/// A mesh of rings and spokes for lenses that are functions of the radius round one centre (predistortion_mesh.hpp).
///
/// Such a lens bends along the radius more than across, by f'' against f'/r - f/r^2. Between two rings d apart, with
/// vertices L apart on each, linear interpolation misses at most
///
///     sqrt((f'' d^2 + A L^2)^2 + (2 A d L)^2) / 8,     A = (f / r)'
///
/// (radial_bend.hpp: the longest edge goes d along the radius and L across.) L takes a fixed part of the bound, d what is
/// left. A ring stands where the slope jumps and where the domain ends, with vertices close enough for its chords.
/// Rings need not have equally many vertices. What reaches beyond the panel is cut off at its edges; where an edge is cut
/// depends on its two ends alone, so that both triangles at it get the same point.
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
      : looker_(looker), bend_(bend), options_(options), room_(8.0 * options.max_error_px / (margin * bend.px)) {
    origin_ = looker.units_at(bend.place.centre);
    unit_ = (looker.units_at(bend.place.centre + bend.place.scale) - origin_).cwiseAbs();
    for (const RadialBend::Kink& kink : bend.kinks)
      stops_.push_back({kink.radius, 0.1 * room_ * kink.radius / kink.jump});
    if (std::isfinite(bend.end_radius)) {
      // A hair inside, for the rounding of its points.
      const double end = bend.end_radius * (1.0 - 1e-6);
      stops_.push_back({end, 8.0 * end * options.border_error_px / bend.px});
    }
    std::sort(stops_.begin(), stops_.end(), [](const Stop& a, const Stop& b) { return a.radius < b.radius; });
  }

  /// False when the bound needs too many vertices.
  [[nodiscard]] bool build() {
    const std::vector<Ring> rings = chosen_rings();
    std::size_t count = 0;
    for (const Ring& ring : rings) count += ring.sectors + 1;
    count = std::min(count, options_.max_vertices);
    draft_.points.reserve(count);
    draft_.triangles.reserve(6 * count);
    Nodes inner{node_at(Vector2::Zero())}, outer;
    for (std::size_t i = 1; i < rings.size(); ++i) {
      place(rings[i], outer);
      if (draft_.points.size() > options_.max_vertices) return false;
      join(rings[i - 1], inner, rings[i], outer);
      std::swap(inner, outer);
    }
    return true;
  }

  [[nodiscard]] MeshDraft draft() && { return std::move(draft_); }
  [[nodiscard]] double worst_px() const { return worst_px_; }

 private:
  static constexpr double margin =
      1.2;  ///< for the table's steps, bends that differ within a triangle, and rounding to float
  static constexpr double share_across = 0.45;
  static constexpr std::uint32_t none = 0xffffffff;

  static constexpr double far_units = 16.0 * panel_units;

  /// A point in units of the panel's lattice, on the panel or beyond.
  struct Node {
    std::int32_t x = 0, y = 0;
    std::uint32_t index = none;  ///< among the draft's points, of those on the panel
    std::uint32_t beyond = 0;    ///< which of the panel's edges
  };

  struct Ring {
    double radius = 0.0;
    double step = 0.0;        ///< from the ring within
    std::size_t sectors = 0;  ///< 0: the centre

    [[nodiscard]] double apart() const { return apart_at(radius, sectors); }
    /// Of the largest disc within the polygon.
    [[nodiscard]] double inner_radius() const {
      return sectors == 0 ? 0.0 : radius * std::cos(std::numbers::pi / static_cast<double>(sectors));
    }
  };

  /// Of a ring: counter-clockwise on the panel, the first one again at the end.
  using Nodes = std::vector<Node>;

  /// A radius at which a ring has to be.
  struct Stop {
    double radius;
    double largest_apart2;  ///< squared distance of its vertices, for the sake of its chords
  };

  [[nodiscard]] static double apart_at(double radius, std::size_t sectors) {
    return sectors == 0 ? 0.0 : 2.0 * std::numbers::pi * radius / static_cast<double>(sectors);
  }
  /// Rings and their vertices need not be closer than 1/32 px, in the lens's unit.
  [[nodiscard]] double shortest() const { return 1.0 / (32.0 * bend_.px); }
  [[nodiscard]] double last_radius() const {
    return std::isfinite(bend_.end_radius) ? stops_.back().radius : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] RadialBend::Bend bend_between(double low, double high) const {
    return bend_.between(low * low, high * high);
  }
  /// The same for triangles between two rings: at its ends a chord of a ring is not square to the radius.
  [[nodiscard]] RadialBend::Bend bend_between(const Ring& inner, const Ring& outer) const {
    RadialBend::Bend bend = bend_between(inner.radius, outer.radius);
    const double turned = apart(inner, outer) / (2.0 * outer.radius);
    bend.across += bend.along * turned * turned;
    return bend;
  }
  [[nodiscard]] static double apart(const Ring& inner, const Ring& outer) {
    return std::max(inner.apart(), outer.apart());
  }

  /// From the centre to the end of the domain or beyond the panel.
  [[nodiscard]] std::vector<Ring> chosen_rings() const {
    std::vector<Ring> rings{{0.0, bend_.widest / 6.0, 0}};
    while (rings.back().radius < last_radius() && rings.back().inner_radius() < bend_.widest) {
      rings.push_back(ring_round(rings.back()));
    }
    return rings;
  }

  [[nodiscard]] Ring ring_round(const Ring& inner) const {
    Ring outer;
    const Stop* stop = nullptr;
    for (auto s = stops_.rbegin(); s != stops_.rend(); ++s) stop = s->radius > inner.radius ? &*s : stop;
    const double to_stop = stop ? stop->radius - inner.radius : std::numeric_limits<double>::infinity();
    for (double step = std::min(1.5 * inner.step, to_stop);;) {
      // Of what is left to the stop two rings make halves, not a ring and a rest.
      if (step < to_stop && 1.5 * step > to_stop) step = to_stop / 2.0;
      const bool is_stop = step >= to_stop;
      outer.radius = is_stop ? stop->radius : inner.radius + step;
      outer.step = step;
      // What the next rings need across, too.
      const RadialBend::Bend about = bend_between(inner.radius, outer.radius + 2.0 * step);
      outer.sectors = sectors(outer.radius, about.across, is_stop ? stop->largest_apart2 : 0.0);
      const RadialBend::Bend bend = bend_between(inner, outer);
      const double found = missed(bend, step, apart(inner, outer));
      if (found <= room_ || step < shortest()) return outer;
      const double largest = largest_step(bend, apart(inner, outer));
      step = largest > 0.0 ? std::min(0.98 * largest, 0.9 * step) : 0.7 * step;
    }
  }

  [[nodiscard]] std::size_t sectors(double radius, double across, double largest_apart2) const {
    double apart2 = share_across * room_ / std::max(across, 1e-12);
    if (largest_apart2 > 0.0) apart2 = std::min(apart2, largest_apart2);
    apart2 = std::max(apart2, shortest() * shortest());
    constexpr double fewest = 8.0;
    return static_cast<std::size_t>(std::max(fewest, std::ceil(2.0 * std::numbers::pi * radius / std::sqrt(apart2))));
  }

  /// Eight times what interpolation misses, in the lens's unit.
  [[nodiscard]] static double missed(const RadialBend::Bend& bend, double step, double apart) {
    const double both = (bend.along + bend.across) * step * step + bend.across * apart * apart;
    const double askew = 2.0 * bend.across * step * apart;
    return std::sqrt(both * both + askew * askew);
  }
  /// The step that misses as much as there is room for; 0 or less: none.
  [[nodiscard]] double largest_step(const RadialBend::Bend& bend, double apart) const {
    const double along = bend.along + bend.across, across = bend.across * apart * apart;
    const double half_b = along * across + 2.0 * bend.across * across, c = across * across - room_ * room_;
    if (!(c < 0.0) || !(along > 0.0)) return 0.0;
    return std::sqrt((-half_b + std::sqrt(half_b * half_b - along * along * c)) / (along * along));
  }

  /// u: in the lens's unit, from its centre.
  [[nodiscard]] Node node_at(const Vector2& u) {
    // To the nearest: what is converted is positive.
    const auto unit = [](double x) {
      return static_cast<std::int32_t>(x + (far_units + 0.5)) - static_cast<std::int32_t>(far_units);
    };
    Node node{unit(origin_.x() + unit_.x() * u.x()), unit(origin_.y() + unit_.y() * u.y())};
    constexpr auto end = static_cast<std::int32_t>(panel_units);
    node.beyond = (node.x < 0 ? 1u : 0u) | (node.x > end ? 2u : 0u) | (node.y < 0 ? 4u : 0u) | (node.y > end ? 8u : 0u);
    if (node.beyond == 0) node.index = add_point(node);
    return node;
  }

  [[nodiscard]] std::uint32_t add_point(const Node& node) {
    draft_.points.push_back({static_cast<std::uint32_t>(node.x), static_cast<std::uint32_t>(node.y)});
    return static_cast<std::uint32_t>(draft_.points.size() - 1);
  }

  void place(const Ring& ring, Nodes& nodes) {
    nodes.clear();
    const double turn = 2.0 * std::numbers::pi / static_cast<double>(ring.sectors);
    const double c = std::cos(turn), s = std::sin(turn);
    Vector2 u(ring.radius, 0.0);
    for (std::size_t i = 0; i < ring.sectors; ++i) {
      nodes.push_back(node_at(u));
      u = Vector2(c * u.x() - s * u.y(), s * u.x() + c * u.y());
    }
    nodes.push_back(nodes[0]);
  }

  void join(const Ring& inner, const Nodes& in, const Ring& outer, const Nodes& out) {
    note_error(inner, outer);
    const std::size_t n = inner.sectors, m = outer.sectors;
    const std::array<Arc, 5> hidden = hidden_arcs(inner);
    std::size_t next = 0;  // of the hidden ones
    for (std::size_t i = 0, j = 0; i < n || j < m;) {
      while (next < hidden.size() && i >= hidden[next].last) ++next;
      if (next < hidden.size() && i >= hidden[next].first && j * n >= hidden[next].first * m) {
        i = hidden[next].last;
        j = i * m / n;
      }
      // On goes the ring whose next vertex comes first: (i + 1) / n against (j + 1) / m.
      if (i < n && (j == m || (i + 1) * m < (j + 1) * n)) {
        add(in[i], out[j], in[i + 1]);
        ++i;
      } else {
        if (j == m) break;
        add(in[i], out[j], out[j + 1]);
        ++j;
      }
    }
  }

  /// Near a pole, where the table is coarse, what is found halfway between the rings is more.
  void note_error(const Ring& inner, const Ring& outer) {
    const double bound = missed(bend_between(inner, outer), outer.step, apart(inner, outer)) * bend_.px / 8.0;
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
    worst_px_ = std::max(worst_px_, margin * std::max(bound, found));
  }

  /// Nodes first to last of a ring.
  struct Arc {
    std::size_t first = 0, last = 0;
  };

  /// Those beyond one edge of the panel, as are the nodes between them of all rings farther out. In order.
  [[nodiscard]] std::array<Arc, 5> hidden_arcs(const Ring& ring) const {
    std::array<Arc, 5> arcs;
    if (ring.sectors == 0) return arcs;
    const double n = static_cast<double>(ring.sectors);
    const Vector2 low = origin_.cwiseQuotient(unit_),
                  high = Vector2(panel_units - origin_.x(), panel_units - origin_.y()).cwiseQuotient(unit_);
    const std::array<double, 5> edge{high.x(), high.y(), low.x(), low.y(), high.x()};
    for (std::size_t side = 0; side < 5; ++side) {
      if (!(edge[side] < ring.radius)) continue;
      // Without a node at either end, for rounding.
      const double half = std::acos(edge[side] / ring.radius) / (2.0 * std::numbers::pi) * n;
      const double first = std::max(std::ceil(static_cast<double>(side) / 4.0 * n - half) + 1.0, 0.0);
      const double last = std::min(std::floor(static_cast<double>(side) / 4.0 * n + half) - 1.0, n);
      if (first < last) arcs[side] = {static_cast<std::size_t>(first), static_cast<std::size_t>(last)};
    }
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
  AdaptiveMeshOptions options_;
  double room_;            ///< eight times what may be missed, in the lens's unit
  Vector2 origin_, unit_;  ///< the lens's centre and unit, in units of the panel's lattice
  std::vector<Stop> stops_;
  MeshDraft draft_;
  double worst_px_ = 0.0;
  std::unordered_map<std::uint64_t, std::uint32_t> on_edge_;
  std::vector<Node> polygon_, cut_;
};

}  // namespace holdfast::detail
