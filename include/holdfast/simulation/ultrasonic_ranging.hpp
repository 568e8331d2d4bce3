/// What a moving body hears of coded beacons that are fired one after another (003 sections 2.1 and 2.2).
///
/// Every `interval` one beacon is triggered, by infrared, thus at once: of those within reach of a receiver the one that
/// waited longest. Its pulse reaches each receiver when it does: sound waves spread from a beacon that stands, so the time of flight
/// is that to where the receiver is when it hears it, and the range is stamped with that time.
///   t_j = t_0 + |X_WB(t_j) r_j - b| / c,    range = measured as ultrasonic_range.hpp has it + noise
/// What goes wrong, each range by itself:
///   lost     not heard
///   echo     the direct path is blocked: what is heard first came by a detour of 0.1 to 1.5 m
///   early    noise, or an echo of the beacon before, stops the counter, anywhere between 0.3 m and the true range
/// Random numbers belong to (seed, shot, receiver): a fault changes no other range's noise.
/// The order is that of time of arrival. Preconditions: interval above zero, as many axes as receivers (assert).
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <holdfast/motion/motion.hpp>
#include <holdfast/simulation/ultrasonic_range.hpp>

namespace holdfast {

struct RangingFaults {
  double lost = 0.0, echo = 0.0, early = 0.0;  ///< probabilities
};

enum class RangingFault { none, echo, early };

struct RangingOptions {
  Duration interval =
      std::chrono::milliseconds(20);  ///< from one beacon to the next: 5 m of sound, and what echoes take to die
  RangingFaults faults;
  double noise_per_m = range_noise_per_m;
  std::uint64_t seed = 1;
};

struct SimulatedRange {
  BeaconRange range;
  RangingFault fault = RangingFault::none;
};

class UltrasonicSimulator {
 public:
  UltrasonicSimulator(const Motion& motion, const ConstellationRig& rig, const UltrasonicDevices& devices,
                      const RangingOptions& options = {})
      : motion_(&motion), rig_(rig), devices_(devices), options_(options), t_(motion.begin()) {
    HOLDFAST_ASSERT(options.interval > Duration(0), "beacons are fired one after another");
    HOLDFAST_ASSERT(devices.beacons_W.size() == rig.beacons.size(), "errors of another rig");
    waited_since_.assign(rig.beacons.size(), -1);
  }

  [[nodiscard]] bool is_done() const { return t_ + longest_flight > motion_->end(); }

  /// Fires one beacon and appends what is heard of it.
  void fire(std::vector<SimulatedRange>& heard) {
    const int beacon = next_beacon();
    if (beacon >= 0) {
      waited_since_[static_cast<std::size_t>(beacon)] = shot_;
      const std::size_t first = heard.size();
      for (std::size_t j = 0; j < rig_.receivers.size(); ++j) hear(beacon, static_cast<int>(j), heard);
      std::sort(heard.begin() + static_cast<std::ptrdiff_t>(first), heard.end(),
                [](const SimulatedRange& a, const SimulatedRange& b) { return a.range.t < b.range.t; });
    }
    t_ += options_.interval;
    ++shot_;
  }

 private:
  static constexpr Duration longest_flight = std::chrono::milliseconds(20);

  [[nodiscard]] TransducerPair pair(int beacon, int receiver, const Rigid& X_WB) const {
    const RangeReceiver& r = rig_.receivers[static_cast<std::size_t>(receiver)];
    const auto b = static_cast<std::size_t>(beacon);
    return {devices_.beacons_W[b], rig_.beacons[b].axis_W, X_WB * r.p_B, X_WB.q() * r.axis_B};
  }

  /// -1: none is in reach.
  [[nodiscard]] int next_beacon() const {
    const Rigid X_WB = motion_->at(t_).X_WB;
    int next = -1;
    std::int64_t longest = std::numeric_limits<std::int64_t>::max();
    for (int i = 0; i < static_cast<int>(rig_.beacons.size()); ++i) {
      const std::int64_t since = waited_since_[static_cast<std::size_t>(i)];
      if (since >= longest) continue;
      bool in_reach = false;
      for (int j = 0; j < static_cast<int>(rig_.receivers.size()); ++j) {
        in_reach = in_reach || pair(i, j, X_WB).in_reach();
      }
      if (!in_reach) continue;
      next = i;
      longest = since;
    }
    return next;
  }

  void hear(int beacon, int receiver, std::vector<SimulatedRange>& heard) const {
    const double speed = speed_of_sound(devices_.true_celsius);
    HostTime t = t_;
    TransducerPair apart = pair(beacon, receiver, motion_->at(t).X_WB);
    for (int k = 0; k < 4; ++k) {  // a head is a hundred times slower than sound: each round is worth two digits
      t = t_ + from_seconds(apart.distance_m / speed);
      apart = pair(beacon, receiver, motion_->at(t).X_WB);
    }
    if (!apart.in_reach()) return;
    KeyedNumbers numbers(options_.seed, {shot_, receiver});
    SimulatedRange measured;
    measured.range = {t, beacon, receiver, devices_.measured_m(apart, beacon, receiver)};
    measured.range.range_m += options_.noise_per_m * apart.distance_m * numbers.normal_pair().x();
    const double fate = numbers.uniform(), detour = numbers.uniform();
    const RangingFaults& faults = options_.faults;
    if (fate < faults.lost) return;
    double wrong_by = 0.0;
    if (fate < faults.lost + faults.echo) {
      measured.fault = RangingFault::echo;
      wrong_by = 0.1 + 1.4 * detour;
    } else if (fate < faults.lost + faults.echo + faults.early && apart.distance_m > 0.3) {
      measured.fault = RangingFault::early;
      wrong_by = -detour * (apart.distance_m - 0.3);
    }
    measured.range.range_m += wrong_by;
    measured.range.t += from_seconds(wrong_by / speed);
    heard.push_back(measured);
  }

  const Motion* motion_;
  ConstellationRig rig_;
  UltrasonicDevices devices_;
  RangingOptions options_;
  HostTime t_;
  std::int64_t shot_ = 0;
  std::vector<std::int64_t> waited_since_;
};

/// All ranges along a motion, in the order of their arrival.
[[nodiscard]] inline std::vector<SimulatedRange> ultrasonic_stream(const Motion& motion, const ConstellationRig& rig,
                                                                   const UltrasonicDevices& devices,
                                                                   const RangingOptions& options = {}) {
  UltrasonicSimulator simulator(motion, rig, devices, options);
  std::vector<SimulatedRange> heard;
  while (!simulator.is_done()) simulator.fire(heard);
  std::ranges::stable_sort(heard, {}, [](const SimulatedRange& s) { return s.range.t; });
  return heard;
}

}  // namespace holdfast
