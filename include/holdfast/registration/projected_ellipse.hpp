/// The exact picture of a disc under perspective: an ellipse, with its centroid, axes and extent in pixels.
///
/// The disc's points are c + r (a cos s + b sin s) in the eye frame E; H = K [r a, r b, c] maps its unit circle to
/// homogeneous pixels (K: tangents to pixels), and the circle's dual conic diag(1, 1, -1) to the picture's, Q* = H
/// diag(1, 1, -1) H^T. From it
///     centre = Q*_02 / Q*_22, Q*_12 / Q*_22;     S = centre centre^T - Q*_(0..1,0..1) / Q*_22,
/// and the outline is (x - centre)^T S^-1 (x - centre) = 1 (Hartley & Zisserman 2004, 2.2.3 and 8.4). The ellipse's
/// centre is the centroid of an evenly bright picture of the disc. It is not the projection of the disc's centre, which
/// lies towards the part of the disc that is farther away. Pixels: origin lower left, pixel centres at half integers.
/// Bad input: a disc that reaches the eye's plane or lies behind it, or that is seen exactly from its edge, has no
/// ellipse: nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <holdfast/optics/eye.hpp>
#include <holdfast/registration/outline_centroid.hpp>
#include <holdfast/registration/scene_fiducials.hpp>

namespace holdfast {

struct ProjectedEllipse {
  Vector2 centroid = Vector2::Zero();  ///< px
  Matrix2 shape = Matrix2::Zero();     ///< S above, px^2
  double semi_major_px = 0.0;
  double semi_minor_px = 0.0;
  Vector2 half_extent_px = Vector2::Zero();  ///< of the box round it
  double depth_m = 0.0;                      ///< of the disc's centre, -z_E
  bool front = false;                        ///< the disc's front is seen, not its back

