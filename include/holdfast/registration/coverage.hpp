/// Coverage: the part of the view for which the application's picture has no pixel.
///
/// The view is the eye's ideal picture, as seen. A direction of it is covered when the ideal pixel that the lens and
/// its correction bring there (ideal_pixel), turned by the late correction's rotation, lies inside the picture that was
/// rendered. P0 and P1 do not warp, so only an imperfect lens correction can uncover something there; a picture
/// deflected by an angle uncovers about angle / field of view at one side unless it was rendered larger (overfill).
/// Counted on a grid of 128 x 72 directions, so to about 0.01 %. Source: evaluation.md "Metrics".
/// Bad input: directions that the lens cannot show count as missing.
#pragma once

#include <algorithm>
#include <optional>

#include <holdfast/optics/eye.hpp>

namespace holdfast {

/// Percent of the view not covered by a picture with the tangents `rendered`, drawn by an eye turned by q_SE against
/// this one (S: the source picture's eye; identity: not deflected).
[[nodiscard]] inline double coverage_missing_pct(const EyeModel& eye, LensMode mode, const FieldTangents& rendered,
                                                 const Quaternion& q_SE = Quaternion::Identity()) {
  constexpr int columns = 128, rows = 72;
  const auto [left, right] = std::minmax({rendered.left, rendered.right});  // swapped where the picture is mirrored
  const auto [down, up] = std::minmax({rendered.down, rendered.up});
  int missing = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vector2 seen(eye.resolution.width * (column + 0.5) / columns, eye.resolution.height * (row + 0.5) / rows);
      const std::optional<Vector2> ideal = ideal_pixel(eye, mode, seen);
      const std::optional<Vector2> source = ideal ? tangents_of_point(q_SE * ray_E(eye, *ideal)) : std::nullopt;
      const bool covered =
          source && source->x() >= left && source->x() <= right && source->y() >= down && source->y() <= up;
      missing += covered ? 0 : 1;
    }
  }
  return 100.0 * missing / (columns * rows);
}

/// Percent of the view not covered by the eye's own picture, without deflection.
[[nodiscard]] inline double coverage_missing_pct(const EyeModel& eye, LensMode mode) {
  return coverage_missing_pct(eye, mode, eye.tangents);
}

}  // namespace holdfast
