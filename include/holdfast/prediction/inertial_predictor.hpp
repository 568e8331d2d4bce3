/// The recommended predictor: measured poses and inertial readings in, the pose at any display time out, with
/// covariance.
///
///     InertialPredictor head;
///     head.update(reading);                              // each InertialReading, as it comes
///     head.update(pose);                                 // each measured TimedPose, as it comes: later, and slower
///     InertialPrediction r = head.predict(t_display);    // r.X_WB, r.covariance; r.status, r.by, r.gyro,
/// r.accelerometer An error-state filter finds pose, velocity and what the sensors do not tell about themselves
/// (inertial_filter.hpp); how the newest readings are to be carried on is weighed anew for every horizon by what would
/// have been best in the last two seconds (horizon_learner.hpp), so that higher derivatives count where they help and
/// do not where they hurt.
/// Nothing is silent:
///   r.status   as of every prediction: ok, clamped (held beyond `limits.future`), backwards, no_velocity (no pose yet)
///   r.by       inertial; poses, when the gyro cannot be believed or the poses are long ago: then a PoseFilter of the
/// poses
///              alone predicts; source, when `source_predicts`: the newest pose as it is, not predicted twice
///   r.gyro, r.accelerometer   what is wrong with them (inertial_health.hpp). Without accelerometer it stays inertial.
/// Covariance: of (dp, dphi), without cross terms, against the true pose. It is learnt from predictions between poses,
/// less the noise that these were found to have (error_spread.hpp). Where poses are missing, and for half a second
/// after a start, the filter's covariance says what comes to it (learnt_uncertainty.hpp).
/// Hot path: nothing here allocates (but the constructor), locks or throws. It is an object of about 110 kB, most of it
/// the moments to learn from: keep it on the heap where stacks are small.
/// Bad input: readings and poses that are not finite, or that go back in time, are refused and named; ten in a row are
/// a clock that was set back, and followed. A pose that no head could have is rejected, and nothing learnt from it.
#pragma once

#include <algorithm>
#include <optional>

#include <holdfast/prediction/guarded_pose_filter.hpp>
#include <holdfast/prediction/horizon_learner.hpp>
#include <holdfast/prediction/learnt_uncertainty.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/tracking/inertial_watch.hpp>

namespace holdfast {

struct InertialPredictorSettings {
  InertialFilterSettings filter;
  HorizonLearnerSettings learner;
  PvaModel model = head_model();  ///< of the filter of poses alone
  PoseFilterSettings poses;
  InertialRanges ranges;
  StatePredictionLimits limits;
  bool source_predicts = false;  ///< the poses are predictions already
};

/// Since the begin.
struct InertialCounts {
  std::size_t readings = 0, poses = 0;                  ///< used
  std::size_t refused_readings = 0, refused_poses = 0;  ///< not finite, said twice, or back in time
  std::size_t rejected_poses = 0;                       ///< no head could have them
};

enum class PredictedBy { nothing, inertial, poses, source };

[[nodiscard]] constexpr std::string_view to_string(PredictedBy by) {
  constexpr std::array<std::string_view, 4> names{"nothing", "inertial", "poses", "source"};
  return names[static_cast<std::size_t>(by)];
}

struct InertialPrediction : PredictionResult {
  PredictedBy by = PredictedBy::nothing;
  SensorFault gyro = SensorFault::none, accelerometer = SensorFault::none;
};

class InertialPredictor {
 public:
  explicit InertialPredictor(const InertialPredictorSettings& settings = {})
      : settings_(settings),
        filter_(settings.filter),
        learner_(settings.learner),
        poses_(settings.model, settings.poses),
        sensors_(settings.ranges) {}

  /// False: refused.
  bool update(const InertialReading& reading) {
    const bool used = take(reading);
    ++(used ? counts_.readings : counts_.refused_readings);
    return used;
  }
  InertialPoseUpdate update(const TimedPose& pose) {
    const InertialPoseUpdate status = take(pose);
    ++(status == InertialPoseUpdate::refused    ? counts_.refused_poses
       : status == InertialPoseUpdate::rejected ? counts_.rejected_poses
                                                : counts_.poses);
    return status;
  }

  [[nodiscard]] InertialPrediction predict(HostTime t) const {
    InertialPrediction result;
    if (!poses_.filter().is_started()) {
      result.t = t;
      result.status = PredictionStatus::no_velocity;
    } else if (settings_.source_predicts) {
      result = as_measured(t);
    } else if (is_inertial()) {
      result = by_inertial(t);
    } else {
      static_cast<PredictionResult&>(result) =
          predict_state(poses_.filter().state(), settings_.model, t, settings_.limits);
      result.by = PredictedBy::poses;
    }
    result.gyro = sensors_.gyro(measured_.t);
    result.accelerometer = sensors_.accelerometer(measured_.t);
    return result;
  }