  /// The whole outline, and `margin_px` more, lies inside the picture.
  [[nodiscard]] bool is_inside(const PixelSize& picture, double margin_px = 0.0) const {
    const Vector2 low = centroid - half_extent_px, high = centroid + half_extent_px;
    return low.x() >= margin_px && low.y() >= margin_px && high.x() <= picture.width - margin_px &&
           high.y() <= picture.height - margin_px;
  }
};

namespace detail {

/// Two unit vectors across `normal` and across each other.
[[nodiscard]] inline std::array<Vector3, 2> basis_across(const Vector3& normal) {
  const Vector3 other = std::abs(normal.y()) < 0.8 ? Vector3(Vector3::UnitY()) : Vector3(Vector3::UnitX());
  const Vector3 a = other.cross(normal).normalized();
  return {a, normal.cross(a).normalized()};
}

}  // namespace detail

/// Ellipse of `disc` in the ideal picture (no lens) of the eye at X_WE. With H_ES: in the picture after it was warped, where
/// (t_E, 1) ~ H_ES (t_S, 1) takes tangents of the picture as drawn to those of what is shown; depth and front stay
/// those of the drawing.
[[nodiscard]] inline std::optional<ProjectedEllipse> project_disc(const EyeModel& eye, const Rigid& X_WE,
                                                                  const Disc& disc,
                                                                  const Matrix3& H_ES = Matrix3::Identity()) {
  const Rigid X_EW = X_WE.inverse();
  const Vector3 c = X_EW * disc.centre_W;
  const std::array<Vector3, 2> across_W = detail::basis_across(disc.normal_W);
  const Vector3 a = disc.radius_m * (X_EW.q() * across_W[0]);
  const Vector3 b = disc.radius_m * (X_EW.q() * across_W[1]);
  if (!c.allFinite() || !(-c.z() > std::hypot(a.z(), b.z()))) return std::nullopt;

  const Vector2 s = pixels_per_tangent(eye);
  const Vector2 axis_px = pixel_of_tangent(eye, Vector2::Zero());
  const auto to_picture = [&](const Vector3& p) {  // K H_ES p with tangents (x / -z, y / -z)
    const Vector3 t = H_ES * Vector3(p.x(), p.y(), -p.z());
    return Vector3(s.x() * t.x() + axis_px.x() * t.z(), s.y() * t.y() + axis_px.y() * t.z(), t.z());
  };
  const Vector3 h0 = to_picture(a), h1 = to_picture(b), h2 = to_picture(c);
  if (!(h2.z() > std::hypot(h0.z(), h1.z()))) return std::nullopt;
  const Matrix3 Q = h0 * h0.transpose() + h1 * h1.transpose() - h2 * h2.transpose();

  ProjectedEllipse e;
  e.centroid = Vector2(Q(0, 2), Q(1, 2)) / Q(2, 2);
  // S as a sum about the centroid: subtracting centre centre^T from Q*'s block would cancel seven digits.
  const auto about = [&](const Vector3& h) { return Vector2(h.head<2>() - h.z() * e.centroid); };
  const Vector2 d0 = about(h0), d1 = about(h1), d2 = about(h2);
  e.shape = (d2 * d2.transpose() - d0 * d0.transpose() - d1 * d1.transpose()) / Q(2, 2);
  const double half_trace = 0.5 * e.shape.trace();
  const double spread = std::hypot(0.5 * (e.shape(0, 0) - e.shape(1, 1)), e.shape(0, 1));
  if (!(half_trace - spread > 0.0)) return std::nullopt;
  e.semi_major_px = std::sqrt(half_trace + spread);
  e.semi_minor_px = std::sqrt(half_trace - spread);
  e.half_extent_px = Vector2(std::sqrt(e.shape(0, 0)), std::sqrt(e.shape(1, 1)));
  e.depth_m = -c.z();
  e.front = (X_EW.q() * disc.normal_W).dot(c) < 0.0;
  return e;
}

/// Where the eye `eye` sees the ideal pixel of a renderer that believes the eye to be `believed`: drawn for one lens
/// and panel, seen through the other. With believed = eye this is seen_pixel.
[[nodiscard]] inline std::optional<Vector2> seen_pixel(const EyeModel& eye, const EyeModel& believed, LensMode mode,
                                                       const Vector2& ideal) {
  const std::optional<Vector2> panel = drawn_pixel(believed, mode, ideal);
  if (!panel || mode == LensMode::none) return panel;
  const std::optional<Vector2> tangent = eye.lens.distort(tangent_of_pixel(eye, *panel));
  return tangent ? std::optional<Vector2>(pixel_of_tangent(eye, *tangent)) : std::nullopt;
}

/// Centroid of the image of an ellipse under a map of pixels: `map(pixel)` is an optional Vector2. Nothing when part of
/// the outline has no image.
template <typename Map>
[[nodiscard]] std::optional<Vector2> centroid_through(const ProjectedEllipse& e, const Map& map) {
  // Any L with L L^T = S maps the unit circle to the outline: the Cholesky factor.
  const double l00 = std::sqrt(e.shape(0, 0));
  const double l10 = e.shape(1, 0) / l00;
  const double l11 = std::sqrt(std::max(0.0, e.shape(1, 1) - l10 * l10));
  return outline_centroid([&](double cosine, double sine) -> std::optional<Vector2> {
    return map(Vector2(e.centroid + Vector2(l00 * cosine, l10 * cosine + l11 * sine)));
  });
}

/// Where `eye` sees the centroid of an ellipse of the ideal picture of `believed` when lens or correction bend it.
/// Nothing when part of it lies outside the lens.
[[nodiscard]] inline std::optional<Vector2> seen_centroid(const EyeModel& eye, const EyeModel& believed, LensMode mode,
                                                          const ProjectedEllipse& e) {
  if (mode == LensMode::none) return e.centroid;
  return centroid_through(e, [&](const Vector2& ideal) { return seen_pixel(eye, believed, mode, ideal); });
}

/// The same for a renderer that knows the eye. An exact correction leaves the ellipse where it is.
[[nodiscard]] inline std::optional<Vector2> seen_centroid(const EyeModel& eye, LensMode mode,
                                                          const ProjectedEllipse& e) {
  if (mode != LensMode::exact) return seen_centroid(eye, eye, mode, e);
  return seen_pixel(eye, mode, e.centroid) ? std::optional<Vector2>(e.centroid) : std::nullopt;
}

}  // namespace holdfast
