/// The predistortion mesh of a lens that is itself a mesh: its own triangles, cut at the panel's and the field's edges.
///
/// Linear interpolation is then exact, but for rounding. Each triangle is cut by one half plane after the other
/// (Sutherland & Hodgman 1974); where an edge is cut, the point is computed from its ends in a fixed order, so that both
/// triangles at the edge get the same one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <holdfast/optics/detail/mesh_cut.hpp>
#include <holdfast/optics/point_mesh_lens.hpp>
#include <holdfast/optics/predistortion_mesh_types.hpp>

namespace holdfast::detail {

/// The colours' lenses when all are point meshes over the same triangles of the panel; else empty.
[[nodiscard]] inline std::vector<const Lens*> shared_point_mesh(const EyeModel& eye, LensMode mode) {
  std::vector<const Lens*> lenses{&eye.lens};
  if (eye.lens_red || eye.lens_blue) {
    lenses = {&eye.lens_of(Color::red), &eye.lens_of(Color::green), &eye.lens_of(Color::blue)};
  }
  const PointMeshLens* first = lenses[0]->model_if<PointMeshLens>();
  if (mode != LensMode::exact || first == nullptr) return {};
  const auto same_panel_point = [](const PointMeshSample& a, const PointMeshSample& b) { return a.panel == b.panel; };
  for (const Lens* lens : lenses) {
    const PointMeshLens* other = lens->model_if<PointMeshLens>();
    if (other == nullptr || !(lens->placement() == lenses[0]->placement())) return {};
    const PointMesh &a = first->mesh(), &b = other->mesh();
    if (a.triangles != b.triangles ||
        !std::equal(a.samples.begin(), a.samples.end(), b.samples.begin(), b.samples.end(), same_panel_point)) {
      return {};
    }
  }
  return lenses;
}

class PointMeshCutter {
 public:
  /// eye: an upright left one.
  PointMeshCutter(const EyeModel& eye, std::vector<const Lens*> lenses, const std::optional<FieldTangents>& field)
      : eye_(eye.tangents), lenses_(std::move(lenses)), field_(field) {}

  struct Corner {
    Vector2 at;  ///< 0 to 1 of the panel
    std::array<Vector2, 3> ideal;
  };

  /// Calls visit(corners) with the convex polygon that is left of each triangle, counter-clockwise.
  template <typename Visit>
  void for_polygons(const Visit& visit) const {
    const PointMesh& mesh = lenses_[0]->model_if<PointMeshLens>()->mesh();
    std::vector<Corner> polygon, cut_polygon;
    for (const std::array<int, 3>& t : mesh.triangles) {
      polygon.clear();
      for (const int sample : t) polygon.push_back(corner(static_cast<std::size_t>(sample)));
      if (area(polygon) < 0.0) std::reverse(polygon.begin(), polygon.end());
      for (std::size_t axis = 0; axis < 2; ++axis) {
        cut_by([&](const Corner& c) { return c.at[axis]; }, polygon, cut_polygon);
        cut_by([&](const Corner& c) { return 1.0 - c.at[axis]; }, polygon, cut_polygon);
      }
      for (std::size_t c = 0; field_ && c < lenses_.size(); ++c) {
        const auto x = std::minmax({field_->left, field_->right});
        const auto y = std::minmax({field_->down, field_->up});
        cut_by([&](const Corner& p) { return p.ideal[c].x() - x.first; }, polygon, cut_polygon);
        cut_by([&](const Corner& p) { return x.second - p.ideal[c].x(); }, polygon, cut_polygon);
        cut_by([&](const Corner& p) { return p.ideal[c].y() - y.first; }, polygon, cut_polygon);
        cut_by([&](const Corner& p) { return y.second - p.ideal[c].y(); }, polygon, cut_polygon);
      }
      if (polygon.size() >= 3) visit(polygon);
    }
  }

 private:
  [[nodiscard]] Corner corner(std::size_t sample) const {
    const LensPlacement& place = lenses_[0]->placement();
    const auto samples = [&](const Lens* lens) -> const PointMeshSample& {
      return lens->model_if<PointMeshLens>()->mesh().samples[sample];
    };
    const Vector2 panel = place.centre + place.scale.cwiseProduct(samples(lenses_[0]).panel);
    Corner out;
    out.at = {(panel.x() - eye_.left) / (eye_.right - eye_.left), (panel.y() - eye_.down) / (eye_.up - eye_.down)};
    for (std::size_t c = 0; c < lenses_.size(); ++c) {
      out.ideal[c] = place.centre + place.scale.cwiseProduct(samples(lenses_[c]).seen);
    }
    return out;
  }

  [[nodiscard]] static double area(const std::vector<Corner>& p) {
    const Vector2 a = p[1].at - p[0].at, b = p[2].at - p[0].at;
    return a.x() * b.y() - a.y() * b.x();
  }

  /// Keeps the part of the polygon where height is not negative.
  template <typename Height>
  void cut_by(const Height& height, std::vector<Corner>& polygon, std::vector<Corner>& scratch) const {
    scratch.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Corner &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double hp = height(p), hq = height(q);
      if (hp >= 0.0) scratch.push_back(p);
      if ((hp >= 0.0) != (hq >= 0.0)) scratch.push_back(between(p, hp, q, hq));
    }
    std::swap(polygon, scratch);
  }

  [[nodiscard]] Corner between(const Corner& p, double hp, const Corner& q, double hq) const {
    const bool swap = std::pair(q.at.x(), q.at.y()) < std::pair(p.at.x(), p.at.y());
    const Corner &a = swap ? q : p, &b = swap ? p : q;
    const double s = swap ? hq / (hq - hp) : hp / (hp - hq);
    Corner out;
    out.at = a.at + s * (b.at - a.at);
    for (std::size_t c = 0; c < lenses_.size(); ++c) out.ideal[c] = a.ideal[c] + s * (b.ideal[c] - a.ideal[c]);
    return out;
  }

  FieldTangents eye_;
  std::vector<const Lens*> lenses_;
  std::optional<FieldTangents> field_;
};

/// The cut triangles as vertices (once each) and indices.
struct PointMeshTriangles {
  std::vector<PanelPoint> points;
  std::vector<PanelLook> looks;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

[[nodiscard]] inline PointMeshTriangles triangles_of(const PointMeshCutter& cutter) {
  PointMeshTriangles out;
  std::unordered_map<std::uint64_t, std::uint32_t> known;
  const auto index = [&](const PointMeshCutter::Corner& c) {
    const auto units = [](double at) {
      return static_cast<std::uint32_t>(std::lround(std::clamp(at, 0.0, 1.0) * panel_units));
    };
    const PanelPoint p{units(c.at.x()), units(c.at.y())};
    const auto next = static_cast<std::uint32_t>(out.points.size());
    const auto [entry, is_new] = known.try_emplace((static_cast<std::uint64_t>(p.x) << 32) | p.y, next);
    if (is_new) {
      out.points.push_back(p);
      out.looks.push_back({c.ideal, true});
    }
    return entry->second;
  };
  std::vector<std::uint32_t> ring;
  cutter.for_polygons([&](const std::vector<PointMeshCutter::Corner>& polygon) {
    ring.clear();
    for (const auto& corner : polygon) ring.push_back(index(corner));
    for (std::size_t i = 2; i < ring.size(); ++i) {
      if (!has_area(out.points[ring[0]], out.points[ring[i - 1]], out.points[ring[i]])) continue;
      out.triangles.push_back({ring[0], ring[i - 1], ring[i]});
    }
  });
  return out;
}

}  // namespace holdfast::detail
