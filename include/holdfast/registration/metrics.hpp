/// Registration error of one point (the statistics of many: prediction/error_statistics.hpp).
///
/// The error is c_virtual - c_real: where the eye sees the virtual point minus where it sees the real one. Told three
/// ways:
///  - px: difference of the two points of the display's picture, right and up positive;
///  - rad (arcmin): the true angle between the two rays, not pixels times a constant, with the direction right and up
///    in the plane across the real ray: right = ray x up / |ray x up|, up' = right x ray;
///  - mm at the fiducial's depth: distance of the two rays' hits on the plane across the eye's axis through the
///    fiducial, that is depth times the difference of tangents.
///
/// Source: evaluation.md "Metrics"; Azuma & Bishop 1994 (001) section 5.3 (screen error) and 4.4 (millimetres).
/// Rays are in the eye frame E (-Z forward), of any length. Bad input: rays across the up axis have no "right"; visible
/// ones are not.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <holdfast/geometry/types.hpp>
#include <holdfast/prediction/error_statistics.hpp>

namespace holdfast {

inline constexpr double arcmin_per_rad = 180.0 * 60.0 / std::numbers::pi;
inline constexpr double degrees_per_rad = 180.0 / std::numbers::pi;

/// Angle between two rays, rad in [0, pi]; accurate for the smallest angles.
[[nodiscard]] inline double angle_between_rays(const Vector3& a, const Vector3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Vector of length angle_between_rays, (right, up) as seen along `real_E`.
[[nodiscard]] inline Vector2 angular_error(const Vector3& real_E, const Vector3& virtual_E) {
  const Vector3 ray = real_E.normalized();
  const Vector3 right = ray.cross(Vector3::UnitY()).normalized();
  const Vector3 up = right.cross(ray);
  const Vector2 across(right.dot(virtual_E), up.dot(virtual_E));
  const double length = across.norm();
  if (!(length > 0.0)) return Vector2::Zero();
  return across * (angle_between_rays(real_E, virtual_E) / length);
}

/// Distance (m) between the hits of two rays on the plane z_E = -depth_m.
[[nodiscard]] inline double error_at_depth(const Vector3& real_E, const Vector3& virtual_E, double depth_m) {
  const Vector2 t_real = real_E.head<2>() / -real_E.z();
  const Vector2 t_virtual = virtual_E.head<2>() / -virtual_E.z();
  return depth_m * (t_virtual - t_real).norm();
}

/// Horizontal and vertical difference of the two eyes' errors (left minus right) of one fiducial: false depth, and
/// strain.
struct StereoResidual {
  double rms_horizontal_arcmin = 0.0, rms_vertical_arcmin = 0.0;
  double peak_horizontal_arcmin = 0.0, peak_vertical_arcmin = 0.0;
};

/// Pairs of errors (rad) of the same fiducial in the same frame; all zero when there are none. Precondition: equal
/// sizes.
[[nodiscard]] inline StereoResidual stereo_residual(std::span<const Vector2> left_rad,
                                                    std::span<const Vector2> right_rad) {
  StereoResidual r;
  const std::size_t n = std::min(left_rad.size(), right_rad.size());
  if (n == 0) return r;
  Vector2 squares = Vector2::Zero(), peak = Vector2::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2 d = arcmin_per_rad * (left_rad[i] - right_rad[i]);
    squares += d.cwiseAbs2();
    peak = peak.cwiseMax(d.cwiseAbs()).eval();
  }
  const Vector2 rms = (squares / static_cast<double>(n)).cwiseSqrt();
  r.rms_horizontal_arcmin = rms.x();
  r.rms_vertical_arcmin = rms.y();
  r.peak_horizontal_arcmin = peak.x();
  r.peak_vertical_arcmin = peak.y();
  return r;
}

}  // namespace holdfast
