/// How far to predict, frame by frame, and how right that was (001 appendix E and figure 40).
///
///     if (auto plan = distance.plan(measured, now)) {
///       ...                                             // predict to plan->middle_of_scan_out, compute the views
///       distance.computed(clock.now() - now);           // A of this frame, from which the next ones' is learned
///     }
///     distance.shown(*plan, scan_out_start);            // once it is known when that picture's scan-out began
/// frame_plan.hpp says what the distance is: (now - measured) + A + B + C. Where the paper measures A in trial runs, here it
/// is a quantile of the last 64 frames': the median by default, which is most often right where the renderer takes whatever
/// is newest at its start. A higher one suits a renderer that waits for the frame planned for it.
/// The display's timing is settings().display: give it what VsyncEstimator learns.
/// A wrong distance is wrong by whole refreshes: `errors()` counts them, and what they were in milliseconds.
/// Nothing here allocates, locks or throws. Bad input: a negative A is not learned from; see plan_frame.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <holdfast/timing/frame_plan.hpp>

namespace holdfast {

/// Of the planned distance less the actual one.
struct PredictionDistanceErrors {
  std::uint64_t frames = 0;
  std::uint64_t too_long = 0, too_short = 0;  ///< by at least half a refresh
  double mean_ms = 0.0, rms_ms = 0.0, peak_ms = 0.0;

  [[nodiscard]] double wrong_share() const {
    return frames == 0 ? 0.0 : static_cast<double>(too_long + too_short) / static_cast<double>(frames);
  }
};

class PredictionDistance {
 public:
  /// `settings.compute_time` serves until the first frames are computed.
  explicit PredictionDistance(const FramePlanSettings& settings, double quantile = 0.5)
      : settings_(settings), quantile_(quantile) {
    HOLDFAST_ASSERT(quantile >= 0.0 && quantile <= 1.0, "a quantile is 0 to 1");
  }

  [[nodiscard]] std::optional<FramePlan> plan(HostTime measured, HostTime now) const {
    return plan_frame(settings_, measured, now);
  }

  /// How long predicting and computing the views took.
  void computed(Duration took) {
    if (took < Duration(0)) return;
    times_[count_++ % times_.size()] = took;
    std::array<Duration, 64> sorted = times_;
    const auto n = static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(count_, times_.size()));
    const auto place =
        sorted.begin() + static_cast<std::ptrdiff_t>(std::lround(quantile_ * static_cast<double>(n - 1)));
    std::nth_element(sorted.begin(), place, sorted.begin() + n);
    settings_.compute_time = *place;
  }

  /// When the scan-out of that frame's picture began.
  void shown(const FramePlan& plan, HostTime scan_out_start) {
    const double error_ms = to_milliseconds(plan.scan_out_start - scan_out_start);
    const double half_refresh_ms = 500.0 / settings_.display.refresh_hz;
    ++errors_.frames;
    if (error_ms >= half_refresh_ms) ++errors_.too_long;
    if (error_ms <= -half_refresh_ms) ++errors_.too_short;
    sum_ms_ += error_ms;
    squares_ms2_ += error_ms * error_ms;
    errors_.mean_ms = sum_ms_ / static_cast<double>(errors_.frames);
    errors_.rms_ms = std::sqrt(squares_ms2_ / static_cast<double>(errors_.frames));
    errors_.peak_ms = std::max(errors_.peak_ms, std::abs(error_ms));
  }

  [[nodiscard]] const PredictionDistanceErrors& errors() const { return errors_; }
  [[nodiscard]] const FramePlanSettings& settings() const { return settings_; }
  /// The display as VsyncEstimator knows it by now.
  void set_display(const DisplayTiming& display) { settings_.display = display; }

 private:
  FramePlanSettings settings_;
  double quantile_;
  std::array<Duration, 64> times_{};
  std::uint64_t count_ = 0;
  PredictionDistanceErrors errors_;
  double sum_ms_ = 0.0, squares_ms2_ = 0.0;
};

}  // namespace holdfast
