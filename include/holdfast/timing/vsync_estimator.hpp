/// Learns a display's true refresh rate and vsync phase from observed vsyncs (or renderer starting points).
///
/// 001 appendix E: the predictor knows the renderer's future starting points from a stream of past ones. Observations
/// may be late (the process woke up late) and may be missing; they are never early. Frame number times nominal period
/// is taken for the display's own clock, and a ClockOffsetEstimator relates it to the host's. An observation later than
/// 0.6 of a refresh cannot be told from an early one of the next vsync, so it is refused (ClockSample::jump); 20 such
/// in a row mean that the display changed its phase, and learning starts afresh. No allocation, lock or throw. Not
/// thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <holdfast/timing/clock_offset_estimator.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace holdfast {

class VsyncEstimator {
 public:
  /// `nominal` gives the nominal refresh, which must be within 0.2 % of the true one (60 for 59.94 is).
  explicit VsyncEstimator(const DisplayTiming& nominal) : nominal_(nominal), estimator_(options()) {}

  ClockSample update(HostTime observed) {
    constexpr std::int64_t limit = (std::int64_t{1} << 61) - 1;  // as in ClockOffsetEstimator
    const std::int64_t count = observed.time_since_epoch().count();
    if (count > limit || count < -limit) return ClockSample::out_of_range;
    if (seen_ > 0 && observed <= last_observed_) return ClockSample::backward_arrival;
    last_observed_ = observed;
    if (seen_ >= first_observations) return place(observed);
    first_[seen_++] = observed;
    if (seen_ == first_observations) place_first();
    return ClockSample::accepted;
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

  /// The one of the first observations whose phase agrees best with the others' becomes vsync 0: the first itself may
  /// be late.
  void place_first() {
    double least = 1e300;
    for (const HostTime candidate : first_) {
      double disagreement = 0.0;
      for (const HostTime other : first_) {
        const double cycles = to_seconds(other - candidate) * nominal_.refresh_hz;
        disagreement += std::abs(cycles - std::round(cycles));
      }
      if (disagreement < least) nominal_.first_vsync = candidate;
      least = std::min(least, disagreement);
    }
    for (const HostTime observed : first_) place(observed);
  }

  /// Finds the vsync that an observation belongs to, and learns from it.
  ClockSample place(HostTime observed) {
    const auto estimate = estimator_.estimate();
    double cycles = 0.0;  // refreshes since vsync 0
    double early = 0.25;  // what may be early after all, as the estimate itself may be late
    double late = 0.5;
    if (estimate) {
      cycles = to_seconds(estimate->offset.convert(observed).time_since_epoch()) * nominal_.refresh_hz;
      early = std::clamp(3.0 * to_seconds(estimate->uncertainty) * nominal_.refresh_hz, 0.005, 0.1);
      late = 0.6;
    } else {
      cycles = to_seconds(observed - nominal_.first_vsync) * nominal_.refresh_hz;
    }
    const double number = std::floor(cycles + early);
    if (cycles - number > late) {
      if (++refused_in_a_row_ >= 20) *this = VsyncEstimator(nominal_);
      return ClockSample::jump;
    }
    const ClockSample verdict = estimator_.update(display_time(static_cast<std::int64_t>(number)), observed);
    if (verdict == ClockSample::accepted || verdict == ClockSample::restarted) {
      refused_in_a_row_ = 0;
      last_number_ = static_cast<std::int64_t>(number);
    }
    return verdict;
  }

  static constexpr std::size_t first_observations = 10;

  DisplayTiming nominal_;
  ClockOffsetEstimator<DisplayClock, HostClock> estimator_;
  std::int64_t last_number_ = 0;
  HostTime last_observed_{};
  std::array<HostTime, first_observations> first_{};
  std::size_t seen_ = 0;
  int refused_in_a_row_ = 0;
};

}  // namespace holdfast
