/// How a tracker's output behaves in time: how soon it is right, and how restless it is (002 figures 6.7-6.10, 6.16, 6.17).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/prediction/jitter.hpp>
#include <holdfast/registration/track_experiment.hpp>

namespace holdfast {

/// When a tracker was right, for good as far as it was watched: the first estimate from which on each one's three-point
/// RMS stays below `good_m`.
class RecoveryTime {
 public:
  explicit RecoveryTime(HostTime since, double good_m = 0.01) : since_(since), good_m_(good_m) {}

  void add(const TrackMoment& moment) {
    if (!moment.fresh || moment.sighting.t < since_) return;
    const double error = three_point_errors(moment.tracker.X_WB(), moment.X_WB).norm() / std::sqrt(3.0);
    if (!(error < good_m_)) {
      right_from_.reset();
    } else if (!right_from_) {
      right_from_ = moment.sighting.t;
    }
  }

  /// Nothing when the last estimate was not right, or there was none.
  [[nodiscard]] std::optional<Duration> time() const {
    if (!right_from_) return std::nullopt;
    return *right_from_ - since_;
  }

 private:
  HostTime since_;
  double good_m_;
  std::optional<HostTime> right_from_;
};

/// Noise of the output: RMS of the three points' error above a frequency, of all its error vectors' components. Two ways:
///   held     the newest estimate against the truth of each sighting's time, as one who shows it would see. Estimates
///            that come every 10 ms make a staircase of the motion itself.
///   at estimates  the error that each estimate had at its own time, held until the next: without that staircase.
/// Precondition: sightings come at `rate_hz`, all along.
class OutputNoise {
 public:
  explicit OutputNoise(double rate_hz) : rate_hz_(rate_hz) {}

  void add(const TrackMoment& moment) {
    const Errors now = three_point_errors(moment.tracker.X_WB(), moment.X_WB).reshaped() / std::sqrt(3.0);
    if (moment.fresh) newest_ = now;
    held_.push_back(now);
    at_estimates_.push_back(newest_);
  }

  /// m; nothing for series shorter than 1 s.
  [[nodiscard]] std::optional<double> held_above(double hz) const { return rms(held_, hz, rate_hz_ / 2); }
  [[nodiscard]] std::optional<double> above(double hz) const { return rms(at_estimates_, hz, rate_hz_ / 2); }

  /// How far the strongest 10 Hz between `hz` and 0.4 of the rate rise over the median of all such bands: RMS by RMS.
  [[nodiscard]] std::optional<double> peak_above(double hz) const {
    std::vector<double> bands;
    for (double low = hz; low <= 0.39 * rate_hz_; low += 10.0) {
      const std::optional<double> band = rms(at_estimates_, low, low + 9.9);
      if (!band) return std::nullopt;
      bands.push_back(*band);
    }
    if (bands.empty()) return std::nullopt;
    std::ranges::sort(bands);
    return bands.back() / bands[bands.size() / 2];
  }

 private:
  using Errors = VectorOf<double, 9>;

  [[nodiscard]] std::optional<double> rms(const std::vector<Errors>& series, double low_hz, double high_hz) const {
    return band_rms<9>(std::span<const Errors>(series), rate_hz_, {low_hz, high_hz}, 0.5);
  }

  double rate_hz_;
  Errors newest_ = Errors::Zero();
  std::vector<Errors> held_, at_estimates_;
};

}  // namespace holdfast
