/// A camera fixed to the tracked body, as the HiBall paper calibrates one (course 11, The HiBall Tracking System, 5.1):
/// a 3x4 view matrix, and a table of deviations that turns real image coordinates into ideal ones.
///
/// For a point p_B of the body's frame, with c = V (p_B, 1):  u = c_x / c_z,  v = c_y / c_z  (eqs 3, 4); c_z > 0 in front.
/// Image coordinates are metres on an image plane at the focal distance, u to the camera's right, v up. `view_matrix`
/// makes V of a pinhole camera at X_BC that looks along its own -Z, as eyes and heads do.
/// Bad input: `project` gives nothing for a point that is not in front of the camera by at least `nearest_m`.
#pragma once

#include <optional>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

using ViewMatrix = MatrixOf<double, 3, 4>;

/// V of a pinhole camera at X_BC with its image plane `focal_m` away (m).
[[nodiscard]] inline ViewMatrix view_matrix(const Rigid& X_BC, double focal_m) {
  const Rigid X_CB = X_BC.inverse();
  const Matrix3 R_CB = X_CB.R();
  ViewMatrix V;
  V.leftCols<3>() = R_CB;
  V.col(3) = X_CB.p();
  V.topRows<2>() *= focal_m;
  V.row(2) *= -1.0;
  return V;
}

struct CameraView {
  ViewMatrix V = ViewMatrix::Zero();

  /// Nearer than this a point counts as not in front: a lens is thicker.
  static constexpr double nearest_m = 1e-3;

  /// Image coordinates (m) of a point of the body's frame; nothing when it is not in front.
  [[nodiscard]] std::optional<Vector2> project(const Vector3& p_B) const {
    const Vector3 c = V.leftCols<3>() * p_B + V.col(3);
    if (!(c.z() > nearest_m)) return std::nullopt;
    return Vector2(c.x() / c.z(), c.y() / c.z());
  }
};

}  // namespace holdfast
