/// Makes a recording fit for calibration: leaves out what cannot be used, and names it.
///
///   poses      not finite; not later than the one before
///   readings   not later than the one before ("time goes back")
///   an axis    missing (not a number), dead (zero) or stuck (one value) nearly always: the axis is left out altogether
///   some time  not a number, stuck while its neighbours change, saturated (held at its largest value): those readings are left out
/// What is left has gaps; a comparison that would reach across one is not made.
/// Bad input: anything. `problem` says why nothing can be calibrated; `notes` what was left out.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <holdfast/calibration/inertial_signal.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

/// Readings of one triad that can be used.
struct CheckedTriad {
  std::array<bool, 3> has_axis{true, true, true};
  std::vector<char> usable;  ///< of each checked reading

  [[nodiscard]] bool complete() const { return has_axis[0] && has_axis[1] && has_axis[2]; }
  [[nodiscard]] bool any() const { return has_axis[0] || has_axis[1] || has_axis[2]; }
};

struct CheckedRecording {
  std::vector<TimedPose> poses;
  std::vector<InertialReading> readings;  ///< times strictly increasing
  CheckedTriad gyro, accelerometer;
  double longest_interval_s = 0.0;  ///< between readings; above it is a gap
  std::string problem;
  std::vector<std::string> notes;
};

namespace detail {

[[nodiscard]] inline std::string said(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// Checks one triad's three channels.
class TriadCheck {
 public:
  TriadCheck(const std::vector<InertialReading>& readings, Vector3 InertialReading::*channel, std::string name,
             std::vector<std::string>& notes)
      : readings_(&readings), channel_(channel), name_(std::move(name)), notes_(&notes) {
    triad_.usable.assign(readings.size(), 1);
  }

  CheckedTriad run() {
    for (int axis = 0; axis < 3; ++axis) check_whole_axis(axis);
    for (int axis = 0; axis < 3; ++axis) {
      if (!triad_.has_axis[static_cast<std::size_t>(axis)]) continue;
      leave_out_missing(axis);
      leave_out_held(axis);
    }
    return triad_;
  }

 private:
  [[nodiscard]] double value(std::size_t i, int axis) const { return ((*readings_)[i].*channel_)[axis]; }
  [[nodiscard]] double time(std::size_t i) const { return to_seconds((*readings_)[i].t - readings_->front().t); }
  void note(int axis, const std::string& what) const { notes_->push_back(name_ + " " + "xyz"[axis] + " " + what); }

  void check_whole_axis(int axis) {
    std::size_t finite = 0, held = 0;
    double last = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < readings_->size(); ++i) {
      const double z = value(i, axis);
      if (!std::isfinite(z)) continue;
      ++finite;
      if (z == last) ++held;
      last = z;
    }
    bool& has = triad_.has_axis[static_cast<std::size_t>(axis)];
    if (10 * finite < readings_->size()) {
      has = false;
      note(axis, "is missing: not a number");
    } else if (10 * held > 9 * finite) {
      has = false;
      note(axis, last == 0.0 ? "is dead: always zero" : said("is stuck at %g", last));
    }
  }

  void leave_out_missing(int axis) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < readings_->size(); ++i) {
      if (std::isfinite(value(i, axis))) continue;
      triad_.usable[i] = 0;
      ++count;
    }
    if (count > 0) note(axis, said("is not a number in %zu readings", count));
  }

  /// Runs of one value: at the largest of all, saturated; long ones while neighbours change, stuck.
  void leave_out_held(int axis) {
    double largest = 0.0;
    for (std::size_t i = 0; i < readings_->size(); ++i) {
      const double z = std::abs(value(i, axis));
      if (std::isfinite(z)) largest = std::max(largest, z);
    }
    std::size_t saturated = 0, stuck = 0, begin = 0;
    for (std::size_t i = 1; i <= readings_->size(); ++i) {
      if (i < readings_->size() && value(i, axis) == value(begin, axis)) continue;
      const bool at_end = std::abs(value(begin, axis)) == largest && largest > 0.0;
      const bool is_saturated = at_end && i - begin >= 3;
      const bool is_stuck = !is_saturated && time(i - 1) - time(begin) > 0.5 && neighbours_change(axis, begin, i);
      if (is_saturated || is_stuck) {
        (is_saturated ? saturated : stuck) += i - begin;
        std::fill(triad_.usable.begin() + static_cast<std::ptrdiff_t>(begin),
                  triad_.usable.begin() + static_cast<std::ptrdiff_t>(i), char(0));
      }
      begin = i;
    }
    if (saturated > 0) note(axis, said("is saturated at %g in %zu readings", largest, saturated));
    if (stuck > 0) note(axis, said("is stuck in %zu readings", stuck));
  }

  [[nodiscard]] bool neighbours_change(int axis, std::size_t begin, std::size_t end) const {
    int changes = 0;
    for (std::size_t i = begin + 1; i < end; ++i) {
      changes += value(i, (axis + 1) % 3) != value(i - 1, (axis + 1) % 3) ? 1 : 0;
      changes += value(i, (axis + 2) % 3) != value(i - 1, (axis + 2) % 3) ? 1 : 0;
    }
    return changes > 20;
  }

  const std::vector<InertialReading>* readings_;
  Vector3 InertialReading::*channel_;
  std::string name_;
  std::vector<std::string>* notes_;
  CheckedTriad triad_;
};

}  // namespace detail

