/// Position from simultaneous ranges to three or more anchors, in closed form (000 section 4.1.1, eqs 4.1-4.3).
///
/// With anchors a_i taken against their centre, half the differences of the spheres' equations (4.1) are linear,
///   a_i . p = (|a_i|^2 - r_i^2 - mean of the same) / 2,
/// and give p along the directions in which the anchors spread. Three anchors, or more in one plane, leave the height h over
/// their plane to the spheres themselves: h = +-sqrt(mean (r_i^2 - |a_i|^2) - |p|^2), eq. 4.3's two signs. Eqs 4.2 and 4.3
/// are the case of anchors at the origin and one unit along x and y. Gauss and Newton's steps then lead from there to the
/// least squares of the ranges themselves.
/// "Above" is the side from which the first three anchors run anticlockwise.
/// Bad input: nothing is answered for fewer than three ranges, numbers that are not finite, negative ranges, or anchors on
/// one line (their spread across it is below 1e-4 of that along it).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include <Eigen/Eigenvalues>

#include <holdfast/geometry/cholesky.hpp>

namespace holdfast {

struct AnchorRange {
  Vector3 anchor_W = Vector3::Zero();
  double range_m = 0.0;
};

struct Trilateration {
  Vector3 above_W;     ///< the position on the upper side of the anchors' plane
  Vector3 below_W;     ///< the one on the lower side; the same when the anchors do not lie in a plane
  double above_rms_m;  ///< of what the ranges differ from those at above_W
  double below_rms_m;
  bool flat = false;  ///< the anchors lie in a plane: both positions explain the ranges

  /// The position that explains the ranges better; of two equally good ones the upper.
  [[nodiscard]] const Vector3& best_W() const { return below_rms_m < above_rms_m ? below_W : above_W; }
};

namespace detail {

/// Root mean square of range_m - |p - anchor|.
[[nodiscard]] inline double range_rms(std::span<const AnchorRange> ranges, const Vector3& p_W) {
  double sum = 0.0;
  for (const AnchorRange& r : ranges) {
    const double residual = r.range_m - (p_W - r.anchor_W).norm();
    sum += residual * residual;
  }
  return std::sqrt(sum / static_cast<double>(ranges.size()));
}

/// Gauss-Newton steps on the ranges, taken while they make things better. Returns position and residual.
[[nodiscard]] inline std::pair<Vector3, double> polish_position(std::span<const AnchorRange> ranges, Vector3 p_W) {
  double rms = range_rms(ranges, p_W);
  for (int step = 0; step < 20; ++step) {
    Matrix3 normal = Matrix3::Zero();
    Vector3 right = Vector3::Zero();
    for (const AnchorRange& r : ranges) {
      const Vector3 apart = p_W - r.anchor_W;
      const double distance = apart.norm();
      if (!(distance > 0.0)) continue;
      const Vector3 unit = apart / distance;
      normal += unit * unit.transpose();
      right += (r.range_m - distance) * unit;
    }
    normal.diagonal().array() += 1e-12 * normal.trace();  // a target in the anchors' plane has no gradient across it
    Matrix3 L;
    if (!cholesky<3>(normal, L)) break;
    const Vector3 next = p_W + solved_by<3, 1>(L, right);
    const double next_rms = range_rms(ranges, next);
    if (!(next_rms < rms)) break;
    p_W = next;
    rms = next_rms;
  }
  return {p_W, rms};
}

}  // namespace detail

[[nodiscard]] inline std::optional<Trilateration> trilaterate(std::span<const AnchorRange> ranges) {
  if (ranges.size() < 3) return std::nullopt;
  const double n = static_cast<double>(ranges.size());
  Vector3 centre = Vector3::Zero();
  for (const AnchorRange& r : ranges) {
    if (!r.anchor_W.allFinite() || !std::isfinite(r.range_m) || r.range_m < 0.0) return std::nullopt;
    centre += r.anchor_W / n;
  }
  Matrix3 spread = Matrix3::Zero();  // mean a a^T
  double mean_square = 0.0;          // of r^2 - |a|^2, which is |p|^2 plus what is linear in a
  for (const AnchorRange& r : ranges) {
    const Vector3 a = r.anchor_W - centre;
    spread += a * a.transpose() / n;
    mean_square += (r.range_m * r.range_m - a.squaredNorm()) / n;
  }
  Vector3 right = Vector3::Zero();
  for (const AnchorRange& r : ranges) {
    const Vector3 a = r.anchor_W - centre;
    right += 0.5 * (a.squaredNorm() - r.range_m * r.range_m + mean_square) * a / n;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> axes(spread);  // variances rise
  const Vector3 variance = axes.eigenvalues();
  if (!(variance[1] > 1e-8 * variance[2])) return std::nullopt;
  const auto along = [&](int axis) {
    const Vector3 direction = axes.eigenvectors().col(axis);
    return Vector3(direction.dot(right) / variance[axis] * direction);
  };
  const Vector3 in_plane = along(1) + along(2);
  Trilateration result;
  // Anchors within a hundredth of a plane tell a height only through the spheres.
  result.flat = !(variance[0] > 1e-4 * variance[2]);
  if (!result.flat) {
    std::tie(result.above_W, result.above_rms_m) = detail::polish_position(ranges, centre + in_plane + along(0));
    result.below_W = result.above_W;
    result.below_rms_m = result.above_rms_m;
    return result;
  }
  Vector3 up = axes.eigenvectors().col(0);
  const Vector3 turning = (ranges[1].anchor_W - ranges[0].anchor_W).cross(ranges[2].anchor_W - ranges[0].anchor_W);
  if (up.dot(turning) < 0.0) up = -up;
  const double height = std::sqrt(std::max(0.0, mean_square - in_plane.squaredNorm()));
  std::tie(result.above_W, result.above_rms_m) = detail::polish_position(ranges, centre + in_plane + height * up);
  std::tie(result.below_W, result.below_rms_m) = detail::polish_position(ranges, centre + in_plane - height * up);
  return result;
}

}  // namespace holdfast
