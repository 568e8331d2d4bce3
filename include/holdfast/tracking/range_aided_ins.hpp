/// An inertial navigator corrected by single ranges: the Constellation tracker (003 section 2.2, figure 5).
///
///     RangeAidedIns ins(beacons, receivers);
///     ins.start(pose);               // an acquired one
///     ins.update(reading);           // each InertialReading: ins.pose() is then that of the reading's time
///     ins.update(range);             // each BeaconRange, as it comes
/// Direct feed-through: every reading is integrated at once and its pose goes out; ranges only correct what has gathered. A
/// complementary Kalman filter estimates the error of place, orientation, velocity and both biases (strapdown_covariance.hpp), one
/// range at a time. P is carried once for each range, not for each reading, by the integrals of the readings in between.
/// A range that is a little late is taken at its own time, if none later was; the readings after it are integrated again.
/// Gate: a range is compared with what is expected within the covariance's tolerance, which widens while ranges are
/// missing, and beyond that while all are turned away (innovation_gate.hpp). Each `patience` of them in a row the filter doubts
/// itself, too: P grows by what a wrong range that was let in may have done.
/// Systematic errors (beacons out of place, delays) repeat whenever the same pair of transducers does. A pair heard again after
/// d seconds gets the variance noise^2 + systematic^2 max(1, correlation / d): in `correlation` seconds a pair counts once,
/// however often it is heard. The gate takes systematic^2 once.
/// Faults (status()): an axis that is not believed (inertial_axes.hpp) is stood in for by no turning, or no acceleration, with
/// the uncertainty of a head that may do either; so is the whole unit without readings for 50 ms. `wrong_gravity`: what the
/// accelerometer feels is not, on average, what keeps a body from falling: then it is not used.
/// Time: what comes from before what is already in, or from more than a second after it, is dropped (`time_backwards` if a
/// reading does not go on). Where a hundred in a row are, the clock was set, and it goes on from there.
/// Frames: B the body, with the unit's axes; the unit sits at `unit_B`. Nothing allocates but the constructor.
/// Bad input: refused and counted; the state stays. Preconditions: noises are positive, beacons and receivers not empty.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <holdfast/motion/timed_pose.hpp>
#include <holdfast/tracking/coded_range.hpp>
#include <holdfast/tracking/felt_gravity.hpp>
#include <holdfast/tracking/inertial_axes.hpp>
#include <holdfast/tracking/innovation_gate.hpp>
#include <holdfast/tracking/range.hpp>
#include <holdfast/tracking/range_aided_settings.hpp>
#include <holdfast/tracking/strapdown_pose.hpp>
#include <holdfast/tracking/time_of_flight.hpp>

namespace holdfast {

class RangeAidedIns {
 public:
  RangeAidedIns(std::span<const CodedBeacon> beacons, std::span<const RangeReceiver> receivers,
                const RangeAidedInsSettings& settings = {})
      : settings_(settings), gate_(settings.gate), axes_(settings.ranges), history_(256), gravity_(settings.gravity_W) {
    HOLDFAST_ASSERT(!beacons.empty() && !receivers.empty(), "ranges need a beacon and a receiver");
    HOLDFAST_ASSERT(!settings.gate.problem(), "bad settings of the gate");
    HOLDFAST_ASSERT(settings.rate_noise > 0.0 && settings.force_noise > 0.0 && settings.range_noise_m > 0.0,
                    "sensors without noise");
    for (const CodedBeacon& beacon : beacons) beacons_W_.push_back(beacon.p_W);
    for (const RangeReceiver& receiver : receivers) receivers_S_.push_back(receiver.p_B - settings.unit_B);
    heard_.assign(beacons_W_.size() * receivers_S_.size(), HostTime::min());
    state_.gravity_W = settings.gravity_W;
    state_.lever_B = settings.unit_B;
  }

  /// Begins at an acquired pose, known to `known`; what was found out about the biases stays.
  void start(const TimedPose& pose, const PoseNoise& known) {
    HOLDFAST_ASSERT(pose.X_WB.is_finite() && known.position_m > 0.0 && known.orientation_rad > 0.0,
                    "no pose to start at");
    state_.t = pose.t;
    state_.X_WS = Rigid(pose.X_WB.q(), pose.X_WB * settings_.unit_B);
    state_.v_WS.setZero();
    StrapdownCovariance begin = StrapdownCovariance::Zero();
    if (started_) {
      begin.bottomRightCorner<6, 6>() = P_.bottomRightCorner<6, 6>();
    } else {
      set_deviation(begin, InertialState::rate_bias, settings_.rate_bias);
      set_deviation(begin, InertialState::force_bias, settings_.force_bias);
    }
    P_ = begin;
    set_deviation(P_, InertialState::place, known.position_m + known.orientation_rad * settings_.unit_B.norm());
    set_deviation(P_, InertialState::turn, known.orientation_rad);
    set_deviation(P_, InertialState::velocity, settings_.speed_m_s);
    heard_.assign(heard_.size(), HostTime::min());
    gate_ = InnovationGate(settings_.gate);
    history_.clear();
    believed_ = {Vector3::Zero(), Vector3::Zero()};
    gravity_.restart();
    now_ = state_;
    aided_ = pose.t;
    started_ = true;
  }

