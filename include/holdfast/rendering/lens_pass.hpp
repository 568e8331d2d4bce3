/// Warp tables for the lens of an eye (optics/eye.hpp): what the eye sees of a picture, and what the panel must show
/// for it.
///
/// Source: Robinett & Holloway 1994 (course 11), 7.9. The application draws an ideal picture and treats the lens by a
/// LensMode; the eye then sees the ideal picture unchanged (exact), nearly so (cubic) or bent by the whole distortion
/// (uncorrected). Both steps are composed into one look-up per pixel. LensMode::none needs no pass at all.
#pragma once

#include <holdfast/optics/eye.hpp>
#include <holdfast/rendering/warp_pass.hpp>

namespace holdfast::rendering {

[[nodiscard]] constexpr bool needs_lens_pass(LensMode mode) {
  return mode != LensMode::none;
}

/// Turns the ideal picture into the one that the eye sees through the lens.
[[nodiscard]] inline WarpTable seen_picture_table(Context& context, const EyeModel& eye, LensMode mode) {
  return WarpTable(context, eye.resolution.width, eye.resolution.height, eye.lens_red || eye.lens_blue,
                   [&](const Vector2& seen, int colour) {
                     const bool per_colour = eye.lens_red || eye.lens_blue;
                     return ideal_pixel(eye, mode, seen, per_colour ? static_cast<Color>(colour) : Color::green);
                   });
}

/// Turns the ideal picture into the one that the application sends to the panel.
[[nodiscard]] inline WarpTable panel_picture_table(Context& context, const EyeModel& eye, LensMode mode) {
  return WarpTable(context, eye.resolution.width, eye.resolution.height, eye.lens_red || eye.lens_blue,
                   [&](const Vector2& panel, int colour) {
                     const bool per_colour = eye.lens_red || eye.lens_blue;
                     return ideal_pixel_at_panel(eye, mode, panel,
                                                 per_colour ? static_cast<Color>(colour) : Color::green);
                   });
}

}  // namespace holdfast::rendering
