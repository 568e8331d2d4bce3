/// Jitter: unrest that the head did not make.
///
/// Head still: the standard deviation of the error about its mean (the mean is static error, not jitter). Head moving:
/// the RMS of the error between 3 and 12 Hz, where Azuma & Bishop found predicted outputs to have energy that head
/// motion lacks (001, appendix D: almost all head motion stays below 2 Hz). The band RMS comes from a Hann-windowed
/// periodogram averaged over half-overlapping segments (Welch 1967), each less its mean; segments of 4 s resolve 0.5
/// Hz. A sinusoid of amplitude a inside the band gives a / sqrt 2. Unit: that of the series. Bad input: a series
/// shorter than 1 s, or sampled too slowly for the band's lower edge, has no band RMS.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

/// sqrt(mean |e - mean e|^2); 0 for fewer than two.
template <int Rows>
[[nodiscard]] double standard_deviation(std::span<const VectorOf<double, Rows>> series) {
  if (series.size() < 2) return 0.0;
  VectorOf<double, Rows> mean = VectorOf<double, Rows>::Zero();
  for (const auto& e : series) mean += e;
  mean /= static_cast<double>(series.size());
  double squares = 0.0;
  for (const auto& e : series) squares += (e - mean).squaredNorm();
  return std::sqrt(squares / static_cast<double>(series.size()));
}

struct FrequencyBand {
  double low_hz = 3.0;
  double high_hz = 12.0;
};

namespace detail {

/// Mean square of `x` (mean removed, Hann window) inside the band.
[[nodiscard]] inline double band_mean_square(std::span<const double> x, double rate_hz, const FrequencyBand& band) {
  const auto n = static_cast<double>(x.size());
  double mean = 0.0;
  for (const double value : x) mean += value;
  mean /= n;
  std::vector<double> windowed(x.size());
  double window_power = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double w = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / n);
    windowed[i] = w * (x[i] - mean);
    window_power += w * w;
  }
  const double bin_hz = rate_hz / n;
  const auto first = static_cast<std::size_t>(std::ceil(band.low_hz / bin_hz));
  const auto last = static_cast<std::size_t>(std::floor(std::min(band.high_hz, 0.499 * rate_hz) / bin_hz));
  double sum = 0.0;
  for (std::size_t k = first; k <= last; ++k) {
    const std::complex<double> turn = std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) / n);
    std::complex<double> phase = 1.0, amplitude = 0.0;
    for (const double value : windowed) {
      amplitude += value * phase;
      phase *= turn;
    }
    sum += std::norm(amplitude);
  }
  return 2.0 * sum / (n * window_power);  // Parseval; both signs of frequency
}

}  // namespace detail

/// RMS inside the band of a series sampled at `rate_hz`; vectors add their components' powers.
template <int Rows>
[[nodiscard]] std::optional<double> band_rms(std::span<const VectorOf<double, Rows>> series, double rate_hz,
                                             const FrequencyBand& band = {}, double segment_s = 4.0) {
  if (!(rate_hz >= 2.5 * band.low_hz) || !(static_cast<double>(series.size()) >= rate_hz)) return std::nullopt;
  const auto length = static_cast<std::size_t>(std::min(static_cast<double>(series.size()), segment_s * rate_hz));
  double sum = 0.0;
  std::size_t segments = 0;
  std::vector<double> component(length);
  for (std::size_t begin = 0; begin + length <= series.size(); begin += std::max<std::size_t>(1, length / 2)) {
    for (int row = 0; row < Rows; ++row) {
      for (std::size_t i = 0; i < length; ++i) component[i] = series[begin + i][row];
      sum += detail::band_mean_square(component, rate_hz, band);
    }
    ++segments;
  }
  return std::sqrt(sum / static_cast<double>(segments));
}

}  // namespace holdfast
