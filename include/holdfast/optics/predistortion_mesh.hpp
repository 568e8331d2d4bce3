/// The mesh that a GPU draws to undo an eye's lens: panel points, and the tangent that each colour shows there.
///
/// Draw the triangles at (panel_x, panel_y), interpolate the tangents linearly, and look the source picture up at the
/// interpolated tangent (after the late correction, if there is one). What no triangle covers stays black.
///
/// Adaptive: linear interpolation differs from the exact lens by at most max_error_px, in pixels of a source picture with
/// the eye's own tangents and resolution. Three ways lead there:
/// - Lenses that are functions of the radius round one centre: rings and spokes, with vertices closer along the radius,
///   where such lenses bend more, than across. A ring stands at a kink (Oculus's spline) and where the lens ends. How
///   close the rings must be is computed from the lens's second derivative (detail/polar_mesher.hpp).
/// - All others, and whatever is cut by a `field`: the panel is cut by newest-vertex bisection (Mitchell 1989: triangles
///   are halved at the middle of their longest edge, together with the neighbour across it, so no vertex ever stands on
///   another triangle's edge and no crack can open). Where the bound is fine each of these triangles is drawn as 16 or 64
///   equal ones. The error is computed as above, or found from the lens's exact values at points that fix a cubic, and
///   taken 5 % larger; up to 2.3 times where a kink may lie between them (samples that differ between colours).
/// - A lens of samples is drawn by its own triangles, exactly.
/// Fixed: columns x rows cells, for comparison.
///
/// Edge: where the lens has no domain, all but folds (something is seen 32 times smaller than it is drawn, or drawn 8
/// times smaller by the cubic), or shows what lies outside `field`, nothing is drawn. Vertices are placed on that
/// border, so it is a smooth line. With lenses of their own for red and blue, all three colours end together.
///
/// The right eye's mesh is made as the mirror image of a left eye's, and an upside-down panel's by a half turn:
/// symmetric headsets get meshes that are mirror images to the last bit. Panel coordinates are multiples of 2^-24.
/// A lens with a pole on the panel enlarges without limit there: the bound is then missed, and the mesh's max_error_px,
/// above what was asked for, says so.
/// Bad input: `problem` names it and the mesh is empty. Preparation: this allocates; see docs/optics.md for its time.
#pragma once

#include <optional>

#include <holdfast/optics/eye.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/optics/predistortion_mesh_types.hpp>

namespace holdfast {

[[nodiscard]] inline PredistortionMesh adaptive_mesh(const EyeModel& eye, LensMode mode,
                                                     const AdaptiveMeshOptions& options = {});

/// Both eyes' meshes. Of a symmetric headset the right eye's is the left one's mirror image, to the last bit what
/// adaptive_mesh makes, and costs little more than its memory. options.field is the left eye's; the right one's is its
/// mirror image.
[[nodiscard]] inline EyeMeshes adaptive_meshes(const HmdModel& hmd, LensMode mode,
                                               const AdaptiveMeshOptions& options = {});

/// The mesh of the other eye of a symmetric headset.
[[nodiscard]] inline PredistortionMesh mirrored(PredistortionMesh mesh);

/// columns x rows cells of two triangles each. Its border is cut along the true one, with the grid's own coarseness.
[[nodiscard]] inline PredistortionMesh grid_mesh(const EyeModel& eye, LensMode mode, int columns, int rows,
                                                 const std::optional<FieldTangents>& field = std::nullopt);

}  // namespace holdfast

#include <holdfast/optics/detail/predistortion_mesh.hpp>
