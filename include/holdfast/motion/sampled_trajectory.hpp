/// A recording as a motion: position linear and rotation at a constant rate between neighbouring samples.
///
/// Between two samples v_WB and w_WB_B are constant and a_WB and alpha_WB_B are zero, which is consistent with the
/// path; at a sample they jump, and the later interval's are returned. For smooth derivatives see
/// spline_trajectory.hpp. Precondition: at least one sample, times strictly increasing (what io/trajectory.hpp
/// returns). One sample is a still head.
#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/motion/timed_pose.hpp>

namespace holdfast {

class SampledTrajectory : public Motion {
 public:
  explicit SampledTrajectory(std::vector<TimedPose> samples) : samples_(std::move(samples)) {
    HOLDFAST_ASSERT(!samples_.empty(), "a trajectory needs a sample");
    HOLDFAST_ASSERT(std::ranges::adjacent_find(samples_, std::greater_equal<>(), &TimedPose::t) == samples_.end(),
                    "times of a trajectory must strictly increase");
  }

  [[nodiscard]] MotionState at(HostTime t) const override {
    MotionState state;
    state.t = clamped(t);
    if (samples_.size() == 1) {
      state.X_WB = samples_.front().X_WB;
      return state;
    }
    const auto after = std::ranges::upper_bound(samples_, state.t, {}, &TimedPose::t);
    const auto newer = after == samples_.end() ? after - 1 : after;
    const TimedPose& a = *(newer - 1);
    const TimedPose& b = *newer;
    const double dt = to_seconds(b.t - a.t);
    state.X_WB = interpolate(a.X_WB, b.X_WB, to_seconds(state.t - a.t) / dt);
    state.v_WB = (b.X_WB.p() - a.X_WB.p()) / dt;
    state.w_WB_B = so3::log<double>(a.X_WB.q().conjugate() * b.X_WB.q()) / dt;
    return state;
  }
  [[nodiscard]] HostTime begin() const override { return samples_.front().t; }
  [[nodiscard]] HostTime end() const override { return samples_.back().t; }

  [[nodiscard]] const std::vector<TimedPose>& samples() const { return samples_; }

 private:
  std::vector<TimedPose> samples_;
};

/// Poses of a motion every `interval` from its begin on, the last at or before its end. Precondition: interval > 0.
[[nodiscard]] inline std::vector<TimedPose> sample(const Motion& motion, Duration interval) {
  HOLDFAST_ASSERT(interval > Duration(0), "a sampling interval must be positive");
  std::vector<TimedPose> samples;
  samples.reserve(static_cast<std::size_t>(motion.duration() / interval) + 1);
  for (HostTime t = motion.begin(); t <= motion.end(); t += interval) samples.push_back({t, motion.at(t).X_WB});
  return samples;
}

/// Median of the intervals between samples; zero with fewer than two.
[[nodiscard]] inline Duration median_interval(std::span<const TimedPose> samples) {
  if (samples.size() < 2) return Duration(0);
  std::vector<Duration> intervals(samples.size() - 1);
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) intervals[i] = samples[i + 1].t - samples[i].t;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  return *middle;
}

}  // namespace holdfast
