// When a filter's noise grows because residuals do, and by how much. With filters: scaat_filter.cpp, joint_filter.cpp.
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/tracking/manoeuvre.hpp>

using namespace holdfast;

TEST_CASE("manoeuvre: off unless asked for") {
  ManoeuvreDetector detector;
  for (int i = 0; i < 1000; ++i) detector.add(1e6, 2);
  CHECK(detector.noise_scale() == 1.0);
}

TEST_CASE("manoeuvre: the running mean of the innovations, per number, beyond the threshold") {
  const ManoeuvreSettings settings{.threshold = 1.5};
  ManoeuvreDetector detector(settings);
  double kept = 1.0;  // share of the old mean
  for (int i = 0; i < 200; ++i) {
    detector.add(8.0, 2);
    kept *= 1.0 - 1.0 / settings.memory;
    const double ratio = 4.0 * (1.0 - kept) / settings.threshold;
    CHECK(detector.noise_scale() == doctest::Approx(std::max(1.0, ratio * ratio)).epsilon(1e-12));
  }
  // A constant 4 per number is 8/3 of the threshold, and is forgotten by a factor of e in `memory` measurements or so.
  CHECK(detector.noise_scale() == doctest::Approx(64.0 / 9.0).epsilon(1e-3));
  for (int i = 0; i < 20; ++i) detector.add(0.0, 2);
  CHECK(detector.noise_scale() == 1.0);
}

TEST_CASE("manoeuvre: one measurement, however absurd, rouses nothing; many do, to the largest") {
  const ManoeuvreSettings settings{.threshold = 0.6, .largest = 50.0};
  ManoeuvreDetector detector(settings);
  detector.add(std::numeric_limits<double>::max(), 1);
  CHECK(detector.noise_scale() == 1.0);
  for (int i = 0; i < 1000; ++i) detector.add(std::numeric_limits<double>::max(), 1);
  CHECK(detector.noise_scale() == doctest::Approx(settings.largest).epsilon(1e-9));
}

TEST_CASE("manoeuvre: as long as all is as modelled, a threshold of 1.5 is seldom passed, and not by far") {
  std::mt19937 random(1);
  std::chi_squared_distribution<double> nis(2.0);
  ManoeuvreDetector detector({.threshold = 1.5});
  int passed = 0;
  double scale = 0.0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    detector.add(nis(random), 2);
    passed += detector.noise_scale() > 1.0;
    scale += detector.noise_scale() / n;
  }
  MESSAGE("passed by " << 100.0 * passed / n << " %, mean noise " << scale << " times");
  CHECK(passed < n / 100);  // 3.1 standard deviations of the mean, skewed upwards: measured 0.4 %
  CHECK(scale < 1.01);
}

TEST_CASE("manoeuvre: bad settings are named") {
  CHECK_FALSE(ManoeuvreSettings().problem());
  CHECK(ManoeuvreSettings{.threshold = -1.0}.problem());
  CHECK(ManoeuvreSettings{.threshold = std::nan("")}.problem());
  CHECK(ManoeuvreSettings{.memory = 0.5}.problem());
  CHECK(ManoeuvreSettings{.largest = 0.0}.problem());
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(ManoeuvreSettings{.threshold = inf}.problem());
  CHECK(ManoeuvreSettings{.memory = inf}.problem());
  CHECK(ManoeuvreSettings{.largest = inf}.problem());
}
