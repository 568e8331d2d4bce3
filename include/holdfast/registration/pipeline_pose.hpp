/// The poses of a pipeline: the one that a frame is drawn for, the late ones that it is deflected to, and the one for
/// which the picture is right in the end.
///
/// The simulated tracker is ideal apart from a constant error X_HT: it says X_WH(t) X_HT. A frame is drawn for what was
/// measured `latency` before the middle of scan-out: P0 takes that pose, the others carry it on at constant velocity
/// over the latency. The velocity is the motion's own at the moment of measurement, as an ideal rate gyro's would be, or
/// the causal difference of two measured poses: a recording's spline bends already before the head does, so its
/// derivative knows the future.
///
/// The late pose is measured `late` before the scan-out starts, and carried on to the light of the first, the
/// middle and the last line by the same predictor. It is never older than the pose that was drawn for, nor newer than the scan-out's start.
///
/// Displayed pose (what the pose columns judge), at the middle of scan-out: not deflected, the pose drawn for;
/// shift, shift_roll and rotation, the late orientation at the place drawn for (what a shift leaves of the turn shows in
/// the fiducials alone); plane and depth, the late pose. Source: evaluation.md "Default experiments". Bad input:
/// pipelines that are not available are a programmer's error here; run_experiment refuses them.
#pragma once

#include <algorithm>

#include <holdfast/assert.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/prediction/predictor.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/tracking/backward_difference.hpp>

namespace holdfast {

/// What the tracker reports of time t.
[[nodiscard]] inline PoseEstimate measure(const Motion& motion, const ExperimentSettings& settings, HostTime t) {
  const MotionState state = motion.at(t);
  const TimedPose newer{t, state.X_WB * settings.X_HT};
  if (settings.velocity == VelocitySource::backward_difference) {
    const HostTime before = t - settings.velocity_baseline;
    return backward_difference({before, motion.at(before).X_WB * settings.X_HT}, newer);
  }
  PoseEstimate estimate;
  estimate.t = t;
  estimate.X_WB = newer.X_WB;
  const Quaternion q_TH = settings.X_HT.q().conjugate();
  estimate.velocity = Twist{state.v_WB + state.X_WB.q() * state.w_WB_B.cross(settings.X_HT.p()), q_TH * state.w_WB_B};
  return estimate;
}

[[nodiscard]] constexpr Predictor predictor_of(Pipeline pipeline) {
  return pipeline == Pipeline::p0 ? Predictor::none : Predictor::constant_velocity;
}

/// X_WH at t, as the pipeline's predictor has it from an estimate.
[[nodiscard]] inline Rigid predicted_pose(const ExperimentSettings& settings, const PoseEstimate& estimate,
                                          HostTime t) {
  PredictionLimits limits;
  limits.maximum_interval = std::max(limits.maximum_interval, t - estimate.t);  // the experiment wants all of it
  return predict(predictor_of(settings.pipeline), estimate, t, limits).X_WB;
}

/// X_WH that a frame is drawn for whose middle of scan-out is t_display.
[[nodiscard]] inline Rigid drawn_pose(const Motion& motion, const ExperimentSettings& settings, HostTime t_display) {
  HOLDFAST_ASSERT(is_available(settings.pipeline), "pipeline not available yet");
  return predicted_pose(settings, measure(motion, settings, t_display - settings.latency), t_display);
}

/// From the light of the first line to the middle of scan-out.
[[nodiscard]] inline Duration half_scan(const DisplayTiming& timing) {
  return timing.scan_out == ScanOut::rolling ? timing.scan_duration / 2 : Duration{0};
}

/// When the late pose is measured.
[[nodiscard]] inline HostTime late_time(const ExperimentSettings& settings, HostTime t_display) {
  const HostTime begin = t_display - half_scan(settings.hmd.timing);
  return std::min(begin, std::max(begin - settings.late, t_display - settings.latency));
}

/// The head at the light of the first line, of the middle one and of the last, as known in time to deflect.
struct LateHeadPoses {
  Rigid X_WH_begin, X_WH_middle, X_WH_end;

  [[nodiscard]] LatePoses of_eye(const Rigid& X_HE) const {
    return {X_WH_begin * X_HE, X_WH_end * X_HE, X_WH_middle * X_HE};
  }
};

[[nodiscard]] inline LateHeadPoses late_poses(const Motion& motion, const ExperimentSettings& settings,
                                              HostTime t_display) {
  const Duration half = half_scan(settings.hmd.timing);
  const HostTime begin = t_display - half, end = t_display + half;
  if (settings.perfect_late_pose) return {motion.at(begin).X_WB, motion.at(t_display).X_WB, motion.at(end).X_WB};
  const PoseEstimate measured = measure(motion, settings, late_time(settings, t_display));
  const Rigid X_WH_middle = predicted_pose(settings, measured, t_display);
  if (half == Duration{0}) return {X_WH_middle, X_WH_middle, X_WH_middle};
  return {predicted_pose(settings, measured, begin), X_WH_middle, predicted_pose(settings, measured, end)};
}

/// The displayed pose, see above.
[[nodiscard]] inline Rigid displayed_pose(DeflectionKind kind, const Rigid& X_WH_drawn, const Rigid& X_WH_late) {
  switch (kind) {
    case DeflectionKind::none:
      break;
    case DeflectionKind::shift:
    case DeflectionKind::shift_roll:
    case DeflectionKind::rotation:
      return Rigid(X_WH_late.q(), X_WH_drawn.p());
    case DeflectionKind::plane:
    case DeflectionKind::depth:
      return X_WH_late;
  }
  return X_WH_drawn;
}

/// X_WH as displayed by a frame whose middle of scan-out is t_display.
[[nodiscard]] inline Rigid displayed_pose(const Motion& motion, const ExperimentSettings& settings,
                                          HostTime t_display) {
  const DeflectionKind kind = deflection_of(settings).kind;
  const Rigid X_WH_drawn = drawn_pose(motion, settings, t_display);
  if (kind == DeflectionKind::none) return X_WH_drawn;
  return displayed_pose(kind, X_WH_drawn, late_poses(motion, settings, t_display).X_WH_middle);
}

/// How far ahead the displayed orientation is predicted: the latency, or the late pose's age at the middle of scan-out.
[[nodiscard]] inline Duration prediction_interval(const ExperimentSettings& settings) {
  if (deflection_of(settings).kind == DeflectionKind::none) return settings.latency;
  return -(late_time(settings, HostTime{}) - HostTime{});
}

}  // namespace holdfast
