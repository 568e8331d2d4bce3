/// The point that three or more planes share, as fixed 1D sensors give them (000 section 4.1.3, eqs 4.9-4.11).
///
/// Each plane says n_i . p = d_i (eq. 4.9). Three determine p (4.10), more by least squares of the distances to the planes
/// (4.11); the normals have unit length, so each plane counts alike. Two rays: nearest_points of rays_planes.hpp.
/// Bad input: nothing is answered for fewer than three planes, numbers that are not finite, or planes that share a
/// direction, or nearly so: distances to them determine the point along it more than `weakest` times worse than along
/// the best.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Eigenvalues>

#include <holdfast/geometry/rays_planes.hpp>

namespace holdfast {

[[nodiscard]] inline std::optional<Vector3> intersection(std::span<const Plane> planes, double weakest = 1e6) {
  if (planes.size() < 3) return std::nullopt;
  Matrix3 normal = Matrix3::Zero();
  Vector3 right = Vector3::Zero();
  for (const Plane& plane : planes) {
    normal += plane.normal * plane.normal.transpose();
    right += plane.offset * plane.normal;
  }
  if (!normal.allFinite() || !right.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Matrix3> axes(normal);  // eigenvalues rise
  const Vector3 weight = axes.eigenvalues();
  if (!(weight[0] * weakest * weakest > weight[2])) return std::nullopt;
  const Vector3 p = axes.eigenvectors() * (axes.eigenvectors().transpose() * right).cwiseQuotient(weight);
  return p;
}

}  // namespace holdfast
