/// One eye of a headset: where it is, what field its panel fills, and which lens lies between.
///
/// Eye frame E: origin at the eye's centre of projection, -Z along the optical axis, +X right, +Y up, metres. X_HE is
/// its pose in the head frame H, midway between the eyes. `tangents` is the field that the panel fills paraxially, that
/// is without the lens's distortion (000 7.9: with predistortion the paraxial window is the right one). Pixels: origin
/// at the lower left, centres at half integers. project and ray_E speak of *ideal* pixels: where a point belongs in an
/// undistorted picture. seen_pixel tells where the eye sees it when the lens is there, drawn_pixel where the panel must
/// light. A panel mounted upside down has its pixel origin at the eye's upper right (000 7.6: a half turn about Z).
/// Sources: Robinett & Holloway 1994 (course 11), 7.6-7.8. Bad input: problem_of names it; a point at or behind the eye
/// is nothing.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/rigid.hpp>
#include <holdfast/geometry/tangents_of_point.hpp>
#include <holdfast/optics/lens.hpp>
#include <holdfast/optics/lens_mode.hpp>
#include <holdfast/optics/lens_relief.hpp>
#include <holdfast/optics/projection.hpp>
#include <holdfast/optics/tangents.hpp>

namespace holdfast {

struct PixelSize {
  int width = 0;
  int height = 0;

  friend bool operator==(const PixelSize&, const PixelSize&) = default;
};

enum class Color { red, green, blue };

struct EyeModel {
  EyeSide side = EyeSide::left;
  Rigid X_HE;                     ///< p_H = X_HE * p_E
  FieldTangents tangents;         ///< of the panel's edges, paraxial
  PixelSize resolution;           ///< of this eye's part of the panel
  Lens lens;                      ///< for green, which stands for the geometry
  std::optional<Lens> lens_red;   ///< when red is bent differently
  std::optional<Lens> lens_blue;  ///< when blue is
  bool upside_down = false;       ///< the panel is mounted turned by 180 degrees
  double image_distance_m =
      std::numeric_limits<double>::infinity();   ///< of the virtual image, |z_p|; infinite: collimated
  double eye_relief_m = 0.0;                     ///< eye to lens; 0: not known
  std::vector<LensesAtRelief> lenses_at_relief;  ///< rising; what with_eye_relief chooses the lenses from

