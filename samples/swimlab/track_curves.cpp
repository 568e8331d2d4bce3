#include "track_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <holdfast/prediction/jitter.hpp>

namespace swimlab {

using namespace holdfast;

namespace {

constexpr std::size_t time_bins = 300;
constexpr double recovery_s = 0.3;
constexpr std::size_t recovery_bins = 150;
/// Of a spectrum's segments: at 1000 Hz, bands are 10 Hz wide.
constexpr std::size_t longest_segment = 200, shortest_segment = 16;
/// More sightings than these, the last of the run, would make the run slower and the curve no clearer.
constexpr std::size_t most_of_spectrum = 20000;

VectorOf<double, 9> errors_mm(const TrackMoment& moment) {
  return 1e3 / std::sqrt(3.0) * three_point_errors(moment.tracker.X_WB(), moment.X_WB).reshaped();
}

}  // namespace

TrackCurves::TrackCurves(const Motion& truth, bool noise)
    : noise_(noise),
      begin_(truth.begin()),
      bin_s_(to_seconds(truth.duration()) / static_cast<double>(time_bins)),
      worst_mm_(time_bins) {}

void TrackCurves::add(const TrackMoment& moment) {
  if (!moment.fresh && !noise_) return;
  const Errors now_mm = errors_mm(moment);
  if (moment.fresh) {
    const double bin = to_seconds(moment.sighting.t - begin_) / bin_s_;
    std::optional<double>& worst = worst_mm_[std::min(static_cast<std::size_t>(std::max(bin, 0.0)), time_bins - 1)];
    worst = std::max(worst.value_or(0.0), now_mm.norm());
    newest_mm_ = now_mm;
  }
  if (!noise_) return;
  if (!first_) first_ = moment.sighting.t;
  last_ = moment.sighting.t;
  at_estimates_mm_.push_back(newest_mm_);
  held_mm_.push_back(now_mm);
}

std::vector<TrackCurve> TrackCurves::curves() const {
  TrackCurve error{TrackCurveKind::error, {}};
  for (std::size_t i = 0; i < time_bins; ++i) {
    if (worst_mm_[i]) error.points.push_back({bin_s_ * (static_cast<double>(i) + 0.5), *worst_mm_[i]});
  }
  if (!noise_) return {error};
  return {error, spectrum(TrackCurveKind::noise, at_estimates_mm_), spectrum(TrackCurveKind::held_noise, held_mm_)};
}

TrackCurve TrackCurves::spectrum(TrackCurveKind kind, const std::vector<Errors>& errors) const {
  TrackCurve curve{kind, {}};
  const std::size_t segment = std::min(errors.size() / 4, longest_segment);
  if (segment < shortest_segment) return curve;
  const double rate_hz = static_cast<double>(errors.size() - 1) / to_seconds(*last_ - *first_);
  const double step_hz = rate_hz / static_cast<double>(segment);
  const std::span<const Errors> last = std::span(errors).last(std::min(errors.size(), most_of_spectrum));
  // Two of a segment's frequencies at a time.
  for (std::size_t k = 1; 5 * k <= 2 * segment; k += 2) {
    const double low_hz = static_cast<double>(k) * step_hz;
    const std::optional<double> band_mm = band_rms<9>(last, rate_hz, {low_hz - 0.25 * step_hz, low_hz + 1.25 * step_hz},
                                                      (static_cast<double>(segment) + 0.5) / rate_hz);
    if (band_mm) curve.points.push_back({low_hz + 0.5 * step_hz, *band_mm / std::sqrt(2.0 * step_hz)});
  }
  return curve;
}

void RecoveryCurves::begin(HostTime since) {
  trials_.push_back({since, false, std::vector<double>(recovery_bins, std::numeric_limits<double>::infinity())});
}

void RecoveryCurves::add(const TrackMoment& moment) {
  if (trials_.empty()) return;
  Trial& trial = trials_.back();
  trial.found = trial.found || (moment.fresh && moment.sighting.t >= trial.since);
  const double since_s = to_seconds(moment.sighting.t - trial.since);
  if (!trial.found || since_s >= recovery_s) return;
  // What is not seen anew stays.
  const auto bin = static_cast<std::ptrdiff_t>(since_s / recovery_s * static_cast<double>(recovery_bins));
  std::fill(trial.error_mm.begin() + bin, trial.error_mm.end(), errors_mm(moment).norm());
}

std::vector<TrackCurve> RecoveryCurves::curves() const {
  return {below(TrackCurveKind::half_recovered, 0.5), below(TrackCurveKind::most_recovered, 0.9)};
}

TrackCurve RecoveryCurves::below(TrackCurveKind kind, double part) const {
  TrackCurve curve{kind, {}};
  if (trials_.empty()) return curve;
  const auto rank =
      static_cast<std::size_t>(std::max(0.0, std::ceil(part * static_cast<double>(trials_.size())) - 1.0));
  for (std::size_t bin = 0; bin < recovery_bins; ++bin) {
    std::vector<double> errors;
    for (const Trial& trial : trials_) errors.push_back(trial.error_mm[bin]);
    std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(rank));
    const double ms = 1e3 * recovery_s * (static_cast<double>(bin) + 1.0) / static_cast<double>(recovery_bins);
    if (std::isfinite(errors[rank])) curve.points.push_back({ms, errors[rank]});
  }
  return curve;
}

}  // namespace swimlab
