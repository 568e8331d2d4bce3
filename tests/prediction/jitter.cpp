#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/prediction/jitter.hpp>

using namespace holdfast;

namespace {

std::vector<VectorOf<double, 2>> sinusoid(double hz, double amplitude, double rate, std::size_t n) {
  std::vector<VectorOf<double, 2>> series;
  for (std::size_t i = 0; i < n; ++i) {
    const double phase = 2.0 * std::numbers::pi * hz * static_cast<double>(i) / rate;
    series.emplace_back(5.0 + amplitude * std::sin(phase), -3.0);
  }
  return series;
}

}  // namespace

TEST_CASE("standard deviation does not see the mean") {
  const std::vector<VectorOf<double, 2>> series{{1.0, 5.0}, {3.0, 5.0}};
  CHECK(standard_deviation<2>(series) == doctest::Approx(1.0));
  CHECK(standard_deviation<2>(std::span(series).first(1)) == 0.0);
}

TEST_CASE("band RMS of a sinusoid inside the band is amplitude over root two, outside it nearly nothing") {
  for (const double hz : {4.0, 6.3, 11.0}) {
    const auto series = sinusoid(hz, 2.0, 90.0, 1800);
    // The Hann window spreads a line over +-0.5 Hz, all of it inside the band.
    CHECK(*band_rms<2>(series, 90.0) == doctest::Approx(2.0 / std::sqrt(2.0)).epsilon(2e-3));
  }
  for (const double hz : {0.5, 2.0, 14.0}) {
    // Hann side lobes four bins away are below 0.3 %.
    CHECK(*band_rms<2>(sinusoid(hz, 2.0, 90.0, 1800), 90.0) < 0.02);
  }
}

TEST_CASE("band RMS of white noise is the band's share of it") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<VectorOf<double, 3>> noise(18000);
  for (auto& n : noise) n = VectorOf<double, 3>(normal(random), normal(random), normal(random));
  // 9 Hz of 45 Hz, three components; 100 segments of 37 bins: 1.5 % statistical, 3 sigma.
  CHECK(*band_rms<3>(noise, 90.0) == doctest::Approx(std::sqrt(3.0 * 9.25 / 45.0)).epsilon(0.045));
}

TEST_CASE("too short or too slow a series has no band RMS") {
  CHECK_FALSE(band_rms<2>(sinusoid(4.0, 1.0, 90.0, 60), 90.0));
  CHECK_FALSE(band_rms<2>(sinusoid(1.0, 1.0, 5.0, 100), 5.0));
  for (const double rate : {0.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_FALSE(band_rms<2>(sinusoid(4.0, 1.0, 90.0, 200), rate));
  }
}
