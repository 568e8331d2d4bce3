/// What one picture is drawn through: an eye, where it is, and the clipping planes.
///
/// p_clip = projection(view) * X_EW * p_W. Matrices are combined in double on the CPU, so that far-away worlds lose
/// nothing before the GPU's single precision. The depth buffer is OpenGL's: 0 at the near plane, 1 at the far plane.
#pragma once

#include <limits>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/optics/eye.hpp>

namespace holdfast::rendering {

/// Pixels left <= x < right, bottom <= y < top, counted from the lower left.
struct PixelRectangle {
  int left = 0;
  int bottom = 0;
  int right = std::numeric_limits<int>::max();
  int top = std::numeric_limits<int>::max();

  friend bool operator==(const PixelRectangle&, const PixelRectangle&) = default;
};

struct View {
  const EyeModel* eye = nullptr;  ///< not owned; must live while the view is used
  Rigid X_WE = {};                ///< p_W = X_WE * p_E
  ClipPlanes clip{0.02, 200.0};
  PixelRectangle part = {};  ///< only this is needed (a band of a rolling display); the rest may be left undrawn
};

[[nodiscard]] inline Matrix4 projection_matrix(const View& view) {
  HOLDFAST_ASSERT(view.eye != nullptr, "a view needs an eye");
  return holdfast::projection_matrix(*view.eye, view.clip);
}

/// Matrix that takes points of the world to clip space.
[[nodiscard]] inline Matrix4 clip_from_world(const View& view) {
  return projection_matrix(view) * view.X_WE.inverse().matrix();
}

/// Distance along the optical axis, -z_E in metres, of a value of the depth buffer.
[[nodiscard]] inline double distance_of_depth(const View& view, double depth) {
  const Matrix4 P = projection_matrix(view);
  const double z_ndc = 2.0 * depth - 1.0;
  return P(2, 3) / (z_ndc + P(2, 2));
}

}  // namespace holdfast::rendering
