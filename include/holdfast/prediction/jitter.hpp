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

/// Adds to each line the mean square of `x` there (mean removed, Hann window).
inline void add_mean_squares(std::span<const double> x, std::size_t first_line, std::span<double> lines) {
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
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto line = static_cast<double>(first_line + k);
    const std::complex<double> turn = std::polar(1.0, -2.0 * std::numbers::pi * line / n);
    std::complex<double> phase = 1.0, amplitude = 0.0;
    for (const double value : windowed) {
      amplitude += value * phase;
      phase *= turn;
    }
    lines[k] += 2.0 * std::norm(amplitude) / (n * window_power);  // Parseval; both signs of frequency
  }
}

}  // namespace detail

/// Where in frequency a series has its power.
struct Spectrum {
  double spacing_hz = 0.0;
  std::vector<double> frequency_hz;
  std::vector<double> power;  ///< mean square per Hz
};

/// The lines inside the band of a series sampled at `rate_hz`; vectors add their components' powers. No lines where
/// there is no band RMS.
template <int Rows>
[[nodiscard]] Spectrum power_spectrum(std::span<const VectorOf<double, Rows>> series, double rate_hz,
                                      const FrequencyBand& band = {}, double segment_s = 4.0) {
  Spectrum spectrum;
  if (!(rate_hz >= 2.5 * band.low_hz) || !(static_cast<double>(series.size()) >= rate_hz)) return spectrum;
  const auto length = static_cast<std::size_t>(std::min(static_cast<double>(series.size()), segment_s * rate_hz));
  spectrum.spacing_hz = rate_hz / static_cast<double>(length);
  const auto first = static_cast<std::size_t>(std::ceil(band.low_hz / spectrum.spacing_hz));
  const auto last = static_cast<std::size_t>(std::floor(std::min(band.high_hz, 0.499 * rate_hz) / spectrum.spacing_hz));
  if (last < first) return spectrum;
  spectrum.power.assign(last - first + 1, 0.0);
  double segments = 0.0;
  std::vector<double> component(length);
  for (std::size_t begin = 0; begin + length <= series.size(); begin += std::max<std::size_t>(1, length / 2)) {
    for (int row = 0; row < Rows; ++row) {
      for (std::size_t i = 0; i < length; ++i) component[i] = series[begin + i][row];
      detail::add_mean_squares(component, first, spectrum.power);
    }
    ++segments;
  }
  for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
    spectrum.frequency_hz.push_back(static_cast<double>(first + k) * spectrum.spacing_hz);
    spectrum.power[k] /= segments * spectrum.spacing_hz;
  }
  return spectrum;
}

/// RMS of what a spectrum has inside the band; nothing for one without lines.
[[nodiscard]] inline std::optional<double> band_rms(const Spectrum& spectrum, const FrequencyBand& band = {}) {
  if (spectrum.power.empty()) return std::nullopt;
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
    const double f = spectrum.frequency_hz[k];
    if (f >= band.low_hz - 1e-9 && f <= band.high_hz + 1e-9) sum += spectrum.spacing_hz * spectrum.power[k];
  }
  return std::sqrt(sum);
}

/// RMS inside the band of a series sampled at `rate_hz`; vectors add their components' powers.
template <int Rows>
[[nodiscard]] std::optional<double> band_rms(std::span<const VectorOf<double, Rows>> series, double rate_hz,
                                             const FrequencyBand& band = {}, double segment_s = 4.0) {
  if (!(rate_hz >= 2.5 * band.low_hz) || !(static_cast<double>(series.size()) >= rate_hz)) return std::nullopt;
  return band_rms(power_spectrum<Rows>(series, rate_hz, band, segment_s), band).value_or(0.0);
}

}  // namespace holdfast
