/// How much a position found from ranges errs for each metre that all of the ranges err: the geometric dilution of
/// precision (003 section 3, eq. 1),
///
///   GDOP = sqrt(s_x^2 + s_y^2 + s_z^2) / s_r = sqrt(trace C),   C = (sum u_i u_i^T)^-1,   covariance of p = s_r^2 C
/// with u_i the unit vector from anchor i to p. It belongs to a place: few anchors, or all in much the same direction, make it
/// large. For random errors that are alike and independent; for systematic ones see registration/range_sensitivity.hpp.
/// Bad input: nothing for fewer than three anchors, numbers that are not finite, a place at an anchor, or directions that lie
/// in one plane (anchors in one line, or a place in the anchors' plane): there it is infinite.
#pragma once

#include <cmath>
#include <optional>
#include <span>

#include <holdfast/tracking/multilateration.hpp>

namespace holdfast {

struct RangeDilution {
  Matrix3 C = Matrix3::Zero();

  [[nodiscard]] double geometric() const { return std::sqrt(C.trace()); }
  /// Along x, y and z of W.
  [[nodiscard]] Vector3 per_axis() const { return C.diagonal().cwiseSqrt(); }
  /// Along a unit vector; of the vertical it is called VDOP.
  [[nodiscard]] double along(const Vector3& direction_W) const { return std::sqrt(direction_W.dot(C * direction_W)); }
  /// In the plane across it: HDOP.
  [[nodiscard]] double across(const Vector3& direction_W) const {
    return std::sqrt(C.trace() - direction_W.dot(C * direction_W));
  }
};

[[nodiscard]] inline std::optional<RangeDilution> range_dilution(std::span<const Vector3> anchors_W,
                                                                 const Vector3& p_W) {
  if (anchors_W.size() < 3) return std::nullopt;
  Matrix3 information = Matrix3::Zero();
  for (const Vector3& anchor_W : anchors_W) {
    const Vector3 apart = p_W - anchor_W;
    information += apart * apart.transpose() / apart.squaredNorm();
  }
  if (!information.allFinite()) return std::nullopt;
  const std::optional<Matrix3> C = detail::inverse_of_information(information);
  if (!C) return std::nullopt;
  return RangeDilution{*C};
}

}  // namespace holdfast
