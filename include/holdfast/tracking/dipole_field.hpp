/// The magnetic field of one transmitter coil, as three orthogonal coils on the body measure it (000 section 3.1.3).
///
///   H_W = (3 (m . u) u - m) / (4 pi d^3),   r = p_WB + R_WB l_B - p_T = d u,   z = R_SB R_WB^T H_W
/// with m the coil's magnetic moment (A m^2: current times turns times area, along the coil's axis) and H in A/m: its
/// radial part is M cos(theta) / (2 pi d^3), the part across it M sin(theta) / (4 pi d^3). A transmitter with three coils
/// drives them one after the other, and each is one measurement of this kind. The source's parameters are the coil's
/// position p_T and moment m in W, six numbers.
/// Bad input: nearer than `nearest_m` a coil is no dipole, and the measurement is refused.
#pragma once

#include <cmath>
#include <numbers>

#include <holdfast/tracking/body_point.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

/// H (A/m) of a dipole of moment m (A m^2) at r from it (m), with derivatives.
struct DipoleField {
  Vector3 H;
  Matrix3 by_r;
  Matrix3 by_moment;

  DipoleField(const Vector3& r, const Vector3& moment) {
    const double d2 = r.squaredNorm();
    const Vector3 u = r / std::sqrt(d2);
    const double k = 1.0 / (4.0 * std::numbers::pi * d2 * std::sqrt(d2));
    const double along = u.dot(moment);
    by_moment = k * (3.0 * u * u.transpose() - Matrix3::Identity());
    H = by_moment * moment;
    const Matrix3 u_m = u * moment.transpose();
    by_r = 3.0 * k / std::sqrt(d2) * (u_m + u_m.transpose() + along * (Matrix3::Identity() - 5.0 * u * u.transpose()));
  }
};

struct DipoleSighting {
  static constexpr int size = 3;
  static constexpr int state_size = 6;
  static constexpr int source_size = 6;
  static constexpr int sensor_size = 0;

  Vector3 field_S = Vector3::Zero();  ///< A/m
  Rigid X_BS;                         ///< the receiver's place and axes
  double variance = 0.0;              ///< per axis, (A/m)^2
  double nearest_m = 0.05;

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector6& coil_W, const DeviceParameters<0>&,
                               Linearization<DipoleSighting>& linear) const {
    const BodyPoint receiver = body_point(state, X_BS.p());
    const Vector3 r = receiver.p_W - coil_W.head<3>();
    if (!(r.norm() > nearest_m)) return false;
    const DipoleField field(r, coil_W.tail<3>());
    const Matrix3 R_SB = X_BS.R().transpose();
    const Matrix3 R_BW = state.X_WB.R().transpose();
    const Matrix3 R_SW = R_SB * R_BW;
    const Vector3 field_B = R_BW * field.H;
    linear.residual = field_S - R_SB * field_B;
    linear.H = R_SW * field.by_r * receiver.by_error;
    linear.H.rightCols<3>() += R_SB * so3::hat<double>(field_B);
    linear.H_source.leftCols<3>() = -R_SW * field.by_r;
    linear.H_source.rightCols<3>() = R_SW * field.by_moment;
    linear.R = variance * Matrix3::Identity();
    return true;
  }
};

}  // namespace holdfast
