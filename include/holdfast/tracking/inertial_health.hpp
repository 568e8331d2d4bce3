/// Finds out when inertial sensors cannot be believed, and says why.
///
///   disconnected     no reading, not even one without numbers, within 50 ms of the newest pose
///   not_finite       readings without a number (a missing axis)
///   dead, stuck      an axis says zero, or the same, for 0.25 s, while poses show that it should not
///   saturated        an axis is at its range's end, now or within 50 ms
///   time_backwards   readings' time does not go on: a few in a row, or by far (one that is a little late is dropped
/// quietly)
///   inconsistent     turns by the gyro are not the poses' turns: wrong axes, wrong unit, a failing sensor
///   wrong_gravity    of the accelerometer: what it feels has not gravity's length on average: wrong unit
/// A fault ends when its cause has been away for 0.25 s; dead and stuck when the axis says something else. Nothing here
/// allocates.
/// Units: rad/s, m/s^2. Bad input: anything; that is what it is for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <holdfast/geometry/so3.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

enum class SensorFault {
  none,
  disconnected,
  not_finite,
  dead,
  stuck,
  saturated,
  time_backwards,
  inconsistent,
  wrong_gravity
};

[[nodiscard]] constexpr std::string_view to_string(SensorFault fault) {
  constexpr std::array<std::string_view, 9> names{"none",           "disconnected", "not_finite",
                                                  "dead",           "stuck",        "saturated",
                                                  "time_backwards", "inconsistent", "wrong_gravity"};
  return names[static_cast<std::size_t>(fault)];
}

struct InertialRanges {
  double rate = 34.9;    ///< rad/s: 2000 deg/s
  double force = 156.9;  ///< m/s^2: 16 g
};

/// One triad: which of its axes have not changed, and how long a fault still counts.
class TriadHealth {
 public:
  static constexpr double unchanged_s = 0.25, recovery_s = 0.25;

  void read(HostTime t, const Vector3& z, double range) {
    if (!z.allFinite()) return report(SensorFault::not_finite, t);
    if (!(z.cwiseAbs().maxCoeff() < 0.999 * range)) report(SensorFault::saturated, t);
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (started_ && z[i] == last_[i]) {
        if (held_[k]) report_held(i, t);
        continue;
      }
      changed_[k] = t;
      held_[k] = false;
      last_[i] = z[i];
    }
    started_ = true;
  }
  /// Compares with what poses say it should be: an axis that does not change although it is off by `tolerance`.
  void expect(HostTime t, const Vector3& expected, double tolerance) {
    if (fault(t) == SensorFault::saturated) return;  // that is why
    for (int i = 0; i < 3 && started_; ++i) {
      if (to_seconds(t - changed_[static_cast<std::size_t>(i)]) < unchanged_s) continue;
      if (!(std::abs(expected[i] - last_[i]) > tolerance)) continue;
      held_[static_cast<std::size_t>(i)] = true;
      report_held(i, t);
    }
  }
  void report(SensorFault fault, HostTime t) {
    fault_ = fault;
    until_ = t + from_seconds(recovery_s);
  }
  /// A fault of the far future is one of a clock that has jumped since.
  [[nodiscard]] SensorFault fault(HostTime t) const {
    return t < until_ && until_ - t < std::chrono::seconds(2) ? fault_ : SensorFault::none;
  }

 private:
  void report_held(int axis, HostTime t) { report(last_[axis] == 0.0 ? SensorFault::dead : SensorFault::stuck, t); }

  bool started_ = false;
  Vector3 last_ = Vector3::Zero();
  std::array<bool, 3> held_{};  ///< found to be dead or stuck, and not changed since
  std::array<HostTime, 3> changed_{};
  SensorFault fault_ = SensorFault::none;
  HostTime until_ = HostTime::min();
};

/// What an accelerometer feels in the world, on average: without the body's acceleration, which comes and goes, that is
/// what stands against gravity. Units: m/s^2, s.
/// Once it is wrong, two to four seconds in which it is right are enough to forget what was felt before, however wrong that was.
class GravityCheck {
 public:
  void add(const Vector3& force_W, double since) {
    time_ += since;
    if (time_ > 0.0) mean_W_ += std::min(1.0, since / std::min(time_, memory_s)) * (force_W - mean_W_);
    of_late_s_ += since;
    sum_of_late_W_ += since * force_W;
    if (of_late_s_ < 2.0) return;
    const Vector3 of_late_W = sum_of_late_W_ / of_late_s_;
    if (contradicts() && !is_off(of_late_W)) mean_W_ = of_late_W;
    of_late_s_ = 0.0;
    sum_of_late_W_.setZero();
  }
  void restart() { *this = {}; }
  /// The mean acceleration of a head that moves at v within the memory is v / memory: well below a tenth of gravity.
  [[nodiscard]] bool contradicts() const { return time_ > 2.0 && is_off(mean_W_); }

 private:
  static constexpr double memory_s = 3.0;
  [[nodiscard]] static bool is_off(const Vector3& force_W) { return std::abs(force_W.norm() - standard_gravity) > 1.0; }

  double time_ = 0.0, of_late_s_ = 0.0;
  Vector3 mean_W_ = Vector3::Zero(), sum_of_late_W_ = Vector3::Zero();
};

/// Compares the gyro's turns between poses with the poses' own, over the last second or so of turning. One pair counts
/// no more than what the gyro says, or 25 mrad: a single wrong pose is not a contradiction. Nor is noise of the poses:
/// what it adds to one pair it takes from the next, whereas a wrong gyro errs alike.
class TurnComparison {
 public:
  void add(const Vector3& turn_by_gyro, const Vector3& turn_by_poses) {
    const double most = std::max(6e-4, turn_by_gyro.squaredNorm());
    Vector3 difference = turn_by_gyro - turn_by_poses;
    difference *= std::min(1.0, std::sqrt(most / std::max(most, difference.squaredNorm())));
    difference_ += 0.02 * (difference.squaredNorm() - difference_);
    lasting_ += 0.02 * (difference.dot(before_) - lasting_);
    before_ = difference;
    turned_ += 0.02 * (std::min(most, turn_by_poses.squaredNorm()) - turned_);
  }
  /// Half of the turn is missed, and it is more than the poses' noise (rad, per axis), if that is believable.
  [[nodiscard]] bool contradicts(double noise) const {
    const double believable = std::min(noise, 0.005);
    return lasting_ > 0.25 * difference_ && difference_ > 0.25 * turned_ &&
           difference_ > 2.5e-5 + 12.0 * believable * believable;
  }

 private:
  double difference_ = 0.0, lasting_ = 0.0, turned_ = 0.0;  // rad^2
  Vector3 before_ = Vector3::Zero();
};

}  // namespace holdfast
