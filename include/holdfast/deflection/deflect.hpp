/// Image deflection: how a finished picture must be moved for where the eye is by now.
///
/// A picture was drawn for the eye frame S; when its light leaves the display the eye is at E. From the view that the
/// picture was drawn with and the late poses of the eye during the scan (LatePoses), deflect() finds for every line the
/// map (t_S, 1) ~ H_SE(s) (t_E, 1) of tangents. Kinds, each leaving less behind than the one before:
///   none        the picture as it is
///   shift       it slides, so that the centre of the view is right (So & Griffin 1992); errs towards the edges
///   shift_roll  it also turns in its plane, by the turn that is nearest to the true map at the centre
///   rotation    the homography of a turned eye: right at any distance, as long as the eye only turned
///   plane       the homography through the plane z_S = -plane_distance_m: right for what lies there, also when it moved
///   depth       each point by its own distance (DepthSearch, DepthMesh); here H_SE is the map of what is infinitely far
/// Sources: So & Griffin, Journal of Aircraft 29(6), 1992; Mazuryk & Gervautz, Eurographics 1995; Hartley & Zisserman
/// 13.1. Nothing is allocated. Bad input: a DeflectionProblem names it, and the maps are then the identity, so that the
/// picture is shown as it was drawn.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/deflection/scan_homography.hpp>
#include <holdfast/deflection/scan_pose.hpp>
#include <holdfast/geometry/homography.hpp>

namespace holdfast {

enum class DeflectionKind { none, shift, shift_roll, rotation, plane, depth };

inline constexpr std::array deflection_kinds{DeflectionKind::none,       DeflectionKind::shift,
                                             DeflectionKind::shift_roll, DeflectionKind::rotation,
                                             DeflectionKind::plane,      DeflectionKind::depth};

[[nodiscard]] constexpr std::string_view name_of(DeflectionKind kind) {
  constexpr std::string_view names[] = {"none", "shift", "shift_roll", "rotation", "plane", "depth"};
  return names[static_cast<std::size_t>(kind)];
}

struct DeflectionSettings {
  DeflectionKind kind = DeflectionKind::rotation;
  double plane_distance_m = 2.0;  ///< plane: in front of S, parallel to its picture
  bool per_scanline = true;       ///< false: all lines as at the scan's middle
};

enum class DeflectionProblem {
  none,
  view_not_finite,     ///< the pose X_WS that the picture was drawn with
  late_not_finite,     ///< a late pose
  no_field,            ///< the view's tangents are not finite, or leave it no width or height
  no_pixels,           ///< the view's size is not positive
  turned_beyond_90,    ///< the eye turned away by 90 degrees or more: S shows nothing ahead of E
  turned_during_scan,  ///< the late poses differ by 90 degrees or more: no display scans that slowly
  no_plane_distance,   ///< plane_distance_m is not a positive number
  eye_in_plane,        ///< E lies in the plane (within a millionth of its distance): it sees its edge
  eye_beyond_plane,    ///< E has passed through the plane: it and S see it from opposite sides
};

[[nodiscard]] constexpr std::string_view describe(DeflectionProblem problem) {
  switch (problem) {
    case DeflectionProblem::none:
      return "the picture can be deflected";
    case DeflectionProblem::view_not_finite:
      return "the pose that the picture was drawn with holds a number that is not finite";
    case DeflectionProblem::late_not_finite:
      return "a late pose holds a number that is not finite";
    case DeflectionProblem::no_field:
      return "the picture's tangents are not finite, or leave it no width or no height";
    case DeflectionProblem::no_pixels:
      return "the picture's width and height must be positive";
    case DeflectionProblem::turned_beyond_90:
      return "the eye has turned by 90 degrees or more since the picture was drawn";
    case DeflectionProblem::turned_during_scan:
      return "the late poses of scan begin and end differ by 90 degrees or more";
    case DeflectionProblem::no_plane_distance:
      return "the plane's distance must be a positive number of metres";
    case DeflectionProblem::eye_in_plane:
      return "the eye lies in the plane";
    case DeflectionProblem::eye_beyond_plane:
      return "the eye has passed through the plane";
  }
  return "unknown problem";
}

struct DeflectionResult {
  ScanHomography H_SE;  ///< (t_S, 1) ~ H_SE(s) (t_E, 1)
  ScanPose X_SE;        ///< p_S = X_SE(s) * p_E: what the depth kinds work with
  DeflectionProblem problem = DeflectionProblem::none;