  /// False when the reading is refused: it is of no use, or not later than what is already in.
  bool update(InertialReading reading) {
    if (!fits(reading.t, newest_)) {
      if (reading.t <= newest_) backwards_until_ = now_.t + from_seconds(0.25);
      misfit(reading.t, counts_.readings_refused);
      return false;
    }
    axes_.read(reading, gate_.rejected_in_a_row() >= 3);
    newest_ = reading.t;
    if (!started_) return true;
    if (!history_.empty() && to_seconds(reading.t - history_.newest().t) > longest_silence_s) go_silent();
    believe(reading);
    stand_in(reading);
    if (++readings_ahead_ > most_readings_ahead && !history_.empty() && history_.newest().t > state_.t) {
      carry(history_.newest().t);
    }
    history_.push(reading);
    carry_now();
    misfits_ = 0;
    return true;
  }

  RangeUpdate update(const BeaconRange& range) {
    const bool known = range.beacon >= 0 && static_cast<std::size_t>(range.beacon) < beacons_W_.size() &&
                       range.receiver >= 0 && static_cast<std::size_t>(range.receiver) < receivers_S_.size();
    if (!started_ || !known || !(range.range_m > 0.0 && range.range_m < farthest_m)) {
      ++counts_.ranges_refused;
      return RangeUpdate::refused;
    }
    if (!fits(range.t, state_.t - Duration(1))) {
      misfit(range.t, counts_.ranges_refused);
      return RangeUpdate::refused;
    }
    if (!history_.empty() && to_seconds(range.t - history_.newest().t) > longest_silence_s) go_silent();
    carry(range.t);
    const RangeUpdate result = correct(range);
    carry_now_from_state();
    misfits_ = 0;
    return result;
  }

  /// A beacon is found to hang elsewhere (auto-mapping).
  void move_beacon(int beacon, const Vector3& p_W) { beacons_W_[static_cast<std::size_t>(beacon)] = p_W; }

  [[nodiscard]] bool is_started() const { return started_; }
  /// With all readings and ranges.
  [[nodiscard]] TimedPose pose() const { return {now_.t, now_.X_WB()}; }
  [[nodiscard]] const InertialState& now() const { return now_; }
  /// At the newest range, with its covariance.
  [[nodiscard]] const InertialState& state() const { return state_; }
  [[nodiscard]] const StrapdownCovariance& covariance() const { return P_; }
  /// Normalised innovation squared of the newest range that was compared; what the gate saw.
  [[nodiscard]] double nis() const { return nis_; }
  [[nodiscard]] const InnovationGate& gate() const { return gate_; }

  /// Now, with velocity and covariance: P is carried on from the newest range.
  [[nodiscard]] PoseEstimate estimate() const {
    StrapdownCovariance P = P_;
    const StrapdownIncrement step = felt(state_, now_.t);
    const Matrix3 R = state_.X_WS.R();
    carry_covariance(P, step, R, believed_);
    add_noise(P, step.seconds, R, noise());
    return strapdown_pose(now_, P, step.rate_end_B);
  }

  [[nodiscard]] RangeAidedInsStatus status() const {
    RangeAidedInsStatus status;
    status.gyro = axes_.triad_fault(0, newest_);
    status.accelerometer = axes_.triad_fault(3, newest_);
    if (gravity_.is_wrong() && status.accelerometer == SensorFault::none) {
      status.accelerometer = SensorFault::wrong_gravity;
    }
    if (history_.empty()) status.gyro = status.accelerometer = SensorFault::disconnected;
    if (now_.t < backwards_until_) status.gyro = status.accelerometer = SensorFault::time_backwards;
    status.trusted = gate_.trusted();
    status.lost = gate_.lost();
    status.unaided_s = to_seconds(now_.t - aided_);
    status.counts = counts_;
    return status;
  }

 private:
  static constexpr double longest_silence_s = 0.05, longest_gap_s = 1.0, farthest_m = 1e3;
  static constexpr int patience_with_time = 100;
  static constexpr int most_readings_ahead = 50;  ///< of the newest range: P is carried on without one, then