  /// What was found out about the sensors.
  [[nodiscard]] const InertialFilter& filter() const { return filter_; }
  [[nodiscard]] const PoseFilter<3>& pose_filter() const { return poses_.filter(); }
  [[nodiscard]] const InertialCounts& counts() const { return counts_; }
  /// Whether the inertial sensors are what predictions are made from.
  [[nodiscard]] bool is_inertial() const {
    return is_inertial_ && filter_.now().t - filter_.state().t < settings_.filter.longest_gap;
  }

 private:
  static constexpr Duration longest_silence = std::chrono::milliseconds(50), rare = std::chrono::milliseconds(12),
                            often = std::chrono::milliseconds(5);  ///< between the moments to learn from
  static constexpr int new_clock_after = 10;                       ///< readings in a row that are older than the newest

  bool take(const InertialReading& reading) {
    if (!is_usual(reading.t)) return false;
    if (read_ && reading.t <= *read_) return refuse_backwards(reading);
    const double since = read_ ? to_seconds(reading.t - *read_) : 0.0;
    read_ = reading.t;
    backwards_ = 0;
    reading_interval_s_ += 0.1 * (std::min(since, to_seconds(longest_silence)) - reading_interval_s_);
    sensors_.read(reading);
    use_force(reading, since);
    const InertialHistory& history = filter_.history();
    const HostTime before = history.empty() ? reading.t : history.newest().t;
    if (!filter_.update(reading)) return false;
    if (!filter_.is_started()) return true;
    if (reading.t - before > longest_silence) acceleration_W_.restart();
    acceleration_W_.update(to_seconds(reading.t - before), filter_.acceleration_now_W());
    trend_ = motion_trend(filter_, acceleration_W_);
    if (is_inertial()) remember(rare);
    return true;
  }

  InertialPoseUpdate take(const TimedPose& pose) {
    const InertialPoseUpdate by_poses = poses_.update(pose);
    if (by_poses == InertialPoseUpdate::refused) return by_poses;
    if (poses_.clock_was_set_back()) is_inertial_ = false;
    const bool was_inertial = is_inertial_;
    InertialPoseUpdate status = by_poses;
    if (was_inertial && is_connected(pose.t)) status = filter_.update(pose);
    check_sensors(pose, by_poses, status);
    measured_ = pose;
    is_inertial_ = sensors_.gyro(pose.t) == SensorFault::none && !filter_.history().empty();
    if (!is_inertial_) status = by_poses;
    if (is_inertial_ && !was_inertial) {
      is_inertial_ = by_poses != InertialPoseUpdate::rejected;
      if (is_inertial_) filter_.start(pose);
      status = is_inertial_ ? InertialPoseUpdate::started : by_poses;
    }
    if (status == InertialPoseUpdate::rejected || status == InertialPoseUpdate::refused) return status;
    if (is_inertial_) {
      learn(pose, status);
    } else {
      learner_.forget_moments();
    }
    previous_ = pose;
    return status;
  }

  /// One said twice, or a little late, is left out quietly.
  bool refuse_backwards(const InertialReading& reading) {
    if (reading.t == *read_) return false;
    ++backwards_;
    if (backwards_ > 2 || to_seconds(*read_ - reading.t) > 4.0 * reading_interval_s_) {
      sensors_.report(SensorFault::time_backwards, measured_.t);
    }
    if (backwards_ < new_clock_after) return false;
    filter_.forget_readings();
    learner_.forget_moments();
    acceleration_W_.restart();
    sensors_.restart_gravity();
    backwards_ = 0;
    read_ = reading.t;
    return filter_.update(reading);
  }

  /// Whether the reading's force counts. When gravity was wrong and is so no more, what was learnt with it goes.
  void use_force(const InertialReading& reading, double since) {
    if (since > to_seconds(longest_silence)) sensors_.restart_gravity();
    if (is_inertial() && reading.has_force()) {
      const Vector3 force_B = reading.force_B - filter_.state().bias.force_B;
      sensors_.weigh(reading.t, filter_.now().X_WS.q() * force_B, since);
    }
    const SensorFault fault = sensors_.accelerometer(reading.t);
    gravity_was_wrong_ = gravity_was_wrong_ || fault == SensorFault::wrong_gravity;
    filter_.use_force(fault == SensorFault::none);
    if (fault != SensorFault::none || !gravity_was_wrong_) return;
    filter_.forget_force();
    gravity_was_wrong_ = false;
  }

