/// Errors of ultrasonic ranges as 003 lists them (section 3, table 1), for one range at a time.
///
///   measured = d c_believed / c_true + delay_beacon + delay_receiver + k angle_receiver
/// with d between where both transducers really are. `UltrasonicErrors` says how large errors are, `UltrasonicDevices` holds
/// those of one installation, drawn once: they do not average out. A range's noise, 1 mm a metre (section 4.1), is apart.
/// Angles: a transducer off its axis answers later, so k > 0. Taken at the receiver only and linear in the angle, table 1's
/// 2.5 mm at 60 degrees gives figure 7; at both ends it would be nearly twice as much.
/// Reach: (5 m) sqrt(cos beacon cos receiver), and nothing from behind.
/// Random numbers belong to (seed, device) (keyed_numbers.hpp). Units: m, degrees Celsius.
/// Bad input: a device that does not exist asserts; a zero axis works in all directions (coded_range.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/simulation/constellation_rig.hpp>
#include <holdfast/simulation/keyed_numbers.hpp>
#include <holdfast/tracking/time_of_flight.hpp>

namespace holdfast {

/// Zero: none. "+-" are ends of uniform distributions.
struct UltrasonicErrors {
  double beacon_horizontal_m = 0.0, beacon_vertical_m = 0.0;  ///< of beacons' places, +-
  double temperature_celsius = 0.0;                           ///< true less believed
  double beacon_delay_m = 0.0, receiver_delay_m = 0.0;        ///< +-
  double angle_m_per_rad = 0.0;                               ///< k
};

/// "What we believe to be the actual systematic error levels" (table 1).
[[nodiscard]] inline UltrasonicErrors table_1_errors() {
  return {2e-3, 4e-3, 0.2, 1e-3, 1e-3, 2.5e-3 / (std::numbers::pi / 3.0)};
}

/// Figure 9: angles are compensated to 1 mm a radian, what the receivers differ by to nothing.
[[nodiscard]] inline UltrasonicErrors improved_compensation_errors() {
  UltrasonicErrors errors = table_1_errors();
  errors.receiver_delay_m = 0.0;
  errors.angle_m_per_rad = 1e-3;
  return errors;
}

inline constexpr double range_noise_per_m = 1e-3;  ///< standard deviation (section 4.1)
inline constexpr double range_reach_m = 5.0;       ///< of transducers that face each other

/// Two transducers: how far apart, and how far off each one's axis the other is.
struct TransducerPair {
  double distance_m = 0.0;
  double cos_beacon = 1.0, cos_receiver = 1.0;

  TransducerPair(const Vector3& beacon_W, const Vector3& beacon_axis_W, const Vector3& receiver_W,
                 const Vector3& receiver_axis_W) {
    const Vector3 apart = receiver_W - beacon_W;
    distance_m = apart.norm();
    if (!beacon_axis_W.isZero()) cos_beacon = beacon_axis_W.dot(apart) / distance_m;
    if (!receiver_axis_W.isZero()) cos_receiver = -receiver_axis_W.dot(apart) / distance_m;
  }
  [[nodiscard]] bool in_reach() const {
    return cos_beacon > 0.0 && cos_receiver > 0.0 &&
           distance_m * distance_m < range_reach_m * range_reach_m * cos_beacon * cos_receiver;
  }
  [[nodiscard]] double angle_receiver() const { return std::acos(std::clamp(cos_receiver, -1.0, 1.0)); }
};

/// One installation: where its beacons really are, and what its devices do wrong.
struct UltrasonicDevices {
  std::vector<Vector3> beacons_W;
  std::vector<double> beacon_delays_m, receiver_delays_m;
  double believed_celsius = 20.0, true_celsius = 20.0;
  double angle_m_per_rad = 0.0;

  UltrasonicDevices(const ConstellationRig& rig, const UltrasonicErrors& errors, std::uint64_t seed = 1)
      : angle_m_per_rad(errors.angle_m_per_rad) {
    true_celsius = believed_celsius + errors.temperature_celsius;
    const auto either_way = [](KeyedNumbers& numbers, double most) { return most * (2.0 * numbers.uniform() - 1.0); };
    for (std::size_t i = 0; i < rig.beacons.size(); ++i) {
      KeyedNumbers numbers(seed, {1, static_cast<std::int64_t>(i)});
      Vector3 off_W;
      off_W.x() = either_way(numbers, errors.beacon_horizontal_m);
      off_W.y() = either_way(numbers, errors.beacon_vertical_m);
      off_W.z() = either_way(numbers, errors.beacon_horizontal_m);
      beacons_W.push_back(rig.beacons[i].p_W + off_W);
      beacon_delays_m.push_back(either_way(numbers, errors.beacon_delay_m));
    }
    for (std::size_t j = 0; j < rig.receivers.size(); ++j) {
      KeyedNumbers numbers(seed, {2, static_cast<std::int64_t>(j)});
      receiver_delays_m.push_back(either_way(numbers, errors.receiver_delay_m));
    }
  }

  /// What is measured, without noise. `pair` is of the beacon's true place.
  [[nodiscard]] double measured_m(const TransducerPair& pair, int beacon, int receiver) const {
    HOLDFAST_ASSERT(beacon >= 0 && beacon < static_cast<int>(beacon_delays_m.size()), "no such beacon");
    HOLDFAST_ASSERT(receiver >= 0 && receiver < static_cast<int>(receiver_delays_m.size()), "no such receiver");
    return pair.distance_m * speed_of_sound(believed_celsius) / speed_of_sound(true_celsius) +
           beacon_delays_m[static_cast<std::size_t>(beacon)] + receiver_delays_m[static_cast<std::size_t>(receiver)] +
           angle_m_per_rad * pair.angle_receiver();
  }
};

}  // namespace holdfast
