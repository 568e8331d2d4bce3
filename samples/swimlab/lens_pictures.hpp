/// Pictures of a headset's lens as SVG: a grid as it is drawn on the panel, as the eye sees it, and the mesh.
#pragma once

#include <string>

#include <holdfast/optics/predistortion_mesh.hpp>

namespace swimlab {

/// One eye, and the mesh that corrects its lens.
struct LensSubject {
  std::string hmd;
  const holdfast::EyeModel& eye;
  const holdfast::PredistortionMesh& mesh;
};

/// A grid of equal angles, drawn through the mesh: lines where the interpolated tangents are constant.
[[nodiscard]] std::string drawn_picture(const LensSubject& subject);
/// The same lines where the lens shows them: straight, if mesh and lens agree. Grey: the grid drawn without the mesh.
[[nodiscard]] std::string seen_picture(const LensSubject& subject);
/// The mesh's edges on the panel.
[[nodiscard]] std::string mesh_picture(const LensSubject& subject);

}  // namespace swimlab
