/// Inertial readings for a recording that has poses alone: simulated along it.
///
/// What a sensor on the head would have felt is not in the recording, and its poses' noise, twice differentiated, would be
/// taken for violent shaking. So the motion is taken to be the recording without what is above 10 Hz (zero-phase, as
/// Azuma & Bishop's truth, 001 appendix B), splined; the readings are that motion's exact derivatives with the errors of
/// `recorded_head_unit`. What is above 10 Hz stays in the poses and in the truth, as noise.
/// Poses that come slower than 100 Hz are splined to that first: the bends of a spline at the poses would else be felt,
/// and predictions that begin at poses err in another way than those that end there. Of slow recordings no more than
/// half of what their rate can carry is taken for movement.
/// This is kind to inertial prediction in two ways: a filter without phase looks ahead by some hundredths of a second, and
/// a spline bends before its samples do. docs/prediction.md has the figures without the low-pass.
/// Precondition: times that increase; at least two poses.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <holdfast/motion/low_pass.hpp>
#include <holdfast/motion/spline_trajectory.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>

namespace holdfast {

/// A headset's unit (mems_inertial_unit) at 500 Hz, whose readings have noise of 0.005 rad/s and 0.01 m/s^2. y is up.
[[nodiscard]] inline InertialUnit recorded_head_unit() {
  InertialUnit unit = mems_inertial_unit();
  const double seconds = to_seconds(unit.interval);
  unit.gyro.noise_density = 0.005 * std::sqrt(seconds);
  unit.accelerometer.noise_density = 0.01 * std::sqrt(seconds);
  return unit;
}

/// `low_pass_hz` 0: the recording as it is, noise and all.
[[nodiscard]] inline std::vector<InertialReading> simulate_inertial(std::span<const TimedPose> recording,
                                                                    const InertialUnit& unit = recorded_head_unit(),
                                                                    double low_pass_hz = 10.0) {
  const SplineTrajectory as_recorded(recording);
  if (low_pass_hz <= 0.0) return inertial_stream(as_recorded, unit);
  constexpr Duration slow = std::chrono::milliseconds(10);
  const bool is_slow = median_interval(recording) > slow;
  const std::vector<TimedPose> resampled = is_slow ? sample(as_recorded, slow) : std::vector<TimedPose>();
  const double cutoff_hz = std::min(low_pass_hz, 0.25 / to_seconds(median_interval(recording)));
  return inertial_stream(SplineTrajectory(zero_phase_low_pass(is_slow ? resampled : recording, cutoff_hz)), unit);
}

/// Every so many-th pose, such that about `rate_hz` are left.
[[nodiscard]] inline std::vector<TimedPose> thinned(std::span<const TimedPose> poses, double rate_hz) {
  std::vector<TimedPose> kept;
  const double interval = to_seconds(median_interval(poses));
  const auto every = static_cast<std::size_t>(std::max(1L, std::lround(1.0 / (rate_hz * interval))));
  for (std::size_t i = 0; i < poses.size(); i += every) kept.push_back(poses[i]);
  return kept;
}

}  // namespace holdfast