  [[nodiscard]] const Lens& lens_of(Color color) const {
    if (color == Color::red && lens_red) return *lens_red;
    if (color == Color::blue && lens_blue) return *lens_blue;
    return lens;
  }
};

/// Tangents of the panel's own left, right, bottom and top edge: `tangents`, with the half turn of an upside-down
/// panel.
[[nodiscard]] inline FieldTangents panel_tangents(const EyeModel& eye) {
  const FieldTangents& t = eye.tangents;
  return eye.upside_down ? FieldTangents{t.right, t.left, t.up, t.down} : t;
}

/// The projection that draws the ideal picture the right way round on this eye's panel.
[[nodiscard]] inline Matrix4 projection_matrix(const EyeModel& eye, const ClipPlanes& clip,
                                               DepthRange depth = DepthRange::minus_one_to_one,
                                               YDirection y = YDirection::up) {
  return projection_matrix(panel_tangents(eye), clip, depth, y);
}

/// Pixels per unit of tangent, to the right and up; negative on an upside-down panel.
[[nodiscard]] inline Vector2 pixels_per_tangent(const EyeModel& eye) {
  const FieldTangents t = panel_tangents(eye);
  return {eye.resolution.width / (t.right - t.left), eye.resolution.height / (t.up - t.down)};
}

[[nodiscard]] inline Vector2 pixel_of_tangent(const EyeModel& eye, const Vector2& tangent) {
  const FieldTangents t = panel_tangents(eye);
  const Vector2 s = pixels_per_tangent(eye);
  return {(tangent.x() - t.left) * s.x(), (tangent.y() - t.down) * s.y()};
}

[[nodiscard]] inline Vector2 tangent_of_pixel(const EyeModel& eye, const Vector2& pixel) {
  const FieldTangents t = panel_tangents(eye);
  const Vector2 s = pixels_per_tangent(eye);
  return {t.left + pixel.x() / s.x(), t.down + pixel.y() / s.y()};
}

/// Ideal pixel of a point; nothing at or behind the eye's plane. The pixel may lie outside the picture: see is_inside.
[[nodiscard]] inline std::optional<Vector2> project(const EyeModel& eye, const Vector3& p_E) {
  const std::optional<Vector2> tangent = tangents_of_point(p_E);
  if (!tangent) return std::nullopt;
  return pixel_of_tangent(eye, *tangent);
}

/// d project / d p_E, 2x3. Precondition: the point is in front of the eye.
[[nodiscard]] inline MatrixOf<double, 2, 3> project_jacobian(const EyeModel& eye, const Vector3& p_E) {
  HOLDFAST_ASSERT(p_E.z() < 0.0, "the point is behind the eye");
  const Vector2 s = pixels_per_tangent(eye);
  const double z = p_E.z();
  MatrixOf<double, 2, 3> J;
  J << -s.x() / z, 0.0, s.x() * p_E.x() / (z * z), 0.0, -s.y() / z, s.y() * p_E.y() / (z * z);
  return J;
}

[[nodiscard]] inline bool is_inside(const EyeModel& eye, const Vector2& pixel) {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= eye.resolution.width &&
         pixel.y() <= eye.resolution.height;
}

/// Direction (unit length, in E) in which an ideal pixel is seen.
[[nodiscard]] inline Vector3 ray_E(const EyeModel& eye, const Vector2& pixel) {
  return direction_of_tangents(tangent_of_pixel(eye, pixel)).normalized();
}

/// Angle between the directions of two ideal pixels; accurate for the smallest.
[[nodiscard]] inline Angle angle_between_pixels(const EyeModel& eye, const Vector2& a, const Vector2& b) {
  const Vector3 u = ray_E(eye, a);
  const Vector3 v = ray_E(eye, b);
  return radians(2.0 * std::atan2((u - v).norm(), (u + v).norm()));
}

/// Arc minutes per pixel at a pixel: the root of the solid angle of that pixel.
[[nodiscard]] inline double arcmin_per_pixel(const EyeModel& eye, const Vector2& pixel) {
  const Vector2 t = tangent_of_pixel(eye, pixel);
  const Vector2 s = pixels_per_tangent(eye);
  const double solid_angle = std::pow(1.0 + t.squaredNorm(), -1.5) / std::abs(s.x() * s.y());
  return radians(std::sqrt(solid_angle)).arcmin();
}
/// The same at the picture's centre.
[[nodiscard]] inline double arcmin_per_pixel(const EyeModel& eye) {
  return arcmin_per_pixel(eye, Vector2(eye.resolution.width / 2.0, eye.resolution.height / 2.0));
}
[[nodiscard]] inline double pixels_per_radian(const EyeModel& eye) {
  return 1.0 / arcmin(arcmin_per_pixel(eye)).radians();
}

/// Panel pixel that the application lights for an ideal pixel.
[[nodiscard]] inline std::optional<Vector2> drawn_pixel(const EyeModel& eye, LensMode mode, const Vector2& ideal,
                                                        Color color = Color::green) {
  const auto tangent = drawn_tangent(eye.lens_of(color), mode, tangent_of_pixel(eye, ideal));
  return tangent ? std::optional<Vector2>(pixel_of_tangent(eye, *tangent)) : std::nullopt;
}

/// Where, among the ideal pixels, the eye sees the ideal pixel `ideal`: exact correction leaves it in place, no
/// correction moves it by the lens's distortion. Nothing outside the lens's domain.
[[nodiscard]] inline std::optional<Vector2> seen_pixel(const EyeModel& eye, LensMode mode, const Vector2& ideal,
                                                       Color color = Color::green) {
  const auto tangent = seen_tangent(eye.lens_of(color), mode, tangent_of_pixel(eye, ideal));
  return tangent ? std::optional<Vector2>(pixel_of_tangent(eye, *tangent)) : std::nullopt;
}

/// The ideal pixel that the eye sees at `seen`: the inverse of seen_pixel, which draws a picture of what the eye sees.
[[nodiscard]] inline std::optional<Vector2> ideal_pixel(const EyeModel& eye, LensMode mode, const Vector2& seen,
                                                        Color color = Color::green) {
  const auto tangent = ideal_tangent(eye.lens_of(color), mode, tangent_of_pixel(eye, seen));
  return tangent ? std::optional<Vector2>(pixel_of_tangent(eye, *tangent)) : std::nullopt;
}

/// The field that the whole panel fills as the eye sees it through the lens: the tangents at which the middles of the
/// panel's edges (level with the lens's centre) are seen. Nothing when the lens folds over before an edge.
[[nodiscard]] inline std::optional<FieldTangents> seen_field(const EyeModel& eye, Color color = Color::green) {
  const Lens& lens = eye.lens_of(color);
  const Vector2& c = lens.centre();
  const FieldTangents& t = eye.tangents;
  const auto left = lens.distort(Vector2(t.left, c.y()));
  const auto right = lens.distort(Vector2(t.right, c.y()));
  const auto down = lens.distort(Vector2(c.x(), t.down));
  const auto up = lens.distort(Vector2(c.x(), t.up));
  if (!left || !right || !down || !up) return std::nullopt;
  return FieldTangents{left->x(), right->x(), down->y(), up->y()};
}

/// The ideal pixel that a panel pixel shows: the inverse of drawn_pixel, the look-up of a predistortion warp.
[[nodiscard]] inline std::optional<Vector2> ideal_pixel_at_panel(const EyeModel& eye, LensMode mode,
                                                                 const Vector2& panel, Color color = Color::green) {
  const auto tangent = ideal_tangent_at_panel(eye.lens_of(color), mode, tangent_of_pixel(eye, panel));
  return tangent ? std::optional<Vector2>(pixel_of_tangent(eye, *tangent)) : std::nullopt;
}

}  // namespace holdfast
