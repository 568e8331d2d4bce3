/// Learns a display's true refresh rate and vsync phase from observed vsyncs (or renderer starting points).
///
/// 001 appendix E: the predictor knows the renderer's future starting points from a stream of past ones. Observations
/// may be late (the process woke up late) and may be missing; they are never early. Frame number times nominal period
/// is taken for the display's own clock, and a ClockOffsetEstimator relates it to the host's. Bad input: observations
/// that run backward or fit no vsync are refused, see ClockSample.
#pragma once

#include <holdfast/timing/clock_offset_estimator.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

class VsyncEstimator {
 public:
  /// `nominal` gives the nominal refresh, which must be within 0.2 % of the true one (60 for 59.94 is).
  explicit VsyncEstimator(const DisplayTiming& nominal) : nominal_(nominal), estimator_(options()) {}

  ClockSample update(HostTime observed) {
    if (estimator_.samples() == 0) nominal_.first_vsync = observed;
    return estimator_.update(display_time(nearest_number(observed)), observed);
  }

  /// The nominal description with refresh_hz and first_vsync (a recent one) as observed; nothing before ten
  /// observations.
  [[nodiscard]] std::optional<DisplayTiming> timing() const {
    const auto estimate = estimator_.estimate();
    if (!estimate) return std::nullopt;
    DisplayTiming timing = nominal_;
    timing.refresh_hz = nominal_.refresh_hz / (1.0 + estimate->offset.skew());
    timing.first_vsync = estimate->offset.convert(display_time(last_number_));
    return timing;
  }

  /// 95 % bound of the error of the newest vsync's time.
  [[nodiscard]] std::optional<Duration> uncertainty() const {
    const auto estimate = estimator_.estimate();
    if (!estimate) return std::nullopt;
    return estimate->uncertainty;
  }

 private:
  [[nodiscard]] static ClockOffsetOptions options() {
    ClockOffsetOptions o;
    o.max_skew = 2e-3;
    return o;
  }

  /// What the display's own clock shows at vsync n.
  [[nodiscard]] TimePoint<DisplayClock> display_time(std::int64_t n) const {
    return TimePoint<DisplayClock>(vsync_at(nominal_, n) - nominal_.first_vsync);
  }

  /// Number of the vsync that an observation belongs to: the nearest by the estimate, else by the last observation.
  [[nodiscard]] std::int64_t nearest_number(HostTime observed) {
    const double hz = nominal_.refresh_hz;
    const auto estimate = estimator_.estimate();
    if (estimate) {
      const TimePoint<DisplayClock> t = estimate->offset.convert(observed);
      last_number_ = std::llround(to_seconds(t.time_since_epoch()) * hz);
    } else if (estimator_.samples() > 0) {
      last_number_ += std::llround(to_seconds(observed - last_observed_) * hz);
    }
    last_observed_ = observed;
    return last_number_;
  }

  DisplayTiming nominal_;
  ClockOffsetEstimator<DisplayClock, HostClock> estimator_;
  std::int64_t last_number_ = 0;
  HostTime last_observed_{};
};

}  // namespace holdfast
