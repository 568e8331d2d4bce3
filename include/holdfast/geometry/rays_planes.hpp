/// Rays and planes: where they meet, and the point nearest to two rays.
///
/// A Ray is p + s d with unit direction d and distance s >= 0 (m). A Plane is the set of points with n.p = d, unit
/// normal n; signed distance is positive on the side n points to. All in one frame, whose letter the variables carry.
/// Sources: 000 section 4.1.2 (eqs 4.4-4.8, two rays), 4.1.3 (eqs 4.9-4.11, planes).
/// Bad input: `make` and the fits give nothing for a zero or non-finite direction and for degenerate point sets.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>

#include <Eigen/Eigenvalues>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

namespace ray_detail {
/// The unit vector along v; nothing when v is zero or not finite.
[[nodiscard]] inline std::optional<Vector3> unit_vector(const Vector3& v) {
  const double length = v.stableNorm();
  if (!(length > 0.0) || !std::isfinite(length)) return std::nullopt;
  const Vector3 scaled = v / length;
  return Vector3(scaled.normalized());
}
}  // namespace ray_detail

struct Ray {
  Vector3 origin = Vector3::Zero();
  Vector3 direction = -Vector3::UnitZ();  ///< unit length

  /// Nothing when a number is not finite or the direction is zero; the direction need not be unit.
  [[nodiscard]] static std::optional<Ray> make(const Vector3& origin, const Vector3& direction) {
    const std::optional<Vector3> unit = ray_detail::unit_vector(direction);
    if (!unit || !origin.allFinite()) return std::nullopt;
    return Ray{origin, *unit};
  }

  [[nodiscard]] Vector3 at(double distance) const { return origin + distance * direction; }
};

struct Plane {
  Vector3 normal = Vector3::UnitY();  ///< unit length
  double offset = 0.0;                ///< n.p of the plane's points: its distance from the origin along the normal, m

  /// The plane through a point; nothing when a number is not finite or the normal is zero; the normal need not be unit.
  [[nodiscard]] static std::optional<Plane> make(const Vector3& normal, const Vector3& point) {
    const std::optional<Vector3> unit = ray_detail::unit_vector(normal);
    if (!unit || !point.allFinite()) return std::nullopt;
    return Plane{*unit, unit->dot(point)};
  }

  /// Metres above the plane on the normal's side, negative below.
  [[nodiscard]] double signed_distance(const Vector3& point) const { return normal.dot(point) - offset; }
  /// The plane's point nearest to `point`.
  [[nodiscard]] Vector3 nearest_point(const Vector3& point) const { return point - signed_distance(point) * normal; }
};

/// The same ray in frame A.
[[nodiscard]] inline Ray operator*(const Rigid& X_AB, const Ray& ray_B) {
  return {X_AB * ray_B.origin, X_AB.q() * ray_B.direction};
}

/// The same plane in frame A.
[[nodiscard]] inline Plane operator*(const Rigid& X_AB, const Plane& plane_B) {
  const Vector3 normal_A = X_AB.q() * plane_B.normal;
  return {normal_A, plane_B.offset + normal_A.dot(X_AB.p())};
}

/// Distance along the ray at which it meets the plane, from either side; nothing when it runs parallel to the plane
/// (within 1e-12 rad) or away from it.
[[nodiscard]] inline std::optional<double> intersection_distance(const Ray& ray, const Plane& plane) {
  const double approach = plane.normal.dot(ray.direction);
  if (!(std::abs(approach) > 1e-12)) return std::nullopt;
  const double distance = -plane.signed_distance(ray.origin) / approach;
  if (!(distance >= 0.0)) return std::nullopt;
  return distance;
}

/// The point where the ray meets the plane; nothing as above.
[[nodiscard]] inline std::optional<Vector3> intersection(const Ray& ray, const Plane& plane) {
  const std::optional<double> distance = intersection_distance(ray, plane);
  if (!distance) return std::nullopt;
  return ray.at(*distance);
}

/// The two nearest points of two rays' lines (000 eqs 4.4-4.8). A negative distance lies behind its ray's origin.
struct NearestPoints {
  double distance_1, distance_2;  ///< s_1 and s_2 of eq. 4.7, m
  Vector3 point_1, point_2;

  [[nodiscard]] Vector3 midpoint() const { return 0.5 * (point_1 + point_2); }  ///< eq. 4.8
  [[nodiscard]] double gap() const { return (point_2 - point_1).norm(); }  ///< length of the shortest line between them
};

/// Nothing when the rays are parallel: sin(angle between them) below 1e-9.
[[nodiscard]] inline std::optional<NearestPoints> nearest_points(const Ray& ray_1, const Ray& ray_2) {
  const Vector3 baseline = ray_2.origin - ray_1.origin;
  // 1 - (d1.d2)^2 of eq. 4.7, written as |d1 x d2|^2, which does not cancel for nearly parallel rays.
  const Vector3 cross = ray_1.direction.cross(ray_2.direction);
  const double denominator = cross.squaredNorm();
  if (!(denominator > 1e-18)) return std::nullopt;
  const double s_1 = baseline.cross(ray_2.direction).dot(cross) / denominator;
  const double s_2 = baseline.cross(ray_1.direction).dot(cross) / denominator;
  return NearestPoints{s_1, s_2, ray_1.at(s_1), ray_2.at(s_2)};
}

/// Plane of least squared distance to three or more points; nothing when they are fewer, not finite, or lie on a line
/// (their spread across it is below 1e-6 of that along it). The normal points to the side from which the first three
/// points run anticlockwise, where they determine one.
[[nodiscard]] inline std::optional<Plane> plane_through(std::span<const Vector3> points) {
  if (points.size() < 3) return std::nullopt;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& p : points) centre += p / static_cast<double>(points.size());
  Matrix3 scatter = Matrix3::Zero();
  for (const Vector3& p : points) scatter += (p - centre) * (p - centre).transpose();
  if (!scatter.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes{Eigen::Matrix3d(scatter)};  // eigenvalues rise
  if (!(axes.eigenvalues()[1] > 1e-12 * axes.eigenvalues()[2])) return std::nullopt;
  Vector3 normal = axes.eigenvectors().col(0);
  const Vector3 turn = (points[1] - points[0]).cross(points[2] - points[0]);
  if (normal.dot(turn) < 0.0) normal = -normal;
  return Plane::make(normal, centre);
}

[[nodiscard]] inline std::optional<Plane> plane_through(const Vector3& a, const Vector3& b, const Vector3& c) {
  const std::array<Vector3, 3> points{a, b, c};
  return plane_through(points);
}

}  // namespace holdfast
