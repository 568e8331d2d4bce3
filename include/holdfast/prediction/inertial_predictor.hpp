/// The recommended predictor: measured poses and inertial readings in, the pose at any display time out, with covariance.
///
///     InertialPredictor head;
///     head.update(reading);                              // each InertialReading, as it comes
///     head.update(pose);                                 // each measured TimedPose, as it comes: later, and slower
///     InertialPrediction r = head.predict(t_display);    // r.X_WB, r.covariance; r.status, r.by, r.gyro, r.accelerometer
/// An error-state filter finds pose, velocity and what the sensors do not tell about themselves (inertial_filter.hpp); how
/// the newest readings are to be carried on is weighed anew for every horizon by what would have been best in the last two
/// seconds (horizon_learner.hpp), so that higher derivatives count where they help and do not where they hurt.
/// Nothing is silent:
///   r.status   as of every prediction: ok, clamped (held beyond `limits.future`), backwards, no_velocity (no pose yet)
///   r.by       inertial; poses, when the gyro cannot be believed or the poses are long ago: then a PoseFilter of the poses
///              alone predicts; source, when `source_predicts`: the newest pose as it is, not predicted twice
///   r.gyro, r.accelerometer   what is wrong with them (inertial_health.hpp). Without accelerometer it stays inertial.
/// Covariance: of (dp, dphi), without cross terms, against poses as they are measured: their noise is in it.
/// Hot path: nothing here allocates (but the constructor), locks or throws.
/// Bad input: readings and poses that are not finite, or that go back in time, are refused and named.
#pragma once

#include <holdfast/prediction/horizon_learner.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/tracking/inertial_health.hpp>
#include <holdfast/tracking/pose_filter.hpp>

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
        poses_(settings.model, settings.poses) {}

  /// False: refused.
  bool update(const InertialReading& reading) {
    const InertialHistory& history = filter_.history();
    const HostTime before = history.empty() ? reading.t : history.newest().t;
    if (!history.empty() && reading.t <= before) return refuse_backwards(reading);
    gyro_.read(reading.t, reading.rate_B, settings_.ranges.rate);
    accelerometer_.read(reading.t, reading.force_B, settings_.ranges.force);
    filter_.use_force(accelerometer_.fault(reading.t) == SensorFault::none);
    if (!filter_.update(reading)) return false;
    backwards_ = 0;
    if (!filter_.is_started()) return true;
    if (reading.t - before > longest_silence) acceleration_W_.restart();
    acceleration_W_.update(to_seconds(reading.t - before), filter_.acceleration_now_W());
    trend_ = motion_trend(filter_, acceleration_W_);
    if (is_inertial() && trend_.t - remembered_ > rare) remember();
    return true;
  }

  InertialPoseUpdate update(const TimedPose& pose) {
    const PoseFilterStatus by_poses = poses_.update(pose);
    if (by_poses == PoseFilterStatus::refused) return InertialPoseUpdate::refused;
    const bool was_inertial = is_inertial_;
    const bool goes_on = by_poses == PoseFilterStatus::updated;
    check_sensors(pose, goes_on);
    previous_ = pose;
    is_inertial_ = gyro_.fault(pose.t) == SensorFault::none && !filter_.history().empty();
    if (!is_inertial_) {
      learner_.forget_moments();
      return goes_on ? InertialPoseUpdate::updated : InertialPoseUpdate::started;
    }
    if (was_inertial) learner_.learn(pose);
    if (!was_inertial) filter_.start(pose);
    const InertialPoseUpdate status = was_inertial ? filter_.update(pose) : InertialPoseUpdate::started;
    if (status == InertialPoseUpdate::started) learner_.forget_moments();
    trend_ = motion_trend(filter_, acceleration_W_);
    remember();
    return status;
  }

  [[nodiscard]] InertialPrediction predict(HostTime t) const {
    InertialPrediction result;
    if (!poses_.is_started()) {
      result.t = t;
      result.status = PredictionStatus::no_velocity;
    } else if (settings_.source_predicts) {
      result = as_measured(t);
    } else if (is_inertial()) {
      result = by_inertial(t);
    } else {
      static_cast<PredictionResult&>(result) = predict_state(poses_.state(), settings_.model, t, settings_.limits);
      result.by = PredictedBy::poses;
    }
    result.gyro = gyro_.fault(previous_.t);
    result.accelerometer = accelerometer_.fault(previous_.t);
    return result;
  }

  /// What was found out about the sensors.
  [[nodiscard]] const InertialFilter& filter() const { return filter_; }
  [[nodiscard]] const PoseFilter<3>& pose_filter() const { return poses_; }
  /// Whether the inertial sensors are what predictions are made from.
  [[nodiscard]] bool is_inertial() const {
    return is_inertial_ && filter_.now().t - filter_.state().t < settings_.filter.longest_gap;
  }

 private:
  static constexpr Duration longest_silence = std::chrono::milliseconds(50), rare = std::chrono::milliseconds(12);
  static constexpr int new_clock_after = 10;  ///< readings in a row that are older than the newest

  bool refuse_backwards(const InertialReading& reading) {
    gyro_.report(SensorFault::time_backwards, previous_.t);
    accelerometer_.report(SensorFault::time_backwards, previous_.t);
    if (++backwards_ == new_clock_after) {
      filter_.forget_readings();
      learner_.forget_moments();
      acceleration_W_.restart();
      backwards_ = 0;
      return filter_.update(reading);
    }
    return false;
  }

  void remember() {
    learner_.remember(trend_);
    remembered_ = trend_.t;
  }

  void check_sensors(const TimedPose& pose, bool goes_on) {
    const InertialHistory& history = filter_.history();
    if (history.empty() || pose.t - history.newest().t > longest_silence) {
      gyro_.report(SensorFault::disconnected, pose.t);
      accelerometer_.report(SensorFault::disconnected, pose.t);
      return;
    }
    if (!goes_on) return;
    const InertialState& state = filter_.state();
    gyro_.expect(pose.t, poses_.state().velocity.w_WB_B + state.bias.rate_B, 0.5);
    if (filter_.is_started()) {
      accelerometer_.expect(pose.t, state.bias.force_B - pose.X_WB.q().conjugate() * state.gravity_W, 3.0);
      const bool gravity_is_known = filter_.covariance().diagonal().segment<3>(InertialState::gravity).sum() < 0.1;
      if (gravity_is_known && std::abs(state.gravity_W.norm() - standard_gravity) > 0.6) {
        accelerometer_.report(SensorFault::wrong_gravity, pose.t);
      }
    }
    const StrapdownIncrement turned = history.integrate(previous_.t + filter_.time_offset(),
                                                        pose.t + filter_.time_offset(), state.bias, Vector3::Zero());
    const Vector3 by_poses = so3::log<double>(previous_.X_WB.q().conjugate() * pose.X_WB.q());
    turns_.add(so3::log<double>(turned.q), by_poses);
    const double noise = filter_.pose_noise().orientation_rad;
    if (turns_.contradicts(noise)) gyro_.report(SensorFault::inconsistent, pose.t);
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
  PoseFilter<3> poses_;
  AccelerationTrend acceleration_W_;
  TriadHealth gyro_, accelerometer_;
  TurnComparison turns_;
  MotionTrend trend_;
  TimedPose previous_;
  HostTime remembered_;
  bool is_inertial_ = false;
  int backwards_ = 0;
};

}  // namespace holdfast
