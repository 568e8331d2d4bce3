/// What goes wrong with sightings in the field: faults to add to a stream, one after another, as many as wanted.
///
/// Each function changes a stream of sightings in place and marks what it changed (BeaconSighting::faults). Where the
/// order matters, physics gives it: move_panel (light comes from elsewhere), misidentify, add_noise_burst, block_cameras,
/// jump_clock (times are then no longer true), deliver.
/// Random choices belong to (seed, time, camera, beacon) (keyed_numbers.hpp), so a fault hits the same sightings whatever
/// was removed before.
/// Bad input: probabilities are clamped to [0, 1]; a camera or panel that does not exist matches nothing or asserts.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <holdfast/simulation/hiball_sightings.hpp>
#include <holdfast/simulation/time_span.hpp>

namespace holdfast {

/// Removes what these cameras saw in the span; no camera named means all of them (002 6.2.8).
inline void block_cameras(std::vector<BeaconSighting>& sightings, const TimeSpan& span,
                          std::span<const int> cameras = {}) {
  std::erase_if(sightings, [&](const BeaconSighting& s) {
    return span.contains(s.t) && (cameras.empty() || std::ranges::find(cameras, s.camera) != cameras.end());
  });
}

/// From `at` on, a panel hangs elsewhere. What its beacons' images gain is exact; sightings whose image leaves the
/// photodiode are lost, and beacons that would newly come into view are not added.
inline void move_panel(std::vector<BeaconSighting>& sightings, const HiBallSimulator& simulator, int panel, HostTime at,
                       const Vector3& displacement_W) {
  HiBallRig moved_rig = simulator.rig();
  move_panel(moved_rig, panel, displacement_W);
  const HiBallSimulator moved(std::move(moved_rig), simulator.truth());
  std::erase_if(sightings, [&](BeaconSighting& s) {
    if (s.t < at || simulator.rig().panel_of(s.beacon) != panel) return false;
    const Rigid X_WB = simulator.pose_at(s.t);
    const std::optional<Vector2> before = simulator.image(X_WB, s.camera, s.beacon);
    const std::optional<Vector2> after = moved.image(X_WB, s.camera, s.beacon);
    if (!before || !after) return true;
    s.uv += *after - *before;
    s.faults.panel_moved = true;
    return false;
  });
}

/// Names another beacon with this probability: one that the same camera sees at the time, or, where it sees no other, one
/// beside the true one in its panel.
inline void misidentify(std::vector<BeaconSighting>& sightings, const HiBallSimulator& simulator, double probability,
                        std::uint64_t seed) {
  std::vector<int> others;
  for (BeaconSighting& s : sightings) {
    KeyedNumbers numbers(seed, {s.t.time_since_epoch().count(), s.camera, s.beacon, 1});
    if (!(numbers.uniform() < probability)) continue;
    simulator.visible(simulator.pose_at(s.t), s.camera, others);
    std::erase(others, s.beacon);
    if (others.empty()) {
      const int place = s.beacon % CeilingLayout::leds_along;
      others.push_back(place + 1 < CeilingLayout::leds_along ? s.beacon + 1 : s.beacon - 1);
    }
    if (!s.faults.wrong_beacon) s.faults.true_beacon = s.beacon;
    s.beacon = others[static_cast<std::size_t>(numbers.below(static_cast<int>(others.size())))];
    s.faults.wrong_beacon = true;
  }
}

/// In the span, noise has `times` the standard deviation that the sightings claim. Precondition: times >= 1.
inline void add_noise_burst(std::vector<BeaconSighting>& sightings, const TimeSpan& span, double times,
                            std::uint64_t seed) {
  HOLDFAST_ASSERT(times >= 1.0, "a burst cannot remove noise");
  for (BeaconSighting& s : sightings) {
    if (!span.contains(s.t)) continue;
    KeyedNumbers numbers(seed, {s.t.time_since_epoch().count(), s.camera, s.beacon, 2});
    s.uv += std::sqrt((times * times - 1.0) * s.variance) * numbers.normal_pair();
    s.faults.noise_burst = true;
  }
}

/// From `at` on, the clock that stamps the sightings is off by `by`, either way.
inline void jump_clock(std::vector<BeaconSighting>& sightings, HostTime at, Duration by) {
  for (BeaconSighting& s : sightings) {
    if (s.t < at) continue;
    s.t += by;
    s.faults.clock_jumped = true;
  }
}

/// A sighting with the time at which the tracker gets it.
struct DeliveredSighting {
  HostTime delivered;
  BeaconSighting sighting;
};

struct DeliveryOptions {
  double late_share = 0.1;                           ///< of the sightings
  Duration usual{0};                                 ///< how late all of them are
  Duration longest = std::chrono::milliseconds(50);  ///< how much later than usual the late ones may be
  std::uint64_t seed = 1;
};

/// The stream in the order of delivery. Late ones take a time uniform in (0, longest] more than usual, so others overtake
/// nearly all of them.
[[nodiscard]] inline std::vector<DeliveredSighting> deliver(std::span<const BeaconSighting> sightings,
                                                            const DeliveryOptions& options = {}) {
  std::vector<DeliveredSighting> delivered;
  delivered.reserve(sightings.size());
  for (const BeaconSighting& s : sightings) {
    KeyedNumbers numbers(options.seed, {s.t.time_since_epoch().count(), s.camera, s.beacon, 3});
    const bool late = numbers.uniform() < options.late_share;
    const Duration more = late ? from_seconds(to_seconds(options.longest) * (1.0 - numbers.uniform())) : Duration(0);
    delivered.push_back({s.t + options.usual + more, s});
  }
  std::ranges::stable_sort(delivered, {}, &DeliveredSighting::delivered);
  return delivered;
}

}  // namespace holdfast
