/// Runs the Constellation tracker (range_aided_ins.hpp) over a motion, under simulated beacons, and says how far off it was.
///
/// It starts at a pose that errs like an acquired one: 5 mm and 1 deg on each axis. Errors count from `settle` on: at each
/// reading the pose that goes out against the truth of that time. What a user sees is judged apart: `shown` samples the newest
/// pose at times of its own, so that effective latency holds the wait for the next reading as well as the unit's lag.
/// NEES is that of position and orientation at every 100th reading, NIS that of every range which the gate let in (it cuts the
/// tail off: 0.99 is expected at 99.9 %), each per degree of freedom: 1 is consistent, above is too sure. One installation's
/// errors stay the same for a whole run, so that its NEES says little: judge the mean of several seeds.
/// What was turned away is counted by what it was: a good range, an echo, an early pulse.
/// `range_microseconds` and `reading_nanoseconds` are times of one thread on the machine at hand.
/// The case says what is wrong; a case's random numbers belong to its seed. Units are in the names.
/// Bad input: a motion shorter than `settle` gives figures of nothing: zeros.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <holdfast/registration/three_point_error.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/simulation/ultrasonic_ranging.hpp>
#include <holdfast/tracking/consistency.hpp>
#include <holdfast/tracking/range_aided_ins.hpp>

namespace holdfast {

struct ConstellationCase {
  std::string name;
  ConstellationRig rig;
  UltrasonicErrors errors;
  RangingOptions ranging;
  InertialUnit unit = mems_inertial_unit();
  bool has_inertial = true;
  /// Changes the readings: what goes wrong with the unit (inertial_faults.hpp).
  std::function<void(std::vector<InertialReading>&)> spoil;
  /// From `at` on readings are stamped as much later, or earlier.
  struct ClockJump {
    HostTime at;
    Duration by{0};
  } clock_jump;
  /// Gravity, the unit's place and its ranges are taken from `unit`.
  RangeAidedInsSettings settings;
  Duration settle = std::chrono::seconds(2);
  std::uint64_t seed = 1;
};

struct RangesByCause {
  long good = 0, echo = 0, early = 0;

  void add(RangingFault fault) { ++(fault == RangingFault::none ? good : fault == RangingFault::echo ? echo : early); }
  [[nodiscard]] long all() const { return good + echo + early; }
};

struct ConstellationRow {
  std::string name;
  ThreePointError three_point;             ///< m; points 1 m ahead are those of three_point_error.hpp
  RmsAndPeak position;                     ///< m
  RmsAndPeak angle;                        ///< rad
  Vector3 mean_error_W = Vector3::Zero();  ///< of position, m
  long readings = 0, ranges = 0, accepted = 0, gated = 0;
  RangesByCause heard, turned_away;
  long corrupt = 0;           ///< ranges that were echoes or early
  long corrupt_accepted = 0;  ///< of these, how many passed the gate
  double range_microseconds = 0.0, reading_nanoseconds = 0.0;
  double nees = std::numeric_limits<double>::quiet_NaN();
  double nis = std::numeric_limits<double>::quiet_NaN();
  std::vector<TimedPose> shown;  ///< what a display saw, every 4.3 ms
  bool finite = true;            ///< no pose was not a number
  bool lost = false;             ///< at any time after settling
};

/// After a reading or range: the tracker, and the truth of its time.
struct ConstellationMoment {
  const RangeAidedIns& tracker;
  Rigid X_WB;
};
using ConstellationObserver = std::function<void(const ConstellationMoment&)>;

namespace detail {

[[nodiscard]] inline RangeAidedInsSettings settings_for(const ConstellationCase& c) {
  RangeAidedInsSettings settings = c.settings;
  settings.unit_B = c.unit.X_BS.p();
  settings.ranges = {c.unit.gyro.range, c.unit.accelerometer.range};
  if (!std::isfinite(settings.ranges.rate)) settings.ranges = InertialRanges();
  return settings;
}

/// The truth, off by 5 mm and 1 degree on each axis.
[[nodiscard]] inline TimedPose acquired_pose(const Motion& motion, std::uint64_t seed) {
  KeyedNumbers numbers(seed, {77});
  const Vector2 a = numbers.normal_pair(), b = numbers.normal_pair(), c = numbers.normal_pair();
  const Rigid X_WB = motion.at(motion.begin()).X_WB;
  const Vector3 turn = degrees(1.0).radians() * Vector3(a[0], a[1], b[0]);
  return {motion.begin(), Rigid(X_WB.q() * so3::exp<double>(turn), X_WB.p() + 0.005 * Vector3(b[1], c[0], c[1]))};
}

/// Judges the tracker as it goes.
class ConstellationJudge {
 public:
  ConstellationJudge(const Motion& motion, const ConstellationCase& c, ConstellationRow& row)
      : motion_(&motion), from_(motion.begin() + c.settle), row_(&row) {}

