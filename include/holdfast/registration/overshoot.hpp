/// Overshoot: how far the picture goes on, or lags behind, after the head has stopped.
///
/// The head stops at the first frame from which on it turns slower than 1 deg/s up to the end (0.1 s of it at least),
/// after having turned faster than 10 deg/s. From that frame on the orientation error's part about the axis of the last
/// movement is followed, in its direction positive; the overshoot is its value of largest size: positive when the
/// picture went past the head's final orientation, negative when it still came up to it. In percent: of the angle of
/// the last movement. Source: evaluation.md "Metrics" and value 11. Bad input: a motion without such a stop has no
/// overshoot: nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// One frame: the true orientation and rate, and the displayed orientation.
struct TurnSample {
  HostTime t;
  Quaternion q_WH_true, q_WH_displayed;
  Vector3 w_WH_H;  ///< rad/s
};

struct Overshoot {
  double arcmin = 0.0;
  double pct = 0.0;
  HostTime stopped;
};

[[nodiscard]] inline std::optional<Overshoot> overshoot(std::span<const TurnSample> frames) {
  constexpr double still = 1.0 / degrees_per_rad, moving = 10.0 / degrees_per_rad;
  const auto rate = [&](std::size_t i) { return frames[i].w_WH_H.norm(); };
  std::size_t stop = frames.size();
  while (stop > 0 && rate(stop - 1) < still) --stop;
  if (stop == 0 || stop == frames.size()) return std::nullopt;
  if (to_seconds(frames.back().t - frames[stop].t) < 0.1) return std::nullopt;
  std::size_t start = stop;
  double fastest = 0.0;
  for (; start > 0 && rate(start - 1) >= still; --start) fastest = std::max(fastest, rate(start - 1));
  if (fastest < moving) return std::nullopt;

  const TurnSample& last = frames[stop - 1];
  const Vector3 axis_W = (last.q_WH_true * last.w_WH_H).normalized();
  const Quaternion& q_before = frames[start > 0 ? start - 1 : 0].q_WH_true;
  const double turned = so3::angle_between<double>(q_before, frames[stop].q_WH_true);
  Overshoot result;
  result.stopped = frames[stop].t;
  for (std::size_t i = stop; i < frames.size(); ++i) {
    const Vector3 error_W = so3::log<double>(frames[i].q_WH_displayed * frames[i].q_WH_true.conjugate());
    const double arcmin = axis_W.dot(error_W) * arcmin_per_rad;
    if (std::abs(arcmin) > std::abs(result.arcmin)) result.arcmin = arcmin;
  }
  result.pct = turned > 0.0 ? 100.0 * result.arcmin / (turned * arcmin_per_rad) : 0.0;
  return result;
}

}  // namespace holdfast
