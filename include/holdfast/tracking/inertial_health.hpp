/// Finds out when inertial sensors cannot be believed, and says why.
///
///   disconnected     no reading within 50 ms of the newest pose
///   not_finite       readings without a number (a missing axis)
///   dead, stuck      an axis says zero, or the same, for 0.25 s, while poses show that it should not
///   saturated        an axis is at its range's end, now or within 50 ms
///   time_backwards   readings' time does not go on
///   inconsistent     turns by the gyro are not the poses' turns: wrong axes, wrong unit, a failing sensor
///   wrong_gravity    of the accelerometer: gravity as found by the filter has not the expected length: wrong unit
/// A fault ends when its cause has been away for 0.25 s. Nothing here allocates.
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
      if (started_ && z[i] == last_[i]) continue;
      changed_[static_cast<std::size_t>(i)] = t;
      last_[i] = z[i];
    }
    started_ = true;
  }
  /// Compares with what poses say it should be: an axis that does not change although it is off by `tolerance`.
  void expect(HostTime t, const Vector3& expected, double tolerance) {
    for (int i = 0; i < 3 && started_; ++i) {
      if (to_seconds(t - changed_[static_cast<std::size_t>(i)]) < unchanged_s) continue;
      if (std::abs(expected[i] - last_[i]) > tolerance) {
        report(last_[i] == 0.0 ? SensorFault::dead : SensorFault::stuck, t);
      }
    }
  }
  void report(SensorFault fault, HostTime t) {
    fault_ = fault;
    until_ = t + from_seconds(recovery_s);
  }
  [[nodiscard]] SensorFault fault(HostTime t) const { return t < until_ ? fault_ : SensorFault::none; }

 private:
  bool started_ = false;
  Vector3 last_ = Vector3::Zero();
  std::array<HostTime, 3> changed_{};
  SensorFault fault_ = SensorFault::none;
  HostTime until_ = HostTime::min();
};

/// Compares the gyro's turns between poses with the poses' own, over the last second or so of turning.
class TurnComparison {
 public:
  void add(const Vector3& turn_by_gyro, const Vector3& turn_by_poses) {
    difference_ += 0.02 * ((turn_by_gyro - turn_by_poses).squaredNorm() - difference_);
    turned_ += 0.02 * (turn_by_poses.squaredNorm() - turned_);
  }
  /// Half of the turn is missed, and it is more than the poses' noise (rad, per axis), if that is believable.
  [[nodiscard]] bool contradicts(double noise) const {
    const double believable = std::min(noise, 0.005);
    return difference_ > 0.25 * turned_ && difference_ > 2.5e-5 + 12.0 * believable * believable;
  }

 private:
  double difference_ = 0.0, turned_ = 0.0;  // rad^2
};

}  // namespace holdfast
