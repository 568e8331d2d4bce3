/// The pose that a pipeline shows: what the tracker measured `latency` before the middle of scan-out, and what was made
/// of it.
///
/// The simulated tracker is ideal apart from a constant error X_HT: it says X_WH(t) X_HT. P0 shows that pose; P1
/// carries it on at constant velocity over the latency. The velocity is the motion's own at the moment of measurement,
/// as an ideal rate gyro's would be, or the causal difference of two measured poses: a recording's spline bends already
/// before the head does, so its derivative knows the future. Source: evaluation.md "Default experiments". Bad input:
/// pipelines other than P0 and P1 are a programmer's error here; run_experiment refuses them.
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

/// X_WH as displayed by a frame whose middle of scan-out is t_display.
[[nodiscard]] inline Rigid displayed_pose(const Motion& motion, const ExperimentSettings& settings,
                                          HostTime t_display) {
  HOLDFAST_ASSERT(is_available(settings.pipeline), "pipeline not available yet");
  const PoseEstimate measured = measure(motion, settings, t_display - settings.latency);
  PredictionLimits limits;
  limits.maximum_interval = std::max(limits.maximum_interval, settings.latency);  // the experiment wants all of it
  const Predictor predictor = settings.pipeline == Pipeline::p0 ? Predictor::none : Predictor::constant_velocity;
  return predict(predictor, measured, t_display, limits).X_WB;
}

}  // namespace holdfast
