#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/tracking/sighting_noise.hpp>

using namespace holdfast;

TEST_CASE("sighting noise: 002 eq. 6.4, worked by hand") {
  const SightingNoise noise;
  CHECK(sighting_variance(noise, 0.0, 1.0) == doctest::Approx(2.89e-14));               // xi_0 itself
  CHECK(std::sqrt(sighting_variance(noise, 0.0, 2.0)) == doctest::Approx(4 * 1.7e-7));  // by the distance's square
  // 60 deg: 1 - 1.074e-6 * 216000 - 2.331e-6 * 3600 - 2.394e-3 * 60 = 0.6159844
  CHECK(signal_strength(noise, degrees(60.0).radians()) == doctest::Approx(0.6159844).epsilon(1e-12));
  CHECK(std::sqrt(sighting_variance(noise, degrees(60.0).radians(), 1.0)) ==
        doctest::Approx(1.7e-7 / 0.6159844).epsilon(1e-12));
  CHECK(sighting_variance(noise, -0.5, 1.0) == sighting_variance(noise, 0.5, 1.0));
}

TEST_CASE("sighting noise: grows with the angle up to its limit, and stays there") {
  const SightingNoise noise;
  double last = 0.0;
  for (int angle = 0; angle <= 180; ++angle) {
    const double variance = sighting_variance(noise, degrees(angle).radians(), 1.3);
    CHECK(variance >= last);
    CHECK(std::isfinite(variance));
    last = variance;
  }
  const double limit = std::pow(1.3, 4) * 2.89e-14 / (weakest_signal * weakest_signal);
  CHECK(last == doctest::Approx(limit));
  CHECK(signal_strength(noise, degrees(88.0).radians()) > weakest_signal);
  CHECK(signal_strength(noise, degrees(89.4).radians()) == weakest_signal);
}

TEST_CASE("sighting noise: the angle between a beacon's axis and a camera's") {
  const SightingNoise noise;
  const Vector3 down(0, 0, -1);
  for (const double angle : {0.0, 0.3, 1.2, 2.0}) {
    const Vector3 camera(std::sin(angle), 0, std::cos(angle));
    // Straight against the light is 0; rounding of the angle is 1e-16.
    CHECK(sighting_variance(noise, down, camera, 1.7) == doctest::Approx(sighting_variance(noise, angle, 1.7)));
  }
}
