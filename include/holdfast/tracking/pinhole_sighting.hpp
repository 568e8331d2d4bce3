/// A beacon seen by a camera of the body whose own calibration is learnt too (002 section 4.4; seven numbers of a camera).
///
///   R_BC = R_nominal exp(dphi),  p_BC = p_nominal + dp,  f = f_nominal + df
///   p_C = R_BC^T (p_B - p_BC),   (u, v) = f (x, y) / -z
/// The camera looks along its own -Z, as in camera_view.hpp; u and v are ideal image coordinates (m). The source's
/// parameters are the beacon's position in W (m); the sensor's are c = (df, dp, dphi), what the camera differs from its
/// nominal values: m, m in B, rad about C's axes. With c = 0 it measures what CameraSighting does.
/// Bad input: a beacon that is not in front of the camera, or a focal distance that is not positive, gives no measurement.
#pragma once

#include <holdfast/tracking/camera_view.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

struct PinholeSighting {
  static constexpr int size = 2;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 7;
  using Camera = DeviceParameters<7>;

  Vector2 uv = Vector2::Zero();  ///< ideal image coordinates, m
  Rigid X_BC;                    ///< nominal
  double focal_m = 0.0;          ///< nominal
  double variance = 0.0;         ///< of u and of v, m^2

  /// The camera that the parameters c describe.
  [[nodiscard]] CameraView camera(const Camera& c) const { return CameraView{view_matrix(pose(c), focal_m + c[0])}; }

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& beacon_W, const Camera& c,
                               Linearization<PinholeSighting>& linear) const {
    const double focal = focal_m + c[0];
    if (!c.allFinite() || !(focal > 0.0)) return false;
    const Rigid X_BC_now = pose(c);
    const Matrix3 R_CB = X_BC_now.R().transpose();
    const Matrix3 R_BW = state.X_WB.R().transpose();
    const Vector3 p_B = R_BW * (beacon_W - state.X_WB.p());
    const Vector3 p_C = R_CB * (p_B - X_BC_now.p());
    const double depth = -p_C.z();
    if (!(depth > CameraView::nearest_m)) return false;
    const Vector2 tangent(p_C.x() / depth, p_C.y() / depth);
    linear.residual = uv - focal * tangent;

    MatrixOf<double, 2, 3> by_p_C;
    by_p_C << 1.0, 0.0, tangent.x(), 0.0, 1.0, tangent.y();
    by_p_C *= focal / depth;
    const MatrixOf<double, 2, 3> by_p_B = by_p_C * R_CB;
    linear.H_source = by_p_B * R_BW;
    linear.H.leftCols<3>() = -linear.H_source;
    linear.H.rightCols<3>() = by_p_B * so3::hat<double>(p_B);
    linear.H_sensor.col(0) = tangent;
    linear.H_sensor.block<2, 3>(0, 1) = -by_p_B;
    // exp(dphi + e) = exp(dphi) exp(J_right e), and a camera that turns by e sees p_C turn by -e.
    linear.H_sensor.block<2, 3>(0, 4) =
        by_p_C * so3::hat<double>(p_C) * so3::right_jacobian<double>(Vector3(c.tail<3>()));
    linear.R = variance * Matrix2::Identity();
    return true;
  }

 private:
  [[nodiscard]] Rigid pose(const Camera& c) const {
    return Rigid(X_BC.q() * so3::exp<double>(Vector3(c.tail<3>())), X_BC.p() + c.segment<3>(1));
  }
};

}  // namespace holdfast
