#include <random>

#include <doctest/doctest.h>

#include <holdfast/registration/jitter.hpp>
#include <holdfast/registration/overshoot.hpp>

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
}

namespace {

/// Yaw at 100 deg/s that stops at 1 s after 40 deg; what is displayed lags by `lag_s`, or goes on for as long when
/// negative.
std::vector<TurnSample> stop(double lag_s) {
  std::vector<TurnSample> frames;
  const auto yaw = [](double t) { return Vector3(0, (100.0 * std::clamp(t, 0.6, 1.0)) / degrees_per_rad, 0); };
  for (int i = 0; i < 180; ++i) {
    const double t = i / 90.0;
    TurnSample frame;
    frame.t = time_at(t);
    frame.q_WH_true = so3::exp<double>(yaw(t));
    Vector3 shown = yaw(t - lag_s);
    if (lag_s < 0.0 && t >= 1.0 && t < 1.0 - lag_s) shown.y() += 100.0 * (t - 1.0) / degrees_per_rad;
    frame.q_WH_displayed = so3::exp<double>(shown);
    if (t > 0.6 && t < 1.0 - 1e-9)
      frame.w_WH_H = Vector3(0, 100.0 / degrees_per_rad, 0);
    else
      frame.w_WH_H = Vector3::Zero();
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace

TEST_CASE("after an abrupt stop a lagging picture has a negative, a predicted one a positive overshoot") {
  const auto lagging = overshoot(stop(0.060));
  REQUIRE(lagging);
  CHECK(to_seconds(lagging->stopped.time_since_epoch()) == doctest::Approx(1.0));
  CHECK(lagging->arcmin == doctest::Approx(-360.0).epsilon(1e-9));  // 100 deg/s * 60 ms = 6 deg
  CHECK(lagging->pct == doctest::Approx(-15.0).epsilon(1e-9));      // of 40 deg
  const auto predicted = overshoot(stop(-0.060));
  REQUIRE(predicted);
  CHECK(predicted->arcmin > 360.0 - 100.0 * 60.0 / 90.0);  // sampled up to one frame before the peak
  CHECK(predicted->arcmin <= 360.0);
}

TEST_CASE("a motion that does not stop has no overshoot") {
  auto frames = stop(0.060);
  CHECK_FALSE(overshoot(std::span(frames).first(85)));  // still turning at the end
  CHECK_FALSE(overshoot(std::span(frames).first(50)));  // never turned
  CHECK_FALSE(overshoot({}));
}
