/// What an inertial filter knows: the motion of the sensors, and their own parameters.
///
/// S is the place of the inertial sensors; their axes are the body's, B. The origin of B, which measured poses are of,
/// may lie elsewhere: p_WB = p_WS - R_WB l_B. The error has 22 numbers, 3 each but for the time offset:
///   d = (dp, dphi, dv, db_rate, db_force, dg, dtau, dl):   p_true = p_WS + dp (W, m),  R_true = R exp(dphi) (about B's
/// axes),
///   v (W, m/s), biases (B, rad/s and m/s^2), gravity (W, m/s^2), time offset (s), lever (B, m).
/// Bad input: is_finite tells.
#pragma once

#include <holdfast/motion/timed_pose.hpp>
#include <holdfast/tracking/inertial_history.hpp>

namespace holdfast {

struct InertialState {
  static constexpr int size = 22;
  /// Where each part of the error begins.
  static constexpr int place = 0, turn = 3, velocity = 6, rate_bias = 9, force_bias = 12, gravity = 15, offset = 18,
                       lever = 19;
  using Error = VectorOf<double, size>;
  using Covariance = MatrixOf<double, size>;

  HostTime t;
  Rigid X_WS;
  Vector3 v_WS = Vector3::Zero();
  InertialBias bias;
  Vector3 gravity_W = Vector3::Zero();  ///< where things fall
  double time_offset_s = 0.0;           ///< a reading stamped t tells of t - offset
  Vector3 lever_B = Vector3::Zero();    ///< from B's origin to S

  [[nodiscard]] Rigid X_WB() const { return Rigid(X_WS.q(), X_WS.p() - X_WS.q() * lever_B); }

  [[nodiscard]] bool is_finite() const {
    return X_WS.is_finite() && v_WS.allFinite() && bias.rate_B.allFinite() && bias.force_B.allFinite() &&
           gravity_W.allFinite() && std::isfinite(time_offset_s) && lever_B.allFinite();
  }

  void add(const Error& d) {
    X_WS = Rigid(X_WS.q() * so3::exp<double>(d.segment<3>(turn)), X_WS.p() + d.segment<3>(place));
    v_WS += d.segment<3>(velocity);
    bias.rate_B += d.segment<3>(rate_bias);
    bias.force_B += d.segment<3>(force_bias);
    gravity_W += d.segment<3>(gravity);
    time_offset_s += d[offset];
    lever_B += d.segment<3>(lever);
  }

  /// Moves on by what the sensors felt.
  void move(const StrapdownIncrement& felt) {
    const double dt = felt.seconds;
    const Quaternion q = X_WS.q();
    X_WS = Rigid(q * felt.q, X_WS.p() + dt * v_WS + 0.5 * dt * dt * gravity_W + q * felt.position_B);
    v_WS += dt * gravity_W + q * felt.velocity_B;
  }
};

/// How an InertialState's error goes on over a stretch that begins with the orientation R.
[[nodiscard]] inline InertialState::Covariance error_transition(const StrapdownIncrement& step, const Matrix3& R) {
  using S = InertialState;
  const double dt = step.seconds;
  const Matrix3 turned = step.q.toRotationMatrix();
  S::Covariance F = S::Covariance::Identity();
  F.block<3, 3>(S::place, S::velocity).diagonal().setConstant(dt);
  F.block<3, 3>(S::turn, S::turn) = turned.transpose();
  F.block<3, 3>(S::turn, S::rate_bias) = -0.5 * dt * (Matrix3::Identity() + turned.transpose());
  F.block<3, 1>(S::turn, S::offset) = step.rate_end_B - turned.transpose() * step.rate_begin_B;
  if (!step.has_force) return F;
  F.block<3, 3>(S::place, S::turn) = -R * so3::hat<double>(step.position_B);
  F.block<3, 3>(S::place, S::force_bias) = -0.5 * dt * dt * R;
  F.block<3, 3>(S::place, S::gravity).diagonal().setConstant(0.5 * dt * dt);
  F.block<3, 3>(S::velocity, S::turn) = -R * so3::hat<double>(step.velocity_B);
  F.block<3, 3>(S::velocity, S::force_bias) = -dt * R;
  F.block<3, 3>(S::velocity, S::gravity).diagonal().setConstant(dt);
  // The stretch begins later by the sensors' clock: what was felt there is lost, and B there has turned on.
  const Vector3& w = step.rate_begin_B;
  const Vector3 velocity = turned * step.force_end_B - step.force_begin_B - w.cross(step.velocity_B);
  const Vector3 position = step.velocity_B - dt * step.force_begin_B - w.cross(step.position_B);
  F.block<3, 1>(S::velocity, S::offset) = R * velocity;
  F.block<3, 1>(S::place, S::offset) = R * position;
  return F;
}

}  // namespace holdfast
