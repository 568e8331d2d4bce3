/// The rotation group SO(3): exponential and logarithm of rotation vectors, with their Jacobians.
///
/// A rotation vector phi (rad) has the rotation's axis for its direction and its angle for its length. With ^ the
/// cross-product matrix, exp(phi) = I + sin(a)/a phi^ + (1 - cos(a))/a^2 phi^^2, a = |phi| (Rodrigues). Jacobians name
/// the side on which the perturbation acts:
///   exp(phi + d) = exp(J_left(phi) d) exp(phi) = exp(phi) exp(J_right(phi) d)         to first order in d.
/// Sources: Barfoot, State Estimation for Robotics, 7.1; Sola et al., A micro Lie theory for state estimation, eqs
/// 143-146. Bad input: nothing is checked; non-finite in gives non-finite out.
#pragma once

#include <cmath>
#include <limits>

#include <holdfast/geometry/types.hpp>

namespace holdfast::so3 {

/// The matrix with hat(a) b = a x b.
template <typename Scalar>
[[nodiscard]] MatrixOf<Scalar, 3> hat(const VectorOf<Scalar, 3>& a) {
  MatrixOf<Scalar, 3> m;
  m << Scalar(0), -a.z(), a.y(), a.z(), Scalar(0), -a.x(), -a.y(), a.x(), Scalar(0);
  return m;
}

namespace detail {

/// Below this squared angle the series are exact to rounding: their first dropped term is angle^6 / 5040 or smaller.
template <typename Scalar>
constexpr Scalar small_angle_squared() {
  return sizeof(Scalar) == sizeof(float) ? Scalar(1e-2) : Scalar(1e-5);
}

/// (1 - cos a) / a^2
template <typename Scalar>
Scalar one_minus_cos_over_square(Scalar a2) {
  if (a2 < small_angle_squared<Scalar>()) return Scalar(0.5) - a2 / Scalar(24) + a2 * a2 / Scalar(720);
  const Scalar half = std::sqrt(a2) / Scalar(2);
  const Scalar s = std::sin(half);
  return Scalar(2) * s * s / a2;
}

/// (a - sin a) / a^3
template <typename Scalar>
Scalar angle_minus_sin_over_cube(Scalar a2) {
  // The difference cancels, so the series serves up to a larger angle than elsewhere.
  if (a2 < Scalar(0.25)) {
    return Scalar(1) / 6 -
           a2 * (Scalar(1) / 120 -
                 a2 * (Scalar(1) / 5040 -
                       a2 * (Scalar(1) / 362880 - a2 * (Scalar(1) / 39916800 - a2 / Scalar(6227020800.0)))));
  }
  const Scalar a = std::sqrt(a2);
  return (a - std::sin(a)) / (a2 * a);
}

}  // namespace detail

/// Unit quaternion of the rotation vector phi (rad).
template <typename Scalar>
[[nodiscard]] QuaternionOf<Scalar> exp(const VectorOf<Scalar, 3>& phi) {
  const Scalar a2 = phi.squaredNorm();
  if (a2 < detail::small_angle_squared<Scalar>()) {
    const Scalar k = Scalar(0.5) - a2 / Scalar(48) + a2 * a2 / Scalar(3840);
    return QuaternionOf<Scalar>(Scalar(1) - a2 / Scalar(8) + a2 * a2 / Scalar(384), k * phi.x(), k * phi.y(),
                                k * phi.z());
  }
  const Scalar a = std::sqrt(a2);
  const Scalar k = std::sin(a / Scalar(2)) / a;
  return QuaternionOf<Scalar>(std::cos(a / Scalar(2)), k * phi.x(), k * phi.y(), k * phi.z());
}

/// Rotation vector (rad, length in [0, pi]) of a unit quaternion; q and -q give the same. At exactly pi either axis
/// sign is right.
template <typename Scalar>
[[nodiscard]] VectorOf<Scalar, 3> log(const QuaternionOf<Scalar>& q) {
  const Scalar sign = q.w() < Scalar(0) ? Scalar(-1) : Scalar(1);
  const VectorOf<Scalar, 3> v(sign * q.x(), sign * q.y(), sign * q.z());
  const Scalar w = sign * q.w();
  const Scalar n = v.norm();
  // atan2 is accurate at both ends, where acos(w) loses half the digits.
  const Scalar t2 = (n * n) / (w * w);  // tan^2 of half the angle
  const Scalar k = n < Scalar(1e-3) * w ? Scalar(2) / w * (Scalar(1) - t2 / Scalar(3) + t2 * t2 / Scalar(5))
                                        : Scalar(2) * std::atan2(n, w) / n;
  return k * v;
}

namespace detail {

/// I + c phi^ + k phi^^2, by phi^^2 = phi phi^T - |phi|^2 I.
template <typename Scalar>
[[nodiscard]] MatrixOf<Scalar, 3> hat_polynomial(Scalar c, Scalar k, const VectorOf<Scalar, 3>& phi) {
  const VectorOf<Scalar, 3> l = c * phi;
  const VectorOf<Scalar, 3> s = k * phi;
  const Scalar xx = s.x() * phi.x(), yy = s.y() * phi.y(), zz = s.z() * phi.z();
  const Scalar xy = s.x() * phi.y(), xz = s.x() * phi.z(), yz = s.y() * phi.z();
  MatrixOf<Scalar, 3> m;
  m << Scalar(1) - (yy + zz), xy - l.z(), xz + l.y(),  //
      xy + l.z(), Scalar(1) - (xx + zz), yz - l.x(),   //
      xz - l.y(), yz + l.x(), Scalar(1) - (xx + yy);
  return m;
}

}  // namespace detail

/// J_left(phi): exp(phi + d) = exp(J_left d) exp(phi).
template <typename Scalar>
[[nodiscard]] MatrixOf<Scalar, 3> left_jacobian(const VectorOf<Scalar, 3>& phi) {
  const Scalar a2 = phi.squaredNorm();
  return detail::hat_polynomial<Scalar>(detail::one_minus_cos_over_square(a2), detail::angle_minus_sin_over_cube(a2),
                                        phi);
}

/// J_right(phi) = J_left(-phi): exp(phi + d) = exp(phi) exp(J_right d).
template <typename Scalar>
[[nodiscard]] MatrixOf<Scalar, 3> right_jacobian(const VectorOf<Scalar, 3>& phi) {
  return left_jacobian<Scalar>(-phi);
}

/// Inverse of J_left; exists for angles below 2 pi.
template <typename Scalar>
[[nodiscard]] MatrixOf<Scalar, 3> left_jacobian_inverse(const VectorOf<Scalar, 3>& phi) {
  const Scalar a2 = phi.squaredNorm();
  const MatrixOf<Scalar, 3> h = hat(phi);
  const MatrixOf<Scalar, 3> h2 = h * h;
  Scalar k;  // (1 - (a/2) cot(a/2)) / a^2
  if (a2 < Scalar(10) * detail::small_angle_squared<Scalar>()) {
    k = Scalar(1) / 12 + a2 / Scalar(720) + a2 * a2 / Scalar(30240);
  } else {
    const Scalar half = std::sqrt(a2) / Scalar(2);
    k = (Scalar(1) - half * std::cos(half) / std::sin(half)) / a2;
  }
  return MatrixOf<Scalar, 3>::Identity() - h / Scalar(2) + k * h2;
}

/// Inverse of J_right; exists for angles below 2 pi.
template <typename Scalar>
[[nodiscard]] MatrixOf<Scalar, 3> right_jacobian_inverse(const VectorOf<Scalar, 3>& phi) {
  return left_jacobian_inverse<Scalar>(-phi);
}

/// Whether M is a rotation matrix: finite, M M^T = I within `tolerance` in every element, and no mirror image.
template <typename Scalar>
[[nodiscard]] bool is_rotation(const MatrixOf<Scalar, 3>& M, Scalar tolerance) {
  if (!M.allFinite()) return false;
  const MatrixOf<Scalar, 3> deviation = M * M.transpose() - MatrixOf<Scalar, 3>::Identity();
  return deviation.cwiseAbs().maxCoeff() <= tolerance && M.determinant() > Scalar(0);
}

/// Tolerance of is_rotation for matrices that went through arithmetic or a text file of 7 digits.
template <typename Scalar>
constexpr Scalar rotation_tolerance() {
  return sizeof(Scalar) == sizeof(float) ? Scalar(1e-5) : Scalar(1e-6);
}

/// Angle (rad, in [0, pi]) of the rotation that carries a into b. (001 section 5.3 prints 2 cos(q_w); it is 2
/// acos(|q_w|).)
template <typename Scalar>
[[nodiscard]] Scalar angle_between(const QuaternionOf<Scalar>& a, const QuaternionOf<Scalar>& b) {
  return log<Scalar>(a.conjugate() * b).norm();
}

/// The shortest rotation R with R a along b; of opposite directions, one of the half turns. The lengths do not matter;
/// precondition: neither is zero.
template <typename Scalar>
[[nodiscard]] QuaternionOf<Scalar> between(const VectorOf<Scalar, 3>& a, const VectorOf<Scalar, 3>& b) {
  const VectorOf<Scalar, 3> from = a.normalized(), onto = b.normalized();
  const Scalar cosine = from.dot(onto);
  // Half the angle: its cosine and sine are those of the sum's direction, unless that is none.
  if (cosine > Scalar(-0.999)) {
    const VectorOf<Scalar, 3> axis = from.cross(onto);
    return QuaternionOf<Scalar>(Scalar(1) + cosine, axis.x(), axis.y(), axis.z()).normalized();
  }
  // A half turn about what is square to both, made exactly square to the first, and the little that is left.
  VectorOf<Scalar, 3> square = from.cross(onto);
  if (square.norm() < Scalar(64) * std::numeric_limits<Scalar>::epsilon()) {
    int least;
    from.cwiseAbs().minCoeff(&least);
    square = from.cross(VectorOf<Scalar, 3>::Unit(least));
  }
  square = (square.normalized() - from * from.dot(square.normalized())).normalized();
  const QuaternionOf<Scalar> half_turn(Scalar(0), square.x(), square.y(), square.z());
  return (between<Scalar>(-from, onto) * half_turn).normalized();
}

/// exp(s log(b a^-1)) a: constant-rate interpolation by the shorter way; s outside [0, 1] extrapolates at the same
/// rate.
template <typename Scalar>
[[nodiscard]] QuaternionOf<Scalar> interpolate(const QuaternionOf<Scalar>& a, const QuaternionOf<Scalar>& b, Scalar s) {
  const VectorOf<Scalar, 3> step = s * log<Scalar>(a.conjugate() * b);
  return (a * exp<Scalar>(step)).normalized();
}

}  // namespace holdfast::so3
