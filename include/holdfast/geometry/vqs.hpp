/// VQS transform T_AB (vector, unit quaternion, scale): p_A = T_AB * p_B = s (q p_B q^-1) + v.
///
/// Source: Robinett & Holloway 1994, *The Visual Display Transformation for Virtual Reality*, section 4 (course 11):
/// translation, rotation and uniform scale, closed under composition and inversion. T_AC = T_AB * T_BC. The scan
/// garbles the quaternion product; Hamilton's is meant. v in units of A; s > 0 is units of A per unit of B.
#pragma once

#include <cmath>
#include <optional>
#include <type_traits>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

template <typename Scalar>
class VqsTransform {
 public:
  using Vector3 = VectorOf<Scalar, 3>;
  using Quaternion = QuaternionOf<Scalar>;
  using Matrix4 = MatrixOf<Scalar, 4>;

  VqsTransform() : q_(Quaternion::Identity()), v_(Vector3::Zero()), s_(Scalar(1)) {}
  /// Preconditions: q finite and not zero (normalised here), s finite and positive. For input that may be bad use
  /// `make`.
  VqsTransform(const Vector3& v_AB, const Quaternion& q_AB, Scalar s_AB) : q_(q_AB.normalized()), v_(v_AB), s_(s_AB) {
    HOLDFAST_ASSERT(q_.coeffs().allFinite() && q_AB.squaredNorm() > Scalar(0), "quaternion is zero or not finite");
    HOLDFAST_ASSERT(std::isfinite(s_) && s_ > Scalar(0), "scale is not a positive number");
  }
  /// A rigid transform is a VQS transform of scale 1.
  VqsTransform(const RigidTransform<Scalar>& X_AB) : q_(X_AB.q()), v_(X_AB.p()), s_(Scalar(1)) {}

  /// Nothing when a number is not finite, the quaternion's length is not in [0.5, 2], or the scale is not positive.
  [[nodiscard]] static std::optional<VqsTransform> make(const Vector3& v_AB, const Quaternion& q_AB, Scalar s_AB) {
    const Scalar n2 = q_AB.squaredNorm();
    if (!(n2 > Scalar(0.25) && n2 < Scalar(4)) || !v_AB.allFinite()) return std::nullopt;
    if (!(s_AB > Scalar(0)) || !std::isfinite(s_AB)) return std::nullopt;
    return VqsTransform(v_AB, q_AB, s_AB);
  }

  /// From a 4x4 matrix of rotation, uniform scale and translation; nothing when it has shear, mirror image, unequal
  /// scales (relative deviation above `tolerance`), projection, or numbers that are not finite.
  [[nodiscard]] static std::optional<VqsTransform> from_matrix(const Matrix4& M_AB,
                                                               Scalar tolerance = so3::rotation_tolerance<Scalar>()) {
    if (!M_AB.allFinite()) return std::nullopt;
    const MatrixOf<Scalar, 3> A = M_AB.template topLeftCorner<3, 3>();
    const Scalar det = A.determinant();
    if (!(det > Scalar(0))) return std::nullopt;
    const Scalar s = std::cbrt(det);
    const MatrixOf<Scalar, 3> R = A / s;
    if (!std::isfinite(s) || !so3::is_rotation<Scalar>(R, tolerance)) return std::nullopt;
    const VectorOf<Scalar, 4> last_row = M_AB.row(3).transpose();
    if ((last_row - VectorOf<Scalar, 4>(0, 0, 0, 1)).cwiseAbs().maxCoeff() > tolerance) return std::nullopt;
    return VqsTransform(M_AB.template topRightCorner<3, 1>(), Quaternion(R), s);
  }

  [[nodiscard]] const Vector3& v() const { return v_; }
  [[nodiscard]] const Quaternion& q() const { return q_; }
  [[nodiscard]] Scalar s() const { return s_; }

  /// T_BA = [ q^-1 (-v / s), q^-1, 1/s ]: not the members' own inverses (000 section 7.4).
  [[nodiscard]] VqsTransform inverse() const {
    const Quaternion q_BA = q_.conjugate();
    return VqsTransform(Unchecked{}, q_BA * (-v_ / s_), q_BA, Scalar(1) / s_);
  }

  /// T_AC = T_AB * T_BC.
  [[nodiscard]] friend VqsTransform operator*(const VqsTransform& T_AB, const VqsTransform& T_BC) {
    Quaternion q = T_AB.q_ * T_BC.q_;
    q.coeffs() *= Scalar(1.5) - Scalar(0.5) * q.squaredNorm();  // one Newton step to unit length
    return VqsTransform(Unchecked{}, T_AB.v_ + T_AB.s_ * (T_AB.q_ * T_BC.v_), q, T_AB.s_ * T_BC.s_);
  }

  /// p_A = T_AB * p_B.
  [[nodiscard]] friend Vector3 operator*(const VqsTransform& T_AB, const Vector3& p_B) {
    return T_AB.s_ * (T_AB.q_ * p_B) + T_AB.v_;
  }

  /// 4x4 matrix M with (p_A, 1) = M (p_B, 1).
  [[nodiscard]] Matrix4 matrix() const {
    Matrix4 m = Matrix4::Identity();
    m.template topLeftCorner<3, 3>() = s_ * q_.toRotationMatrix();
    m.template topRightCorner<3, 1>() = v_;
    return m;
  }

  /// The same pose without the scale: X_AB with B's axes and origin, in units of A.
  [[nodiscard]] RigidTransform<Scalar> rigid() const { return RigidTransform<Scalar>(q_, v_); }

  template <typename Other>
  [[nodiscard]] VqsTransform<Other> cast() const {
    const RigidTransform<Other> X = rigid().template cast<Other>();
    return VqsTransform<Other>(X.p(), X.q(), Other(s_));
  }

  [[nodiscard]] bool is_finite() const { return q_.coeffs().allFinite() && v_.allFinite() && std::isfinite(s_); }

 private:
  struct Unchecked {};
  VqsTransform(Unchecked, const Vector3& v, const Quaternion& q, Scalar s) : q_(q), v_(v), s_(s) {}

  Quaternion q_;
  Vector3 v_;
  Scalar s_;
};

using Vqs = VqsTransform<double>;
using Vqsf = VqsTransform<float>;

/// Interpolates the vector linearly, the rotation at a constant rate, the scale at a constant ratio; s = 0 gives a, 1
/// gives b.
template <typename Scalar>
[[nodiscard]] VqsTransform<Scalar> interpolate(const VqsTransform<Scalar>& a, const VqsTransform<Scalar>& b,
                                               std::type_identity_t<Scalar> s) {
  return VqsTransform<Scalar>(a.v() + s * (b.v() - a.v()), so3::interpolate<Scalar>(a.q(), b.q(), s),
                              a.s() * std::pow(b.s() / a.s(), s));
}

}  // namespace holdfast