  void after_reading(const RangeAidedIns& tracker) {
    const TimedPose pose = tracker.pose();
    row_->finite = row_->finite && pose.X_WB.is_finite() && tracker.covariance().allFinite();
    if (pose.t < from_) return;
    const Rigid X_WB = motion_->at(pose.t).X_WB;
    row_->three_point.add(pose.X_WB, X_WB);
    row_->position.add((pose.X_WB.p() - X_WB.p()).norm());
    row_->angle.add(so3::angle_between(pose.X_WB.q(), X_WB.q()));
    row_->mean_error_W += pose.X_WB.p() - X_WB.p();
    row_->lost = row_->lost || tracker.gate().lost();
    if (row_->position.count() % 100 == 1) {
      const PoseEstimate estimate = tracker.estimate();
      Vector6 d;
      d << X_WB.p() - pose.X_WB.p(), so3::log<double>(pose.X_WB.q().conjugate() * X_WB.q());
      nees_.add(normalised_square<6>(d, estimate.pose_covariance()));
    }
  }
  /// Shows the newest pose at the times up to t.
  void show_until(HostTime t, const RangeAidedIns& tracker) {
    for (; next_shown_ < t; next_shown_ += std::chrono::microseconds(4300)) {
      if (next_shown_ >= from_) row_->shown.push_back({next_shown_, tracker.pose().X_WB});
    }
  }
  void begin_showing(HostTime t) { next_shown_ = t; }
  void after_range(const RangeAidedIns& tracker, const SimulatedRange& heard, RangeUpdate update) {
    ++row_->ranges;
    row_->accepted += update == RangeUpdate::accepted;
    row_->gated += update == RangeUpdate::gated;
    row_->heard.add(heard.fault);
    if (update == RangeUpdate::gated) row_->turned_away.add(heard.fault);
    row_->corrupt += heard.fault != RangingFault::none;
    row_->corrupt_accepted += heard.fault != RangingFault::none && update == RangeUpdate::accepted;
    if (heard.range.t >= from_ && update == RangeUpdate::accepted) nis_.add(tracker.nis());
  }
  void finish() {
    row_->nees = nees_.mean() / nees_.expected();
    row_->nis = nis_.mean();
    if (row_->position.count() > 0) row_->mean_error_W /= static_cast<double>(row_->position.count());
  }

 private:
  const Motion* motion_;
  HostTime from_, next_shown_;
  ConstellationRow* row_;
  ConsistencyMean nees_{6}, nis_{1};
};

}  // namespace detail

[[nodiscard]] inline ConstellationRow run_constellation(const ConstellationCase& c, const Motion& motion,
                                                        const ConstellationObserver& observe = {}) {
  using Clock = std::chrono::steady_clock;
  ConstellationRow row;
  row.name = c.name;
  const UltrasonicDevices devices(c.rig, c.errors, c.seed);
  RangingOptions ranging = c.ranging;
  ranging.seed = c.seed;
  const std::vector<SimulatedRange> ranges = ultrasonic_stream(motion, c.rig, devices, ranging);
  std::vector<InertialReading> readings;
  if (c.has_inertial) readings = inertial_stream(motion, c.unit, c.seed);
  if (c.spoil) c.spoil(readings);

  RangeAidedIns tracker(c.rig.beacons, c.rig.receivers, detail::settings_for(c));
  tracker.start(detail::acquired_pose(motion, c.seed), {0.005, degrees(1.0).radians()});
  detail::ConstellationJudge judge(motion, c, row);
  judge.begin_showing(motion.begin());
  Clock::duration in_readings{}, in_ranges{};
  std::size_t next = 0;
  const auto take_range = [&] {
    judge.show_until(ranges[next].range.t, tracker);
    const Clock::time_point begin = Clock::now();
    const RangeUpdate update = tracker.update(ranges[next].range);
    in_ranges += Clock::now() - begin;
    judge.after_range(tracker, ranges[next], update);
    if (!c.has_inertial) judge.after_reading(tracker);
    if (observe) observe({tracker, motion.at(tracker.pose().t).X_WB});
    ++next;
  };
  for (const InertialReading& reading : readings) {
    while (next < ranges.size() && ranges[next].range.t < reading.t) take_range();
    judge.show_until(reading.t, tracker);
    InertialReading stamped = reading;
    if (reading.t >= c.clock_jump.at) stamped.t += c.clock_jump.by;
    const Clock::time_point begin = Clock::now();
    tracker.update(stamped);
    in_readings += Clock::now() - begin;
    judge.after_reading(tracker);
    if (observe) observe({tracker, motion.at(tracker.pose().t).X_WB});
  }
  while (next < ranges.size()) take_range();
  row.readings = static_cast<long>(readings.size());
  const auto mean = [](Clock::duration spent, long n, double unit) {
    return n > 0 ? std::chrono::duration<double>(spent).count() / unit / static_cast<double>(n) : 0.0;
  };
  row.range_microseconds = mean(in_ranges, row.ranges, 1e-6);
  row.reading_nanoseconds = mean(in_readings, row.readings, 1e-9);
  judge.finish();
  return row;
}

}  // namespace holdfast
