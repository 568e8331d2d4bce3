/// From a draft on an upright left eye's panel to the mesh of the eye that was asked for.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <holdfast/optics/detail/mesh_cut.hpp>
#include <holdfast/optics/detail/mesh_pieces.hpp>
#include <holdfast/optics/detail/point_mesh_triangles.hpp>
#include <holdfast/optics/predistortion_mesh_types.hpp>

namespace holdfast::detail {

class MeshAssembly {
 public:
  MeshAssembly(const PanelLooker& looker, const EyeModel& eye)
      : looker_(looker), mirror_(eye.side == EyeSide::right), turn_(eye.upside_down) {
    mesh_.resolution = eye.resolution;
    mesh_.per_color = looker.colours() == 3;
  }

  /// The part of the draft that shows something.
  [[nodiscard]] PredistortionMesh assemble(MeshDraft draft) && {
    look_at(draft.points);
    if (std::find(inside_.begin(), inside_.end(), 0) == inside_.end()) {
      mesh_.triangles = std::move(draft.triangles);
      if (mirror_) turn_over(mesh_.triangles);
    } else {
      drop_what_shows_nothing();
      mesh_.triangles.reserve(draft.triangles.size());
      for (std::size_t t = 0; t < draft.triangles.size(); t += 3) {
        add_cut(draft, {draft.triangles[t], draft.triangles[t + 1], draft.triangles[t + 2]});
      }
      drop_unused();
    }
    if (mesh_.triangles.empty()) {
      mesh_.vertices.clear();
      mesh_.problem = MeshProblem::nothing_visible;
    }
    return std::move(mesh_);
  }

  /// Triangles that are cut already.
  [[nodiscard]] PredistortionMesh assemble(const PointMeshTriangles& done) && {
    for (std::size_t i = 0; i < done.points.size(); ++i)
      mesh_.vertices.push_back(vertex(done.points[i], done.looks[i]));
    for (const auto& v : done.triangles) push(v);
    drop_unused();
    if (mesh_.triangles.empty()) mesh_.problem = MeshProblem::nothing_visible;
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t none = 0xffffffff;

  void look_at(std::span<const PanelPoint> points) {
    mesh_.vertices.resize(points.size());
    inside_.resize(points.size());
    constexpr std::size_t batch = 16;
    std::array<Vector2, batch> at;
    std::array<PanelLook, batch> seen;
    for (std::size_t first = 0; first < points.size(); first += batch) {
      const std::size_t count = std::min(batch, points.size() - first);
      for (std::size_t i = 0; i < count; ++i) at[i] = looker_.tangent_at(points[first + i]);
      looker_.map().look(std::span(at).first(count), seen.data());
      for (std::size_t i = 0; i < count; ++i) {
        inside_[first + i] = seen[i].inside;
        if (seen[i].inside) mesh_.vertices[first + i] = vertex(points[first + i], seen[i]);
      }
    }
  }

  [[nodiscard]] PredistortionVertex vertex(const PanelPoint& p, const PanelLook& seen) const {
    const auto panel = [](std::uint32_t units, bool turned) {
      return static_cast<float>(turned ? panel_units - units : units) / static_cast<float>(panel_units);
    };
    PredistortionVertex v;
    v.panel_x = panel(p.x, mirror_ != turn_);
    v.panel_y = panel(p.y, turn_);
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector2& ideal = seen.ideal[mesh_.per_color ? c : 0];
      v.tangent[c][0] = static_cast<float>(mirror_ ? -ideal.x() : ideal.x());
      v.tangent[c][1] = static_cast<float>(ideal.y());
    }
    return v;
  }

  /// Counter-clockwise also when mirrored.
  void push(const std::array<std::uint32_t, 3>& v) {
    const std::array<std::uint32_t, 3> turned{mirror_ ? v[1] : v[0], mirror_ ? v[0] : v[1], v[2]};
    mesh_.triangles.insert(mesh_.triangles.end(), turned.begin(), turned.end());
  }

  static void turn_over(std::vector<std::uint32_t>& triangles) {
    for (std::size_t t = 0; t < triangles.size(); t += 3) std::swap(triangles[t], triangles[t + 1]);
  }

  void drop_what_shows_nothing() {
    index_.assign(inside_.size(), none);
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < inside_.size(); ++i) {
      if (!inside_[i]) continue;
      index_[i] = kept;
      mesh_.vertices[kept++] = mesh_.vertices[i];
    }
    mesh_.vertices.resize(kept);
  }

  void add_cut(const MeshDraft& draft, const std::array<std::uint32_t, 3>& v) {
    if (inside_[v[0]] && inside_[v[1]] && inside_[v[2]]) return push({index_[v[0]], index_[v[1]], index_[v[2]]});
    const CutTriangle shown = cut({inside_[v[0]] != 0, inside_[v[1]] != 0, inside_[v[2]] != 0});
    for (std::size_t i = 0; i < shown.count; ++i) {
      const auto& part = shown.parts[i];
      std::array<PanelPoint, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t in = v[part[k].in], out = v[part[k].out];
        corner[k] = part[k].is_on_border() ? border(draft, in, out).point : draft.points[in];
      }
      // Slivers without area, and those that a fold turns over.
      if (!has_area(corner[0], corner[1], corner[2])) continue;
      if (looker_.is_turned_over(corner[0], corner[1], corner[2])) continue;
      std::array<std::uint32_t, 3> index;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t in = v[part[k].in], out = v[part[k].out];
        // A border that begins right at the vertex needs no other.
        index[k] = corner[k] == draft.points[in] ? index_[in] : border_index(border(draft, in, out));
      }
      push(index);
    }
  }

  struct BorderPoint {
    PanelPoint point;
    std::uint32_t index = none;  ///< of its vertex, once it has one
  };

  /// Where the border crosses the draft's edge from `in`, which shows something, to `out`.
  [[nodiscard]] BorderPoint& border(const MeshDraft& draft, std::uint32_t in, std::uint32_t out) {
    const auto [entry, is_new] = border_.try_emplace((static_cast<std::uint64_t>(in) << 32) | out);
    if (is_new) entry->second.point = border_between(looker_, draft.points[in], draft.points[out]);
    return entry->second;
  }

  [[nodiscard]] std::uint32_t border_index(BorderPoint& on_border) {
    if (on_border.index == none) {
      on_border.index = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(vertex(on_border.point, looker_.look(on_border.point)));
    }
    return on_border.index;
  }

  /// Vertices that only dropped slivers had.
  void drop_unused() {
    std::vector<std::uint32_t> index(mesh_.vertices.size(), none);
    for (const std::uint32_t v : mesh_.triangles) index[v] = 0;
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < index.size(); ++i) {
      if (index[i] == none) continue;
      mesh_.vertices[kept] = mesh_.vertices[i];
      index[i] = kept++;
    }
    mesh_.vertices.resize(kept);
    for (std::uint32_t& v : mesh_.triangles) v = index[v];
  }

  const PanelLooker& looker_;
  PredistortionMesh mesh_;
  std::vector<std::uint8_t> inside_;  ///< which points of the draft show something
  std::vector<std::uint32_t> index_;  ///< of the mesh's vertex, for each such point
  std::unordered_map<std::uint64_t, BorderPoint> border_;
  bool mirror_, turn_;
};

}  // namespace holdfast::detail
