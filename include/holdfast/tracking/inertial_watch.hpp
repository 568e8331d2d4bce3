/// Watches gyro and accelerometer of an InertialFilter: what of inertial_health.hpp is wrong with each, if anything.
///
/// Readings are looked at as they come, and compared with poses and with gravity as these come.
/// Frames: B is the body. Units: rad/s, m/s^2. Nothing here allocates. Bad input: readings may be anything; that is
/// what it is for.
#pragma once

#include <algorithm>

#include <holdfast/tracking/inertial_filter.hpp>
#include <holdfast/tracking/inertial_health.hpp>

namespace holdfast {

class InertialWatch {
 public:
  explicit InertialWatch(const InertialRanges& ranges = {})
      : ranges_{std::min(ranges.rate, fastest_rad_s), std::min(ranges.force, hardest_m_s2)} {}

  [[nodiscard]] SensorFault gyro(HostTime t) const { return gyro_.fault(t); }
  [[nodiscard]] SensorFault accelerometer(HostTime t) const { return accelerometer_.fault(t); }

  void read(const InertialReading& reading) {
    gyro_.read(reading.t, reading.rate_B, ranges_.rate);
    accelerometer_.read(reading.t, reading.force_B, ranges_.force);
  }
  /// Of both.
  void report(SensorFault fault, HostTime t) {
    gyro_.report(fault, t);
    accelerometer_.report(fault, t);
  }

  /// A force was felt in the world, `since` seconds after the one before.
  void weigh(HostTime t, const Vector3& force_W, double since) {
    const SensorFault fault = accelerometer_.fault(t);
    if (fault != SensorFault::none && fault != SensorFault::wrong_gravity) return;
    gravity_.add(force_W, since);
    if (gravity_.contradicts()) accelerometer_.report(SensorFault::wrong_gravity, t);
  }
  void restart_gravity() { gravity_.restart(); }

  /// Compares the gyro's turn with that between two poses: `believed`, or not but perhaps right: when the filter
  /// `started` from them.
  void compare_turn(const InertialFilter& filter, const TimedPose& from, const TimedPose& to, bool believed,
                    bool started) {
    const StrapdownIncrement turned = filter.history().integrate(
        from.t + filter.time_offset(), to.t + filter.time_offset(), filter.state().bias, Vector3::Zero());
    (believed ? turns_ : doubtful_turns_)
        .add(so3::log<double>(turned.q), so3::log<double>(from.X_WB.q().conjugate() * to.X_WB.q()));
    if (believed) doubtful_turns_ = turns_;
    if (started) turns_ = doubtful_turns_;
    const SensorFault known = gyro_.fault(to.t);
    if (known != SensorFault::none && known != SensorFault::inconsistent) return;  // that is why
    if (turns_.contradicts(filter.pose_noise().orientation_rad)) gyro_.report(SensorFault::inconsistent, to.t);
  }

  /// At a measured pose, when the body turns at `rate_B` by the poses alone.
  void expect(const InertialFilter& filter, const TimedPose& pose, const Vector3& rate_B) {
    const InertialState& state = filter.state();
    gyro_.expect(pose.t, rate_B + state.bias.rate_B, 0.5);
    if (!filter.is_started()) return;
    accelerometer_.expect(pose.t, state.bias.force_B - pose.X_WB.q().conjugate() * state.gravity_W, 3.0);
  }

 private:
  InertialRanges ranges_;
  TriadHealth gyro_, accelerometer_;
  GravityCheck gravity_;
  TurnComparison turns_, doubtful_turns_;  ///< those between believed poses; and with the rejected ones since
};

}  // namespace holdfast
