/// adaptive_mesh and grid_mesh (predistortion_mesh.hpp).
#pragma once

#include <cmath>
#include <optional>
#include <utility>

#include <holdfast/optics/detail/adaptive_mesher.hpp>
#include <holdfast/optics/detail/kink_cut.hpp>
#include <holdfast/optics/detail/mesh_assembly.hpp>
#include <holdfast/optics/detail/polar_mesher.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast {

namespace detail {

/// The eye as a left one with an upright panel.
[[nodiscard]] inline EyeModel upright_left(const EyeModel& eye) {
  EyeModel left = eye.side == EyeSide::right ? mirrored(eye) : eye;
  left.upside_down = false;
  return left;
}
[[nodiscard]] inline std::optional<FieldTangents> upright_left(const std::optional<FieldTangents>& field,
                                                               EyeSide side) {
  return field && side == EyeSide::right ? std::optional(mirrored(*field)) : field;
}

/// Whether both lenses do the same to the last bit: without a side, radial ones may be mirrored.
[[nodiscard]] inline bool do_the_same(const Lens& a, const Lens& b) {
  if (a == b) return true;
  if (!is_radial(a)) return false;
  const auto unmirrored = [](const Lens& lens) {
    return lens.with_placement({lens.centre(), lens.placement().scale.cwiseAbs()});
  };
  return unmirrored(a) == unmirrored(b);
}

/// Whether the eyes' meshes are mirror images.
[[nodiscard]] inline bool are_mirror_images(const EyeModel& left, const EyeModel& right) {
  if (left.side == right.side || left.upside_down != right.upside_down) return false;
  const EyeModel other = mirrored(right);
  if (!(left.tangents == other.tangents) || !(left.resolution == other.resolution)) return false;
  if (left.lens_red.has_value() != other.lens_red.has_value()) return false;
  if (left.lens_blue.has_value() != other.lens_blue.has_value()) return false;
  return do_the_same(left.lens, other.lens) && do_the_same(left.lens_of(Color::red), other.lens_of(Color::red)) &&
         do_the_same(left.lens_of(Color::blue), other.lens_of(Color::blue));
}

[[nodiscard]] inline MeshProblem problem_of_panel(const EyeModel& eye, const std::optional<FieldTangents>& field) {
  if (eye.resolution.width <= 0 || eye.resolution.height <= 0) return MeshProblem::no_pixels;
  if (problem_of(eye.tangents) != FieldProblem::none) return MeshProblem::impossible_field;
  if (field && problem_of(*field) != FieldProblem::none) return MeshProblem::impossible_field;
  return MeshProblem::none;
}

[[nodiscard]] inline PredistortionMesh no_mesh(const EyeModel& eye, MeshProblem problem) {
  PredistortionMesh mesh;
  mesh.resolution = eye.resolution;
  mesh.problem = problem;
  return mesh;
}

/// Whether rings round one centre suit all colours, and nothing else ends the picture.
[[nodiscard]] inline bool suits_rings(const PanelLooker& looker, const RadialBend& bend) {
  return !looker.map().has_field() && bend.groups().size() == 1 && PolarMesher::suits(looker, bend.groups().front());
}

/// columns x rows cells of the panel.
[[nodiscard]] inline MeshDraft grid(std::uint32_t columns, std::uint32_t rows) {
  MeshDraft draft;
  const auto unit = [](std::uint32_t i, std::uint32_t count) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(i) * panel_units + count / 2) / count);
  };
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) draft.points.push_back({unit(x, columns), unit(y, rows)});
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t sw = y * (columns + 1) + x, se = sw + 1, nw = sw + columns + 1, ne = nw + 1;
      // The longest edge across the way to the picture's middle, along which lenses bend most.
      if ((2 * x + 1 < columns) == (2 * y + 1 < rows)) {
        draft.triangles.insert(draft.triangles.end(), {se, nw, sw, nw, se, ne});
      } else {
        draft.triangles.insert(draft.triangles.end(), {sw, ne, nw, ne, sw, se});
      }
    }
  }
  return draft;
}

/// Largest error of a draft's triangles, with its margin, where they show something.
[[nodiscard]] inline double worst_px(const PanelLooker& looker, const MeshDraft& draft) {
  double worst = 0.0;
  for (std::size_t t = 0; t < draft.triangles.size(); t += 3) {
    const std::uint32_t* v = &draft.triangles[t];
    const std::array<PanelPoint, 3> corner{draft.points[v[0]], draft.points[v[1]], draft.points[v[2]]};
    const CutTriangle shown =
        cut({looker.look(corner[0]).inside, looker.look(corner[1]).inside, looker.look(corner[2]).inside});
    for (std::size_t i = 0; i < shown.count; ++i) {
      const std::array<PanelPoint, 3> part = points_of(looker, corner, shown.parts[i]);
      worst = std::max(
          worst, error_margin(looker, corner) * error_of(looker, part, std::numeric_limits<double>::infinity()).px);
    }
  }
  return worst;
}

/// The error that was found; never below what rounding may do, to float and to the panel's lattice
/// (seen at most 8 times enlarged).
[[nodiscard]] inline double stated_error_px(const PanelLooker& looker, const PredistortionMesh& mesh, double found_px) {
  float largest = 0.0f;
  for (const PredistortionVertex& v : mesh.vertices) {
    largest = std::max(largest, std::max(std::abs(v.tangent[1][0]), std::abs(v.tangent[1][1])));
  }
  const double rounding =
      largest * looker.px_per_tangent().norm() + 8.0 * std::hypot(mesh.resolution.width, mesh.resolution.height);
  return std::max(found_px, std::ldexp(rounding, -24));
}

