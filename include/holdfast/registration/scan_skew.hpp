/// Scan skew: how far a rolling scan-out tilts virtual things against real ones while the head turns.
///
/// A frame is drawn for one pose, but its lines light one after another; meanwhile the real world moves on. Here the
/// vertical edge is followed line by line: at each of a number of rows the azimuth (angle to the right of the eye's
/// forward plane, atan of the horizontal tangent) at which the virtual and the real edge cross that row at the time of
/// that row, and a line is fitted through their difference. For a head that yaws at w the skew from top to bottom is w
/// times the scan duration, wherever the edge stands: 100 deg/s and 11.1 ms give 66.6 arcmin (evaluation.md, value 9).
/// Rows are those of a panel without lens: px from the bottom. A display that lights columns one after another shifts an
/// upright edge and does not tilt it: nothing. Bad input: an edge that does not cross the middle half of the picture has
/// no skew: nothing.
#pragma once

#include <cmath>
#include <optional>

#include <holdfast/optics/eye.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/scene_fiducials.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

/// Tilt of a line from the picture's top to its bottom: bottom less top, right positive.
struct ScanSkew {
  double arcmin = 0.0;  ///< difference of azimuth
  double deg = 0.0;     ///< of the line in the picture, from the vertical; positive leans its bottom to the right
};

namespace detail {

/// Horizontal tangent at which the edge crosses the height `tan_y` of the eye at X_WE; nothing when it does not, or
/// behind the eye.
[[nodiscard]] inline std::optional<double> edge_crossing(const VerticalEdge& edge, const Rigid& X_WE, double tan_y) {
  const Rigid X_EW = X_WE.inverse();
  const Vector3 bottom = X_EW * edge.bottom_W, top = X_EW * edge.top_W;
  // On the row: y + tan_y z = 0.
  const double at_bottom = bottom.y() + tan_y * bottom.z(), at_top = top.y() + tan_y * top.z();
  const double s = at_bottom / (at_bottom - at_top);
  if (!(s >= 0.0 && s <= 1.0)) return std::nullopt;
  const Vector3 p = bottom + s * (top - bottom);
  if (!(p.z() < 0.0)) return std::nullopt;
  return -p.x() / p.z();
}

}  // namespace detail

/// Skew of the virtual edge, drawn for X_WE_displayed, against the real one seen by the eye at X_WE_true(seconds from
/// the middle of scan-out). `Pose` is callable as Rigid(double).
template <typename Pose>
[[nodiscard]] std::optional<ScanSkew> scan_skew(const VerticalEdge& edge, const EyeModel& eye,
                                                const DisplayTiming& timing, const Rigid& X_WE_displayed,
                                                const Pose& X_WE_true) {
  constexpr int rows = 16;
  if (is_sideways(timing.scan_direction)) return std::nullopt;
  const double width = eye.resolution.width, height = eye.resolution.height;
  double n = 0.0, y_sum = 0.0, yy = 0.0, azimuth_sum = 0.0, y_azimuth = 0.0, x_sum = 0.0, y_x = 0.0;
  for (int i = 0; i < rows; ++i) {
    const double y = height * (i + 0.5) / rows;
    const double tan_y = tangent_of_pixel(eye, Vector2(0.0, y)).y();
    const double line = line_fraction_of_pixel(timing.scan_direction, Vector2(0.0, y), Vector2(width, height));
    const double t = line_seconds_from_middle(timing, line);
    const std::optional<double> shown = detail::edge_crossing(edge, X_WE_displayed, tan_y);
    const std::optional<double> real = detail::edge_crossing(edge, X_WE_true(t), tan_y);
    if (!shown || !real) continue;
    const bool in_view = is_inside(eye, pixel_of_tangent(eye, Vector2(*shown, tan_y))) &&
                         is_inside(eye, pixel_of_tangent(eye, Vector2(*real, tan_y)));
    if (!in_view) continue;
    const double down = 0.5 - y / height;  // -1/2 top, 1/2 bottom
    const double azimuth = std::atan(*shown) - std::atan(*real);
    const double x = (*shown - *real) * pixels_per_tangent(eye).x() / height;
    n += 1.0;
    y_sum += down;
    yy += down * down;
    azimuth_sum += azimuth;
    y_azimuth += down * azimuth;
    x_sum += x;
    y_x += down * x;
  }
  if (n < rows / 2) return std::nullopt;
  const double spread = yy - y_sum * y_sum / n;
  ScanSkew skew;
  skew.arcmin = (y_azimuth - y_sum * azimuth_sum / n) / spread * arcmin_per_rad;
  skew.deg = std::atan((y_x - y_sum * x_sum / n) / spread) * degrees_per_rad;
  return skew;
}

}  // namespace holdfast
