/// Auto-mapping (tracking/beacon_mapping.hpp) judged by simulation: how far off new beacons end, and whether the mapper knows it.
///
/// A room has three seed beacons, at known places, and others that hang at random (003 section 5: "they need not be
/// coplanar"). A head walks about beneath; at first only the seed is fired, then all codes in turn. Errors of the ranging system are those of an installation
/// (simulation/ultrasonic_range.hpp); the seed defines the frame, so that beacons have no errors of place. Random numbers belong to
/// the case's seed.
/// Bad input: none of its own. Units are in the names.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include <holdfast/motion/head_curve.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/simulation/ultrasonic_ranging.hpp>
#include <holdfast/tracking/beacon_mapping.hpp>
#include <holdfast/tracking/consistency.hpp>

namespace holdfast {

/// A slow walk through a room of 2.6 m, with the head up and down and turning: whoever maps must get about.
[[nodiscard]] inline std::unique_ptr<Motion> make_mapping_walk(Duration duration) {
  return std::make_unique<CurveMotion>(duration, [](const Jet& t) {
    const auto sine = [&](double amplitude, double hz, double phase) {
      return amplitude * sin(2.0 * std::numbers::pi * hz * t + phase);
    };
    HeadCurve curve;
    curve.x = sine(1.3, 0.041, 0.0);
    curve.z = sine(1.3, 0.057, 1.0);
    curve.y = 1.45 + sine(0.25, 0.13, 0.5);
    curve.yaw = sine(1.5, 0.05, 0.3);
    curve.pitch = sine(0.2, 0.21, 0.0);
    curve.roll = sine(0.1, 0.17, 2.0);
    return curve;
  });
}

struct MappingCase {
  std::vector<CodedBeacon> seeds;
  std::vector<CodedBeacon> others;  ///< where they really hang; the mapper is told nothing of them
  std::vector<RangeReceiver> receivers = camera_receivers();
  UltrasonicErrors errors = [] {
    UltrasonicErrors improved = improved_compensation_errors();
    improved.beacon_horizontal_m = improved.beacon_vertical_m = 0.0;
    return improved;
  }();
  RangingOptions ranging;
  InertialUnit unit = mems_inertial_unit();
  BeaconMappingSettings settings;
  Duration duration = std::chrono::seconds(120), seed_alone = std::chrono::seconds(5);
  std::uint64_t seed = 1;

