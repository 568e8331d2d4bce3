/// Which of an inertial unit's six numbers can be believed, told from the readings alone.
///
///   not_finite  no number, or one that no head comes near: while it lasts and 50 ms on
///   saturated   at its range's end: the same
///   dead, stuck zero, or the same, in `block` readings in a row, in a unit that has moved: noise alone would move it. Until a
///               block in which it changes. A unit that has not moved yet may be one at rest without noise: it takes
///               `contradicted`, what else is measured, to call that stuck
/// Each axis is judged by itself: a unit that has lost one still has five. A fault found by a block may have lasted two.
/// Nothing here allocates. Channels: 0 to 2 rates, 3 to 5 forces. Units: rad/s, m/s^2. Bad input: anything; that is what it is for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <holdfast/tracking/inertial_health.hpp>
#include <holdfast/tracking/strapdown_covariance.hpp>

namespace holdfast {

class InertialAxes {
 public:
  static constexpr int block = 15;                               ///< readings
  static constexpr double recovery_s = 0.05;                     ///< of the first two faults
  static constexpr double moved_rad_s = 0.05, moved_m_s2 = 0.3;  ///< more than noise

  explicit InertialAxes(const InertialRanges& ranges = {}) : ranges_(ranges) {}

  /// Call with each reading, in the order of time. `contradicted`: other measurements do not fit what this unit says.
  void read(const InertialReading& reading, bool contradicted) {
    for (std::size_t i = 0; i < 6; ++i) {
      const double z = channel(reading, i);
      const double range = i < 3 ? ranges_.rate : ranges_.force;
      const double impossible = i < 3 ? fastest_rad_s : hardest_m_s2;
      if (!(std::abs(z) < impossible)) {
        report(i, SensorFault::not_finite, reading.t);
      } else if (!(std::abs(z) < 0.999 * range)) {
        report(i, SensorFault::saturated, reading.t);
      }
      if (counted_ == 0) first_[i] = z;
      if (z == z) moved_[i] = std::max(moved_[i], std::abs(z - first_[i]));
    }
    if (++counted_ > block) judge_block(contradicted);
  }

  [[nodiscard]] SensorFault fault(std::size_t channel, HostTime t) const {
    return t < until_[channel] ? reported_[channel] : frozen_[channel];
  }
  /// The first fault among three axes that begin at a channel.
  [[nodiscard]] SensorFault triad_fault(std::size_t begin, HostTime t) const {
    for (std::size_t i = begin; i < begin + 3; ++i) {
      if (fault(i, t) != SensorFault::none) return fault(i, t);
    }
    return SensorFault::none;
  }
  [[nodiscard]] BelievedAxes believed(HostTime t) const {
    BelievedAxes axes;
    for (std::size_t i = 0; i < 6; ++i) {
      double& axis = i < 3 ? axes.rate[static_cast<int>(i)] : axes.force[static_cast<int>(i) - 3];
      axis = fault(i, t) == SensorFault::none ? 1.0 : 0.0;
    }
    return axes;
  }

 private:
  [[nodiscard]] static double channel(const InertialReading& reading, std::size_t i) {
    return i < 3 ? reading.rate_B[static_cast<int>(i)] : reading.force_B[static_cast<int>(i) - 3];
  }
  void report(std::size_t i, SensorFault fault, HostTime t) {
    reported_[i] = fault;
    until_[i] = t + from_seconds(recovery_s);
  }
  void judge_block(bool contradicted) {
    for (std::size_t i = 0; i < 6; ++i) has_moved_ = has_moved_ || moved_[i] > (i < 3 ? moved_rad_s : moved_m_s2);
    for (std::size_t i = 0; i < 6; ++i) {
      if (moved_[i] > 0.0) {
        frozen_[i] = SensorFault::none;
      } else if ((has_moved_ || contradicted) && first_[i] == first_[i]) {
        frozen_[i] = first_[i] == 0.0 ? SensorFault::dead : SensorFault::stuck;
      }
      moved_[i] = 0.0;
    }
    counted_ = 0;
  }

  InertialRanges ranges_;
  int counted_ = 0;
  bool has_moved_ = false;
  std::array<double, 6> first_{}, moved_{};
  std::array<SensorFault, 6> frozen_{}, reported_{};
  std::array<HostTime, 6> until_{HostTime::min(), HostTime::min(), HostTime::min(),
                                 HostTime::min(), HostTime::min(), HostTime::min()};
};

}  // namespace holdfast