  static void set_deviation(StrapdownCovariance& P, int begin, double deviation) {
    P.diagonal().segment<3>(begin).setConstant(deviation * deviation);
  }
  /// Later than what is already in, by no more than a second.
  [[nodiscard]] bool fits(HostTime t, HostTime last) const {
    if (!is_usual(t) || t <= last) return false;
    return !started_ || t - now_.t <= from_seconds(longest_gap_s);
  }
  void misfit(HostTime t, std::uint64_t& count) {
    ++count;
    if (!started_ || ++misfits_ < patience_with_time) return;
    state_ = now_;
    doubt_pose(0.2);
    state_.t = now_.t = aided_ = newest_ = t;
    backwards_until_ = t + from_seconds(0.25);
    misfits_ = 0;
    heard_.assign(heard_.size(), HostTime::min());
    history_.clear();
    believed_ = {Vector3::Zero(), Vector3::Zero()};
  }

  /// Nothing was felt after the newest reading.
  void go_silent() {
    const HostTime t = history_.newest().t;
    if (t > state_.t) carry(t);
    history_.clear();
    believed_ = {Vector3::Zero(), Vector3::Zero()};
    now_ = state_;
  }

  /// Changes which axes count, from the newest reading on.
  void believe(const InertialReading& reading) {
    BelievedAxes believed = axes_.believed(reading.t);
    if (believed.force == Vector3::Ones()) {
      judge_gravity(reading);
    } else {
      gravity_.restart();
    }
    if (gravity_.is_wrong()) believed.force.setZero();
    if (history_.empty()) {
      if (reading.t > state_.t) carry(reading.t);
    } else if (believed == believed_) {
      return;
    } else if (history_.newest().t > state_.t) {
      carry(history_.newest().t);
    }
    doubt(believed);
    believed_ = believed;
    now_ = state_;
  }
  /// An axis that just turned out to be wrong has been so for up to two blocks of readings.
  void doubt(const BelievedAxes& believed) {
    if (history_.empty()) return;
    const double since =
        2.0 * InertialAxes::block * std::min(longest_silence_s, to_seconds(newest_ - history_.newest().t) + 1e-3);
    for (int i = 0; i < 3; ++i) {
      if (believed_.rate[i] > believed.rate[i]) add_variance(InertialState::turn + i, since * settings_.usual_rate);
      if (believed_.force[i] > believed.force[i]) {
        for (int k = 0; k < 3; ++k) {  // whichever way the axis points
          add_variance(InertialState::velocity + k, since * settings_.usual_force);
          add_variance(InertialState::place + k, 0.5 * since * since * settings_.usual_force);
        }
      }
    }
  }
  void doubt_pose(double seconds) {
    for (int k = 0; k < 3; ++k) {
      add_variance(InertialState::place + k, seconds * settings_.speed_m_s);
      add_variance(InertialState::velocity + k, settings_.speed_m_s);
      add_variance(InertialState::turn + k, seconds * settings_.usual_rate);
    }
  }
  /// Where many ranges in a row do not fit, a wrong one was let in before them, and this is what it may have done. (Much more
  /// would let the next wrong one in: of 180 runs with 30 % of ranges wrong five went astray without, one with twice of it.)
  void doubt_itself() {
    for (int k = 0; k < 3; ++k) {
      add_variance(InertialState::place + k, 0.03);
      add_variance(InertialState::velocity + k, 0.15);
      add_variance(InertialState::turn + k, 0.01);
    }
  }
  void add_variance(int i, double deviation) { P_(i, i) += deviation * deviation; }

  void judge_gravity(const InertialReading& reading) {
    const double dt = history_.empty() ? 0.0 : to_seconds(reading.t - history_.newest().t);
    if (!gravity_.feel(now_.X_WS.q() * reading.force_B, dt)) return;
    state_.bias.force_B.setZero();  // what was learnt of it, and of the pose meanwhile, is in doubt
    P_.middleRows<3>(InertialState::force_bias).setZero();
    P_.middleCols<3>(InertialState::force_bias).setZero();
    set_deviation(P_, InertialState::force_bias, settings_.force_bias);
    doubt_pose(0.2);
  }

  /// Numbers for the axes that are not believed. What is saturated is at least that much.
  void stand_in(InertialReading& reading) const {
    const Vector3 resting_B = state_.bias.force_B - now_.X_WS.q().conjugate() * settings_.gravity_W;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      if (believed_.rate[i] == 0.0 && axes_.fault(axis, reading.t) != SensorFault::saturated) {
        reading.rate_B[i] = state_.bias.rate_B[i];
      }
      if (believed_.force[i] == 0.0 && axes_.fault(axis + 3, reading.t) != SensorFault::saturated) {
        reading.force_B[i] = resting_B[i];
      }
      if (!std::isfinite(reading.rate_B[i])) reading.rate_B[i] = state_.bias.rate_B[i];
      if (!std::isfinite(reading.force_B[i])) reading.force_B[i] = resting_B[i];
    }
  }

