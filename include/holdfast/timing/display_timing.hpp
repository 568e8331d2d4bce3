/// When a display's light reaches the eye: refresh, scan-out, persistence and vsync phase.
///
/// A frame's scan-out starts at a vsync. Its first light follows `internal_delay` later (000 section 5.1.2). A global
/// display lights all lines together; a rolling one lights them one after another over `scan_duration`. Each line
/// shines for `persistence`. The time of a line is the middle of its light, and the time of a frame is that of the line
/// half way through the scan: what evaluation.md calls the middle of scan-out and OpenXR calls predictedDisplayTime.
/// Line fraction: 0 at the picture edge that is scanned first, 1 at the edge scanned last. Pixels are continuous, from
/// the picture's lower left (centres at half integers). Outside [0, 1] is extrapolated. Bad input:
/// `find_problem` names what is wrong with a description; the other functions want a description without problem.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

enum class ScanOut {
  global,   ///< all lines light together
  rolling,  ///< lines light one after another
};

[[nodiscard]] constexpr std::string_view name_of(ScanOut scan_out) {
  return scan_out == ScanOut::global ? "global" : "rolling";
}

/// The way in which a rolling display lights its lines: rows one after another, or columns (a panel built in turned).
enum class ScanDirection { top_to_bottom, bottom_to_top, left_to_right, right_to_left };

inline constexpr std::array scan_directions{ScanDirection::top_to_bottom, ScanDirection::bottom_to_top,
                                            ScanDirection::left_to_right, ScanDirection::right_to_left};

[[nodiscard]] constexpr std::string_view name_of(ScanDirection direction) {
  constexpr std::string_view names[] = {"top_to_bottom", "bottom_to_top", "left_to_right", "right_to_left"};
  return names[static_cast<std::size_t>(direction)];
}

[[nodiscard]] constexpr bool is_sideways(ScanDirection direction) {
  return direction == ScanDirection::left_to_right || direction == ScanDirection::right_to_left;
}

struct DisplayTiming {
  double refresh_hz = 90.0;
  ScanOut scan_out = ScanOut::global;
  Duration scan_duration{0};  ///< rolling: from the light of the first line to that of the last; global: not used
  Duration persistence{0};    ///< how long one line shines
  ScanDirection scan_direction = ScanDirection::top_to_bottom;  ///< rolling: which line is lit first
  Duration internal_delay{
      0};  ///< from vsync to the first light: what the device buffers or, when global, loads before the flash
  HostTime first_vsync{};  ///< any one vsync; it is number 0
};

/// What is wrong with a description: the member's name and what was expected.
struct DisplayTimingProblem {
  std::string_view member;
  std::string_view expected;
};

/// Nothing when the description is sound. Durations may exceed the frame period by 1 %, as published figures are
/// rounded.
[[nodiscard]] inline std::optional<DisplayTimingProblem> find_problem(const DisplayTiming& timing) {
  if (!(timing.refresh_hz >= 1.0 && timing.refresh_hz <= 1e6)) {
    return DisplayTimingProblem{"refresh_hz", "a number of 1 to 1e6 Hz"};
  }
  const double longest = 1.01 / timing.refresh_hz;
  const auto is_outside = [](Duration d, double most) { return d < Duration{0} || to_seconds(d) > most; };
  if (timing.scan_out == ScanOut::rolling && timing.scan_duration <= Duration{0}) {
    return DisplayTimingProblem{"scan_duration", "above zero, as scan_out is rolling"};
  }
  if (is_outside(timing.scan_duration, longest)) {
    return DisplayTimingProblem{"scan_duration", "0 to one frame period"};
  }
  if (is_outside(timing.persistence, longest)) return DisplayTimingProblem{"persistence", "0 to one frame period"};
  if (is_outside(timing.internal_delay, 1.0)) return DisplayTimingProblem{"internal_delay", "0 to 1 s"};
  return std::nullopt;
}

/// One frame, rounded to whole nanoseconds. For times of frames use vsync_at, which does not gather the rounding.
[[nodiscard]] inline Duration frame_period(const DisplayTiming& timing) {
  return from_seconds(1.0 / timing.refresh_hz);
}

