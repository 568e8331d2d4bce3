/// The field of view of one eye as signed tangents, and the ways to come by them.
///
/// Tangents are those of the angles between the eye's forward axis (-Z) and the four edges of its picture: right and up
/// positive, left and down negative, so usually left < 0 < right and down < 0 < up. They need not be symmetric, nor
/// enclose zero. A pair in swapped order (left > right, or down > up) means a mirrored picture, as in OpenXR's XrFovf.
/// Sources: Robinett & Holloway 1994 (course 11), 7.6-7.7, figures 7.2-7.4; OpenXR 1.1, XrFovf.
/// Units: metres for the virtual image, Angle for angles, tangents have none.
/// Bad input: an impossible field is answered with a FieldProblem that names what is wrong.
#pragma once

#include <cmath>
#include <numbers>
#include <string_view>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/angle.hpp>

namespace holdfast {

enum class EyeSide { left, right };

[[nodiscard]] constexpr std::string_view name_of(EyeSide side) {
  return side == EyeSide::left ? "left" : "right";
}

struct FieldTangents {
  double left = -1.0;
  double right = 1.0;
  double down = -1.0;
  double up = 1.0;

  friend bool operator==(const FieldTangents&, const FieldTangents&) = default;
};

/// What makes a field of view impossible.
enum class FieldProblem {
  none,
  not_finite,           ///< a number is NaN or infinite
  zero_width,           ///< left equals right
  zero_height,          ///< down equals up
  angle_beyond_90,      ///< an edge 90 degrees or more from the axis has no tangent: no flat picture reaches it
  image_not_in_front,   ///< the virtual image's z_p is not negative
  extent_not_positive,  ///< the virtual image's width or height is not positive
};

[[nodiscard]] constexpr std::string_view describe(FieldProblem problem) {
  switch (problem) {
    case FieldProblem::none:
      return "the field of view is usable";
    case FieldProblem::not_finite:
      return "a tangent, angle or length is not a finite number";
    case FieldProblem::zero_width:
      return "the field has no width: its left and right edges coincide";
    case FieldProblem::zero_height:
      return "the field has no height: its down and up edges coincide";
    case FieldProblem::angle_beyond_90:
      return "an edge lies 90 degrees or more from the forward axis";
    case FieldProblem::image_not_in_front:
      return "the virtual image is not in front of the eye: z_p must be negative";
    case FieldProblem::extent_not_positive:
      return "the virtual image's width and height must be positive";
  }
  return "unknown problem";
}

[[nodiscard]] inline FieldProblem problem_of(const FieldTangents& t) {
  if (!std::isfinite(t.left) || !std::isfinite(t.right) || !std::isfinite(t.down) || !std::isfinite(t.up)) {
    return FieldProblem::not_finite;
  }
  if (!(std::abs(t.right - t.left) > 0.0)) return FieldProblem::zero_width;
  if (!(std::abs(t.up - t.down) > 0.0)) return FieldProblem::zero_height;
  return FieldProblem::none;
}

/// A field of view, or what is wrong with it.
struct FieldResult {
  FieldTangents tangents;
  FieldProblem problem = FieldProblem::none;

