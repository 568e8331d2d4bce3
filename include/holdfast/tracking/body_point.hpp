/// A point fixed to the tracked body, and a beacon as a sensor sees it: the geometry that measurements share.
///
///   body_point     p_W = p_WB + R_WB l_B                          of an antenna, a microphone, a diode at lever arm l_B
///   SensorOnBody   p_S = X_SB X_BW b_W     the sensor rides on the body, the beacon stands in the world (inside out)
///   SensorInRoom   p_S = X_SW X_WB b_B     the sensor stands in the world, the beacon rides on the body (outside in)
/// Derivatives are by the error (dp, dphi) of target_state.hpp and by the beacon's own three numbers. Lengths in metres.
/// Bad input: nothing is checked; what is not finite stays so.
#pragma once

#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

/// Nearer than this (m) a beacon or an antenna has no direction, or no range, that a sensor could tell.
inline constexpr double nearest_sighting_m = 1e-3;

struct BodyPoint {
  Vector3 p_W;
  MatrixOf<double, 3, 6> by_error;  ///< of p_W by (dp, dphi)
};

template <int Order>
[[nodiscard]] BodyPoint body_point(const TargetState<Order>& state, const Vector3& lever_B) {
  const Matrix3 R_WB = state.X_WB.R();
  BodyPoint point;
  point.p_W = state.X_WB.p() + R_WB * lever_B;
  point.by_error.leftCols<3>().setIdentity();
  point.by_error.rightCols<3>() = -R_WB * so3::hat<double>(lever_B);
  return point;
}

/// A beacon in the frame S of a sensor.
struct SeenBeacon {
  Vector3 p_S;
  MatrixOf<double, 3, 6> by_error;  ///< of p_S by (dp, dphi)
  Matrix3 by_beacon;                ///< of p_S by the beacon's position
};

struct SensorOnBody {
  Rigid X_BS;

  /// The beacon's position is given, and calibrated, in W.
  template <int Order>
  [[nodiscard]] SeenBeacon see(const TargetState<Order>& state, const Vector3& beacon_W) const {
    const Matrix3 R_SB = X_BS.R().transpose();
    const Matrix3 R_BW = state.X_WB.R().transpose();
    const Vector3 p_B = R_BW * (beacon_W - state.X_WB.p());
    SeenBeacon seen;
    seen.p_S = R_SB * (p_B - X_BS.p());
    seen.by_beacon = R_SB * R_BW;
    seen.by_error.leftCols<3>() = -seen.by_beacon;
    seen.by_error.rightCols<3>() = R_SB * so3::hat<double>(p_B);
    return seen;
  }
};

struct SensorInRoom {
  Rigid X_WS;

  /// The beacon's position is given, and calibrated, in B.
  template <int Order>
  [[nodiscard]] SeenBeacon see(const TargetState<Order>& state, const Vector3& beacon_B) const {
    const Matrix3 R_SW = X_WS.R().transpose();
    const BodyPoint point = body_point(state, beacon_B);
    SeenBeacon seen;
    seen.p_S = R_SW * (point.p_W - X_WS.p());
    seen.by_error = R_SW * point.by_error;
    seen.by_beacon = R_SW * state.X_WB.R();
    return seen;
  }
};

}  // namespace holdfast
