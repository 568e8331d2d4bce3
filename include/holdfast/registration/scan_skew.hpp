/// Scan skew: how far a rolling scan-out tilts virtual things against real ones while the head turns.
///
/// A frame is drawn for one pose, but its lines light one after another; meanwhile the real world moves on. Here the
/// vertical edge is followed line by line: at each of a number of rows of what the eye sees, the azimuth (angle to the
/// right of the eye's forward plane, atan of the horizontal tangent) at which the virtual and the real edge cross that
/// row, each at the time at which its place there is lit, and a line is fitted through their difference. For a head that
/// yaws at w the skew from top to bottom is w times the scan duration, wherever the edge stands: 100 deg/s and 11.1 ms
/// give 66.6 arcmin (evaluation.md, value 9). A picture that is deflected line by line follows, and has none.
/// With a lens, its correction must be exact: else the edge is bent besides. A display that lights columns one after
/// another shifts an upright edge and does not tilt it: nothing. Bad input: an edge that does not cross the middle half
/// of the picture has no skew: nothing.
#pragma once

#include <cmath>
#include <optional>

#include <holdfast/optics/eye.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/scene_fiducials.hpp>
#include <holdfast/registration/shown_point.hpp>
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

/// The same for the edge of a picture drawn for X_WS, which the map t_S ~ H_SE t_E moved.
[[nodiscard]] inline std::optional<double> edge_crossing(const VerticalEdge& edge, const Rigid& X_WS,
                                                         const Matrix3& H_SE, double tan_y) {
  const Rigid X_SW = X_WS.inverse();
  const Matrix3 H_ES = H_SE.inverse();
  const auto shown = [&](const Vector3& p_W) {
    const Vector3 p_S = X_SW * p_W;
    return Vector3(H_ES * Vector3(p_S.x(), p_S.y(), -p_S.z()));
  };
  const Vector3 bottom = shown(edge.bottom_W), top = shown(edge.top_W);
  const double at_bottom = bottom.y() - tan_y * bottom.z(), at_top = top.y() - tan_y * top.z();
  const double s = at_bottom / (at_bottom - at_top);
  if (!(s >= 0.0 && s <= 1.0)) return std::nullopt;
  const Vector3 p = bottom + s * (top - bottom);
  if (!(p.z() > 0.0)) return std::nullopt;
  return p.x() / p.z();
}

/// Tangent x at which the edge crosses a row of what the eye sees, when crossing(s) is that for line fraction s.
template <typename Crossing>
[[nodiscard]] std::optional<double> crossing_on_its_line(const ShownOn& on, double tan_y, const Crossing& crossing) {
  const auto x = on_its_line([&](double s) -> std::optional<LitPlace<double>> {
    const std::optional<double> crossed = crossing(s);
    if (!crossed) return std::nullopt;
    const std::optional<Vector2> panel =
        drawn_pixel(on.eye, on.lens, pixel_of_tangent(on.eye, Vector2(*crossed, tan_y)));
    if (!panel) return std::nullopt;
    return LitPlace<double>{*crossed, on.line_fraction(*panel)};
  });
  return x && is_inside(on.eye, pixel_of_tangent(on.eye, Vector2(*x, tan_y))) ? x : std::nullopt;
}

}  // namespace detail

/// Skew of the virtual edge, as `picture` shows it, against the real one seen by the eye at X_WE_true(seconds from the
/// middle of scan-out). `Pose` is callable as Rigid(double). Precondition: no lens, or one that is exactly corrected.
template <typename Pose>
[[nodiscard]] std::optional<ScanSkew> scan_skew(const VerticalEdge& edge, const ShownPicture& picture,
                                                const ShownOn& on, const Pose& X_WE_true) {
  HOLDFAST_ASSERT(on.lens == LensMode::none || on.lens == LensMode::exact, "a bent edge has no skew");
  constexpr int rows = 16;
  if (is_sideways(on.timing.scan_direction)) return std::nullopt;
  const double height = on.eye.resolution.height;
  const Rigid& X_WS = picture.view.X_WS;
  const auto shown_at = [&](double s, double tan_y) {
    if (!picture.is_deflected()) return detail::edge_crossing(edge, X_WS, tan_y);
    const DeflectionResult& d = picture.deflection;
    if (picture.how.kind == DeflectionKind::depth) return detail::edge_crossing(edge, X_WS * d.X_SE.at(s), tan_y);
    return detail::edge_crossing(edge, X_WS, d.H_SE.at(s), tan_y);
  };
  const auto real_at = [&](double s, double tan_y) {
    return detail::edge_crossing(edge, X_WE_true(line_seconds_from_middle(on.timing, s)), tan_y);
  };
  double n = 0.0, y_sum = 0.0, yy = 0.0, azimuth_sum = 0.0, y_azimuth = 0.0, x_sum = 0.0, y_x = 0.0;
  for (int i = 0; i < rows; ++i) {
    const double y = height * (i + 0.5) / rows;
    const double tan_y = tangent_of_pixel(on.eye, Vector2(0.0, y)).y();
    const auto shown = detail::crossing_on_its_line(on, tan_y, [&](double s) { return shown_at(s, tan_y); });
    const auto real = detail::crossing_on_its_line(on, tan_y, [&](double s) { return real_at(s, tan_y); });
    if (!shown || !real) continue;
    const double down = 0.5 - y / height;  // -1/2 top, 1/2 bottom
    const double azimuth = std::atan(*shown) - std::atan(*real);
    const double x = (*shown - *real) * pixels_per_tangent(on.eye).x() / height;
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
