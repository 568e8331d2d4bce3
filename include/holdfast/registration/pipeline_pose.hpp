/// The poses of a pipeline: the one that a frame is drawn for, the late ones that it is deflected to, and the one for
/// which the picture is right in the end.
///
/// The simulated tracker is ideal apart from a constant error X_HT: it says X_WH(t) X_HT. A frame is drawn for what was
/// measured `latency` before the middle of scan-out: P0 takes that pose, the others carry it on over the latency.
///   P1         at constant velocity. The velocity is the motion's own at the moment of measurement, as an ideal rate
///              gyro's would be, or the causal difference of two measured poses: a recording's spline bends already
///              before the head does, so its derivative knows the future.
///   P2         by a Kalman filter (pose_filter.hpp) of all poses measured since the motion's begin: the last is that
///              of P0, the others come before it at most `tracker_interval` apart. No velocity is measured.
///   P3 to P6   by InertialPredictor, of the same poses and of an inertial unit's readings until the last of them. The
///              unit rides along the motion, and errs as real ones do (inertial_sensor.hpp).
/// All that predict take the light for `interval_error` later than it is.
///
/// The late pose is measured `late` before the scan-out starts, and carried on to the light of the first, the
/// middle and the last line by the same predictor. It is never older than the pose that was drawn for, nor newer than the scan-out's start.
///
/// Displayed pose (what the pose columns judge), at the middle of scan-out: not deflected, the pose drawn for;
/// shift, shift_roll and rotation, the late orientation at the place drawn for (what a shift leaves of the turn shows in
/// the fiducials alone); plane and depth, the late pose. Source: evaluation.md "Default experiments". Precondition:
/// settings that run_experiment would take.
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include <holdfast/motion/motion.hpp>
#include <holdfast/prediction/inertial_predictor.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
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
  switch (prediction_of(pipeline)) {
    case PosePrediction::none:
      return Predictor::none;
    case PosePrediction::constant_velocity:
      return Predictor::constant_velocity;
    case PosePrediction::kalman:
    case PosePrediction::kalman_inertial:
      break;
  }
  return std::nullopt;
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

/// A tracker with an inertial unit on the head, as the motion goes.
class InertialTracker {
 public:
  InertialTracker(const Motion& motion, const ExperimentSettings& settings)
      : sensors_(motion, carried_unit(settings), settings.inertial_seed),
        predictor_(predictor_settings(settings)),
        next_(sensors_.next()) {}

  /// A measured pose, and the readings until then.
  void follow(const TimedPose& pose) {
    while (next_ && next_->t <= pose.t) {
      predictor_.update(*next_);
      next_ = sensors_.is_done() ? std::nullopt : std::optional(sensors_.next());
    }
    predictor_.update(pose);
  }
  [[nodiscard]] const InertialPredictor& predictor() const { return predictor_; }

 private:
  static InertialUnit carried_unit(const ExperimentSettings& settings) {
    InertialUnit unit = settings.inertial;
    unit.X_BS = settings.X_HT * unit.X_BS;
    return unit;
  }
  static InertialPredictorSettings predictor_settings(const ExperimentSettings& settings) {
    InertialPredictorSettings inertial;
    inertial.model = settings.filter_model;
    inertial.poses = settings.filter;
    inertial.limits.future = std::chrono::hours(1);  // what a long interval does is to be seen
    return inertial;
  }

  InertialSimulator sensors_;
  InertialPredictor predictor_;
  std::optional<InertialReading> next_;
};

/// Answers where the head is at one time as known at another. Quickest for measurements that only become newer.
class HeadPredictor {
 public:
  HeadPredictor(const Motion& motion, const ExperimentSettings& settings)
      : motion_(motion),
        settings_(settings),
        prediction_(prediction_of(settings.pipeline)),
        filter_(settings.filter_model, settings.filter) {}

  /// X_WH at t, from what was measured until t_measured.
  [[nodiscard]] Rigid at(HostTime t, HostTime t_measured) {
    if (prediction_ != PosePrediction::none) t += settings_.interval_error;
    if (prediction_ == PosePrediction::kalman_inertial) return at_by_inertial(t, t_measured);
    const Duration whole = std::max<Duration>(PredictionLimits().maximum_interval, t - t_measured);
    if (const std::optional<Predictor> predictor = predictor_of(settings_.pipeline)) {
      return predict(*predictor, measure(motion_, settings_, t_measured), t, {whole}).X_WB;
    }
    follow(t_measured);
    return predict_state(filter_.state(), filter_.model(), t, {whole}).X_WB;
  }

 private:
  [[nodiscard]] Rigid at_by_inertial(HostTime t, HostTime t_measured) {
    KnownPoses* const known = settings_.known_poses.get();
    if (known != nullptr) {
      const auto found = known->find({t, t_measured});
      if (found != known->end()) return found->second;
    }
    follow(t_measured);
    const Rigid X_WH = inertial_->predictor().predict(t).X_WB;
    if (known != nullptr) known->emplace(std::pair(t, t_measured), X_WH);
    return X_WH;
  }
  /// Tracks what is measured until t, evenly.
  void follow(HostTime t) {
    if (!known_until_ || t < *known_until_) start(std::min(t, motion_.begin()));
    const HostTime from = *known_until_;
    const auto steps = (t - from + settings_.tracker_interval - Duration{1}) / settings_.tracker_interval;
    for (auto i = 1; i <= steps; ++i) {
      const TimedPose pose = measured_pose(from + (t - from) * i / steps);
      inertial_ ? inertial_->follow(pose) : void(filter_.update(pose));
    }
    known_until_ = t;
  }
  void start(HostTime t) {
    if (prediction_ == PosePrediction::kalman_inertial) {
      inertial_.emplace(motion_, settings_).follow(measured_pose(t));
    } else {
      filter_.start(measured_pose(t));
    }
    known_until_ = t;
  }
  [[nodiscard]] TimedPose measured_pose(HostTime t) const { return {t, motion_.at(t).X_WB * settings_.X_HT}; }

  const Motion& motion_;
  const ExperimentSettings& settings_;
  PosePrediction prediction_;
  PoseFilter<3> filter_;
  std::optional<InertialTracker> inertial_;
  std::optional<HostTime> known_until_;
};

}  // namespace detail

/// All poses of one experiment's frames. Motion and settings are not owned.
class PipelinePoses {
 public:
  PipelinePoses(const Motion& motion, const ExperimentSettings& settings)
      : motion_(motion), settings_(settings), drawn_(motion, settings), late_(motion, settings) {}
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
