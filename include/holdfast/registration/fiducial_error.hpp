/// One disc in one frame: where the eye sees the real and the virtual one.
///
/// Under a rolling scan-out each line of the panel has its own time. The virtual disc is drawn for the frame's pose,
/// whatever the line, unless it is deflected line by line (shown_point.hpp); the real one is where the true eye pose
/// puts it at the time of the line on which it then appears (deflection/lit_line.hpp). What is seen on a row of
/// the view is lit by the panel line that the lens brings there. Pixels as in eye.hpp. Bad input: discs behind the eye,
/// seen from behind, cut by the picture's border or outside the lens's domain are not visible.
#pragma once

#include <optional>

#include <holdfast/deflection/lit_line.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/projected_ellipse.hpp>

namespace holdfast {

/// The panel pixel that the eye sees at an ideal pixel, through the true lens.
[[nodiscard]] inline std::optional<Vector2> panel_pixel_seen(const EyeModel& eye, LensMode lens, const Vector2& seen) {
  return lens == LensMode::none ? seen : drawn_pixel(eye, LensMode::exact, seen);
}

/// Seconds from the middle of scan-out at which the light arrives that is seen at an ideal pixel. Outside the lens: 0.
[[nodiscard]] inline double light_seconds(const EyeModel& eye, const DisplayTiming& timing, LensMode lens,
                                          const Vector2& seen) {
  if (timing.scan_out == ScanOut::global) return 0.0;
  const std::optional<Vector2> panel = panel_pixel_seen(eye, lens, seen);
  if (!panel) return 0.0;
  const Vector2 size(eye.resolution.width, eye.resolution.height);
  return line_seconds_from_middle(timing, line_fraction_of_pixel(timing.scan_direction, *panel, size));
}

/// The real disc's ellipse in the picture that is scanned out round t_display.
[[nodiscard]] inline std::optional<ProjectedEllipse> real_ellipse(const Motion& motion, const EyeModel& eye,
                                                                  const DisplayTiming& timing, LensMode lens,
                                                                  const Disc& disc, HostTime t_display,
                                                                  const Rigid& X_WE_at_display) {
  if (timing.scan_out == ScanOut::global) return project_disc(eye, X_WE_at_display, disc);
  const Vector2 size(eye.resolution.width, eye.resolution.height);
  return on_its_line([&](double s) -> std::optional<LitPlace<ProjectedEllipse>> {
    const Rigid X_WE = motion.at(t_display + line_time_from_middle(timing, s)).X_WB * eye.X_HE;
    const std::optional<ProjectedEllipse> ellipse = project_disc(eye, X_WE, disc);
    if (!ellipse) return std::nullopt;
    const std::optional<Vector2> panel = panel_pixel_seen(eye, lens, ellipse->centroid);
    if (!panel) return std::nullopt;
    return LitPlace<ProjectedEllipse>{*ellipse, line_fraction_of_pixel(timing.scan_direction, *panel, size)};
  });
}

/// Fills in both images of a disc and their difference. `real` is its ellipse in the ideal picture, `shown` the centroid
/// of the virtual one as seen (shown_centroid).
[[nodiscard]] inline FiducialRecord fiducial_error(const EyeModel& eye, const std::optional<ProjectedEllipse>& real,
                                                   const std::optional<Vector2>& shown) {
  constexpr double margin_px = 1.0;
  FiducialRecord record;
  if (!real || !shown || !real->front) return record;
  if (!real->is_inside(eye.resolution, margin_px) || !is_inside(eye, *shown)) return record;
  record.visible = true;
  record.c_real = real->centroid;
  record.c_virtual = *shown;
  record.error_px = record.c_virtual - record.c_real;
  const Vector3 ray_real = ray_E(eye, record.c_real), ray_virtual = ray_E(eye, record.c_virtual);
  record.error_rad = angular_error(ray_real, ray_virtual);
  record.error_arcmin = record.error_rad.norm() * arcmin_per_rad;
  record.error_mm = 1e3 * error_at_depth(ray_real, ray_virtual, real->depth_m);
  return record;
}

}  // namespace holdfast
