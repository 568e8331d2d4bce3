/// The poses of a pipeline: the one that a frame is drawn for, the late ones that it is deflected to, and the one for
/// which the picture is right in the end.
///
/// The simulated tracker is ideal apart from a constant error X_HT: it says X_WH(t) X_HT. A frame is drawn for what was
/// measured `latency` before the middle of scan-out: P0 takes that pose, the others carry it on over the latency.
///   P1, P4 to P6   at constant velocity. The velocity is the motion's own at the moment of measurement, as an ideal rate
///                  gyro's would be, or the causal difference of two measured poses: a recording's spline bends already
///                  before the head does, so its derivative knows the future.
///   P2             by a Kalman filter (pose_filter.hpp) of all poses measured since the motion's begin: the last is that
///                  of P0, the others come before it at most `tracker_interval` apart. No velocity is measured.
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
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/tracking/backward_difference.hpp>
#include <holdfast/tracking/pose_filter.hpp>

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

/// The predictor that works on one measurement alone; nothing when the pipeline filters them.
[[nodiscard]] constexpr std::optional<Predictor> predictor_of(Pipeline pipeline) {
  if (pipeline == Pipeline::p2) return std::nullopt;
  return pipeline == Pipeline::p0 ? Predictor::none : Predictor::constant_velocity;
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

namespace detail {

/// Answers where the head is at one time as known at another. Quickest for measurements that only become newer.
class HeadPredictor {
 public:
  HeadPredictor(const Motion& motion, const ExperimentSettings& settings)
      : motion_(motion), settings_(settings), filter_(settings.filter_model, settings.filter) {}

  /// X_WH at t, from what was measured until t_measured.
  [[nodiscard]] Rigid at(HostTime t, HostTime t_measured) {
    const Duration whole = std::max<Duration>(PredictionLimits().maximum_interval, t - t_measured);
    if (const std::optional<Predictor> predictor = predictor_of(settings_.pipeline)) {
      return predict(*predictor, measure(motion_, settings_, t_measured), t, {whole}).X_WB;
    }
    follow(t_measured);
    return predict_state(filter_.state(), filter_.model(), t, {whole}).X_WB;
  }

 private:
  /// Filters what is measured until t, evenly.
  void follow(HostTime t) {
    if (!filter_.is_started() || t < filter_.state().t) start(std::min(t, motion_.begin()));
    const HostTime from = filter_.state().t;
    const auto steps = (t - from + settings_.tracker_interval - Duration{1}) / settings_.tracker_interval;
    for (auto i = 1; i <= steps; ++i) filter_.update(measured_pose(from + (t - from) * i / steps));
  }
  void start(HostTime t) { filter_.start(measured_pose(t)); }
  [[nodiscard]] TimedPose measured_pose(HostTime t) const { return {t, motion_.at(t).X_WB * settings_.X_HT}; }

  const Motion& motion_;
  const ExperimentSettings& settings_;
  PoseFilter<3> filter_;
};

}  // namespace detail

/// All poses of one experiment's frames. Motion and settings are not owned.
class PipelinePoses {
 public:
  PipelinePoses(const Motion& motion, const ExperimentSettings& settings)
      : motion_(motion), settings_(settings), drawn_(motion, settings), late_(motion, settings) {
    HOLDFAST_ASSERT(is_available(settings.pipeline), "pipeline not available yet");
  }
  PipelinePoses(const PipelinePoses&) = delete;
  PipelinePoses& operator=(const PipelinePoses&) = delete;

  /// X_WH that a frame is drawn for whose middle of scan-out is t_display.
  [[nodiscard]] Rigid drawn(HostTime t_display) { return drawn_.at(t_display, t_display - settings_.latency); }

  [[nodiscard]] LateHeadPoses late(HostTime t_display) {
    const Duration half = half_scan(settings_.hmd.timing);
    const HostTime begin = t_display - half, end = t_display + half;
    if (settings_.perfect_late_pose) return {motion_.at(begin).X_WB, motion_.at(t_display).X_WB, motion_.at(end).X_WB};
    const HostTime t_measured = late_time(settings_, t_display);
    const Rigid X_WH_middle = late_.at(t_display, t_measured);
    if (half == Duration{0}) return {X_WH_middle, X_WH_middle, X_WH_middle};
    return {late_.at(begin, t_measured), X_WH_middle, late_.at(end, t_measured)};
  }

  /// X_WH as displayed by a frame whose middle of scan-out is t_display.
  [[nodiscard]] Rigid displayed(HostTime t_display) {
    const DeflectionKind kind = deflection_of(settings_).kind;
    const Rigid X_WH_drawn = drawn(t_display);
    return kind == DeflectionKind::none ? X_WH_drawn : displayed_pose(kind, X_WH_drawn, late(t_display).X_WH_middle);
  }

 private:
  const Motion& motion_;
  const ExperimentSettings& settings_;
  detail::HeadPredictor drawn_, late_;
};

/// How far ahead the displayed orientation is predicted: the latency, or the late pose's age at the middle of scan-out.
[[nodiscard]] inline Duration prediction_interval(const ExperimentSettings& settings) {
  if (deflection_of(settings).kind == DeflectionKind::none) return settings.latency;
  return -(late_time(settings, HostTime{}) - HostTime{});
}

}  // namespace holdfast
