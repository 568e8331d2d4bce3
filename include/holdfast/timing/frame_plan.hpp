/// How far to predict: when the frame that is about to be computed will give its light.
///
/// Tracker and renderer run asynchronously, so the prediction distance changes from frame to frame (001 appendix E). It
/// is the time from the measurement to the start of scan-out:
///   (now - measured) + A + B + C
///   A  time to run the predictor and compute the view matrices: nearly constant, measured in trial runs
///   B  delay until the renderer accepts the matrices: up to its next starting point after now + A
///   C  time for the renderer to draw: until the scan-out of what it started, a fixed number of refreshes
/// The renderer starts once per refresh, at a fixed time after vsync, so all its future starting points are known.
/// Beyond the paper, the plan also names the middle of scan-out, which is when the average line shines and what should
/// be predicted to. When A is exceeded and a starting point missed, the plan is wrong by exactly one refresh, as in the
/// paper's figure 40. Bad input: nothing when the measurement's time lies more than `clock_tolerance` after now (clocks
/// mixed up or not aligned).
#pragma once

#include <cstdint>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

struct FramePlanSettings {
  DisplayTiming display;
  Duration compute_time{0};        ///< A
  Duration render_start_phase{0};  ///< the renderer starts this long after a vsync, 0 to one frame
  int scan_out_refreshes = 1;      ///< C: what starts in one refresh is scanned out this many vsyncs later, at least 1
  Duration clock_tolerance = std::chrono::milliseconds(1);
};

struct FramePlan {
  HostTime measured;            ///< t_0, when the tracker measured
  HostTime now;                 ///< when the prediction distance must be set
  HostTime render_start;        ///< when the renderer will take the matrices
  HostTime scan_out_start;      ///< the vsync at which the picture's scan-out starts
  HostTime middle_of_scan_out;  ///< the moment to predict for
  Duration compute{0};          ///< A
  Duration wait{0};             ///< B
  Duration render{0};           ///< C

  /// Measurement to start of scan-out: the paper's total prediction distance.
  [[nodiscard]] Duration prediction_distance() const { return scan_out_start - measured; }
  /// Measurement to the middle of scan-out: the interval to hand to a predictor.
  [[nodiscard]] Duration prediction_distance_to_middle() const { return middle_of_scan_out - measured; }
};

/// The first starting point of the renderer after t (not at t).
[[nodiscard]] inline std::int64_t next_render_start_number(const FramePlanSettings& settings, HostTime t) {
  return next_vsync_number(settings.display, t - settings.render_start_phase + Duration{1});
}

/// The plan of a frame whose pose was measured at `measured` and whose prediction is about to be computed at `now`.
[[nodiscard]] inline std::optional<FramePlan> plan_frame(const FramePlanSettings& settings, HostTime measured,
                                                         HostTime now) {
  HOLDFAST_ASSERT(settings.scan_out_refreshes >= 1,
                  "a picture cannot be scanned out in the refresh in which it is drawn");
  if (measured - now > settings.clock_tolerance) return std::nullopt;
  const std::int64_t n = next_render_start_number(settings, now + settings.compute_time);
  FramePlan plan;
  plan.measured = measured;
  plan.now = now;
  plan.render_start = vsync_at(settings.display, n) + settings.render_start_phase;
  plan.scan_out_start = vsync_at(settings.display, n + settings.scan_out_refreshes);
  plan.middle_of_scan_out = middle_of_scan_out(settings.display, plan.scan_out_start);
  plan.compute = settings.compute_time;
  plan.wait = plan.render_start - (now + settings.compute_time);
  plan.render = plan.scan_out_start - plan.render_start;
  return plan;
}

}  // namespace holdfast
