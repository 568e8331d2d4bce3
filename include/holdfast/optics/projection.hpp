/// Off-centre perspective projection from signed tangents, in every depth range and Y direction in use.
///
/// Eye space is right-handed, +X right, +Y up, -Z forward, metres. With tangents l, r, d, u, near n and far f, and m[i]
/// the i-th entry in column-major order (OpenGL's):
///
///     m0 = 2/(r-l)   m8 = (r+l)/(r-l)   m5 = 2/(u-d)   m9 = (u+d)/(u-d)   m11 = -1
///     depth -1..1:          m10 = -(f+n)/(f-n)   m14 = -2fn/(f-n)     f infinite: -1, -2n
///     depth 0..1:           m10 = -f/(f-n)       m14 = -fn/(f-n)      f infinite: -1, -n
///     depth 1..0 reversed:  m10 = n/(f-n)        m14 = fn/(f-n)       f infinite:  0,  n
///     Y downward (Vulkan's clip space): m5 and m9 change sign.
///
/// Sources: Robinett & Holloway 1994 (course 11), 7.7 (the matrix T_N_E); Upchurch & Desbrun 2012 on the infinite far
/// plane. Bad input: problem_of tells it beforehand; projection_matrix itself takes it as a programmer's error.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/tangents.hpp>

namespace holdfast {

/// Distances (positive, m) of the clipping planes in front of the eye; far_m may be infinite.
struct ClipPlanes {
  double near_m = 0.05;
  double far_m = 1000.0;

  [[nodiscard]] static constexpr ClipPlanes with_infinite_far(double near_m) {
    return {near_m, std::numeric_limits<double>::infinity()};
  }
};

enum class DepthRange {
  minus_one_to_one,  ///< OpenGL's: near -1, far 1
  zero_to_one,       ///< Direct3D's, Vulkan's, Metal's: near 0, far 1
  one_to_zero,       ///< reversed: near 1, far 0; spreads the precision of a floating-point depth buffer evenly
};

enum class YDirection {
  up,    ///< clip-space +Y is the picture's top (OpenGL, Direct3D, Metal)
  down,  ///< clip-space +Y is the picture's bottom (Vulkan)
};

enum class ClipProblem { none, near_not_positive, far_not_beyond_near };

[[nodiscard]] constexpr std::string_view describe(ClipProblem problem) {
  switch (problem) {
    case ClipProblem::none:
      return "the clipping planes are usable";
    case ClipProblem::near_not_positive:
      return "the near distance must be positive and finite";
    case ClipProblem::far_not_beyond_near:
      return "the far distance must exceed the near distance (it may be infinite)";
  }
  return "unknown problem";
}

[[nodiscard]] inline ClipProblem problem_of(const ClipPlanes& clip) {
  if (!(clip.near_m > 0.0) || !std::isfinite(clip.near_m)) return ClipProblem::near_not_positive;
  if (!(clip.far_m > clip.near_m)) return ClipProblem::far_not_beyond_near;
  return ClipProblem::none;
}

/// Clip coordinates of a point in eye space: p_clip = projection_matrix(...) * (p_E, 1); w is the distance along -Z.
[[nodiscard]] inline Matrix4 projection_matrix(const FieldTangents& t, const ClipPlanes& clip,
                                               DepthRange depth = DepthRange::minus_one_to_one,
                                               YDirection y = YDirection::up) {
  HOLDFAST_ASSERT(problem_of(t) == FieldProblem::none, "impossible field of view");
  HOLDFAST_ASSERT(problem_of(clip) == ClipProblem::none, "impossible clipping planes");
  const double n = clip.near_m;
  const bool infinite = std::isinf(clip.far_m);
  const double ratio =
      infinite ? 0.0 : n / clip.far_m;  // dividing through by f keeps the finite form exact up to infinity
  const double width = t.right - t.left;
  const double height = (y == YDirection::up ? 1.0 : -1.0) * (t.up - t.down);

  Matrix4 m = Matrix4::Zero();
  m(0, 0) = 2.0 / width;
  m(0, 2) = (t.right + t.left) / width;
  m(1, 1) = 2.0 / height;
  m(1, 2) = (t.up + t.down) / height;
  m(3, 2) = -1.0;
  switch (depth) {
    case DepthRange::minus_one_to_one:
      m(2, 2) = -(1.0 + ratio) / (1.0 - ratio);
      m(2, 3) = -2.0 * n / (1.0 - ratio);
      break;
    case DepthRange::zero_to_one:
      m(2, 2) = -1.0 / (1.0 - ratio);
      m(2, 3) = -n / (1.0 - ratio);
      break;
    case DepthRange::one_to_zero:
      m(2, 2) = ratio / (1.0 - ratio);
      m(2, 3) = n / (1.0 - ratio);
      break;
  }
  return m;
}

/// Normalised device coordinates of a point; nothing for a point at or behind the eye's plane (w <= 0).
[[nodiscard]] inline std::optional<Vector3> project_to_ndc(const Matrix4& projection, const Vector3& p_E) {
  const Vector4 clip = projection * Vector4(p_E.x(), p_E.y(), p_E.z(), 1.0);
  if (!(clip.w() > 0.0)) return std::nullopt;
  return Vector3(clip.x() / clip.w(), clip.y() / clip.w(), clip.z() / clip.w());
}

/// The point p_E of normalised device coordinates; the inverse of project_to_ndc for any matrix of projection_matrix.
/// Nothing for a depth at infinity or behind the eye.
[[nodiscard]] inline std::optional<Vector3> unproject(const Matrix4& projection, const Vector3& ndc) {
  const double denominator = ndc.z() + projection(2, 2);
  const double z_E = -projection(2, 3) / denominator;
  if (!(z_E < 0.0) || !std::isfinite(z_E)) return std::nullopt;
  return Vector3(-z_E * (ndc.x() + projection(0, 2)) / projection(0, 0),
                 -z_E * (ndc.y() + projection(1, 2)) / projection(1, 1), z_E);
}

}  // namespace holdfast
