/// The direction to a beacon, and the plane that holds it: what 2D and 1D optical sensors tell (000 sections 4.1.2, 4.1.3).
///
///   Bearing        a unit vector in the sensor's frame S, of two degrees of freedom. Measured against the expected
///                  direction u as two small angles: h = angle(d, u), split along two unit vectors across the measured
///                  direction d. No azimuth and no elevation, so that no direction is singular but the one opposite to d.
///   PlaneSighting  a plane through the sensor's origin held the beacon: a linear CCD, a sweeping sheet of light. Measured
///                  against the expected angle above that plane: h = asin(n . u).
/// Both are templates of where the sensor is: on the body (default; the beacon's position is in W) or in the room (the
/// beacon's position is in B), see body_point.hpp. The source's parameters are the beacon's position (m).
/// Noise: variance of each angle, rad^2.
/// Bad input: refused when the beacon is nearer than 1 mm, is expected opposite to the measured direction, or stands on the
/// plane's normal (within 1e-6 rad). Directions and normals are normalised here; zero is refused.
#pragma once

#include <cmath>

#include <holdfast/tracking/body_point.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

namespace detail {

/// Two unit vectors across a unit vector d, and across each other.
[[nodiscard]] inline MatrixOf<double, 3, 2> across(const Vector3& d) {
  Eigen::Index least = 0;
  d.cwiseAbs().minCoeff(&least);
  MatrixOf<double, 3, 2> sides;
  sides.col(0) = d.cross(Vector3::Unit(least)).normalized();
  sides.col(1) = d.cross(Vector3(sides.col(0)));
  return sides;
}

}  // namespace detail

template <typename Mount = SensorOnBody>
struct Bearing {
  static constexpr int size = 2;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 0;

  Vector3 direction_S = -Vector3::UnitZ();
  Mount sensor{};
  double variance = 0.0;  ///< of each of the two angles, rad^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& beacon, const DeviceParameters<0>&,
                               Linearization<Bearing>& linear) const {
    const SeenBeacon seen = sensor.see(state, beacon);
    const double distance = seen.p_S.norm();
    const double length = direction_S.norm();
    if (!(distance > nearest_sighting_m) || !(length > 0.0)) return false;
    const Vector3 u = seen.p_S / distance;
    const Vector3 d = direction_S / length;
    const MatrixOf<double, 3, 2> sides = detail::across(d);

    // h = k B^T u with k = angle / sin(angle); dk = -dcos (k cos - 1) / sin^2 .
    const Vector2 aside = sides.transpose() * u;
    const double sine = aside.norm();
    const double cosine = d.dot(u);
    if (cosine < 0.0 && sine < 1e-6) return false;
    const bool small = sine < 1e-4 && cosine > 0.0;
    const double k = small ? 1.0 + sine * sine / 6.0 : std::atan2(sine, cosine) / sine;
    const double slope = small ? 1.0 / 3.0 : (1.0 - k * cosine) / (sine * sine);
    linear.residual = -k * aside;
    const MatrixOf<double, 2, 3> by_u = k * sides.transpose() - aside * (slope * d.transpose());
    const MatrixOf<double, 2, 3> by_p_S = (by_u - (by_u * u) * u.transpose()) / distance;
    linear.H = by_p_S * seen.by_error;
    linear.H_source = by_p_S * seen.by_beacon;
    linear.R = variance * Matrix2::Identity();
    return true;
  }
};

template <typename Mount = SensorOnBody>
struct PlaneSighting {
  static constexpr int size = 1;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 0;

  Vector3 normal_S = Vector3::UnitX();
  Mount sensor{};
  double variance = 0.0;  ///< of the angle between the beacon and the plane, rad^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& beacon, const DeviceParameters<0>&,
                               Linearization<PlaneSighting>& linear) const {
    const SeenBeacon seen = sensor.see(state, beacon);
    const double distance = seen.p_S.norm();
    const double length = normal_S.norm();
    if (!(distance > nearest_sighting_m) || !(length > 0.0)) return false;
    const Vector3 u = seen.p_S / distance;
    const Vector3 n = normal_S / length;
    const double sine = n.dot(u);
    const double cosine = n.cross(u).norm();
    if (!(cosine > 1e-6)) return false;
    linear.residual[0] = -std::atan2(sine, cosine);
    const MatrixOf<double, 1, 3> by_p_S = (n - sine * u).transpose() / (distance * cosine);
    linear.H = by_p_S * seen.by_error;
    linear.H_source = by_p_S * seen.by_beacon;
    linear.R(0, 0) = variance;
    return true;
  }
};

}  // namespace holdfast
