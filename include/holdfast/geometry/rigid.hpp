/// Rigid transform X_AB: the pose of frame B in frame A, p_A = X_AB * p_B = R_AB p_B + p_AB.
///
/// Neighbouring letters match: X_AC = X_AB * X_BC. Lengths in metres. The notation is Robinett & Holloway's T_A_B
/// (course 11, section 3) without scale; with scale see vqs.hpp. The rotation is a unit quaternion: constructors
/// normalise, and a zero or non-finite quaternion is refused by `make`.
#pragma once

#include <cmath>
#include <optional>
#include <type_traits>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/so3.hpp>

namespace holdfast {

template <typename Scalar>
class RigidTransform {
 public:
  using Vector3 = VectorOf<Scalar, 3>;
  using Quaternion = QuaternionOf<Scalar>;
  using Matrix4 = MatrixOf<Scalar, 4>;

  RigidTransform() : q_(Quaternion::Identity()), p_(Vector3::Zero()) {}

  /// Rotation q_AB (normalised here; precondition: finite, not zero) and position p_AB of B's origin in A.
  RigidTransform(const Quaternion& q_AB, const Vector3& p_AB) : q_(q_AB.normalized()), p_(p_AB) {
    HOLDFAST_ASSERT(q_.coeffs().allFinite() && q_AB.squaredNorm() > Scalar(0), "quaternion is zero or not finite");
  }

  /// For input that may be bad: nothing when a number is not finite or the quaternion's length is not in [0.5, 2].
  [[nodiscard]] static std::optional<RigidTransform> make(const Quaternion& q_AB, const Vector3& p_AB) {
    const Scalar n2 = q_AB.squaredNorm();
    if (!(n2 > Scalar(0.25) && n2 < Scalar(4)) || !p_AB.allFinite()) return std::nullopt;
    return RigidTransform(q_AB, p_AB);
  }

  /// From a 4x4 matrix of rotation and translation; nothing when it holds anything else (an element off by more than
  /// `tolerance`) or a number that is not finite. A matrix with scale is a VqsTransform.
  [[nodiscard]] static std::optional<RigidTransform> from_matrix(const Matrix4& M_AB,
                                                                 Scalar tolerance = so3::rotation_tolerance<Scalar>()) {
    const MatrixOf<Scalar, 3> R_AB = M_AB.template topLeftCorner<3, 3>();
    const VectorOf<Scalar, 4> last_row = M_AB.row(3).transpose();
    if (!M_AB.allFinite() || !so3::is_rotation<Scalar>(R_AB, tolerance) ||
        (last_row - VectorOf<Scalar, 4>(0, 0, 0, 1)).cwiseAbs().maxCoeff() > tolerance) {
      return std::nullopt;
    }
    return RigidTransform(Quaternion(R_AB), M_AB.template topRightCorner<3, 1>());
  }

  [[nodiscard]] static RigidTransform translation(const Vector3& p_AB) {
    return RigidTransform(Quaternion::Identity(), p_AB);
  }
  [[nodiscard]] static RigidTransform rotation(const Quaternion& q_AB) { return RigidTransform(q_AB, Vector3::Zero()); }

  [[nodiscard]] const Quaternion& q() const { return q_; }
  [[nodiscard]] const Vector3& p() const { return p_; }
  [[nodiscard]] MatrixOf<Scalar, 3> R() const { return q_.toRotationMatrix(); }

  /// X_BA.
  [[nodiscard]] RigidTransform inverse() const {
    const Quaternion q_BA = q_.conjugate();
    return RigidTransform(Unchecked{}, q_BA, -(q_BA * p_));
  }

  /// X_AC = X_AB * X_BC.
  [[nodiscard]] friend RigidTransform operator*(const RigidTransform& X_AB, const RigidTransform& X_BC) {
    Quaternion q = X_AB.q_ * X_BC.q_;
    // One Newton step to unit length: long chains stay unit without a square root.
    q.coeffs() *= Scalar(1.5) - Scalar(0.5) * q.squaredNorm();
    return RigidTransform(Unchecked{}, q, X_AB.p_ + X_AB.q_ * X_BC.p_);
  }

  /// p_A = X_AB * p_B.
  [[nodiscard]] friend Vector3 operator*(const RigidTransform& X_AB, const Vector3& p_B) {
    return X_AB.q_ * p_B + X_AB.p_;
  }

  /// 4x4 matrix M with (p_A, 1) = M (p_B, 1).
  [[nodiscard]] Matrix4 matrix() const {
    Matrix4 m = Matrix4::Identity();
    m.template topLeftCorner<3, 3>() = R();
    m.template topRightCorner<3, 1>() = p_;
    return m;
  }

  [[nodiscard]] bool is_finite() const { return q_.coeffs().allFinite() && p_.allFinite(); }

  template <typename Other>
  [[nodiscard]] RigidTransform<Other> cast() const {
    return RigidTransform<Other>(QuaternionOf<Other>(Other(q_.w()), Other(q_.x()), Other(q_.y()), Other(q_.z())),
                                 p_.template cast<Other>());
  }

 private:
  struct Unchecked {};
  RigidTransform(Unchecked, const Quaternion& q, const Vector3& p) : q_(q), p_(p) {}

  Quaternion q_;
  Vector3 p_;
};

using Rigid = RigidTransform<double>;
using Rigidf = RigidTransform<float>;

/// Interpolates position linearly and rotation at a constant rate by the shorter way; s = 0 gives a, s = 1 gives b, and
/// s outside [0, 1] extrapolates.
template <typename Scalar>
[[nodiscard]] RigidTransform<Scalar> interpolate(const RigidTransform<Scalar>& a, const RigidTransform<Scalar>& b,
                                                 std::type_identity_t<Scalar> s) {
  return RigidTransform<Scalar>(so3::interpolate<Scalar>(a.q(), b.q(), s), a.p() + s * (b.p() - a.p()));
}

}  // namespace holdfast
