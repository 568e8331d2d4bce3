#include <algorithm>
#include <span>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/registration/overshoot.hpp>

using namespace holdfast;

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