  void remember(Duration at_least) {
    if (trend_.t >= remembered_ && trend_.t - remembered_ < at_least) return;
    learner_.remember(trend_);
    remembered_ = trend_.t;
  }

  void learn(const TimedPose& pose, InertialPoseUpdate status) {
    uncertainty_.update(filter_, status);
    if (status == InertialPoseUpdate::updated) {
      learner_.learn(pose, filter_.pose_noise(), uncertainty_.usual(), uncertainty_.usual_age_s());
    } else {
      learner_.forget_moments();
    }
    trend_ = motion_trend(filter_, acceleration_W_);
    remember(often);
  }

  /// Whether readings that can be integrated come until the pose.
  [[nodiscard]] bool is_connected(HostTime t) const {
    const InertialHistory& history = filter_.history();
    return !history.empty() && t - history.newest().t <= longest_silence;
  }

  void check_sensors(const TimedPose& pose, InertialPoseUpdate by_poses, InertialPoseUpdate status) {
    if (!read_ || pose.t - *read_ > longest_silence) sensors_.report(SensorFault::disconnected, pose.t);
    if (!is_connected(pose.t) || by_poses == InertialPoseUpdate::started) return;
    // Turns to rejected poses count when the filter had to begin anew from them; those to a lone one never.
    const bool believed = status == InertialPoseUpdate::updated;
    const TimedPose& from = believed ? previous_ : measured_;
    if (from.t < pose.t && pose.t - from.t <= settings_.poses.longest_gap) {
      sensors_.compare_turn(filter_, from, pose, believed, status == InertialPoseUpdate::started);
    }
    if (by_poses != InertialPoseUpdate::updated || status == InertialPoseUpdate::rejected) return;
    sensors_.expect(filter_, pose, poses_.filter().state().velocity.w_WB_B);
  }

  [[nodiscard]] InertialPrediction as_measured(HostTime t) const {
    InertialPrediction result;
    result.t = t;
    result.X_WB = previous_.X_WB;
    result.by = PredictedBy::source;
    const PoseNoise noise = filter_.pose_noise();
    detail::add_isotropic(result.covariance, noise.position_m, noise.orientation_rad);
    return result;
  }

  [[nodiscard]] InertialPrediction by_inertial(HostTime t) const {
    const double asked = detail::seconds_between(trend_.t, t);
    const double future = to_seconds(settings_.limits.future), past = to_seconds(settings_.limits.past);
    const double h = std::clamp(asked, -past, future);
    InertialPrediction result;
    result.t = t;
    result.by = PredictedBy::inertial;
    result.interval = from_seconds(h);
    const HorizonWeights weights = learner_.at(std::max(0.0, h) + trend_.gap);
    const MotionTrend::TurnWeights turn = weights.turn.cwiseProduct(trend_.turn_powers(h));
    const MotionTrend::MoveWeights move = weights.move.cwiseProduct(trend_.move_powers(h));
    result.X_WB = trend_.carried(trend_.turn_rates * turn, trend_.move_rates * move);
    result.covariance.topLeftCorner<3, 3>() = weights.move_covariance;
    result.covariance.bottomRightCorner<3, 3>() = weights.turn_covariance;
    uncertainty_.complete(result.covariance, trend_.t, std::max(0.0, h));
    if (asked == h) return result;
    result.status = asked > h ? PredictionStatus::clamped : PredictionStatus::backwards;
    Vector6 missed;  // held there: what the velocity says of the rest is an error
    missed << (asked - h) * trend_.move_rates.col(0), (asked - h) * trend_.turn_rates.col(0);
    result.covariance += missed * missed.transpose();
    return result;
  }

  InertialPredictorSettings settings_;
  InertialFilter filter_;
  HorizonLearner learner_;
  LearntUncertainty uncertainty_;
  GuardedPoseFilter poses_;
  InertialWatch sensors_;
  AccelerationTrend acceleration_W_;
  MotionTrend trend_;
  TimedPose previous_, measured_;  ///< the newest that was believed, and the newest
  HostTime remembered_;
  std::optional<HostTime> read_;  ///< of the newest reading, whatever was in it
  double reading_interval_s_ = 0.0;
  InertialCounts counts_;
  bool is_inertial_ = false, gravity_was_wrong_ = false;
  int backwards_ = 0;  ///< readings in a row
};

}  // namespace holdfast
