/// What another tracker says: a whole pose, a position, or an orientation of the body.
///
///   PoseMeasurement         (p_z - p, log(R^T R_z))
///   PositionMeasurement     p_z - (p + R l_B), of a point at lever arm l_B
///   OrientationMeasurement  log(R^T R_z)
/// A sensor that is turned against the body needs no term of its own: give X_WB = X_WS X_BS^-1. Covariances are of
/// positions in W (m^2) and of small turns about B's axes (rad^2), as in pose_estimate.hpp. No parameters to calibrate.
/// Bad input: at half a turn between state and measurement either sign of the residual is right, and one is taken.
#pragma once

#include <holdfast/tracking/body_point.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

namespace detail {

/// Residual log(R^T R_z) of an orientation, and H of it: the residual becomes log(exp(-dphi) R^T R_z).
template <typename Residual, typename Jacobian>
void linearize_orientation(const Quaternion& q_WB, const Quaternion& measured, Residual&& residual, Jacobian&& H) {
  const Vector3 turn = so3::log<double>(q_WB.conjugate() * measured);
  residual = turn;
  H = so3::left_jacobian_inverse<double>(turn);
}

}  // namespace detail

struct PoseMeasurement {
  static constexpr int size = 6;
  static constexpr int state_size = 6;
  static constexpr int source_size = 0;
  static constexpr int sensor_size = 0;

  Rigid X_WB;
  Matrix6 covariance = Matrix6::Zero();

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const DeviceParameters<0>&, const DeviceParameters<0>&,
                               Linearization<PoseMeasurement>& linear) const {
    linear.H.setIdentity();
    linear.residual.head<3>() = X_WB.p() - state.X_WB.p();
    detail::linearize_orientation(state.X_WB.q(), X_WB.q(), linear.residual.tail<3>(), linear.H.block<3, 3>(3, 3));
    linear.R = covariance;
    return true;
  }
};

struct PositionMeasurement {
  static constexpr int size = 3;
  static constexpr int state_size = 6;
  static constexpr int source_size = 0;
  static constexpr int sensor_size = 0;

  Vector3 p_W = Vector3::Zero();
  Vector3 lever_B = Vector3::Zero();
  Matrix3 covariance = Matrix3::Zero();

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const DeviceParameters<0>&, const DeviceParameters<0>&,
                               Linearization<PositionMeasurement>& linear) const {
    const BodyPoint point = body_point(state, lever_B);
    linear.residual = p_W - point.p_W;
    linear.H = point.by_error;
    linear.R = covariance;
    return true;
  }
};

struct OrientationMeasurement {
  static constexpr int size = 3;
  static constexpr int state_size = 6;
  static constexpr int source_size = 0;
  static constexpr int sensor_size = 0;

  Quaternion q_WB = Quaternion::Identity();  ///< unit length
  Matrix3 covariance = Matrix3::Zero();

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const DeviceParameters<0>&, const DeviceParameters<0>&,
                               Linearization<OrientationMeasurement>& linear) const {
    linear.H.leftCols<3>().setZero();
    detail::linearize_orientation(state.X_WB.q(), q_WB, linear.residual, linear.H.rightCols<3>());
    linear.R = covariance;
    return true;
  }
};

}  // namespace holdfast
