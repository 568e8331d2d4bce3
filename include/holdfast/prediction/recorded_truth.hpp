/// A recording as the truth that predictions are compared with: where the body was between its samples.
///
/// Where these come evenly, by the spline through them: of a recording at 30 Hz a straight line misses a tenth of a
/// millimetre and more. Where they do not (one interval 1.5 times another), linearly, at constant rate: a spline through
/// noisy samples of which two nearly coincide would swing.
/// What is interpolated is less noisy than the samples, if their noise is white: of its variance a straight line leaves
/// a^2 + b^2, with a and b the parts of both samples, and a cubic spline about 1 - a b.
/// Units: s. Bad input: precondition times that strictly increase, at least two samples, and times asked for within
/// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <holdfast/motion/sampled_trajectory.hpp>
#include <holdfast/motion/spline_trajectory.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

namespace holdfast::detail {

/// Finds, for times that mostly increase, the pose of a recording; remembers where it was.
class Walker {
 public:
  explicit Walker(std::span<const TimedPose> samples) : samples_(samples) {}

  /// Precondition: t within the samples' times. Quick where it is near the last one asked.
  [[nodiscard]] Rigid at(HostTime t) {
    while (next_ + 1 < samples_.size() && samples_[next_].t < t) ++next_;
    while (next_ > 1 && samples_[next_ - 1].t > t) --next_;
    const TimedPose& b = samples_[next_];
    if (b.t == t || next_ == 0) return b.X_WB;
    const TimedPose& a = samples_[next_ - 1];
    return interpolate(a.X_WB, b.X_WB, to_seconds(t - a.t) / to_seconds(b.t - a.t));
  }

 private:
  std::span<const TimedPose> samples_;
  std::size_t next_ = 1;
};

/// For each sample the time at which its stretch without gaps begins and ends.
struct Stretches {
  std::vector<HostTime> first, last;

  Stretches(std::span<const TimedPose> samples, Duration longest) : first(samples.size()), last(samples.size()) {
    const std::size_t n = samples.size();
    for (std::size_t i = 0; i < n; ++i) {
      first[i] = i > 0 && samples[i].t - samples[i - 1].t <= longest ? first[i - 1] : samples[i].t;
    }
    for (std::size_t i = n; i-- > 0;) {
      last[i] = i + 1 < n && samples[i + 1].t - samples[i].t <= longest ? last[i + 1] : samples[i].t;
    }
  }
};

/// Where the body was, and how much of the samples' noise is in that.
struct TrueMoment {
  Rigid X_WB;
  double noise_share = 1.0;  ///< of the variance

  [[nodiscard]] PoseNoise noisy(const PoseNoise& samples) const {
    const double part = std::sqrt(noise_share);
    return {part * samples.position_m, part * samples.orientation_rad};
  }
};

class RecordedTruth {
 public:
  explicit RecordedTruth(std::span<const TimedPose> samples) : samples_(samples), spline_(samples) {}

  [[nodiscard]] TrueMoment at(HostTime t) const {
    const auto after = std::ranges::lower_bound(samples_, t, {}, &TimedPose::t);
    if (after->t == t || after == samples_.begin()) return {after->X_WB, 1.0};
    const TimedPose &a = *(after - 1), &b = *after;
    const double s = to_seconds(t - a.t) / to_seconds(b.t - a.t);
    if (is_even(static_cast<std::size_t>(after - samples_.begin()))) return {spline_.at(t).X_WB, 1.0 - s * (1.0 - s)};
    return {interpolate(a.X_WB, b.X_WB, s), 1.0 - 2.0 * s * (1.0 - s)};
  }

 private:
  /// The interval that ends with the i-th sample, beside its neighbours.
  [[nodiscard]] bool is_even(std::size_t i) const {
    if (i < 2 || i + 1 >= samples_.size()) return false;
    const auto interval = [&](std::size_t k) { return samples_[k].t - samples_[k - 1].t; };
    const auto [shortest, longest] = std::minmax({interval(i - 1), interval(i), interval(i + 1)});
    return 2 * longest < 3 * shortest;
  }

  std::span<const TimedPose> samples_;
  SplineTrajectory spline_;
};

}  // namespace holdfast::detail