/// Whether the eye sees a triangle turned over, beyond what rounding to float does to slivers.
[[nodiscard]] inline bool has_fold(const EyeModel& eye, const PredistortionMesh& mesh) {
  const FieldTangents& t = eye.tangents;
  const double upright = (t.right - t.left) * (t.up - t.down) > 0.0 ? 1.0 : -1.0;
  const std::size_t colours = mesh.per_color ? 3 : 1;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const PredistortionVertex& a = mesh.vertices[mesh.triangles[i]];
    const PredistortionVertex& b = mesh.vertices[mesh.triangles[i + 1]];
    const PredistortionVertex& c = mesh.vertices[mesh.triangles[i + 2]];
    for (std::size_t k = 0; k < colours; ++k) {
      const double px = b.tangent[k][0] - a.tangent[k][0], py = b.tangent[k][1] - a.tangent[k][1];
      const double qx = c.tangent[k][0] - a.tangent[k][0], qy = c.tangent[k][1] - a.tangent[k][1];
      if ((px * qy - py * qx) * upright < -1e-9) return true;
    }
  }
  return false;
}

/// Rings and spokes; nothing where they do not suit, or do not keep the bound: near a pole of the lens, bisection may.
[[nodiscard]] inline std::optional<PredistortionMesh> mesh_of_rings(const EyeModel& eye, const PanelLooker& looker,
                                                                    const AdaptiveMeshOptions& options) {
  const std::optional<RadialBend> bend = looker.bend();
  if (!bend || !suits_rings(looker, *bend)) return std::nullopt;
  PolarMesher mesher(looker, bend->groups().front(), options);
  if (!mesher.build() || mesher.worst_px() > options.max_error_px * (1.0 + 1e-9)) return std::nullopt;
  PredistortionMesh mesh = MeshAssembly(looker, eye).assemble(std::move(mesher).draft());
  if (!mesh.ok() || has_fold(eye, mesh)) return std::nullopt;
  mesh.max_error_px = stated_error_px(looker, mesh, mesher.worst_px());
  return mesh;
}

}  // namespace detail

inline PredistortionMesh adaptive_mesh(const EyeModel& eye, LensMode mode, const AdaptiveMeshOptions& options) {
  if (const MeshProblem problem = detail::problem_of_panel(eye, options.field); problem != MeshProblem::none) {
    return detail::no_mesh(eye, problem);
  }
  if (!(options.max_error_px >= 0.005) || !std::isfinite(options.max_error_px) ||
      !(options.border_error_px >= 0.01 && options.border_error_px <= 100.0)) {
    return detail::no_mesh(eye, MeshProblem::error_bound_out_of_range);
  }
  const EyeModel left = detail::upright_left(eye);
  const std::optional<FieldTangents> field = detail::upright_left(options.field, eye.side);
  const detail::PanelLooker looker(left, mode, field);
  if (auto lenses = detail::shared_point_mesh(left, mode); !lenses.empty()) {
    const detail::PointMeshCutter cutter(left, std::move(lenses), field);
    PredistortionMesh mesh = detail::MeshAssembly(looker, eye).assemble(detail::triangles_of(cutter));
    if (mesh.ok()) mesh.max_error_px = detail::stated_error_px(looker, mesh, 0.0);
    return mesh;
  }
  if (std::optional<PredistortionMesh> mesh = detail::mesh_of_rings(eye, looker, options)) return *std::move(mesh);
  detail::AdaptiveMesher mesher(looker, eye.resolution, options);
  if (!mesher.refine()) return detail::no_mesh(eye, MeshProblem::too_many_vertices);
  detail::MeshDraft draft = mesher.draft();
  for (const detail::LensCircle& kink : mesher.kinks()) detail::KinkCut(looker, kink, draft).cut();
  PredistortionMesh mesh = detail::MeshAssembly(looker, eye).assemble(std::move(draft));
  if (mesh.ok()) mesh.max_error_px = detail::stated_error_px(looker, mesh, mesher.worst_px());
  return mesh;
}

inline PredistortionMesh mirrored(PredistortionMesh mesh) {
  for (PredistortionVertex& v : mesh.vertices) {
    v.panel_x = 1.0f - v.panel_x;
    for (auto& tangent : v.tangent) tangent[0] = -tangent[0];
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) std::swap(mesh.triangles[t], mesh.triangles[t + 1]);
  return mesh;
}

inline EyeMeshes adaptive_meshes(const HmdModel& hmd, LensMode mode, const AdaptiveMeshOptions& options) {
  EyeMeshes meshes{adaptive_mesh(hmd.left, mode, options), {}};
  if (detail::are_mirror_images(hmd.left, hmd.right)) {
    meshes.right = mirrored(meshes.left);
  } else {
    AdaptiveMeshOptions of_right = options;
    if (options.field) of_right.field = mirrored(*options.field);
    meshes.right = adaptive_mesh(hmd.right, mode, of_right);
  }
  return meshes;
}

inline PredistortionMesh grid_mesh(const EyeModel& eye, LensMode mode, int columns, int rows,
                                   const std::optional<FieldTangents>& field) {
  if (const MeshProblem problem = detail::problem_of_panel(eye, field); problem != MeshProblem::none) {
    return detail::no_mesh(eye, problem);
  }
  if (columns < 1 || rows < 1 || columns > 4096 || rows > 4096) return detail::no_mesh(eye, MeshProblem::no_cells);
  const detail::PanelLooker looker(detail::upright_left(eye), mode, detail::upright_left(field, eye.side));
  detail::MeshDraft draft = detail::grid(static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(rows));
  const double worst_px = detail::worst_px(looker, draft);
  PredistortionMesh mesh = detail::MeshAssembly(looker, eye).assemble(std::move(draft));
  if (mesh.ok()) mesh.max_error_px = detail::stated_error_px(looker, mesh, worst_px);
  return mesh;
}

}  // namespace holdfast
