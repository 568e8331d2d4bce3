/// The picture of a display that lights its lines one after another: drawn in bands along the lines, each at its own
/// pose.
///
/// The scan-out itself is continuous; a band shows the pose of its middle line, so the error left is half a band's
/// motion: at 100 deg/s and 11.1 ms over 720 rows, bands of 8 rows are off by at most 0.4 arcmin.
#pragma once

#include <algorithm>
#include <utility>

#include <holdfast/rendering/render_target.hpp>
#include <holdfast/rendering/view.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast::rendering {

struct Band {
  PixelRectangle part;
  Vector2 middle_px;  ///< of the band
};

/// The i-th of n bands of a picture, of rows from the bottom or (a sideways scan) of columns from the left; together
/// they cover it without overlap.
[[nodiscard]] inline Band band_of(PixelSize size, ScanDirection direction, int n, int i) {
  const auto edge = [&](int lines, int k) { return static_cast<int>(static_cast<long long>(lines) * k / n); };
  Band band;
  band.part = {0, 0, size.width, size.height};
  if (is_sideways(direction)) {
    band.part.left = edge(size.width, i);
    band.part.right = edge(size.width, i + 1);
  } else {
    band.part.bottom = edge(size.height, i);
    band.part.top = edge(size.height, i + 1);
  }
  band.middle_px = 0.5 * Vector2(band.part.left + band.part.right, band.part.bottom + band.part.top);
  return band;
}

/// Calls draw(band) for each band, with everything outside the band protected. The target is bound, not cleared. In
/// draw, take the pose at middle_of_scan_out + line_time_from_middle(timing, line_fraction_of_pixel(direction,
/// band.middle_px, size)) and put band.part into the View.
template <typename Draw>
void draw_rolling(RenderTarget& target, ScanDirection direction, int bands, Draw&& draw) {
  HOLDFAST_ASSERT(bands >= 1, "a picture has at least one band");
  target.bind();
  const GlFunctions& gl = target.context().gl();
  const PixelSize size{target.width(), target.height()};
  const int n = std::min(bands, is_sideways(direction) ? size.width : size.height);
  for (int i = 0; i < n; ++i) {
    const Band band = band_of(size, direction, n, i);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(band.part.left, band.part.bottom, band.part.right - band.part.left, band.part.top - band.part.bottom);
    draw(band);
  }
  gl.Disable(GL_SCISSOR_TEST);
}

}  // namespace holdfast::rendering
