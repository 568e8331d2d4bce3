/// What a strapdown navigator's state and covariance say of the body: pose and velocity with their covariance.
///
/// The unit sits at lever_B of the body's origin, so that a turn of it moves the origin, and its rate adds to the velocity:
///   dp_B = dp_S + R [l]x dphi,    v_B = v_S - R (w x l)
/// P is that of strapdown_covariance.hpp at the state's time; rate_B the rate there, without its bias. Nothing here allocates.
/// Bad input: nothing is checked; what is not finite stays so.
#pragma once

#include <holdfast/tracking/pose_estimate.hpp>
#include <holdfast/tracking/strapdown_covariance.hpp>

namespace holdfast {

[[nodiscard]] inline PoseEstimate strapdown_pose(const InertialState& now, const StrapdownCovariance& P,
                                                 const Vector3& rate_B) {
  const Matrix3 R_now = now.X_WS.R();
  const Vector3 swing_B = rate_B.cross(now.lever_B);
  const Matrix3 R_lever = R_now * so3::hat<double>(now.lever_B);
  MatrixOf<double, 12, strapdown_error_size> J = MatrixOf<double, 12, strapdown_error_size>::Zero();
  J.block<3, 3>(0, InertialState::place).setIdentity();
  J.block<3, 3>(0, InertialState::turn) = R_lever;
  J.block<3, 3>(3, InertialState::turn).setIdentity();
  J.block<3, 3>(6, InertialState::velocity).setIdentity();
  J.block<3, 3>(6, InertialState::turn) = R_now * so3::hat<double>(swing_B);
  J.block<3, 3>(6, InertialState::rate_bias) = -R_lever;
  J.block<3, 3>(9, InertialState::rate_bias) = -Matrix3::Identity();
  PoseEstimate estimate;
  estimate.t = now.t;
  estimate.X_WB = now.X_WB();
  estimate.velocity = Twist{now.v_WS - now.X_WS.q() * swing_B, rate_B};
  MatrixOf<double, 12, strapdown_error_size> JP;
  JP.noalias() = J.lazyProduct(P);
  estimate.covariance.noalias() = JP.lazyProduct(J.transpose());
  estimate.covariance = 0.5 * (estimate.covariance + estimate.covariance.transpose()).eval();
  return estimate;
}

}  // namespace holdfast