  [[nodiscard]] StrapdownNoise noise() const {
    const auto either = [](const Vector3& believed, double noise, double otherwise) -> Vector3 {
      return noise * believed + otherwise * (Vector3::Ones() - believed);
    };
    return {either(believed_.rate, settings_.rate_noise, settings_.no_rate_noise),
            either(believed_.force, settings_.force_noise, settings_.no_force_noise),
            settings_.rate_bias_walk * Vector3::Ones(), settings_.force_bias_walk * Vector3::Ones()};
  }

  /// What the sensors feel after `begin`, until t; without them, as if the velocity stayed.
  [[nodiscard]] StrapdownIncrement felt(const InertialState& begin, HostTime t) const {
    StrapdownIncrement step = history_.integrate(begin.t, t, begin.bias, Vector3::Zero());
    if (!history_.empty()) return step;
    const Vector3 force_B = -(begin.X_WS.q().conjugate() * begin.gravity_W);
    step.velocity_B = step.seconds * force_B;
    step.position_B = 0.5 * step.seconds * step.velocity_B;
    return step;
  }
  void carry_now() {
    if (history_.empty() || history_.newest().t <= now_.t) return;
    const HostTime t = history_.newest().t;
    now_.move(felt(now_, t));
    now_.t = t;
  }
  void carry_now_from_state() {
    now_ = state_;
    carry_now();
  }
  void carry(HostTime t) {
    const StrapdownIncrement step = felt(state_, t);
    const Matrix3 R = state_.X_WS.R();
    carry_covariance(P_, step, R, believed_);
    add_noise(P_, step.seconds, R, noise());
    state_.move(step);
    state_.t = t;
    readings_ahead_ = 0;
  }

  [[nodiscard]] RangeUpdate correct(const BeaconRange& range) {
    TargetState<1> pose;
    pose.X_WB = state_.X_WS;
    Linearization<Range> linear;
    const auto receiver = static_cast<std::size_t>(range.receiver), beacon = static_cast<std::size_t>(range.beacon);
    const double by_length = settings_.range_noise_per_m * range.range_m;
    const double variance_of_noise = settings_.range_noise_m * settings_.range_noise_m + by_length * by_length;
    const Range measured{range.range_m, receivers_S_[receiver], variance_of_noise};
    if (!measured.linearize(pose, beacons_W_[beacon], {}, linear)) {
      ++counts_.ranges_refused;
      return RangeUpdate::refused;
    }
    using Column = VectorOf<double, strapdown_error_size>;
    const Vector6 h = linear.H.transpose();
    Column PH;
    PH.noalias() = P_.leftCols<6>().lazyProduct(h);
    const double explained = h.dot(PH.head<6>()), residual = linear.residual[0];
    const double systematic = settings_.systematic_m * settings_.systematic_m;
    nis_ = residual * residual / (explained + linear.R(0, 0) + systematic);
    if (gate_.judge(nis_, 1, nullptr) != GateVerdict::accepted) {
      ++counts_.ranges_gated;
      if (gate_.rejected_in_a_row() % std::max(1, settings_.gate.patience) == 0) doubt_itself();
      return RangeUpdate::gated;
    }
    HostTime& heard = heard_[beacon * receivers_S_.size() + receiver];
    double repeated = 1.0;
    if (heard != HostTime::min()) {
      const double since = std::max(1e-3, to_seconds(range.t - heard));
      repeated = std::max(1.0, settings_.systematic_correlation_s / since);
    }
    heard = aided_ = range.t;
    const double variance = explained + linear.R(0, 0) + repeated * systematic;
    const Column gain = PH / variance;
    InertialState::Error d = InertialState::Error::Zero();
    d.head<strapdown_error_size>() = residual * gain;
    P_.noalias() -= gain * PH.transpose();
    P_ = 0.5 * (P_ + P_.transpose()).eval();
    P_.diagonal() *= 1.0 + 1e-12;  // what rounding may have taken (innovation.hpp)
    state_.add(d);
    ++counts_.ranges_accepted;
    return RangeUpdate::accepted;
  }

  RangeAidedInsSettings settings_;
  InnovationGate gate_;
  InertialAxes axes_;
  InertialHistory history_;
  std::vector<Vector3> beacons_W_, receivers_S_;  ///< receivers from the unit, in B's axes
  std::vector<HostTime> heard_;                   ///< of each pair of transducers, when last
  InertialState state_, now_;
  StrapdownCovariance P_ = StrapdownCovariance::Zero();
  BelievedAxes believed_;
  FeltGravity gravity_;
  HostTime newest_ = HostTime::min(), backwards_until_ = HostTime::min(), aided_;
  double nis_ = std::numeric_limits<double>::quiet_NaN();
  int readings_ahead_ = 0;
  int misfits_ = 0;  ///< inputs in a row of a wrong time
  bool started_ = false;
  RangeAidedInsCounts counts_;
};

}  // namespace holdfast
