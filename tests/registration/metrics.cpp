#include <random>

#include <doctest/doctest.h>

#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/swim.hpp>

using namespace holdfast;

TEST_CASE("angles between rays are true angles, right and up") {
  const Vector3 forward(0, 0, -1);
  const double a = 0.01;
  const Vector2 right = angular_error(forward, Vector3(std::sin(a), 0, -std::cos(a)));
  CHECK(right.x() == doctest::Approx(a).epsilon(1e-12));
  CHECK(std::abs(right.y()) < 1e-15);
  const Vector2 up = angular_error(forward, Vector3(0, std::sin(a), -std::cos(a)));
  CHECK(up.y() == doctest::Approx(a).epsilon(1e-12));
  // 25 deg off the axis a pixel is smaller in angle: the same turn of the ray must give the same angle all the same.
  const Vector3 off(std::sin(0.44), 0, -std::cos(0.44)), off2(std::sin(0.45), 0, -std::cos(0.45));
  CHECK(angular_error(off, off2).x() == doctest::Approx(0.01).epsilon(1e-10));
  CHECK(angular_error(off, off).norm() == 0.0);
  // Lengths of rays do not matter.
  CHECK(angular_error(3.0 * off, 0.2 * off2).x() == doctest::Approx(0.01).epsilon(1e-10));
}

TEST_CASE("millimetres at the fiducial's depth") {
  // 1 mm to the side at 2 m, seen through rays of any length.
  CHECK(error_at_depth(Vector3(0.5, 0.2, -2.0), Vector3(0.501, 0.2, -2.0) * 0.3, 2.0) == doctest::Approx(0.001));
}

TEST_CASE("stereo residual is the left error less the right one") {
  const std::vector<Vector2> left{{3e-3, 1e-3}, {1e-3, 0.0}}, right{{1e-3, 2e-3}, {1e-3, 0.0}};
  const StereoResidual r = stereo_residual(left, right);
  CHECK(r.peak_horizontal_arcmin == doctest::Approx(2e-3 * arcmin_per_rad));
  CHECK(r.peak_vertical_arcmin == doctest::Approx(1e-3 * arcmin_per_rad));
  CHECK(r.rms_horizontal_arcmin == doctest::Approx(2e-3 / std::sqrt(2.0) * arcmin_per_rad));
}

TEST_CASE("swim of a sinusoidal error is its derivative, as frames can show it") {
  const double hz = 2.0, amplitude = 0.02, rate = 90.0;
  SwimMeter meter(1);
  double peak = 0.0;
  for (std::size_t n = 0; n < 450; ++n) {
    const double t = static_cast<double>(n) / rate;
    const Vector2 error(amplitude * std::sin(2.0 * std::numbers::pi * hz * t), 0.0);
    const auto swim = meter.add(0, n, time_at(t), 1000.0 * error, error);
    CHECK(swim.has_value() == (n > 0));
    if (swim) peak = std::max(peak, swim->rad_s.norm());
    if (swim) CHECK(swim->px_s.x() == doctest::Approx(1000.0 * swim->rad_s.x()).epsilon(1e-9));
  }
  const double half_turn = std::numbers::pi * hz / rate;
  // One frame interval is centred on the zero crossing only by chance: at most half a frame off, cos(half_turn).
  const double expected = amplitude * 2.0 * std::sin(half_turn) * rate;
  CHECK(peak <= expected * (1.0 + 1e-6));
  CHECK(peak >= expected * std::cos(half_turn) * (1.0 - 1e-6));
  CHECK(expected == doctest::Approx(amplitude * 2.0 * std::numbers::pi * hz).epsilon(1e-3));
}

TEST_CASE("a fiducial that was out of view starts its swim anew") {
  SwimMeter meter(2);
  const Vector2 zero = Vector2::Zero(), one(1.0, 0.0);
  CHECK_FALSE(meter.add(1, 0, time_at(0.0), zero, zero));
  CHECK(meter.add(1, 1, time_at(0.01), one, one)->px_s.x() == doctest::Approx(100.0));
  CHECK_FALSE(meter.add(1, 3, time_at(0.03), zero, zero));  // frame 2 did not show it
  CHECK_FALSE(meter.add(0, 4, time_at(0.04), zero, zero));  // another fiducial
  CHECK_FALSE(meter.add(1, 4, time_at(0.03), one, one));    // time stood still
}