[[nodiscard]] inline CheckedRecording check_recording(std::span<const TimedPose> poses,
                                                      std::span<const InertialReading> readings) {
  CheckedRecording checked;
  std::size_t bad_poses = 0, back = 0;
  for (const TimedPose& pose : poses) {
    const bool goes_on = checked.poses.empty() || pose.t > checked.poses.back().t;
    if (goes_on && pose.X_WB.is_finite()) {
      checked.poses.push_back(pose);
    } else {
      ++bad_poses;
    }
  }
  if (bad_poses > 0) {
    checked.notes.push_back(detail::said("%zu poses are not finite or not later than the one before", bad_poses));
  }
  for (const InertialReading& reading : readings) {
    if (checked.readings.empty() || reading.t > checked.readings.back().t) {
      checked.readings.push_back(reading);
      continue;
    }
    if (back++ == 0) {
      checked.notes.push_back(detail::said("the readings' time goes back after %.3f s",
                                           to_seconds(checked.readings.back().t - checked.readings.front().t)));
    }
  }
  if (back > 0) checked.notes.push_back(detail::said("%zu readings are not later than one before", back));
  if (checked.poses.size() < 3) checked.problem = "too few poses";
  if (checked.readings.size() < 3) checked.problem = "too few readings";
  if (!checked.problem.empty()) return checked;

  const double from = to_seconds(checked.readings.front().t - checked.poses.front().t);
  const double to = to_seconds(checked.readings.back().t - checked.poses.front().t);
  const double end = to_seconds(checked.poses.back().t - checked.poses.front().t);
  if (to < 0.0 || from > end) {
    checked.problem =
        detail::said("times do not overlap: poses last from 0 to %.3f s, readings from %.3f to %.3f s", end, from, to);
    return checked;
  }
  std::vector<Duration> intervals;
  for (std::size_t i = 1; i < checked.readings.size(); ++i) {
    intervals.push_back(checked.readings[i].t - checked.readings[i - 1].t);
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  checked.longest_interval_s = std::max(5.0 * to_seconds(*middle), 0.025);
  checked.gyro = detail::TriadCheck(checked.readings, &InertialReading::rate_B, "gyro", checked.notes).run();
  checked.accelerometer =
      detail::TriadCheck(checked.readings, &InertialReading::force_B, "accelerometer", checked.notes).run();
  return checked;
}

/// The channel's usable readings as a signal; axes that are left out are zero. Nothing with fewer than two.
[[nodiscard]] inline std::optional<SensorSignal> signal_of(const CheckedRecording& checked,
                                                           Vector3 InertialReading::*channel, const CheckedTriad& triad,
                                                           const std::vector<char>& also_usable) {
  std::vector<double> t;
  std::vector<Vector3> z;
  for (std::size_t i = 0; i < checked.readings.size(); ++i) {
    if (triad.usable[i] == 0 || also_usable[i] == 0) continue;
    Vector3 said = checked.readings[i].*channel;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!triad.has_axis[axis]) said[static_cast<int>(axis)] = 0.0;
    }
    t.push_back(to_seconds(checked.readings[i].t - checked.poses.front().t));
    z.push_back(said);
  }
  if (t.size() < 2) return std::nullopt;
  return SensorSignal(std::move(t), std::move(z), checked.longest_interval_s);
}

}  // namespace holdfast
