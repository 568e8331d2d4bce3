/// Azuma & Bishop's predictor in closed form (001 sections 5.2.1 and 5.2.2): constant acceleration, turning and straight on.
///
///   Q(t) = (I cos d + M sin d / d) Q(t0),   d = sqrt(a^2 + b^2 + c^2),
///   (a, b, c) = (T w + T^2 w' / 2) / 2,     y(t) = y + y' T + y'' T^2 / 2,   T = t - t0
/// where M Q writes the quaternion product Q (0, a, b, c) as a matrix. It is R exp(T w + T^2 w' / 2): what predict_state
/// (state_prediction.hpp) makes of an undamped PVA model, with covariance and status. Use that; this is the formula as
/// printed.
/// Units: s, rad/s, rad/s^2, m. Bad input: nothing is checked; what is not finite stays so.
#pragma once

#include <cmath>

#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

/// Orientation after `seconds`.
[[nodiscard]] inline Quaternion azuma_bishop_orientation(const Quaternion& q_WB, const Vector3& w_WB_B,
                                                         const Vector3& alpha_WB_B, double seconds) {
  const Vector3 half = 0.5 * (seconds * w_WB_B + 0.5 * seconds * seconds * alpha_WB_B);
  const double a = half.x(), b = half.y(), c = half.z(), d = half.norm();
  Matrix4 M;             // of (w, x, y, z)
  M << 0.0, -a, -b, -c,  //
      a, 0.0, c, -b,     //
      b, -c, 0.0, a,     //
      c, b, -a, 0.0;
  const double sinc = d < 1e-4 ? 1.0 - d * d / 6.0 : std::sin(d) / d;  // the next term is d^4 / 120
  const Vector4 Q0(q_WB.w(), q_WB.x(), q_WB.y(), q_WB.z());
  const Vector4 Q = std::cos(d) * Q0 + sinc * (M * Q0);
  return Quaternion(Q[0], Q[1], Q[2], Q[3]);
}

/// Pose after `seconds`.
[[nodiscard]] inline Rigid azuma_bishop_pose(const TargetState<3>& state, double seconds) {
  const Quaternion q =
      azuma_bishop_orientation(state.X_WB.q(), state.velocity.w_WB_B, state.acceleration.alpha_WB_B, seconds);
  return Rigid(q, 0.5 * state.acceleration.a_WB * seconds * seconds + state.velocity.v_WB * seconds + state.X_WB.p());
}

}  // namespace holdfast
