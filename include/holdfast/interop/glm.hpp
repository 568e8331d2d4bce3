/// Vectors, quaternions and transforms to and from GLM, for engines that speak it. Target holdfast::glm.
///
/// Everything is copied member by member, by name. GLM's quaternion constructor takes (w, x, y, z), its memory and
/// Eigen's hold (x, y, z, w), and GLM_FORCE_QUAT_DATA_WXYZ turns its memory round: by name none of that matters.
/// Matrices of both are column-major and multiply column vectors: p_A = M_AB * p_B either way, and m[column][row] of
/// GLM is m(row, column) here.
///   to_glm(x)        in x's own precision        to_glm<float>(x)   rounded, as shaders want it
///   from_glm(x)      the Holdfast type of the same precision
///   rigid_from_glm, vqs_from_glm: from a 4x4; nothing when the matrix is not such a transform
///   (VqsTransform::from_matrix)
/// Units and frames are those of the arguments. Bad input: numbers that are not finite pass through vectors and
/// matrices; quaternions are not normalised.
#pragma once

#include <cmath>
#include <optional>
#include <type_traits>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/geometry/vqs.hpp>

namespace holdfast {

// ---- to GLM
// -------------------------------------------------------------------------------------------------------------------

namespace detail {

/// Other, or Own when Other is void: the precision that to_glm<Other> gives.
template <typename Other, typename Own>
using PrecisionOf = std::conditional_t<std::is_void_v<Other>, Own, Other>;

}  // namespace detail

template <typename Other = void, typename Scalar, int Size>
[[nodiscard]] glm::vec<Size, detail::PrecisionOf<Other, Scalar>> to_glm(const VectorOf<Scalar, Size>& v) {
  static_assert(Size >= 2 && Size <= 4, "GLM has vectors of 2 to 4 numbers");
  glm::vec<Size, detail::PrecisionOf<Other, Scalar>> out;
  for (int i = 0; i < Size; ++i) out[i] = static_cast<detail::PrecisionOf<Other, Scalar>>(v[i]);
  return out;
}

/// out[column][row] = m(row, column).
template <typename Other = void, typename Scalar, int Rows, int Columns>
requires(Columns >= 2) [[nodiscard]] glm::mat<Columns, Rows, detail::PrecisionOf<Other, Scalar>> to_glm(
    const MatrixOf<Scalar, Rows, Columns>& m) {
  glm::mat<Columns, Rows, detail::PrecisionOf<Other, Scalar>> out;
  for (int c = 0; c < Columns; ++c) {
    for (int r = 0; r < Rows; ++r) out[c][r] = static_cast<detail::PrecisionOf<Other, Scalar>>(m(r, c));
  }
  return out;
}

template <typename Other = void, typename Scalar>
[[nodiscard]] glm::qua<detail::PrecisionOf<Other, Scalar>> to_glm(const QuaternionOf<Scalar>& q) {
  using To = detail::PrecisionOf<Other, Scalar>;
  glm::qua<To> out;
  out.w = static_cast<To>(q.w());
  out.x = static_cast<To>(q.x());
  out.y = static_cast<To>(q.y());
  out.z = static_cast<To>(q.z());
  return out;
}

/// The 4x4 matrix M_AB of X_AB.
template <typename Other = void, typename Scalar>
[[nodiscard]] glm::mat<4, 4, detail::PrecisionOf<Other, Scalar>> to_glm(const RigidTransform<Scalar>& X_AB) {
  const MatrixOf<Scalar, 4> m = X_AB.matrix();
  return to_glm<Other>(m);
}

/// The 4x4 matrix M_AB of T_AB.
template <typename Other = void, typename Scalar>
[[nodiscard]] glm::mat<4, 4, detail::PrecisionOf<Other, Scalar>> to_glm(const VqsTransform<Scalar>& T_AB) {
  const MatrixOf<Scalar, 4> m = T_AB.matrix();
  return to_glm<Other>(m);
}

// ---- from GLM
// -----------------------------------------------------------------------------------------------------------------

template <int Size, typename Scalar, glm::qualifier Q>
[[nodiscard]] VectorOf<Scalar, Size> from_glm(const glm::vec<Size, Scalar, Q>& v) {
  VectorOf<Scalar, Size> out;
  for (int i = 0; i < Size; ++i) out[i] = v[i];
  return out;
}

template <int Columns, int Rows, typename Scalar, glm::qualifier Q>
[[nodiscard]] MatrixOf<Scalar, Rows, Columns> from_glm(const glm::mat<Columns, Rows, Scalar, Q>& m) {
  MatrixOf<Scalar, Rows, Columns> out;
  for (int c = 0; c < Columns; ++c) {
    for (int r = 0; r < Rows; ++r) out(r, c) = m[c][r];
  }
  return out;
}

template <typename Scalar, glm::qualifier Q>
[[nodiscard]] QuaternionOf<Scalar> from_glm(const glm::qua<Scalar, Q>& q) {
  return QuaternionOf<Scalar>(q.w, q.x, q.y, q.z);
}

/// T_AB of a matrix M_AB; nothing when it shears, mirrors, projects, scales unequally, or is not finite.
template <typename Scalar, glm::qualifier Q>
[[nodiscard]] std::optional<VqsTransform<Scalar>> vqs_from_glm(const glm::mat<4, 4, Scalar, Q>& M_AB,
                                                               Scalar tolerance = Scalar(1e-5)) {
  return VqsTransform<Scalar>::from_matrix(from_glm(M_AB), tolerance);
}

/// X_AB of a matrix M_AB; nothing when it is no rotation and translation, a scale among them.
template <typename Scalar, glm::qualifier Q>
[[nodiscard]] std::optional<RigidTransform<Scalar>> rigid_from_glm(const glm::mat<4, 4, Scalar, Q>& M_AB,
                                                                   Scalar tolerance = Scalar(1e-5)) {
  const std::optional<VqsTransform<Scalar>> T_AB = vqs_from_glm(M_AB, tolerance);
  if (!T_AB || std::abs(T_AB->s() - Scalar(1)) > tolerance) return std::nullopt;
  return T_AB->rigid();
}

}  // namespace holdfast
