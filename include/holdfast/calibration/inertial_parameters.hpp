/// What inertial sensors do not tell about themselves: orientation, biases, scales, place, and by how much their stamps are late.
///
/// S are the axes of three gyros, A those of three accelerometers, B the body that the tracker's poses are of. A reading stamped t
/// tells of t - time_offset (as in tracking/inertial_state.hpp and simulation/inertial_sensor.hpp):
///   z_gyro          = k (R_SB w_WB_B) + b
///   z_accelerometer = k (R_AB f) + b,   number i with f as felt at place i:  f = R_BW (a - g) + w' x l_i + w x (w x l_i)
/// k is taken axis by axis; axes are square to each other (001 appendix C knows no others).
/// Units: rad/s, m/s^2, m, s. Bad input: scales must not be zero.
#pragma once

#include <array>

#include <holdfast/geometry/so3.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

struct GyroParameters {
  Quaternion q_BS = Quaternion::Identity();
  Vector3 bias = Vector3::Zero(), scale = Vector3::Ones();
  double time_offset_s = 0.0;

  /// w_WB_B that the gyros spoke of.
  [[nodiscard]] Vector3 rate_B(const Vector3& said) const {
    const Vector3 rate_S = (said - bias).cwiseQuotient(scale);
    return q_BS * rate_S;
  }
};

struct AccelerometerParameters {
  Quaternion q_BA = Quaternion::Identity();
  Vector3 bias = Vector3::Zero(), scale = Vector3::Ones();
  std::array<Vector3, 3> places_B{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};  ///< all alike: a triad
  Vector3 gravity_W = -standard_gravity * Vector3::UnitY();                            ///< where things fall

  [[nodiscard]] Vector3 force_B(const Vector3& said) const {
    const Vector3 force_A = (said - bias).cwiseQuotient(scale);
    return q_BA * force_A;
  }
};

/// The reading as ideal sensors along B's axes would have given it, by the tracker's clock: for filters whose sensors are
/// known (tracking/inertial_filter.hpp). The accelerometers stay where they are.
[[nodiscard]] inline InertialReading calibrated(const InertialReading& reading, const GyroParameters& gyro,
                                                const AccelerometerParameters& accelerometer) {
  return {reading.t - from_seconds(gyro.time_offset_s), gyro.rate_B(reading.rate_B),
          accelerometer.force_B(reading.force_B)};
}

}  // namespace holdfast
