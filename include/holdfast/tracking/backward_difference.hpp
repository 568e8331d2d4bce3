/// Causal velocity from the two newest poses: (newer - older) / dt.
///
/// It is the mean velocity over the interval, taken for the one at the newer time; so it is dt / 2 old. The angular
/// velocity log(R_older^-1 R_newer) / dt is expressed in B. The result's covariance holds, per axis,
///   measured poses of independent noise s:   s^2 for the pose, 2 s^2 / dt^2 for the velocity, s^2 / dt between them;
///   the velocity's age:                      (a dt / 2)^2, with the usual acceleration a of a head.
/// Bad input: times that do not increase give an estimate without velocity.
#pragma once

#include <array>

#include <holdfast/motion/timed_pose.hpp>
#include <holdfast/tracking/head_dynamics.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

namespace holdfast {

/// Twist that carries `older` into `newer` at a constant rate. Precondition: newer.t > older.t.
[[nodiscard]] inline Twist mean_twist(const TimedPose& older, const TimedPose& newer) {
  const double dt = to_seconds(newer.t - older.t);
  Twist twist;
  twist.v_WB = (newer.X_WB.p() - older.X_WB.p()) / dt;
  twist.w_WB_B = so3::log<double>(older.X_WB.q().conjugate() * newer.X_WB.q()) / dt;
  return twist;
}

/// The newer pose with the mean velocity since the older one.
[[nodiscard]] inline PoseEstimate backward_difference(const TimedPose& older, const TimedPose& newer,
                                                      const PoseNoise& noise = {}, const HeadDynamics& head = {}) {
  PoseEstimate estimate;
  estimate.t = newer.t;
  estimate.X_WB = newer.X_WB;
  const std::array variance{noise.position_m * noise.position_m, noise.orientation_rad * noise.orientation_rad};
  for (int i = 0; i < 6; ++i) estimate.covariance(i, i) = variance[i / 3];
  if (newer.t <= older.t) return estimate;

  estimate.velocity = mean_twist(older, newer);
  const double dt = to_seconds(newer.t - older.t);
  const std::array aged{0.5 * dt * head.acceleration_m_s2, 0.5 * dt * head.angular_acceleration_rad_s2};
  for (int i = 0; i < 6; ++i) {
    const int v = i + 6;
    estimate.covariance(v, v) = 2.0 * variance[i / 3] / (dt * dt) + aged[i / 3] * aged[i / 3];
    estimate.covariance(i, v) = estimate.covariance(v, i) = variance[i / 3] / dt;
  }
  return estimate;
}

}  // namespace holdfast
