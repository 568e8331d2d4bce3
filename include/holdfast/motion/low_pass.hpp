/// Non-causal low-pass filter without phase delay, for recordings that serve as truth.
///
/// A second-order Butterworth filter (bilinear transform, frequency prewarped) runs over the samples forward and then
/// backward, which cancels its phase and squares its gain. Its corner is moved so that both passes together have gain
/// 1/sqrt(2) at cutoff_hz:
///   gain(f) = 1 / (1 + (tan(pi f / fs) / w)^4),   w = tan(pi cutoff / fs) / (sqrt(2) - 1)^(1/4),   fs the sampling
///   rate.
/// Ends are continued by reflection through the end sample (three cut-off periods), so that they neither jump nor
/// droop. Orientations are filtered as quaternion components with agreeing signs and normalised, as Azuma & Bishop did
/// with theirs (10 Hz: 001 appendix B).
///
/// Rates: where intervals differ from their median by more than 1 %, the poses are resampled evenly at the median
/// interval by a spline (spline_trajectory.hpp), filtered, and resampled by another at the original times. Gaps (longer
/// than five medians) are not bridged: each stretch between them is filtered by itself. Precondition: times strictly
/// increase. A cut-off that is not positive or not below half the rate leaves the samples as they are.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include <holdfast/motion/spline_trajectory.hpp>

namespace holdfast {

namespace detail {

/// Coefficients of y[i] = b0 x[i] + b1 x[i-1] + b2 x[i-2] - a1 y[i-1] - a2 y[i-2].
struct Biquad {
  double b0, b1, b2, a1, a2;

  /// Butterworth of second order with its -3 dB corner where tan(pi f / fs) = w.
  [[nodiscard]] static Biquad low_pass(double w) {
    const double scale = 1.0 / (1.0 + std::numbers::sqrt2 * w + w * w);
    const double b = w * w * scale;
    return {b, 2.0 * b, b, 2.0 * (w * w - 1.0) * scale, (1.0 - std::numbers::sqrt2 * w + w * w) * scale};
  }

  /// One pass in place, as if the first value had stood for ever before.
  template <typename Iterator>
  void run(Iterator first, Iterator last) const {
    if (first == last) return;
    Vector7 x1 = *first, x2 = x1, y1 = x1, y2 = x1;
    for (; first != last; ++first) {
      const Vector7 x = *first;
      const Vector7 y = b0 * x + b1 * x1 + b2 * x2 - a1 * y1 - a2 * y2;
      x2 = x1;
      x1 = x;
      y2 = y1;
      y1 = y;
      *first = y;
    }
  }
};

/// Filters evenly spaced values forward and backward, continued at both ends by reflection through the end value.
inline void filter_both_ways(std::vector<Vector7>& values, double cutoff_over_rate) {
  const std::size_t n = values.size();
  if (n < 2) return;
  const double w = std::tan(std::numbers::pi * cutoff_over_rate) / std::pow(std::numbers::sqrt2 - 1.0, 0.25);
  const Biquad filter = Biquad::low_pass(w);
  const auto pad = std::min(n - 1, static_cast<std::size_t>(std::ceil(std::min(3.0 / cutoff_over_rate, 1e9))));
  std::vector<Vector7> padded;
  padded.reserve(n + 2 * pad);
  for (std::size_t k = pad; k > 0; --k) padded.push_back(2.0 * values.front() - values[k]);
  padded.insert(padded.end(), values.begin(), values.end());
  for (std::size_t k = 1; k <= pad; ++k) padded.push_back(2.0 * values.back() - values[n - 1 - k]);
  filter.run(padded.begin(), padded.end());
  filter.run(padded.rbegin(), padded.rend());
  std::copy_n(padded.begin() + static_cast<std::ptrdiff_t>(pad), n, values.begin());
}

/// Filters evenly spaced poses.
inline void filter_even(std::span<TimedPose> poses, double cutoff_over_rate) {
  std::vector<Vector7> values(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Quaternion& q = poses[i].X_WB.q();
    values[i] << poses[i].X_WB.p(), q.x(), q.y(), q.z(), q.w();
    if (i > 0 && values[i].tail<4>().dot(values[i - 1].tail<4>()) < 0.0) values[i].tail<4>() = -values[i].tail<4>();
  }
  filter_both_ways(values, cutoff_over_rate);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector7& y = values[i];
    poses[i].X_WB = Rigid(Quaternion(y[6], y[3], y[4], y[5]), y.head<3>());
  }
}

[[nodiscard]] inline bool evenly_spaced(std::span<const TimedPose> poses, Duration interval) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (std::chrono::abs(poses[i].t - poses[i - 1].t - interval) > interval / 100) return false;
  }
  return true;
}

/// Filters one stretch without gaps.
inline void filter_stretch(std::span<TimedPose> stretch, Duration interval, double cutoff_hz) {
  if (stretch.size() < 3) return;
  const double cutoff_over_rate = cutoff_hz * to_seconds(interval);
  if (evenly_spaced(stretch, interval)) return filter_even(stretch, cutoff_over_rate);

  const Duration length = stretch.back().t - stretch.front().t;
  const auto count = static_cast<std::int64_t>(std::ceil(to_seconds(length) / to_seconds(interval))) + 1;
  std::vector<TimedPose> even(static_cast<std::size_t>(count));
  const SplineTrajectory original(stretch);
  for (std::int64_t i = 0; i < count; ++i) {
    const HostTime t =
        stretch.front().t + Duration(length.count() / (count - 1) * i + length.count() % (count - 1) * i / (count - 1));
    even[static_cast<std::size_t>(i)] = {t, original.at(t).X_WB};
  }
  filter_even(even, cutoff_over_rate);
  const SplineTrajectory filtered(even);
  for (TimedPose& pose : stretch) pose.X_WB = filtered.at(pose.t).X_WB;
}

}  // namespace detail

[[nodiscard]] inline std::vector<TimedPose> zero_phase_low_pass(std::span<const TimedPose> samples, double cutoff_hz) {
  std::vector<TimedPose> filtered(samples.begin(), samples.end());
  const Duration interval = median_interval(samples);
  const double cutoff_over_rate = cutoff_hz * to_seconds(interval);
  if (!(cutoff_over_rate > 0.0 && cutoff_over_rate < 0.5)) return filtered;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= filtered.size(); ++i) {
    if (i < filtered.size() && filtered[i].t - filtered[i - 1].t <= 5 * interval) continue;
    detail::filter_stretch(std::span(filtered).subspan(first, i - first), interval, cutoff_hz);
    first = i;
  }
  return filtered;
}

}  // namespace holdfast
