/// Causal velocity from the two newest poses: (newer - older) / dt.
///
/// The mean velocity over the interval, assigned to the newer time; it therefore lags the true velocity by dt / 2. With
/// measured poses of independent noise s, the velocity's standard deviation is sqrt(2) s / dt and it errs together with
/// the newer pose (covariance s^2 / dt), which the result's covariance carries. The angular velocity log(R_older^-1
/// R_newer) / dt is expressed in B. Bad input: times that do not increase give an estimate without velocity.
#pragma once

#include <cmath>

#include <holdfast/motion/timed_pose.hpp>
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

/// The newer pose with the mean velocity since the older one, and the covariance that noise of the poses leaves.
[[nodiscard]] inline PoseEstimate backward_difference(const TimedPose& older, const TimedPose& newer,
                                                      const PoseNoise& noise = {}) {
  PoseEstimate estimate;
  estimate.t = newer.t;
  estimate.X_WB = newer.X_WB;
  const double variances[2] = {noise.position_m * noise.position_m, noise.orientation_rad * noise.orientation_rad};
  const bool in_order = newer.t > older.t;
  const double dt = in_order ? to_seconds(newer.t - older.t) : 1.0;
  for (int i = 0; i < 6; ++i) {
    const double s2 = variances[i / 3];
    estimate.covariance(i, i) = s2;
    if (!in_order) continue;
    estimate.covariance(i + 6, i + 6) = 2.0 * s2 / (dt * dt);
    estimate.covariance(i, i + 6) = estimate.covariance(i + 6, i) = s2 / dt;
  }
  if (in_order) estimate.velocity = mean_twist(older, newer);
  return estimate;
}

}  // namespace holdfast
