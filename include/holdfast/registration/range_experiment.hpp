/// How far off a body is that is tracked by a recording's ranges, one at a time (range_tracker.hpp).
///
/// The start is the true pose at the first reading, taken as known to `start_m` and `start_rad`, at rest. It matters:
/// biases are learnt relative to where the body takes itself to be, and the height hangs on biases more than on anything else
/// (the gauge freedom of 002 section 5.1.4).
/// Errors are of B's origin, after each range, counted or not, at the filter's own time, against the truth between its
/// two neighbouring samples; ranges outside the truth's times are not used at all.
/// Preconditions: at least one pose of truth, whose times increase; other times do not decrease; indices of anchors exist.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>
#include <holdfast/registration/range_tracker.hpp>
#include <holdfast/registration/range_types.hpp>
#include <holdfast/tracking/consistency.hpp>

namespace holdfast {

/// After each range: the reading, what became of it, the tracker, and the truth at the tracker's time.
struct RangeMoment {
  const RangeReading& reading;
  UpdateStatus status;
  const RangeTracker& tracker;
  Rigid X_WB;
};
using RangeObserver = std::function<void(const RangeMoment&)>;

namespace detail {

[[nodiscard]] inline TargetState<3> start_on_truth(const Motion& truth, HostTime t, const RangeSettings& settings) {
  TargetState<3> start;
  start.t = t;
  start.X_WB = truth.at(t).X_WB;
  const double v = settings.start_velocity * settings.start_velocity;
  start.P.setZero();
  start.P.diagonal() << Vector3::Constant(settings.start_m * settings.start_m),
      Vector3::Constant(settings.start_rad * settings.start_rad), Vector6::Constant(v), Vector6::Constant(v);
  return start;
}

inline void judge(RangeRow& row, const TargetState<3>& state, const Rigid& X_WB, const Vector3& up_W) {
  const Vector3 error = state.X_WB.p() - X_WB.p();
  const double height = error.dot(up_W);
  row.three_point.add(state.X_WB, X_WB);
  row.position.add(error.norm());
  row.height.add(std::abs(height));
  row.horizontal.add((error - height * up_W).norm());
  row.angle.add(so3::angle_between(state.X_WB.q(), X_WB.q()));
}

/// e^T P^-1 e of the position alone.
[[nodiscard]] inline double position_nees(const TargetState<3>& state, const Rigid& X_WB) {
  const Vector3 error = state.X_WB.p() - X_WB.p();
  return normalised_square<3>(error, state.P.topLeftCorner<3, 3>()).value_or(std::nan(""));
}

}  // namespace detail

/// One variant over a recording.
[[nodiscard]] inline RangeRow track_ranges(const RangeRecording& recording, const RangeVariant& variant,
                                           const RangeSettings& settings, const RangeObserver& observe = {}) {
  using Clock = std::chrono::steady_clock;
  HOLDFAST_ASSERT(!recording.truth.empty(), "nothing to judge a track by");
  const SampledTrajectory truth(recording.truth);
  RangeRow row;
  row.variant = variant;
  Clock::duration spent{};
  ConsistencyMean nis(1), nees(3);
  std::optional<RangeTracker> tracker;
  const auto started = [&](HostTime t) {
    if (t < truth.begin()) return false;
    if (!tracker) {
      tracker.emplace(detail::start_on_truth(truth, t, settings), recording.anchors, variant, settings);
    }
    return true;
  };
  auto inertial = recording.inertial.begin();
  for (const RangeReading& range : recording.ranges) {
    if (range.t > truth.end()) break;
    const Clock::time_point begin = Clock::now();
    for (; inertial != recording.inertial.end() && inertial->t <= range.t; ++inertial) {
      if (started(inertial->t)) tracker->add(*inertial);
    }
    if (!started(range.t)) continue;
    const UpdateStatus status = tracker->add(range);
    spent += Clock::now() - begin;
    ++row.ranges;
    if (status == UpdateStatus::updated) ++row.accepted;
    if (status == UpdateStatus::gated || status == UpdateStatus::on_probation) ++row.gated;
    const TargetState<3>& state = tracker->state();
    const Rigid X_WB = truth.at(state.t).X_WB;
    detail::judge(row, state, X_WB, settings.up_W);
    nis.add(tracker->nis());
    nees.add(detail::position_nees(state, X_WB));
    if (observe) observe({range, status, *tracker, X_WB});
  }
  if (!tracker) return row;
  row.refused = static_cast<long>(tracker->counters().total() - tracker->counters()[UpdateStatus::updated]);
  row.microseconds_per_range =
      std::chrono::duration<double, std::micro>(spent).count() / static_cast<double>(std::max(1L, row.ranges));
  row.nis = nis.mean() / nis.expected();
  row.position_nees = nees.mean() / nees.expected();
  if (variant.bias_states) {
    for (int i = 0; i < tracker->biases().size(); ++i) row.biases_m.push_back(tracker->biases().at(i).x[0]);
  }
  return row;
}

}  // namespace holdfast
