/// How adaptive_mesh and grid_mesh (predistortion_mesh.hpp) work.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include <holdfast/optics/detail/mesh_cut.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>

namespace holdfast {

namespace detail {

/// The eye as a left one with an upright panel; the mesh is turned back afterwards.
[[nodiscard]] inline EyeModel upright_left(const EyeModel& eye) {
  EyeModel out = eye.side == EyeSide::right ? mirrored(eye) : eye;
  out.upside_down = false;
  return out;
}

[[nodiscard]] inline MeshProblem problem_of_panel(const EyeModel& eye, const std::optional<FieldTangents>& field) {
  if (eye.resolution.width <= 0 || eye.resolution.height <= 0) return MeshProblem::no_pixels;
  if (problem_of(eye.tangents) != FieldProblem::none) return MeshProblem::impossible_field;
  if (field && problem_of(*field) != FieldProblem::none) return MeshProblem::impossible_field;
  return MeshProblem::none;
}

/// How much larger than at the tried points the error may be between them, and by the rounding to float.
inline constexpr double error_margin = 1.05;

/// Cuts the panel until every triangle keeps to the bound.
class AdaptiveMesher {
 public:
  AdaptiveMesher(const EyeModel& eye, LensMode mode, const std::optional<FieldTangents>& field,
                 const AdaptiveMeshOptions& options)
      : draft_(eye, mode, field),
        bisection_(cells(eye, 0), cells(eye, 1)),
        options_(options),
        limit_(options.max_error_px / error_margin),
        coarsest_(longest_side(eye) / 8.0) {}

  /// False when the bound needs too many vertices.
  [[nodiscard]] bool refine() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t t = 0; t < bisection_.triangles().size(); ++t) open.push_back(t);
    draft_.add(bisection_.points());
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      if (!is_too_coarse(t)) continue;
      bisection_.split(t, [&](std::uint32_t changed) { open.push_back(changed); });
      if (bisection_.points().size() > options_.max_vertices) return false;
      draft_.add(bisection_.points());
    }
    return true;
  }

  [[nodiscard]] const MeshDraft& draft() const { return draft_; }
  [[nodiscard]] const Bisection& bisection() const { return bisection_; }
  [[nodiscard]] double worst_px() const {
    return error_px_.empty() ? 0.0 : *std::max_element(error_px_.begin(), error_px_.end());
  }

 private:
  /// Below this no refinement helps what is drawn: pixels of the panel.
  static constexpr double shortest_edge_px = 0.5;
  /// Above this a border is not looked for with care.
  static constexpr double longest_border_edge_px = 32.0;

  [[nodiscard]] static double longest_side(const EyeModel& eye) {
    return std::max(eye.resolution.width, eye.resolution.height);
  }

  /// Columns (axis 0) or rows (1) of the first cells: a power of two, so that a cell is at most sqrt(2) longer one way.
  [[nodiscard]] static std::uint32_t cells(const EyeModel& eye, int axis) {
    const double w = eye.resolution.width, h = eye.resolution.height;
    const double aspect = axis == 0 ? w / h : h / w;
    const double steps = std::clamp(std::round(std::log2(std::max(aspect, 1.0))), 0.0, 6.0);
    return 1u << static_cast<unsigned>(steps);
  }

  [[nodiscard]] bool is_too_coarse(std::uint32_t t) {
    const std::array<std::uint32_t, 3>& v = bisection_.triangles()[t].v;
    const MeshCorner &a = draft_.corner(v[0]), &b = draft_.corner(v[1]), &c = draft_.corner(v[2]);
    if (error_px_.size() <= t) error_px_.resize(bisection_.triangles().size() + t / 2, 0.0);
    const double length_px = draft_.pixels_between(a.point, b.point).norm();
    const int inside = a.look.inside + b.look.inside + c.look.inside;
    error_px_[t] = 0.0;
    if (inside == 0 || inside == 3) {
      const bool may_split = length_px > shortest_edge_px;
      if (may_split && length_px > coarsest_ && draft_.map().is_bounded()) return true;
      const TriangleError error = draft_.error_of(a, b, c, limit_);
      if (inside == 0) return may_split && error.shown;
      error_px_[t] = error.px;
      return may_split && (error.px > limit_ || error.hole);
    }
    return is_too_coarse_at_border(t, v, length_px);
  }

  [[nodiscard]] bool is_too_coarse_at_border(std::uint32_t t, const std::array<std::uint32_t, 3>& v, double length_px) {
    if (length_px > longest_border_edge_px) return true;
    const bool may_split = length_px > shortest_edge_px;
    const CutTriangle shown = cut(draft_, v);
    for (std::size_t i = 0; i < shown.count; ++i) {
      const auto& part = shown.parts[i];
      const TriangleError error =
          draft_.error_of(corner_of(draft_, part[0]), corner_of(draft_, part[1]), corner_of(draft_, part[2]), limit_);
      error_px_[t] = std::max(error_px_[t], error.px);
      if (may_split && error.px > limit_) return true;
    }
    return may_split && !keeps_to_border(border_of(shown));
  }

  /// Whether the border's chord has the true border within the tolerance, at its middle.
  [[nodiscard]] bool keeps_to_border(const std::array<CutVertex, 2>& border) const {
    const PanelPoint p = corner_of(draft_, border[0]).point, q = corner_of(draft_, border[1]).point;
    const Vector2 chord = draft_.pixels_between(p, q);
    if (chord.norm() < options_.border_error_px) return true;
    // The part that shows something is on the left of the way from the first to the second border vertex.
    const Vector2 to_inside = Vector2(-chord.y(), chord.x()) / chord.norm() * options_.border_error_px;
    const Vector2 middle = chord / 2.0;
    return draft_.shows(p, middle + to_inside) && !draft_.shows(p, middle - to_inside);
  }

  MeshDraft draft_;
  Bisection bisection_;
  AdaptiveMeshOptions options_;
  double limit_, coarsest_;
  std::vector<double> error_px_;  ///< of each triangle, as it was last tried
};

