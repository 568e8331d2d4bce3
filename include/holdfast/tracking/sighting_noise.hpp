/// Noise of a beacon's sighting by a lateral-effect photodiode, as angle and distance weaken the signal (002 eq. 6.4).
///
///   sqrt(xi_c) = sqrt(xi_0) d^2 / (a alpha^3 + b alpha^2 + c alpha + 1)
/// xi_c is the variance of u, and of v (m^2 on the image plane, eq. 6.3); d the distance from camera to beacon (m); alpha
/// the angle between the beacon's axis and the camera's, here the angle by which the camera fails to look straight
/// against the light. The published coefficients take alpha in degrees: the conversion is inside.
/// The denominator is the signal's strength. It falls from 1 to zero at 89.4 deg with 002's coefficients, where the
/// formula has a pole and then makes no sense; here it never falls below `weakest_signal`, so that a filter whose estimate
/// is far off still gets a finite variance. A beacon as weak as that is not seen (simulation/).
/// Bad input: a number that is not finite gives one that is not finite.
#pragma once

#include <cmath>
#include <numbers>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

struct SightingNoise {
  double xi_0 = 2.89e-14;  ///< variance at 0 deg and 1 m, m^2
  double a = -1.074e-6;    ///< per deg^3
  double b = -2.331e-6;    ///< per deg^2
  double c = -2.394e-3;    ///< per deg
};

/// Below this share of the signal at 0 deg eq. 6.4 is not followed: the standard deviation is then 100 times that at 0 deg.
inline constexpr double weakest_signal = 0.01;

/// Strength of the signal relative to that at 0 deg.
[[nodiscard]] inline double signal_strength(const SightingNoise& noise, double angle_rad) {
  const double alpha = std::abs(angle_rad) * (180.0 / std::numbers::pi);
  const double signal = 1.0 + alpha * (noise.c + alpha * (noise.b + alpha * noise.a));
  return signal < weakest_signal ? weakest_signal : signal;
}

/// Variance of u and of v, m^2.
[[nodiscard]] inline double sighting_variance(const SightingNoise& noise, double angle_rad, double distance_m) {
  const double ratio = distance_m * distance_m / signal_strength(noise, angle_rad);
  return noise.xi_0 * ratio * ratio;
}

/// The same for a beacon that shines along `beacon_axis` and a camera that looks along `camera_axis`, unit vectors of one
/// frame.
[[nodiscard]] inline double sighting_variance(const SightingNoise& noise, const Vector3& beacon_axis,
                                              const Vector3& camera_axis, double distance_m) {
  const double angle = std::atan2(beacon_axis.cross(camera_axis).norm(), -beacon_axis.dot(camera_axis));
  return sighting_variance(noise, angle, distance_m);
}

}  // namespace holdfast