  [[nodiscard]] bool ok() const { return problem == FieldProblem::none; }
  /// Precondition: ok().
  [[nodiscard]] const FieldTangents& value() const {
    HOLDFAST_ASSERT(ok(), "the field of view is impossible");
    return tangents;
  }
};

/// The virtual image of the screen as one eye sees it (figure 7.2): a rectangle w_x by w_y at z = z_p < 0, its centre
/// at (x_cw, y_cw) from the point where the forward axis meets it. Metres.
struct VirtualImage {
  double w_x = 0.0;
  double w_y = 0.0;
  double z_p = -1.0;
  double x_cw = 0.0;
  double y_cw = 0.0;
};

/// Figure 7.3: the window's centre from the eye, x_cw = x_H_CW + IPD/2 (left eye) or x_H_CW - IPD/2 (right eye), for a
/// display whose optics do not move with the eyes. x_H_CW is the centre's x in the head frame (usually negative for the
/// left eye). Metres.
[[nodiscard]] constexpr double x_cw_of_ipd(double x_H_CW, double ipd_m, EyeSide side) {
  return side == EyeSide::left ? x_H_CW + ipd_m / 2.0 : x_H_CW - ipd_m / 2.0;
}

/// Tangents of the virtual image's edges: (x_cw -+ w_x/2) / |z_p|, (y_cw -+ w_y/2) / |z_p|.
[[nodiscard]] inline FieldResult tangents_of(const VirtualImage& image) {
  FieldResult result;
  if (!std::isfinite(image.z_p)) return {result.tangents, FieldProblem::not_finite};
  if (!(image.z_p < 0.0)) return {result.tangents, FieldProblem::image_not_in_front};
  const double z = -image.z_p;
  result.tangents = {(image.x_cw - image.w_x / 2.0) / z, (image.x_cw + image.w_x / 2.0) / z,
                     (image.y_cw - image.w_y / 2.0) / z, (image.y_cw + image.w_y / 2.0) / z};
  result.problem = problem_of(result.tangents);
  if (result.problem == FieldProblem::not_finite) return result;
  if (!(image.w_x > 0.0) || !(image.w_y > 0.0)) result.problem = FieldProblem::extent_not_positive;
  return result;
}

/// The image at z_p that has these tangents; the inverse of tangents_of. Precondition: z_p < 0.
[[nodiscard]] inline VirtualImage image_of(const FieldTangents& t, double z_p) {
  HOLDFAST_ASSERT(z_p < 0.0, "the virtual image lies in front of the eye");
  const double z = -z_p;
  return {z * (t.right - t.left), z * (t.up - t.down), z_p, z * (t.right + t.left) / 2.0, z * (t.up + t.down) / 2.0};
}

/// Signed angles of the four edges, as in XrFovf: right and up positive.
struct FieldAngles {
  Angle left;
  Angle right;
  Angle down;
  Angle up;
};

[[nodiscard]] inline FieldResult tangents_of(const FieldAngles& a) {
  FieldResult result;
  for (const Angle edge : {a.left, a.right, a.down, a.up}) {
    if (!std::isfinite(edge.radians())) return {result.tangents, FieldProblem::not_finite};
    if (std::abs(edge.radians()) >= std::numbers::pi / 2.0) return {result.tangents, FieldProblem::angle_beyond_90};
  }
  result.tangents = {tan(a.left), tan(a.right), tan(a.down), tan(a.up)};
  result.problem = problem_of(result.tangents);
  return result;
}

/// A field centred on the forward axis, from its full angles.
[[nodiscard]] inline FieldResult symmetric_tangents(Angle horizontal, Angle vertical) {
  return tangents_of(FieldAngles{-horizontal / 2.0, horizontal / 2.0, -vertical / 2.0, vertical / 2.0});
}

[[nodiscard]] inline FieldAngles angles_of(const FieldTangents& t) {
  return {radians(std::atan(t.left)), radians(std::atan(t.right)), radians(std::atan(t.down)),
          radians(std::atan(t.up))};
}

/// The parts of the field of figure 7.4, each positive when its edge lies on its own side of the axis.
[[nodiscard]] inline Angle fov_left(const FieldTangents& t) {
  return radians(-std::atan(t.left));
}
[[nodiscard]] inline Angle fov_right(const FieldTangents& t) {
  return radians(std::atan(t.right));
}
[[nodiscard]] inline Angle fov_bottom(const FieldTangents& t) {
  return radians(-std::atan(t.down));
}
[[nodiscard]] inline Angle fov_top(const FieldTangents& t) {
  return radians(std::atan(t.up));
}
[[nodiscard]] inline Angle fov_horizontal(const FieldTangents& t) {
  return fov_left(t) + fov_right(t);
}
[[nodiscard]] inline Angle fov_vertical(const FieldTangents& t) {
  return fov_bottom(t) + fov_top(t);
}

[[nodiscard]] constexpr bool is_mirrored_x(const FieldTangents& t) {
  return t.left > t.right;
}
[[nodiscard]] constexpr bool is_mirrored_y(const FieldTangents& t) {
  return t.down > t.up;
}

/// The field as the other eye of a symmetric headset has it: left and right change places and sign.
[[nodiscard]] constexpr FieldTangents mirrored(const FieldTangents& t) {
  return {-t.right, -t.left, t.down, t.up};
}

}  // namespace holdfast
