/// Acceleration of a body's origin, freed from gravity and from what turning adds: 001 appendix A, and the modern triad.
///
/// 001's accelerometers sat apart, each with one sensitive axis; the three axes S_i are orthogonal. At its place r_i (F_i
/// there), each feels f = a_W - g_W + V_i, of which it says the part along S_i, where
///   V_i = W' x r_i + W x (W x r_i).
/// Appendix A, all of it in world space:
///   step 1   subtract what each would say at rest: -g . S_i                      (its "bias point")
///   step 2   the three numbers, along their axes, are the vector A_B = sum_i z_i S_i
///   step 3   A_A = A_B - sum_i (V_i . S_i) S_i                                   (printed without the last S_i)
/// Three accelerometers at one place l are a triad: then A_A = R_WB (f - W' x l - W x (W x l)) + g, with less work.
/// W and W' come from the orientation's filter; both are B's own here (w_WB_B, alpha_WB_B). Accelerometers alone cannot
/// tell them.
/// Exact for orthogonal axes. Units: m, m/s^2, rad/s, rad/s^2. Bad input: nothing is checked; what is not finite stays so.
/// Nothing here allocates.
#pragma once

#include <array>

#include <holdfast/motion/motion.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

struct SeparateAccelerometers {
  std::array<Vector3, 3> places_B{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};   ///< F_0, F_1, F_2
  std::array<Vector3, 3> axes_B{Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};  ///< orthogonal, of unit length
};

/// Of an inertial unit at X_BS, whose accelerometer i lies along axis i of S at places_S[i].
[[nodiscard]] inline SeparateAccelerometers accelerometers_on_body(const Rigid& X_BS,
                                                                   const std::array<Vector3, 3>& places_S) {
  SeparateAccelerometers sensors;
  for (std::size_t i = 0; i < 3; ++i) {
    sensors.places_B[i] = X_BS * places_S[i];
    sensors.axes_B[i] = X_BS.q() * Vector3(Vector3::Unit(static_cast<int>(i)));
  }
  return sensors;
}

/// How the body turns, as the orientation's filter knows it.
struct TurningState {
  Quaternion q_WB = Quaternion::Identity();
  Vector3 w_WB_B = Vector3::Zero();
  Vector3 alpha_WB_B = Vector3::Zero();
};

/// a_WB of the body's origin, m/s^2 in W. `said`: one number from each accelerometer.
[[nodiscard]] inline Vector3 linear_acceleration(const SeparateAccelerometers& sensors, const Vector3& said,
                                                 const TurningState& turning, const Vector3& gravity_W) {
  const Vector3 W = turning.q_WB * turning.w_WB_B, W_rate = turning.q_WB * turning.alpha_WB_B;
  Vector3 A_B = Vector3::Zero(), turned = Vector3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 S = turning.q_WB * sensors.axes_B[i], r = turning.q_WB * sensors.places_B[i];
    const double bias_point = -gravity_W.dot(S);
    A_B += (said[static_cast<int>(i)] - bias_point) * S;
    const Vector3 W_r = W.cross(r);
    const Vector3 V = W_rate.cross(r) + W.cross(W_r);
    turned += V.dot(S) * S;
  }
  return A_B - turned;
}

/// The same of a triad at X_BS.
[[nodiscard]] inline Vector3 linear_acceleration(const Rigid& X_BS, const Vector3& force_S, const TurningState& turning,
                                                 const Vector3& gravity_W) {
  const Vector3 &l = X_BS.p(), &w = turning.w_WB_B;
  const Vector3 w_l = w.cross(l);
  const Vector3 force_B = X_BS.q() * force_S;
  const Vector3 at_origin_B = force_B - turning.alpha_WB_B.cross(l) - w.cross(w_l);
  return turning.q_WB * at_origin_B + gravity_W;
}

/// How a simulated or recorded motion turns.
[[nodiscard]] inline TurningState turning_state(const MotionState& state) {
  return {state.X_WB.q(), state.w_WB_B, state.alpha_WB_B};
}

}  // namespace holdfast