/// Time of vsync number n (it may be negative); never more than 1 ns from n / refresh within 100 days.
[[nodiscard]] inline HostTime vsync_at(const DisplayTiming& timing, std::int64_t n) {
  return timing.first_vsync + Duration(std::llround(static_cast<double>(n) * (1e9 / timing.refresh_hz)));
}

/// Number of the first vsync at or after t.
[[nodiscard]] inline std::int64_t next_vsync_number(const DisplayTiming& timing, HostTime t) {
  HOLDFAST_ASSERT(timing.refresh_hz > 0.0, "refresh_hz is not positive");
  const double frames = static_cast<double>((t - timing.first_vsync).count()) * (timing.refresh_hz * 1e-9);
  auto n = static_cast<std::int64_t>(std::ceil(frames));
  // The division may be off by one in its last digit: settle it on the vsync times themselves.
  while (vsync_at(timing, n - 1) >= t) --n;
  while (vsync_at(timing, n) < t) ++n;
  return n;
}

/// The first vsync at or after t.
[[nodiscard]] inline HostTime next_vsync(const DisplayTiming& timing, HostTime t) {
  return vsync_at(timing, next_vsync_number(timing, t));
}

/// Line fraction of a pixel in a picture of `size` (width, height) px.
[[nodiscard]] inline double line_fraction_of_pixel(ScanDirection direction, const Vector2& pixel, const Vector2& size) {
  HOLDFAST_ASSERT(size.x() > 0.0 && size.y() > 0.0, "picture without lines");
  switch (direction) {
    case ScanDirection::top_to_bottom:
      break;
    case ScanDirection::bottom_to_top:
      return pixel.y() / size.y();
    case ScanDirection::left_to_right:
      return pixel.x() / size.x();
    case ScanDirection::right_to_left:
      return 1.0 - pixel.x() / size.x();
  }
  return 1.0 - pixel.y() / size.y();
}

/// Seconds from the middle of the frame's scan-out to the light of a line: negative for lines lit before the middle.
[[nodiscard]] inline double line_seconds_from_middle(const DisplayTiming& timing, double line_fraction) {
  return timing.scan_out == ScanOut::global ? 0.0 : (line_fraction - 0.5) * to_seconds(timing.scan_duration);
}

/// The same, to whole nanoseconds.
[[nodiscard]] inline Duration line_time_from_middle(const DisplayTiming& timing, double line_fraction) {
  HOLDFAST_ASSERT(std::isfinite(line_fraction), "line fraction is not finite");
  return from_seconds(line_seconds_from_middle(timing, line_fraction));
}

/// From the vsync that starts a frame to the middle of its scan-out.
[[nodiscard]] inline Duration vsync_to_middle(const DisplayTiming& timing) {
  const Duration scan = timing.scan_out == ScanOut::rolling ? timing.scan_duration : Duration{0};
  return timing.internal_delay + (scan + timing.persistence) / 2;
}

/// Middle of the scan-out of the frame that starts at `vsync`.
[[nodiscard]] inline HostTime middle_of_scan_out(const DisplayTiming& timing, HostTime vsync) {
  return vsync + vsync_to_middle(timing);
}

/// When a line shines.
struct LightInterval {
  HostTime begin, middle, end;
};

/// Light of the line at `line_fraction` in the frame that starts at `vsync`.
[[nodiscard]] inline LightInterval light_of_line(const DisplayTiming& timing, HostTime vsync, double line_fraction) {
  const HostTime middle = middle_of_scan_out(timing, vsync) + line_time_from_middle(timing, line_fraction);
  const HostTime begin = middle - timing.persistence / 2;
  return {begin, middle, begin + timing.persistence};
}

/// Light of a pixel of a picture of `size` (width, height) px in the frame that starts at `vsync`.
[[nodiscard]] inline LightInterval light_of_pixel(const DisplayTiming& timing, HostTime vsync, const Vector2& pixel,
                                                  const Vector2& size) {
  return light_of_line(timing, vsync, line_fraction_of_pixel(timing.scan_direction, pixel, size));
}

}  // namespace holdfast
