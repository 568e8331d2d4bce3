/// An inertial pose filter: gyro and accelerometer at their high rate, corrected by whole poses that come slower and
/// late.
///
///     InertialFilter filter;
///     filter.update(reading);          // each InertialReading
///     filter.update(pose);             // each measured TimedPose, of any time since the one before
///     filter.now().X_WB();             // with all readings in it
/// A strapdown integral carries the state, an error-state Kalman filter corrects it (inertial_state.hpp has the 22
/// numbers).
/// What the sensors do not tell about themselves is found on line: biases, gravity in whatever direction, the time by
/// which their stamps lag behind the poses', and where on the body they sit. Integrals, not readings, meet the poses,
/// so the covariance is carried once for each pose; a late pose only makes the readings after it be integrated again.
/// The poses' own noise is estimated from what is left over (innovations), starting at `noise`.
/// Sources: strapdown and error state, Sola 2017 (Quaternion kinematics for the error-state Kalman filter), section 5;
/// time offset as a state, Li & Mourikis 2014 (Online temporal calibration for camera-IMU systems).
/// Hot path: nothing here allocates (but the constructor), locks or throws.
/// Where the force is missing the velocity stays, more or less, and nothing is learnt of the accelerometer.
/// Bad input: readings without a rate (inertial_reading.hpp) or not later than the newest are refused (false); so are
/// poses that are not finite or not later than the one before, and both of an unusual time. A pose that contradicts the
/// state is rejected; `patience` of them in a row start it anew.
#pragma once

#include <algorithm>
#include <cmath>

#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/fading_polynomial.hpp>
#include <holdfast/tracking/inertial_process.hpp>
#include <holdfast/tracking/inertial_spread.hpp>
#include <holdfast/tracking/inertial_state.hpp>
#include <holdfast/tracking/noise_estimate.hpp>

namespace holdfast {

struct InertialFilterSettings : InertialProcessSettings {
  /// Of the measured poses, to begin with, and found within some ten poses. Rather too much: noise that is taken for
  /// none is blamed on time offset and biases, which then stay wrong.
  PoseNoise noise{2e-3, 5e-3};
  // Standard deviations at the start.
  double speed_m_s = 2.0, rate_bias = 0.05, force_bias = 0.2, gravity = 1.5, time_offset_s = 0.01, lever_m = 0.03;
  Duration longest_gap = std::chrono::milliseconds(500);  ///< between poses; then it starts anew
  double gate = 60.0;                                     ///< of the normalised innovation squared, 6 numbers
  int patience = 4;                                       ///< rejected poses in a row
};

enum class InertialPoseUpdate { started, updated, rejected, refused };

class InertialFilter {
 public:
  /// Remembers `capacity` readings: as many as come in the longest delay of a pose and the gap before it.
  explicit InertialFilter(const InertialFilterSettings& settings = {}, int capacity = 1024)
      : settings_(settings), history_(capacity) {
    HOLDFAST_ASSERT(settings.noise.position_m > 0.0 && settings.noise.orientation_rad > 0.0, "a pose without noise");
    place_noise_ = NoiseEstimate(settings.noise.position_m, 5e-5);
    turn_noise_ = NoiseEstimate(settings.noise.orientation_rad, 1e-5);
  }

  bool update(InertialReading reading) {
    if (!reading.has_rate() || !is_usual(reading.t)) return false;
    const bool has_force = uses_force_ && reading.has_force();
    if (!has_force) reading.force_B.setZero();  // stands in; integrals over it are not used (felt)
    const double since = history_.empty() ? 0.0 : to_seconds(reading.t - history_.newest().t);
    if (!history_.push(reading, has_force)) return false;
    if (since > longest_step_s) rate_trend_.restart();
    rate_trend_.update(since, reading.rate_B);
    if (!started_) return true;
    carry_now();
    if (has_force && !knows_gravity_) take_gravity();
    return true;
  }

  InertialPoseUpdate update(const TimedPose& pose) {
    const bool usable = pose.X_WB.is_finite() && pose.X_WB.p().squaredNorm() < 1e18 && is_usual(pose.t);
    if (!usable) return InertialPoseUpdate::refused;
    const bool is_late = started_ && pose.t <= state_.t;
    if (is_late && ++late_ < new_clock_after) return InertialPoseUpdate::refused;
    late_ = 0;
    if (!started_ || is_late || pose.t - state_.t > settings_.longest_gap) {
      start(pose);
      return InertialPoseUpdate::started;
    }
    carry(pose.t);
    if (!correct(pose)) {
      if (++rejected_ < settings_.patience) {
        carry_now_from_state();
        return InertialPoseUpdate::rejected;
      }
      start(pose);
      return InertialPoseUpdate::started;
    }
    rejected_ = 0;
    carry_now_from_state();
    return InertialPoseUpdate::updated;
  }

