/// One beacon seen by one camera of the tracked body: the HiBall's measurement (002 section 6.1.5, eq. 6.2).
///
///   p_B = R_WB^T (b - p_WB),  c = V (p_B, 1),  (u, v) = (c_x, c_y) / c_z
/// The source's parameters are the beacon's position b in W (m), so that it can be calibrated. The noise is one variance
/// for u and v (m^2, eq. 6.3).
/// A beacon that the state puts behind the camera is no measurement: 002's "backwards camera" (6.2.7) is refused.
#pragma once

#include <holdfast/tracking/camera_view.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

struct CameraSighting {
  static constexpr int size = 2;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 0;

  Vector2 uv = Vector2::Zero();        ///< ideal image coordinates, m
  const CameraView* camera = nullptr;  ///< not owned, not null
  double variance = 0.0;               ///< of u and of v, m^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& beacon_W,
                               const DeviceParameters<0>& /*camera*/, Linearization<CameraSighting>& linear) const {
    const Matrix3 R_BW = state.X_WB.q().conjugate().toRotationMatrix();
    const Vector3 p_B = R_BW * (beacon_W - state.X_WB.p());
    const Vector3 c = camera->V.leftCols<3>() * p_B + camera->V.col(3);
    if (!(c.z() > CameraView::nearest_m)) return false;
    const double w = 1.0 / c.z();
    const Vector2 h(c.x() * w, c.y() * w);
    linear.residual = uv - h;

    // dh/dp_B = (V_12 - h V_3) / c_z; dp_B = -R_BW dp + p_B x dphi + R_BW db.
    const MatrixOf<double, 2, 3> by_p_B = w * (camera->V.topLeftCorner<2, 3>() - h * camera->V.block<1, 3>(2, 0));
    linear.H_source.noalias() = by_p_B * R_BW;
    linear.H.leftCols<3>() = -linear.H_source;
    for (int row = 0; row < 2; ++row) {
      // row (p_B x dphi) = dphi . (row x p_B)
      const Vector3 gradient = by_p_B.row(row).transpose();
      linear.H.block<1, 3>(row, 3) = gradient.cross(p_B).transpose();
    }
    linear.R = variance * Matrix2::Identity();
    return true;
  }
};

}  // namespace holdfast
