/// The picture of a display that lights its lines one after another: drawn in horizontal bands, each at its own pose.
///
/// The scan-out itself is continuous; a band shows the pose of its middle row, so the error left is half a band's
/// motion: at 100 deg/s and 11.1 ms over 720 rows, bands of 8 rows are off by at most 0.4 arcmin.
#pragma once

#include <algorithm>
#include <utility>

#include <holdfast/rendering/render_target.hpp>
#include <holdfast/rendering/view.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast::rendering {

struct Band {
  RowRange rows;
  double middle_y_px = 0.0;  ///< from the picture's bottom
};

/// The i-th of n bands of a picture of `height` rows; together they cover it without overlap.
[[nodiscard]] constexpr Band band_of(int height, int n, int i) {
  const auto edge = [&](int k) { return static_cast<int>(static_cast<long long>(height) * k / n); };
  return {{edge(i), edge(i + 1)}, 0.5 * (edge(i) + edge(i + 1))};
}

/// Calls draw(band) for each band from the bottom up, with everything outside the band protected. The target is bound,
/// not cleared. In draw, take the pose at middle_of_scan_out + line_time_from_middle(timing,
/// line_fraction_of_row(timing, band.middle_y_px, height)) and put band.rows into the View.
template <typename Draw>
void draw_rolling(RenderTarget& target, int bands, Draw&& draw) {
  HOLDFAST_ASSERT(bands >= 1, "a picture has at least one band");
  target.bind();
  const GlFunctions& gl = target.context().gl();
  const int n = std::min(bands, target.height());
  for (int i = 0; i < n; ++i) {
    const Band band = band_of(target.height(), n, i);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(0, band.rows.first, target.width(), band.rows.end - band.rows.first);
    draw(band);
  }
  gl.Disable(GL_SCISSOR_TEST);
}

}  // namespace holdfast::rendering
