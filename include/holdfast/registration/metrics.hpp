/// Registration error of one point, and the statistics of many.
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
#include <vector>

#include <holdfast/geometry/types.hpp>

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

struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0.0, rms = 0.0, p50 = 0.0, p95 = 0.0, p99 = 0.0, peak = 0.0;
};

/// Value below which the fraction `p` (0 to 1) of sorted values lies, linear between neighbours (the default of R and
/// NumPy). Precondition: sorted, not empty.
[[nodiscard]] inline double percentile_of_sorted(std::span<const double> sorted, double p) {
  const double place = std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(place);
  if (i + 1 >= sorted.size()) return sorted.back();
  return sorted[i] + (place - static_cast<double>(i)) * (sorted[i + 1] - sorted[i]);
}

/// Statistics of error lengths (not negative); all zero when there are none.
[[nodiscard]] inline ErrorStatistics statistics_of(std::vector<double> lengths) {
  ErrorStatistics s;
  s.count = lengths.size();
  if (lengths.empty()) return s;
  std::sort(lengths.begin(), lengths.end());
  double sum = 0.0, squares = 0.0;
  for (const double x : lengths) {
    sum += x;
    squares += x * x;
  }
  const auto n = static_cast<double>(lengths.size());
  s.mean = sum / n;
  s.rms = std::sqrt(squares / n);
  s.p50 = percentile_of_sorted(lengths, 0.50);
  s.p95 = percentile_of_sorted(lengths, 0.95);
  s.p99 = percentile_of_sorted(lengths, 0.99);
  s.peak = lengths.back();
  return s;
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
