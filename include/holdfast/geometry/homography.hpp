/// Projective map between the pictures of two eyes, in tangents of field angle.
///
/// An eye looks along -Z (+X right, +Y up). The tangents of a point are (x / -z, y / -z), so a direction is S (t_x,
/// t_y, 1) with S = diag(1, 1, -1). H_AB maps tangents seen by eye B to tangents seen by eye A: (t_A, 1) ~ H_AB (t_B,
/// 1), and H_AC = H_AB * H_BC. The matrix keeps its sign: a third component that is positive is a direction ahead of
/// eye A.
///   turn only:     H_AB = S R_AB S                       exact for points at any distance when p_AB = 0
///   a plane:       H_AB = S (R_AB + p_AB n_B^T / d) S    exact for points of the plane n_B.p_B = d
/// Source: Hartley & Zisserman, Multiple View Geometry, 13.1, with this library's axes.
/// Bad input: `make` and `through_plane` give nothing for a map that mirrors, is singular or is not finite.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/LU>

#include <holdfast/geometry/rays_planes.hpp>
#include <holdfast/geometry/tangents_of_point.hpp>

namespace holdfast {

class Homography {
 public:
  Homography() : H_(Matrix3::Identity()) {}

  /// Nothing when the matrix is not finite or its determinant is not positive (a mirror image, or singular).
  [[nodiscard]] static std::optional<Homography> make(const Matrix3& H_AB) {
    const double size = H_AB.cwiseAbs().maxCoeff();
    if (!H_AB.allFinite() || !(size > 0.0)) return std::nullopt;
    const Matrix3 scaled = H_AB / size;
    if (!(scaled.determinant() > 1e-14)) return std::nullopt;
    return Homography(H_AB);
  }

  /// Two eyes in one place, turned by q_AB.
  [[nodiscard]] static Homography rotation(const Quaternion& q_AB) {
    return Homography(conjugate_by_flip(q_AB.toRotationMatrix()));
  }

  /// Two eyes anywhere, looking at a plane; nothing when an eye's centre lies in the plane, or the eyes are on
  /// different sides of it. It holds for those tangents of eye B at which the plane is ahead of B (see
  /// intersection_distance).
  [[nodiscard]] static std::optional<Homography> through_plane(const Rigid& X_AB, const Plane& plane_B) {
    const double to_B = plane_B.signed_distance(Vector3::Zero());
    if (!(std::abs(to_B) > 0.0)) return std::nullopt;
    const Matrix3 H = X_AB.R() - X_AB.p() * plane_B.normal.transpose() / to_B;
    return make(conjugate_by_flip(H));
  }

  [[nodiscard]] const Matrix3& matrix() const { return H_; }

  /// t_A of t_B; nothing when the direction is not ahead of eye A.
  [[nodiscard]] std::optional<Vector2> apply(const Vector2& t_B) const {
    const Vector3 h = H_ * Vector3(t_B.x(), t_B.y(), 1.0);
    if (!(h.z() > 0.0)) return std::nullopt;
    return Vector2(h.x() / h.z(), h.y() / h.z());
  }

  /// H_BA.
  [[nodiscard]] Homography inverse() const { return Homography(H_.inverse()); }

  /// H_AC = H_AB * H_BC.
  [[nodiscard]] friend Homography operator*(const Homography& H_AB, const Homography& H_BC) {
    return Homography(H_AB.H_ * H_BC.H_);
  }

 private:
  explicit Homography(const Matrix3& H_AB) : H_(H_AB) {}

  /// S M S: changes the signs of the third row and column, but not of their common element.
  [[nodiscard]] static Matrix3 conjugate_by_flip(const Matrix3& M) {
    const Vector3 flip(1.0, 1.0, -1.0);
    return flip.asDiagonal() * M * flip.asDiagonal();
  }

  Matrix3 H_;
};

}  // namespace holdfast