  /// Begins at this pose without velocity; what was found out about the sensors stays.
  void start(const TimedPose& pose) {
    const bool knows_sensors = started_;
    InertialState begin = knows_sensors ? state_ : InertialState();
    begin.t = pose.t;
    begin.X_WS = Rigid(pose.X_WB.q(), pose.X_WB.p() + pose.X_WB.q() * begin.lever_B);
    begin.v_WS.setZero();
    place_balance_.restart();
    turn_balance_.restart();
    state_ = begin;
    const InertialState::Covariance known = P_;
    P_.setZero();
    if (knows_sensors) P_.bottomRightCorner<13, 13>() = known.bottomRightCorner<13, 13>();
    set_deviation(InertialState::place, place_noise_.assumed() + 1e-5);
    set_deviation(InertialState::turn, turn_noise_.assumed() + 1e-5);
    set_deviation(InertialState::velocity, settings_.speed_m_s);
    if (!knows_sensors) {
      set_deviation(InertialState::rate_bias, settings_.rate_bias);
      set_deviation(InertialState::force_bias, settings_.force_bias);
      set_deviation(InertialState::gravity, settings_.gravity);
      set_deviation(InertialState::lever, settings_.lever_m);
      P_(InertialState::offset, InertialState::offset) = settings_.time_offset_s * settings_.time_offset_s;
    }
    // The sensors' place errs with the lever to it, and with all that errs with that.
    const Matrix3 R = begin.X_WS.R(), lever = P_.bottomRightCorner<3, 3>();
    const MatrixOf<double, 3, 13> with_sensors = R * P_.bottomRightCorner<3, 13>();
    P_.topRightCorner<3, 13>() = with_sensors;
    P_.bottomLeftCorner<13, 3>() = with_sensors.transpose();
    P_.topLeftCorner<3, 3>() += R * lever * R.transpose();
    started_ = true;
    rejected_ = 0;
    carry_now_from_state();
    if (!knows_gravity_ && history_.has_force()) take_gravity();
  }

  /// Without the accelerometer the velocity stays, more or less.
  void use_force(bool yes) { uses_force_ = yes; }
  /// What was found out about the accelerometer was wrong: its bias, its noise and gravity are to be found anew.
  void forget_force() {
    place_balance_ = InnovationBalance{place_balance_.most()};
    state_.bias.force_B.setZero();
    forget(InertialState::force_bias, settings_.force_bias);
    knows_gravity_ = false;
    carry_now_from_state();
  }
  /// Their clock may have jumped: the time offset is to be found anew.
  void forget_readings() {
    history_.clear();
    rate_trend_.restart();
    place_balance_.restart();
    turn_balance_.restart();
    P_.row(InertialState::offset).setZero();
    P_.col(InertialState::offset).setZero();
    P_(InertialState::offset, InertialState::offset) = settings_.time_offset_s * settings_.time_offset_s;
  }

  [[nodiscard]] bool is_started() const { return started_; }
  /// At the newest pose, with its covariance.
  [[nodiscard]] const InertialState& state() const { return state_; }
  [[nodiscard]] const InertialState::Covariance& covariance() const { return P_; }
  /// How uncertain its pose becomes, the longer no other comes.
  [[nodiscard]] PoseSpread spread() const { return pose_spread(state_, P_, uses_force_ && knows_gravity_, process_); }
  /// With all readings: at the newest reading or the newest pose, whichever is later.
  [[nodiscard]] const InertialState& now() const { return now_; }
  [[nodiscard]] Vector3 acceleration_now_W() const { return now_.X_WS.q() * force_now_B_ + now_.gravity_W; }
  [[nodiscard]] const InertialHistory& history() const { return history_; }
  [[nodiscard]] Duration time_offset() const { return from_seconds(state_.time_offset_s); }
  /// What the poses' noise was found to be.
  [[nodiscard]] PoseNoise pose_noise() const { return {place_noise_.found(), turn_noise_.found()}; }

 private:
  static constexpr double longest_step_s = 0.05, largest_offset_s = 0.1;
  static constexpr int new_clock_after = 10;

  void set_deviation(int begin, double deviation) {
    P_.diagonal().segment<3>(begin).setConstant(deviation * deviation);
  }
  /// Three numbers of the error are as unknown as at the start.
  void forget(int begin, double deviation) {
    P_.middleRows<3>(begin).setZero();
    P_.middleCols<3>(begin).setZero();
    set_deviation(begin, deviation);
  }
  /// Gravity is what the newest force, felt as if the body did not accelerate, stands against.
  void take_gravity() {
    const InertialReading& newest = history_.newest();
    state_.gravity_W = -(now_.X_WS.q() * (newest.force_B - state_.bias.force_B));
    forget(InertialState::gravity, settings_.gravity);
    knows_gravity_ = true;
    carry_now_from_state();
  }
  /// What the sensors feel after `begin`, until `to`; where there is no force, as if the velocity stayed.
  [[nodiscard]] StrapdownIncrement felt(const InertialState& begin, HostTime to) const {
    StrapdownIncrement step =
        history_.integrate(begin.t + time_offset(), to + time_offset(), state_.bias, rate_trend_.rate());
    if (step.has_force && knows_gravity_) return step;
    step.has_force = false;
    step.force_begin_B = -(begin.X_WS.q().conjugate() * begin.gravity_W);
    step.force_end_B = step.q.conjugate() * step.force_begin_B;
    step.velocity_B = step.seconds * step.force_begin_B;
    step.position_B = 0.5 * step.seconds * step.velocity_B;
    return step;
  }
  void carry_now() {
    const HostTime t = history_.newest().t - time_offset();
    if (t <= now_.t) return;
    const StrapdownIncrement step = felt(now_, t);
    now_.move(step);
    now_.t = t;
    force_now_B_ = step.force_end_B;
  }
  void carry_now_from_state() {
    now_ = state_;
    force_now_B_ = felt(now_, now_.t).force_end_B;
    if (!history_.empty()) carry_now();
  }

