/// 001's figure 6 on any motion: how far displayed poses are off over a prediction interval, by no prediction, prediction
/// without inertial sensors, and with them.
///
/// A tracker measures noisy poses of the motion's true ones, an inertial unit rides along (simulation/inertial_sensor.hpp),
/// and each method says at every pose where the head will be after the interval, with only the past known. Errors against
/// the motion itself:
///   angle      of R_true^-1 R_predicted, deg          position   |p_predicted - p_true|, mm
///   screen     the point target_W, px: where a 512 x 512 screen of 30 deg shows it for both poses. 001 prints no field
///              for its hypothetical screen; the headset had about 30 deg, and figure 6's pixels per degree agree
/// 001 judged recordings, low-passed at 10 Hz, which served as truth and as measurements alike; here truth has no noise and
/// measurements keep theirs. A prediction for which the target is behind either eye counts in angle and position alone.
/// Preconditions: intervals above zero.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/motion/head_motions.hpp>
#include <holdfast/prediction/azuma_bishop_prediction.hpp>
#include <holdfast/prediction/error_statistics.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/tracking/azuma_bishop_filter.hpp>

namespace holdfast {

struct SensingSettings {
  Duration pose_interval = std::chrono::milliseconds(10);
  PoseNoise noise{5e-4, 5e-4};  ///< of each measured pose
  InertialUnit unit = azuma_bishop_inertial_unit();
  std::uint64_t seed = 1;
};

/// What tracker and inertial unit say along a motion.
struct SensedMotion {
  std::vector<TimedPose> poses;
  std::vector<InertialReading> readings;
};

[[nodiscard]] inline SensedMotion sense(const Motion& motion, const SensingSettings& settings) {
  HOLDFAST_ASSERT(settings.pose_interval > Duration(0), "poses need an interval");
  SensedMotion sensed;
  for (HostTime t = motion.begin(); t <= motion.end(); t += settings.pose_interval) {
    KeyedNumbers numbers(settings.seed, {t.time_since_epoch().count(), 1});
    const Vector2 a = numbers.normal_pair(), b = numbers.normal_pair(), c = numbers.normal_pair();
    const Rigid X_WB = motion.at(t).X_WB;
    const Vector3 turn = settings.noise.orientation_rad * Vector3(a.x(), a.y(), b.x());
    const Vector3 shift = settings.noise.position_m * Vector3(b.y(), c.x(), c.y());
    sensed.poses.push_back({t, Rigid(X_WB.q() * so3::exp<double>(turn), X_WB.p() + shift)});
  }
  sensed.readings = inertial_stream(motion, settings.unit, settings.seed);
  return sensed;
}

struct PredictionErrors {
  ErrorStatistics angle_deg, position_mm, screen_px;
};

/// One method: from a new pose, and the readings after the last pose until this one, to the pose at `t`.
using PosePredictor =
    std::function<Rigid(const TimedPose& measured, std::span<const InertialReading> readings, HostTime t)>;

/// 001's screen: a point's place on it, px from the middle.
[[nodiscard]] inline Vector2 figure_6_pixel(const Vector3& p_B) {
  const double pixels_per_tangent = 256.0 / std::tan(degrees(15.0).radians());
  return pixels_per_tangent / -p_B.z() * p_B.head<2>();
}

/// Errors of one method from `settle` after the begin on.
[[nodiscard]] inline PredictionErrors prediction_errors(const Motion& motion, const SensedMotion& sensed,
                                                        const PosePredictor& predictor, Duration interval,
                                                        Duration settle = std::chrono::seconds(1),
                                                        const Vector3& target_W = gaze_target_W) {
  std::vector<double> angles, positions, pixels;
  auto from = sensed.readings.begin();
  for (const TimedPose& pose : sensed.poses) {
    if (pose.t + interval > motion.end()) break;
    const auto to = std::ranges::upper_bound(from, sensed.readings.end(), pose.t, {}, &InertialReading::t);
    const Rigid X_WB = predictor(pose, std::span(from, to), pose.t + interval);
    from = to;
    if (pose.t < motion.begin() + settle) continue;
    const Rigid truth = motion.at(pose.t + interval).X_WB;
    angles.push_back(radians(so3::angle_between<double>(truth.q(), X_WB.q())).degrees());
    positions.push_back(1e3 * (truth.p() - X_WB.p()).norm());
    const Vector3 real = truth.inverse() * target_W, drawn = X_WB.inverse() * target_W;
    if (real.z() < 0.0 && drawn.z() < 0.0) pixels.push_back((figure_6_pixel(real) - figure_6_pixel(drawn)).norm());
  }
  return {statistics_of(std::move(angles)), statistics_of(std::move(positions)), statistics_of(std::move(pixels))};
}

/// Figure 6's three methods, of Azuma & Bishop's filters. The unit's errors in `settings` are not told to them.
struct Figure6 {
  PredictionErrors none, without_inertial, with_inertial;
};

[[nodiscard]] inline Figure6 figure_6(const Motion& motion, const SensedMotion& sensed,
                                      const AzumaBishopSettings& settings, Duration interval) {
  const auto predicted = [](const AzumaBishopFilter& filter, HostTime t) {
    const TargetState<3> state = filter.state();
    return azuma_bishop_pose(state, to_seconds(t - state.t));
  };
  AzumaBishopFilter without(settings), with(settings);
  Figure6 figure;
  figure.none = prediction_errors(
      motion, sensed, [](const TimedPose& pose, auto, HostTime) { return pose.X_WB; }, interval);
  figure.without_inertial = prediction_errors(
      motion, sensed,
      [&](const TimedPose& pose, auto, HostTime t) {
        without.update(pose);
        return predicted(without, t);
      },
      interval);
  figure.with_inertial = prediction_errors(
      motion, sensed,
      [&](const TimedPose& pose, std::span<const InertialReading> readings, HostTime t) {
        readings.empty() ? with.update(pose) : with.update(pose, readings.back());
        return predicted(with, t);
      },
      interval);
  return figure;
}

}  // namespace holdfast
