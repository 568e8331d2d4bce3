/// What inertial sensors fixed to the body tell: angular velocity, and specific force at a lever arm (000 section 3.1.2).
///
///   AngularRate    z = R_SB w_B + b
///   SpecificForce  z = R_SB f_B + b,   f_B = R_WB^T (a_W - g_W) + alpha_B x l_B + w_B x (w_B x l_B)
/// with l_B the accelerometer's place. A body at rest feels f = -g: its support pushes it up. The sensor's parameters are
/// the bias b (rad/s, or m/s^2, in S); there is no source.
/// A filter must keep angular velocities (Order 2) for the first, accelerations (Order 3) for the second.
/// Bad input: nothing of its own; numbers that are not finite are refused by the filter.
#pragma once

#include <holdfast/tracking/inertial_reading.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

struct AngularRate {
  static constexpr int size = 3;
  static constexpr int state_size = 12;
  static constexpr int source_size = 0;
  static constexpr int sensor_size = 3;

  Vector3 rate_S = Vector3::Zero();  ///< rad/s
  Quaternion q_BS = Quaternion::Identity();
  double variance = 0.0;  ///< per axis, (rad/s)^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const DeviceParameters<0>&, const Vector3& bias_S,
                               Linearization<AngularRate>& linear) const {
    const Matrix3 R_SB = q_BS.conjugate().toRotationMatrix();
    linear.residual = rate_S - R_SB * state.velocity.w_WB_B - bias_S;
    linear.H.leftCols<9>().setZero();
    linear.H.rightCols<3>() = R_SB;
    linear.H_sensor.setIdentity();
    linear.R = variance * Matrix3::Identity();
    return true;
  }
};

struct SpecificForce {
  static constexpr int size = 3;
  static constexpr int state_size = 18;
  static constexpr int source_size = 0;
  static constexpr int sensor_size = 3;

  Vector3 force_S = Vector3::Zero();                         ///< m/s^2
  Rigid X_BS;                                                ///< the accelerometer's place and axes
  Vector3 gravity_W = -standard_gravity * Vector3::UnitY();  ///< where things fall, m/s^2
  double variance = 0.0;                                     ///< per axis, (m/s^2)^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const DeviceParameters<0>&, const Vector3& bias_S,
                               Linearization<SpecificForce>& linear) const {
    const Matrix3 R_SB = X_BS.R().transpose();
    const Matrix3 R_BW = state.X_WB.R().transpose();
    const Vector3& l = X_BS.p();
    const Vector3& w = state.velocity.w_WB_B;
    const Vector3 at_origin_B = R_BW * (state.acceleration.a_WB - gravity_W);
    const Vector3 w_l = w.cross(l);
    const Vector3 force_B = at_origin_B + state.acceleration.alpha_WB_B.cross(l) + w.cross(w_l);
    linear.residual = force_S - R_SB * force_B - bias_S;
    linear.H.leftCols<9>().setZero();
    linear.H.block<3, 3>(0, 3) = R_SB * so3::hat<double>(at_origin_B);
    // d(w x (w x l)) = dw x (w x l) + w x (dw x l)
    linear.H.block<3, 3>(0, 9) = -R_SB * (so3::hat<double>(w_l) + so3::hat<double>(w) * so3::hat<double>(l));
    linear.H.block<3, 3>(0, 12) = R_SB * R_BW;
    linear.H.block<3, 3>(0, 15) = -R_SB * so3::hat<double>(l);
    linear.H_sensor.setIdentity();
    linear.R = variance * Matrix3::Identity();
    return true;
  }
};

}  // namespace holdfast
