#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/low_pass.hpp>

using namespace holdfast;

namespace {

constexpr double pi = std::numbers::pi;

double yaw_of(const TimedPose& pose) {
  return so3::log<double>(pose.X_WB.q()).y();
}

/// Poses whose x (m) and yaw (rad) are amplitude * sin(2 pi hz t), at a mean of 120 Hz; uneven: intervals of 7 and 9.67
/// ms in turn.
std::vector<TimedPose> sine_poses(double hz, double amplitude, bool uneven) {
  std::vector<TimedPose> poses;
  for (int i = 0; i < 1200; ++i) {
    const double t = i / 120.0 + (uneven && i % 2 == 1 ? -0.0013 : 0.0);
    const double x = amplitude * std::sin(2 * pi * hz * t);
    const Vector3 phi(0, x, 0);
    poses.push_back({time_at(t), Rigid(so3::exp<double>(phi), Vector3(x, 0, 0))});
  }
  return poses;
}

/// Amplitude in phase and a quarter ahead, by correlation over the middle half (whole periods for hz a multiple of
/// 0.2).
template <typename Value>
std::pair<double, double> gain_of(const std::vector<TimedPose>& poses, double hz, double amplitude,
                                  const Value& value) {
  double ss = 0, cc = 0, sc = 0, sx = 0, cx = 0;
  for (std::size_t i = poses.size() / 4; i < 3 * poses.size() / 4; ++i) {
    const double t = to_seconds(poses[i].t.time_since_epoch());
    const double s = std::sin(2 * pi * hz * t), c = std::cos(2 * pi * hz * t), x = value(poses[i]);
    ss += s * s, cc += c * c, sc += s * c, sx += s * x, cx += c * x;
  }
  const double d = ss * cc - sc * sc;
  return {(sx * cc - cx * sc) / d / amplitude, (cx * ss - sx * sc) / d / amplitude};
}

}  // namespace

TEST_CASE("gain on sines is the formula's, with no phase, for position and orientation") {
  const double cutoff = 10.0, fs = 120.0, amplitude = 0.01;
  const double w = std::tan(pi * cutoff / fs) / std::pow(std::sqrt(2.0) - 1.0, 0.25);
  for (const double hz : {0.2, 1.0, 5.0, 10.0, 15.0, 20.0, 40.0}) {
    CAPTURE(hz);
    const double expected = 1.0 / (1.0 + std::pow(std::tan(pi * hz / fs) / w, 4));
    const auto filtered = zero_phase_low_pass(sine_poses(hz, amplitude, false), cutoff);
    const auto [gain_x, ahead_x] = gain_of(filtered, hz, amplitude, [](const TimedPose& p) { return p.X_WB.p().x(); });
    CHECK(gain_x == doctest::Approx(expected).epsilon(1e-6));  // times are whole nanoseconds
    CHECK(std::abs(ahead_x) < 1e-6);
    const auto [gain_q, ahead_q] = gain_of(filtered, hz, amplitude, yaw_of);
    CHECK(gain_q == doctest::Approx(expected).epsilon(1e-4));  // quaternion components: sine of half the angle, (A/2)^2
    CHECK(std::abs(ahead_q) < 1e-6);
    if (hz == cutoff) CHECK(gain_x == doctest::Approx(1 / std::sqrt(2.0)).epsilon(1e-6));
  }
}

TEST_CASE("uneven rates are resampled: the gain stays within half a percent, the phase at zero") {
  for (const double hz : {1.0, 5.0, 10.0}) {
    CAPTURE(hz);
    const double w = std::tan(pi * 10.0 / 120.0) / std::pow(std::sqrt(2.0) - 1.0, 0.25);
    const double expected = 1.0 / (1.0 + std::pow(std::tan(pi * hz / 120.0) / w, 4));
    // The median interval is one of 7.03 and 9.63 ms, so the filter's bilinear warping differs from 120 Hz's: 0.5 %.
    const auto filtered = zero_phase_low_pass(sine_poses(hz, 0.01, true), 10.0);
    const auto [gain, ahead] = gain_of(filtered, hz, 0.01, [](const TimedPose& p) { return p.X_WB.p().x(); });
    CHECK(gain == doctest::Approx(expected).epsilon(0.005));
    CHECK(std::abs(ahead) < 0.002);
  }
}

TEST_CASE("a constant and a ramp pass unchanged up to the ends") {
  std::vector<TimedPose> poses;
  for (int i = 0; i < 240; ++i)
    poses.push_back({time_at(i / 120.0), Rigid::translation(Vector3(3.0, 0.5 * i / 120.0, 0))});
  const auto filtered = zero_phase_low_pass(poses, 10.0);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CHECK(std::abs(filtered[i].X_WB.p().x() - 3.0) < 1e-12);
    // The padding continues the ramp for three cut-off periods (36 samples), which start-up transients do not outlast.
    CHECK(std::abs(filtered[i].X_WB.p().y() - poses[i].X_WB.p().y()) < 1e-6);
  }
}

TEST_CASE("gaps are not bridged, times are kept, and a cut-off above half the rate changes nothing") {
  auto poses = sine_poses(1.0, 0.01, false);
  for (std::size_t i = 600; i < poses.size(); ++i) {
    poses[i].t += std::chrono::seconds(2);
    poses[i].X_WB = Rigid::translation(Vector3(5, 0, 0));
  }
  const auto filtered = zero_phase_low_pass(poses, 10.0);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CHECK(filtered[i].t == poses[i].t);
    if (i >= 600) CHECK(std::abs(filtered[i].X_WB.p().x() - 5.0) < 1e-12);
    if (i < 600) CHECK(std::abs(filtered[i].X_WB.p().x()) < 0.011);
  }
  for (const double cutoff : {61.0, 1000.0, 0.0, -1.0}) {
    CHECK(zero_phase_low_pass(poses, cutoff)[17].X_WB.p() == poses[17].X_WB.p());
  }
  CHECK(zero_phase_low_pass({}, 10.0).empty());
}