  void carry(HostTime t) {
    using S = InertialState;
    const StrapdownIncrement step = felt(state_, t);
    const S::Covariance F = error_transition(step, state_.X_WS.R());
    S::Covariance FP;
    FP.noalias() = F.lazyProduct(P_);
    P_.noalias() = FP.lazyProduct(F.transpose());
    process_ = process_noise(step, settings_, turn_balance_.scale(), place_balance_.scale());
    add_process_noise(P_, process_, step.seconds, settings_);
    state_.move(step);
    state_.t = t;
  }

  /// False when the pose contradicts the state, which then stays.
  [[nodiscard]] bool correct(const TimedPose& pose) {
    using S = InertialState;
    const Matrix3 R = state_.X_WS.R();
    const Rigid X_WB = state_.X_WB();
    Vector6 residual;
    residual << pose.X_WB.p() - X_WB.p(), so3::log<double>(X_WB.q().conjugate() * pose.X_WB.q());
    MatrixOf<double, S::size, 6> PH = P_.leftCols<6>();  // P H^T, H = (1, R [l], 0, ..., -R; 0, 1, 0, ...)
    PH.leftCols<3>() += P_.middleCols<3>(S::turn) * (R * so3::hat<double>(state_.lever_B)).transpose();
    PH.leftCols<3>() -= P_.middleCols<3>(S::lever) * R.transpose();
    Matrix6 innovation = PH.topRows<6>();
    innovation.topRows<3>() += R * so3::hat<double>(state_.lever_B) * PH.middleRows<3>(S::turn);
    innovation.topRows<3>() -= R * PH.middleRows<3>(S::lever);
    const Vector6 explained = innovation.diagonal();
    innovation.diagonal().head<3>().array() += place_noise_.assumed_variance();
    innovation.diagonal().tail<3>().array() += turn_noise_.assumed_variance();
    Matrix6 L;
    if (!cholesky<6>(innovation, L)) return false;
    const Vector6 weighted = solved_by<6, 1>(L, residual);
    const bool accepted = residual.dot(weighted) < settings_.gate;
    // One that is off alone is wrong; several in a row may be noisier than thought.
    if ((accepted || rejected_ > 0) && residual.allFinite() && explained.allFinite()) {
      place_noise_.add(residual.head<3>(), explained.head<3>().mean());
      turn_noise_.add(residual.tail<3>(), explained.tail<3>().mean());
    }
    if (!accepted) {
      place_balance_.restart();
      turn_balance_.restart();
      return false;
    }
    turn_balance_.add(residual.tail<3>(), innovation.diagonal().tail<3>().mean());
    if (uses_force_ && knows_gravity_) {
      place_balance_.add(residual.head<3>(), innovation.diagonal().head<3>().mean());
    } else {
      place_balance_.restart();
    }
    const MatrixOf<double, 6, S::size> gain = solved_by<6, S::size>(L, PH.transpose());  // transposed
    S::Error d = PH * weighted;
    d[S::offset] =
        std::clamp(d[S::offset], -largest_offset_s - state_.time_offset_s, largest_offset_s - state_.time_offset_s);
    S::Covariance corrected = P_;
    corrected.noalias() -= PH.lazyProduct(gain);
    P_ = 0.5 * (corrected + corrected.transpose());
    P_.diagonal() *= 1.0 + rounding_floor;
    state_.add(d);
    return true;
  }

  InertialFilterSettings settings_;
  InertialHistory history_;
  FadingPolynomial rate_trend_{0.012};
  InertialState state_, now_;
  InertialState::Covariance P_ = InertialState::Covariance::Zero();
  Vector3 force_now_B_ = Vector3::Zero();
  NoiseEstimate place_noise_, turn_noise_;                    ///< of the poses
  InnovationBalance turn_balance_{1.0}, place_balance_{4.0};  ///< how much gyro and accelerometer err
  ProcessNoise process_;                                      ///< that was added last
  bool started_ = false, uses_force_ = true, knows_gravity_ = false;
  int rejected_ = 0, late_ = 0;  ///< in a row
};

}  // namespace holdfast