/// The gathered mesh of the upright left eye, turned to the eye that was asked for.
[[nodiscard]] inline PredistortionMesh finished(const MeshGatherer& gathered, const EyeModel& eye, bool per_color) {
  PredistortionMesh mesh;
  mesh.resolution = eye.resolution;
  mesh.per_color = per_color;
  if (gathered.triangles.empty()) {
    mesh.problem = MeshProblem::nothing_visible;
    return mesh;
  }
  const bool mirror = eye.side == EyeSide::right;
  const auto panel = [](std::uint32_t units, bool turned) {
    return static_cast<float>(turned ? panel_units - units : units) / static_cast<float>(panel_units);
  };
  mesh.vertices.reserve(gathered.corners.size());
  for (const MeshCorner& corner : gathered.corners) {
    PredistortionVertex v;
    v.panel_x = panel(corner.point.x, mirror != eye.upside_down);
    v.panel_y = panel(corner.point.y, eye.upside_down);
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector2& ideal = corner.look.ideal[per_color ? c : 0];
      v.tangent[c][0] = static_cast<float>(mirror ? -ideal.x() : ideal.x());
      v.tangent[c][1] = static_cast<float>(ideal.y());
    }
    mesh.vertices.push_back(v);
  }
  mesh.triangles = gathered.triangles;
  if (mirror) {
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i], mesh.triangles[i + 1]);
  }
  return mesh;
}

[[nodiscard]] inline std::optional<FieldTangents> upright_left(const std::optional<FieldTangents>& field,
                                                               EyeSide side) {
  return field && side == EyeSide::right ? std::optional(mirrored(*field)) : field;
}

[[nodiscard]] inline PredistortionMesh with_problem(const EyeModel& eye, MeshProblem problem) {
  PredistortionMesh mesh;
  mesh.resolution = eye.resolution;
  mesh.problem = problem;
  return mesh;
}

}  // namespace detail

inline PredistortionMesh adaptive_mesh(const EyeModel& eye, LensMode mode, const AdaptiveMeshOptions& options) {
  if (const MeshProblem problem = detail::problem_of_panel(eye, options.field); problem != MeshProblem::none) {
    return detail::with_problem(eye, problem);
  }
  if (!(options.max_error_px >= 0.001) || !std::isfinite(options.max_error_px) ||
      !(options.border_error_px >= 0.01 && options.border_error_px <= 100.0)) {
    return detail::with_problem(eye, MeshProblem::error_bound_out_of_range);
  }
  const EyeModel left = detail::upright_left(eye);
  detail::AdaptiveMesher mesher(left, mode, detail::upright_left(options.field, eye.side), options);
  if (!mesher.refine()) return detail::with_problem(eye, MeshProblem::too_many_vertices);
  detail::MeshGatherer gathered(mesher.draft());
  for (const auto& triangle : mesher.bisection().triangles()) gathered.add(detail::cut(mesher.draft(), triangle.v));
  PredistortionMesh mesh = detail::finished(gathered, eye, mesher.draft().map().colours() == 3);
  mesh.max_error_px = detail::error_margin * mesher.worst_px();
  return mesh;
}

inline PredistortionMesh grid_mesh(const EyeModel& eye, LensMode mode, int columns, int rows,
                                   const std::optional<FieldTangents>& field) {
  if (const MeshProblem problem = detail::problem_of_panel(eye, field); problem != MeshProblem::none) {
    return detail::with_problem(eye, problem);
  }
  if (columns < 1 || rows < 1 || columns > 4096 || rows > 4096) {
    return detail::with_problem(eye, MeshProblem::no_cells);
  }
  const EyeModel left = detail::upright_left(eye);
  detail::MeshDraft draft(left, mode, detail::upright_left(field, eye.side));
  std::vector<detail::PanelPoint> points;
  const auto unit = [](int i, int count) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(i) * detail::panel_units * 2 + count) / (2u * count));
  };
  for (int y = 0; y <= rows; ++y) {
    for (int x = 0; x <= columns; ++x) points.push_back({unit(x, columns), unit(y, rows)});
  }
  draft.add(points);
  detail::MeshGatherer gathered(draft);
  double worst_px = 0.0;
  const auto add = [&](std::array<std::uint32_t, 3> v) {
    const detail::CutTriangle shown = detail::cut(draft, v);
    gathered.add(shown);
    for (std::size_t i = 0; i < shown.count; ++i) {
      const auto& part = shown.parts[i];
      const detail::TriangleError error =
          draft.error_of(corner_of(draft, part[0]), corner_of(draft, part[1]), corner_of(draft, part[2]), 1e300);
      worst_px = std::max(worst_px, error.px);
    }
  };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const auto sw = static_cast<std::uint32_t>(y * (columns + 1) + x);
      const std::uint32_t se = sw + 1, nw = sw + static_cast<std::uint32_t>(columns) + 1, ne = nw + 1;
      // The long edge across the way to the picture's middle, along which lenses bend most.
      const bool falling = (2 * x + 1 < columns) == (2 * y + 1 < rows);
      if (falling) {
        add({se, nw, sw});
        add({nw, se, ne});
      } else {
        add({sw, ne, nw});
        add({ne, sw, se});
      }
    }
  }
  PredistortionMesh mesh = detail::finished(gathered, eye, draft.map().colours() == 3);
  mesh.max_error_px = detail::error_margin * worst_px;
  return mesh;
}

}  // namespace holdfast
