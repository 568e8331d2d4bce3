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
/// Covariance: of (dp, dphi), without cross terms, against poses as they are measured: their noise is in it. It is learnt from
/// predictions between poses; where poses are missing, and for half a second after a start, the filter's own covariance says what
/// comes to it (inertial_spread.hpp).
/// Hot path: nothing here allocates (but the constructor), locks or throws.
/// Bad input: readings and poses that are not finite, or that go back in time, are refused and named; ten in a row are a clock that
/// was set back, and followed. A pose that no head could have is rejected, and nothing learnt from it.
#pragma once

#include <algorithm>
#include <optional>

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
    if (!is_usual(reading.t)) return false;
    if (read_ && reading.t <= *read_) return refuse_backwards(reading);
    const double since = read_ ? to_seconds(reading.t - *read_) : 0.0;
    read_ = reading.t;
    backwards_ = 0;
    reading_interval_s_ += 0.1 * (std::min(since, to_seconds(longest_silence)) - reading_interval_s_);
    gyro_.read(reading.t, reading.rate_B, std::min(settings_.ranges.rate, fastest_rad_s));
    accelerometer_.read(reading.t, reading.force_B, std::min(settings_.ranges.force, hardest_m_s2));
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

  InertialPoseUpdate update(const TimedPose& pose) {
    const InertialPoseUpdate by_poses = update_poses(pose);
    if (by_poses == InertialPoseUpdate::refused) return by_poses;
    const bool was_inertial = is_inertial_;
    InertialPoseUpdate status = by_poses;
    if (was_inertial && is_connected(pose.t)) status = filter_.update(pose);
    check_sensors(pose, by_poses, status);
    measured_ = pose;
    is_inertial_ = gyro_.fault(pose.t) == SensorFault::none && !filter_.history().empty();
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
    result.gyro = gyro_.fault(measured_.t);
    result.accelerometer = accelerometer_.fault(measured_.t);
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
  static constexpr Duration longest_silence = std::chrono::milliseconds(50), rare = std::chrono::milliseconds(12),
                            often = std::chrono::milliseconds(5);  ///< between the moments to learn from
  static constexpr int new_clock_after = 10;  ///< readings, or poses, in a row that are older than the newest
  static constexpr int patience = 4;          ///< poses in a row that no head could have

  /// One said twice, or a little late, is left out quietly.
  bool refuse_backwards(const InertialReading& reading) {
    if (reading.t == *read_) return false;
    ++backwards_;
    if (backwards_ > 2 || to_seconds(*read_ - reading.t) > 4.0 * reading_interval_s_) {
      gyro_.report(SensorFault::time_backwards, measured_.t);
      accelerometer_.report(SensorFault::time_backwards, measured_.t);
    }
    if (backwards_ < new_clock_after) return false;
    filter_.forget_readings();
    learner_.forget_moments();
    acceleration_W_.restart();
    gravity_.restart();
    backwards_ = 0;
    read_ = reading.t;
    return filter_.update(reading);
  }

  /// Whether the reading's force counts. When gravity was wrong and is so no more, what was learnt with it goes.
  void use_force(const InertialReading& reading, double since) {
    const auto is_weighed = [&] {
      const SensorFault fault = accelerometer_.fault(reading.t);
      return fault == SensorFault::none || fault == SensorFault::wrong_gravity;
    };
    if (since > to_seconds(longest_silence)) gravity_.restart();
    if (is_weighed() && is_inertial() && reading.has_force()) {
      gravity_.add(filter_.now().X_WS.q() * (reading.force_B - filter_.state().bias.force_B), since);
      if (gravity_.contradicts()) accelerometer_.report(SensorFault::wrong_gravity, reading.t);
    }
    const SensorFault fault = accelerometer_.fault(reading.t);
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
    if (status == InertialPoseUpdate::updated) {
      learner_.learn(pose);
      const double since = to_seconds(pose.t - previous_.t);
      pose_interval_s_ += (pose_interval_s_ > 0.0 ? 0.05 : 1.0) * (since - pose_interval_s_);
    } else {
      learner_.forget_moments();
      settled_ = pose.t + std::chrono::milliseconds(500);
    }
    spread_ = filter_.spread();
    if (pose.t >= settled_) {
      usual_spread_.place += 0.05 * (spread_.place - usual_spread_.place);
      usual_spread_.turn += 0.05 * (spread_.turn - usual_spread_.turn);
    }
    trend_ = motion_trend(filter_, acceleration_W_);
    remember(often);
  }

  /// Of the poses alone. PoseFilter believes everything: what no head does is kept from it, unless it comes again and again.
  InertialPoseUpdate update_poses(const TimedPose& pose) {
    if (!is_usual(pose.t) || !pose.X_WB.is_finite()) return InertialPoseUpdate::refused;
    if (poses_.is_started() && pose.t <= poses_.state().t) {
      if (++refused_ < new_clock_after) return InertialPoseUpdate::refused;
      is_inertial_ = false;  // their clock was set back: begin anew
      return start_poses(pose);
    }
    if (contradicts(pose)) return ++doubted_ < patience ? InertialPoseUpdate::rejected : start_poses(pose);
    const PoseFilterStatus status = poses_.update(pose);
    if (status == PoseFilterStatus::refused) return InertialPoseUpdate::refused;
    refused_ = doubted_ = 0;
    return status == PoseFilterStatus::updated ? InertialPoseUpdate::updated : InertialPoseUpdate::started;
  }
  InertialPoseUpdate start_poses(const TimedPose& pose) {
    if (!(pose.X_WB.p().squaredNorm() < 1e18)) return InertialPoseUpdate::refused;
    poses_.start(pose);
    refused_ = doubted_ = 0;
    return InertialPoseUpdate::started;
  }
  /// Eight standard deviations off, of poses that are noisy by 10 mm and 1 degree.
  [[nodiscard]] bool contradicts(const TimedPose& pose) const {
    if (!poses_.is_started() || pose.t - poses_.state().t > settings_.poses.longest_gap) return false;
    const PredictionResult expected = predict_state(poses_.state(), settings_.model, pose.t, settings_.limits);
    const auto is_off = [](double square, double variance, double noise) {
      return !(square < 64.0 * (variance + noise * noise));
    };
    const double turn = so3::angle_between<double>(expected.X_WB.q(), pose.X_WB.q());
    const Vector6 variance = expected.covariance.diagonal();
    return is_off((pose.X_WB.p() - expected.X_WB.p()).squaredNorm(), variance.head<3>().sum(), 0.01) ||
           is_off(turn * turn, variance.tail<3>().sum(), 0.0175);
  }

  /// Whether readings that can be integrated come until the pose.
  [[nodiscard]] bool is_connected(HostTime t) const {
    const InertialHistory& history = filter_.history();
    return !history.empty() && t - history.newest().t <= longest_silence;
  }

  void check_sensors(const TimedPose& pose, InertialPoseUpdate by_poses, InertialPoseUpdate status) {
    if (!read_ || pose.t - *read_ > longest_silence) {
      gyro_.report(SensorFault::disconnected, pose.t);
      accelerometer_.report(SensorFault::disconnected, pose.t);
    }
    if (!is_connected(pose.t) || by_poses == InertialPoseUpdate::started) return;
    compare_turns(pose, status);
    if (by_poses != InertialPoseUpdate::updated || status == InertialPoseUpdate::rejected) return;
    const InertialState& state = filter_.state();
    gyro_.expect(pose.t, poses_.state().velocity.w_WB_B + state.bias.rate_B, 0.5);
    if (!filter_.is_started()) return;
    accelerometer_.expect(pose.t, state.bias.force_B - pose.X_WB.q().conjugate() * state.gravity_W, 3.0);
  }

  /// Turns to rejected poses count when the filter had to begin anew from them; those to a lone one never.
  void compare_turns(const TimedPose& pose, InertialPoseUpdate status) {
    const bool believed = status == InertialPoseUpdate::updated;
    const TimedPose& from = believed ? previous_ : measured_;
    if (from.t >= pose.t || pose.t - from.t > settings_.poses.longest_gap) return;
    const StrapdownIncrement turned = filter_.history().integrate(
        from.t + filter_.time_offset(), pose.t + filter_.time_offset(), filter_.state().bias, Vector3::Zero());
    (believed ? turns_ : doubtful_turns_)
        .add(so3::log<double>(turned.q), so3::log<double>(from.X_WB.q().conjugate() * pose.X_WB.q()));
    if (believed) doubtful_turns_ = turns_;
    if (status == InertialPoseUpdate::started) turns_ = doubtful_turns_;
    if (turns_.contradicts(filter_.pose_noise().orientation_rad)) gyro_.report(SensorFault::inconsistent, pose.t);
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
    add_growth(result.covariance, std::max(0.0, h));
    if (asked == h) return result;
    result.status = asked > h ? PredictionStatus::clamped : PredictionStatus::backwards;
    Vector6 missed;  // held there: what the velocity says of the rest is an error
    missed << (asked - h) * trend_.move_rates.col(0), (asked - h) * trend_.turn_rates.col(0);
    result.covariance += missed * missed.transpose();
    return result;
  }

  /// By how much the pose is more uncertain than it was when the covariance was learnt.
  void add_growth(Matrix6& covariance, double h) const {
    const double since = to_seconds(trend_.t - filter_.state().t), usual = pose_interval_s_ + h;
    if (since <= 1.5 * pose_interval_s_ && filter_.state().t >= settled_) return;
    const double place = spread_.place_m2(since + h) - usual_spread_.place_m2(usual);
    const double turn = spread_.turn_rad2(since + h) - usual_spread_.turn_rad2(usual);
    covariance.diagonal().head<3>().array() += std::max(0.0, place);
    covariance.diagonal().tail<3>().array() += std::max(0.0, turn);
  }

  InertialPredictorSettings settings_;
  InertialFilter filter_;
  HorizonLearner learner_;
  PoseFilter<3> poses_;
  AccelerationTrend acceleration_W_;
  TriadHealth gyro_, accelerometer_;
  GravityCheck gravity_;
  TurnComparison turns_, doubtful_turns_;  ///< those between believed poses; and with the rejected ones since
  MotionTrend trend_;
  PoseSpread spread_, usual_spread_;  ///< after the newest pose, and of late
  double pose_interval_s_ = 0.0;
  HostTime settled_;
  TimedPose previous_, measured_;  ///< the newest that was believed, and the newest
  HostTime remembered_;
  std::optional<HostTime> read_;  ///< of the newest reading, whatever was in it
  double reading_interval_s_ = 0.0;
  bool is_inertial_ = false, gravity_was_wrong_ = false;
  int backwards_ = 0, refused_ = 0, doubted_ = 0;  ///< in a row
};

}  // namespace holdfast