  [[nodiscard]] bool ok() const { return problem == DeflectionProblem::none; }
};

namespace deflection_detail {

[[nodiscard]] inline DeflectionProblem problem_of(const RenderedView& view, const LatePoses& late) {
  if (!view.X_WS.is_finite()) return DeflectionProblem::view_not_finite;
  if (!late.is_finite()) return DeflectionProblem::late_not_finite;
  if (holdfast::problem_of(view.tangents) != FieldProblem::none) return DeflectionProblem::no_field;
  if (view.size.width <= 0 || view.size.height <= 0) return DeflectionProblem::no_pixels;
  return DeflectionProblem::none;
}

/// Whether S's picture plane can show the forward axis of an eye that is turned by q_SE.
[[nodiscard]] inline bool looks_ahead(const Rigid& X_SE) {
  return (X_SE.q() * Vector3(0.0, 0.0, -1.0)).z() < -1e-9;
}

[[nodiscard]] inline DeflectionProblem problem_of(const ScanPose& X_SE) {
  // |q.w| is the cosine of half the angle.
  const auto is_near = [&](const Rigid& X) {
    return std::abs(relative_pose(X_SE.begin(), X).q().w()) > std::sqrt(0.5);
  };
  if (!is_near(X_SE.middle()) || !is_near(X_SE.end())) return DeflectionProblem::turned_during_scan;
  const bool ahead = looks_ahead(X_SE.begin()) && looks_ahead(X_SE.middle()) && looks_ahead(X_SE.end());
  return ahead ? DeflectionProblem::none : DeflectionProblem::turned_beyond_90;
}

[[nodiscard]] inline DeflectionProblem problem_of_plane(const ScanPose& X_SE, double distance_m) {
  if (!(distance_m > 0.0) || !std::isfinite(distance_m)) return DeflectionProblem::no_plane_distance;
  const double nearest = distance_m + X_SE.least_z();
  if (std::abs(nearest) <= 1e-6 * distance_m) return DeflectionProblem::eye_in_plane;
  return nearest < 0.0 ? DeflectionProblem::eye_beyond_plane : DeflectionProblem::none;
}

/// The turn in the picture's plane nearest to the map H at t: the rotation part of its Jacobian.
[[nodiscard]] inline double roll_at(const Matrix3& H, const Vector2& t) {
  const Vector3 h = H * Vector3(t.x(), t.y(), 1.0);
  const Matrix2 J = (H.topLeftCorner<2, 2>() - h.head<2>() / h.z() * H.bottomLeftCorner<1, 2>()) / h.z();
  return std::atan2(J(1, 0) - J(0, 1), J(0, 0) + J(1, 1));
}

/// The slide (and turn) of the picture that agrees with the rotation's homography at `centre`.
[[nodiscard]] inline std::optional<Homography> shift(const Rigid& X_SE, const Vector2& centre, bool with_roll) {
  const Homography turned = Homography::rotation(X_SE.q());
  const std::optional<Vector2> centre_S = turned.apply(centre);
  if (!centre_S) return std::nullopt;
  const double roll = with_roll ? roll_at(turned.matrix(), centre) : 0.0;
  const double c = std::cos(roll), s = std::sin(roll);
  Matrix3 H;
  H << c, -s, centre_S->x() - (c * centre.x() - s * centre.y()),  //
      s, c, centre_S->y() - (s * centre.x() + c * centre.y()),    //
      0.0, 0.0, 1.0;
  return Homography::make(H);
}

[[nodiscard]] inline std::optional<Homography> through_picture_plane(const Rigid& X_SE, double distance_m) {
  const Plane plane_S{Vector3(0.0, 0.0, 1.0), -distance_m};
  return Homography::through_plane(X_SE, X_SE.inverse() * plane_S);
}

/// The map of one pose; nothing when the kind cannot follow it.
[[nodiscard]] inline std::optional<Homography> homography(const DeflectionSettings& settings, const Vector2& centre,
                                                          const Rigid& X_SE) {
  switch (settings.kind) {
    case DeflectionKind::none:
      break;
    case DeflectionKind::shift:
      return shift(X_SE, centre, false);
    case DeflectionKind::shift_roll:
      return shift(X_SE, centre, true);
    case DeflectionKind::rotation:
    case DeflectionKind::depth:
      return Homography::rotation(X_SE.q());
    case DeflectionKind::plane:
      return through_picture_plane(X_SE, settings.plane_distance_m);
  }
  return Homography();
}

}  // namespace deflection_detail

/// How the picture of `view` must be moved for an eye at the late poses.
[[nodiscard]] inline DeflectionResult deflect(const DeflectionSettings& settings, const RenderedView& view,
                                              const LatePoses& late) {
  namespace detail = deflection_detail;
  DeflectionResult result;
  const auto refuse = [&](DeflectionProblem problem) { return DeflectionResult{{}, {}, problem}; };
  result.problem = detail::problem_of(view, late);
  if (!result.ok()) return refuse(result.problem);
  if (settings.kind == DeflectionKind::none) return result;

  result.X_SE = ScanPose(view.X_WS, late);
  result.problem = detail::problem_of(result.X_SE);
  if (result.ok() && settings.kind == DeflectionKind::plane) {
    result.problem = detail::problem_of_plane(result.X_SE, settings.plane_distance_m);
  }
  if (!result.ok()) return refuse(result.problem);
  if (!settings.per_scanline) result.X_SE = result.X_SE.without_scan();

  const FieldTangents& t = view.tangents;
  const Vector2 centre((t.left + t.right) / 2.0, (t.down + t.up) / 2.0);
  const auto begin = detail::homography(settings, centre, result.X_SE.begin());
  if (result.X_SE.is_constant()) {
    if (!begin) return refuse(DeflectionProblem::turned_beyond_90);
    const bool still = begin->matrix() == Matrix3::Identity();
    result.H_SE = still ? ScanHomography() : ScanHomography(*begin);
    return result;
  }
  const auto middle = detail::homography(settings, centre, result.X_SE.middle());
  const auto end = detail::homography(settings, centre, result.X_SE.end());
  if (!begin || !middle || !end) return refuse(DeflectionProblem::turned_beyond_90);
  result.H_SE = ScanHomography(*begin, *middle, *end);
  return result;
}

/// The same from the picture itself: what an application should call, as the pose cannot be another picture's.
template <typename Picture>
[[nodiscard]] DeflectionResult deflect(const DeflectionSettings& settings, const RenderedPicture<Picture>& picture,
                                       const LatePoses& late) {
  return deflect(settings, picture.view(), late);
}

}  // namespace holdfast
