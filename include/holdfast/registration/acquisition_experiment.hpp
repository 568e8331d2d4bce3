/// Acquisition by ranges (tracking/range_acquisition.hpp) judged by simulation: how often, how well, and never wrongly.
///
/// A head stands at random places under a square array whose beacons have codes drawn at random: `codes` of them, each in many
/// places. Of beacons with one code a receiver hears the nearest. Errors are those of an installation
/// (simulation/ultrasonic_range.hpp), new in each trial, and `wrong` of the ranges are echoes or early pulses. The vertical is
/// known to half a degree, heading is not.
/// Random numbers belong to the seed. Preconditions: trials and codes above zero.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/registration/three_point_error.hpp>
#include <holdfast/simulation/ultrasonic_range.hpp>
#include <holdfast/tracking/range_acquisition.hpp>

namespace holdfast {

struct AcquisitionTrials {
  int trials = 40;
  int codes = 8;       ///< 003 has eight, and plans for sixteen
  double wrong = 0.0;  ///< share of ranges
  UltrasonicErrors errors = table_1_errors();
  std::vector<RangeReceiver> receivers = camera_receivers();
  RangeAcquisitionSettings settings;
  std::uint64_t seed = 1;
};

struct AcquisitionRow {
  int trials = 0, acquired = 0, ambiguous = 0;
  int false_poses = 0;       ///< of those acquired: more than 5 cm or 5 degrees off
  int no_pose = 0;           ///< the ranges contradict each other, or are too few
  double position_mm = 0.0;  ///< mean error of those that are not false
  double angle_deg = 0.0;
  RmsAndPeak position, angle;  ///< m and rad, of the same
  double ranges = 0.0;         ///< mean number that is heard
  double tuples = 0.0;         ///< mean number of 4-tuples of codes that were tried
  double milliseconds = 0.0;   ///< mean time of one thread on the machine at hand
};

namespace detail {

[[nodiscard]] inline std::vector<CodedRange> first_arrivals(const ConstellationRig& rig,
                                                            const UltrasonicDevices& devices, const Rigid& X_WB,
                                                            const AcquisitionTrials& trials, std::int64_t trial) {
  std::vector<CodedRange> heard;
  for (int k = 0; k < static_cast<int>(rig.receivers.size()); ++k) {
    const RangeReceiver& receiver = rig.receivers[static_cast<std::size_t>(k)];
    const Vector3 p_W = X_WB * receiver.p_B, axis_W = X_WB.q() * receiver.axis_B;
    for (int code = 0; code < trials.codes; ++code) {
      double nearest_m = range_reach_m;
      KeyedNumbers numbers(trials.seed, {trial, k, code});
      for (std::size_t i = 0; i < rig.beacons.size(); ++i) {
        if (rig.beacons[i].code != code) continue;
        const TransducerPair pair(devices.beacons_W[i], rig.beacons[i].axis_W, p_W, axis_W);
        if (pair.in_reach()) nearest_m = std::min(nearest_m, devices.measured_m(pair, static_cast<int>(i), k));
      }
      if (nearest_m == range_reach_m) continue;
      nearest_m *= 1.0 + range_noise_per_m * numbers.normal_pair().x();
      const double fate = numbers.uniform(), by = numbers.uniform();
      if (fate < 0.5 * trials.wrong) nearest_m += 0.1 + 1.4 * by;
      if (fate >= 0.5 * trials.wrong && fate < trials.wrong) nearest_m = 0.3 + by * std::max(0.0, nearest_m - 0.3);
      heard.push_back({k, code, nearest_m});
    }
  }
  return heard;
}

}  // namespace detail

[[nodiscard]] inline AcquisitionRow acquire_at_random(const AcquisitionTrials& trials) {
  using Clock = std::chrono::steady_clock;
  HOLDFAST_ASSERT(trials.trials > 0 && trials.codes > 0, "nothing to acquire");
  AcquisitionRow row;
  ConstellationRig rig{infinite_constellation(), trials.receivers};
  for (int trial = 0; trial < trials.trials; ++trial) {
    KeyedNumbers numbers(trials.seed, {trial});
    for (CodedBeacon& beacon : rig.beacons) beacon.code = numbers.below(trials.codes);
    const UltrasonicDevices devices(rig, trials.errors, trials.seed + static_cast<std::uint64_t>(trial));
    const auto within = [&](double low, double high) { return low + (high - low) * numbers.uniform(); };
    const Vector3 p_W(within(-1.5, 1.5), within(0.8, 2.0), within(-1.5, 1.5));
    const Vector2 tilt = degrees(10.0).radians() * numbers.normal_pair();
    const Rigid X_WB(so3::exp<double>(Vector3(tilt[0], 0.0, tilt[1])) *
                         so3::exp<double>(Vector3(0.0, within(-std::numbers::pi, std::numbers::pi), 0.0)),
                     p_W);
    const Vector2 off = degrees(0.5).radians() * numbers.normal_pair();
    const SeenDirection vertical{
        Vector3::UnitY(), X_WB.q().conjugate() * (so3::exp<double>(Vector3(off[0], 0.0, off[1])) * Vector3::UnitY()),
        degrees(0.5).radians()};
    const std::vector<CodedRange> heard = detail::first_arrivals(rig, devices, X_WB, trials, trial);
    const Clock::time_point begin = Clock::now();
    const RangeAcquisition found =
        acquire_by_ranges(rig.beacons, rig.receivers, heard, std::span(&vertical, 1), trials.settings);
    const std::chrono::duration<double, std::milli> spent = Clock::now() - begin;
    ++row.trials;
    row.milliseconds += spent.count() / trials.trials;
    row.ranges += static_cast<double>(heard.size()) / trials.trials;
    row.tuples += static_cast<double>(found.tuples_tried) / trials.trials;
    row.ambiguous += found.status == RangeAcquisitionStatus::ambiguous;
    row.no_pose += !found.ok() && found.status != RangeAcquisitionStatus::ambiguous;
    if (!found.ok()) continue;
    ++row.acquired;
    const double off_m = (found.X_WB.p() - X_WB.p()).norm();
    const double off_deg = so3::angle_between(found.X_WB.q(), X_WB.q()) / degrees(1.0).radians();
    if (off_m > 0.05 || off_deg > 5.0) {
      ++row.false_poses;
      continue;
    }
    row.position.add(off_m);
    row.angle.add(degrees(off_deg).radians());
    row.position_mm += 1000.0 * off_m;
    row.angle_deg += off_deg;
  }
  const int right = std::max(1, row.acquired - row.false_poses);
  row.position_mm /= right;
  row.angle_deg /= right;
  return row;
}

}  // namespace holdfast