  /// Three seeds a few feet apart on a ceiling at 3 m, and so many others at random, 2.2 to 3 m high, over 4 m by 4 m.
  [[nodiscard]] static MappingCase random(int others, std::uint64_t seed) {
    MappingCase room;
    room.seed = seed;
    const Vector3 down = -Vector3::UnitY();
    room.seeds = {{0, Vector3(-two_feet_m, 3.0, -two_feet_m), down},
                  {1, Vector3(two_feet_m, 3.0, -two_feet_m), down},
                  {2, Vector3(0.0, 3.0, two_feet_m), down}};
    for (int i = 0; i < others; ++i) {
      KeyedNumbers numbers(seed, {55, i});
      const double x = 4.0 * numbers.uniform() - 2.0, y = 2.2 + 0.8 * numbers.uniform(),
                   z = 4.0 * numbers.uniform() - 2.0;
      room.others.push_back({3 + i, Vector3(x, y, z), down});
    }
    return room;
  }
};

struct MappedBeaconError {
  int code = 0;
  double installed_s = std::numeric_limits<double>::quiet_NaN();  ///< after the start; NaN: never
  double first_mm = 0.0, error_mm = 0.0;                          ///< when installed, and at the end
  double stated_mm = 0.0;                                         ///< sqrt(trace P) at the end
  double nees = 0.0;                                              ///< 3 degrees of freedom
  int ranges = 0;
};

struct MappingRow {
  std::vector<MappedBeaconError> beacons;  ///< the new ones
  int installed = 0;
  double mean_mm = 0.0, worst_mm = 0.0;  ///< of those installed, at the end
  double nees = 0.0;                     ///< mean, per degree of freedom
  double position_mm = 0.0;              ///< RMS of the mapper's own, over the last half
  long ranges = 0, gated = 0;
};

namespace detail {

/// A pose as acquisition leaves it.
[[nodiscard]] inline MappingStart mapping_start(const Motion& motion, std::uint64_t seed) {
  KeyedNumbers numbers(seed, {77});
  const Vector2 a = numbers.normal_pair(), b = numbers.normal_pair(), c = numbers.normal_pair();
  MappingStart start;
  start.t = motion.begin();
  const Rigid X_WB = motion.at(start.t).X_WB;
  start.X_WB = Rigid(X_WB.q() * so3::exp<double>(start.orientation_rad * Vector3(a[0], a[1], b[0])),
                     X_WB.p() + start.position_m * Vector3(b[1], c[0], c[1]));
  return start;
}

inline void judge_beacons(MappingRow& row, const BeaconMapper& mapper, const MappingCase& room) {
  ConsistencyMean nees(3);
  for (const MappedBeacon& beacon : mapper.beacons()) {
    const auto true_beacon = std::find_if(room.others.begin(), room.others.end(),
                                          [&](const CodedBeacon& b) { return b.code == beacon.code; });
    if (beacon.seed || true_beacon == room.others.end()) continue;
    MappedBeaconError& judged = row.beacons[static_cast<std::size_t>(true_beacon - room.others.begin())];
    const Vector3 error = beacon.p_W - true_beacon->p_W;
    judged.error_mm = 1000.0 * error.norm();
    judged.stated_mm = 1000.0 * std::sqrt(beacon.covariance.trace());
    judged.nees = normalised_square<3>(error, beacon.covariance).value_or(std::numeric_limits<double>::infinity());
    judged.ranges = beacon.ranges;
    nees.add(judged.nees);
    ++row.installed;
    row.mean_mm += judged.error_mm;
    row.worst_mm = std::max(row.worst_mm, judged.error_mm);
  }
  if (row.installed == 0) return;
  row.mean_mm /= row.installed;
  row.nees = nees.mean() / 3.0;
}

}  // namespace detail

namespace detail {

/// What is heard; indices are of the seeds, then of the others.
[[nodiscard]] inline std::vector<SimulatedRange> mapping_ranges(const MappingCase& room, const Motion& motion) {
  RangingOptions ranging = room.ranging;
  ranging.seed = room.seed;
  const auto stream = [&](const std::vector<CodedBeacon>& beacons) {
    const ConstellationRig rig{beacons, room.receivers};
    return ultrasonic_stream(motion, rig, UltrasonicDevices(rig, room.errors, room.seed), ranging);
  };
  std::vector<CodedBeacon> all = room.seeds;
  all.insert(all.end(), room.others.begin(), room.others.end());
  const HostTime change = motion.begin() + room.seed_alone;
  std::vector<SimulatedRange> heard = stream(room.seeds);
  std::erase_if(heard, [&](const SimulatedRange& s) { return s.range.t >= change; });
  for (const SimulatedRange& s : stream(all)) {
    if (s.range.t >= change) heard.push_back(s);
  }
  return heard;
}

}  // namespace detail

[[nodiscard]] inline MappingRow map_beacons(const MappingCase& room) {
  const std::unique_ptr<Motion> motion = make_mapping_walk(room.duration);
  BeaconMappingSettings settings = room.settings;
  settings.ins.gravity_W = room.unit.gravity_W;
  settings.ins.unit_B = room.unit.X_BS.p();

  MappingRow row;
  for (const CodedBeacon& other : room.others) {
    row.beacons.emplace_back();
    row.beacons.back().code = other.code;
  }
  BeaconMapper mapper(room.seeds, room.receivers, detail::mapping_start(*motion, room.seed), settings);
  const std::vector<InertialReading> readings = inertial_stream(*motion, room.unit, room.seed);
  std::size_t next = 0;
  double square = 0.0;
  long judged = 0;
  for (const SimulatedRange& heard : detail::mapping_ranges(room, *motion)) {
    for (; next < readings.size() && readings[next].t <= heard.range.t; ++next) mapper.add(readings[next]);
    const auto index = static_cast<std::size_t>(heard.range.beacon);
    const bool is_seed = index < room.seeds.size();
    const CodedBeacon& beacon = is_seed ? room.seeds[index] : room.others[index - room.seeds.size()];
    const MappingStatus status = mapper.add(heard.range.t, {heard.range.receiver, beacon.code, heard.range.range_m});
    ++row.ranges;
    row.gated += status == MappingStatus::gated;
    if (status == MappingStatus::installed) {
      MappedBeaconError& fresh = row.beacons[index - room.seeds.size()];
      fresh.installed_s = to_seconds(heard.range.t - motion->begin());
      fresh.first_mm = 1000.0 * (mapper.beacons().back().p_W - beacon.p_W).norm();
    }
    if (heard.range.t - motion->begin() < room.duration / 2) continue;
    square += (mapper.state().X_WB().p() - motion->at(mapper.state().t).X_WB.p()).squaredNorm();
    ++judged;
  }
  if (judged > 0) row.position_mm = 1000.0 * std::sqrt(square / static_cast<double>(judged));
  detail::judge_beacons(row, mapper, room);
  return row;
}

}  // namespace holdfast
