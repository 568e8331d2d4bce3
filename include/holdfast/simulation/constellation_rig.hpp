/// Rigs of the Constellation tracker: beacons on a ceiling, microphones on a head (003 sections 2.1, 3 and 4.2).
///
/// W has y up, its origin on the floor, or on the table, below the middle of the beacons. Head frame B: x right, y up, -z ahead;
/// its origin is where the inertial unit sits. Beacons are what was surveyed; where they really are, ultrasonic_range.hpp tells.
///   infinite_constellation   a square array, 2 feet (61 cm) apart and 3 m high, as far as a range reaches (section 3)
///   bench_constellation      3 by 3 with one corner missing, 2 feet apart, 1.5 m above the table (section 4.2)
///   camera_receivers         three microphones, baselines of 28 cm across and 25 cm up (section 4.2)
///   head_receivers           three microphones, 15 cm apart, "sufficient" on a headset (section 3, figure 10)
/// Codes count from 0 and repeat after `codes` (eight in section 2.2). How a rangefinder's microphone is tilted is not
/// printed: here they face up. Lengths in metres.
#pragma once

#include <cmath>
#include <vector>

#include <holdfast/tracking/coded_range.hpp>

namespace holdfast {

struct ConstellationRig {
  std::vector<CodedBeacon> beacons;
  std::vector<RangeReceiver> receivers;
};

inline constexpr double two_feet_m = 0.6096;

/// Facing down, in rows along x then z, centred above W's origin. Precondition: columns, rows, codes >= 1.
[[nodiscard]] inline std::vector<CodedBeacon> beacon_grid(int columns, int rows, double spacing_m, double height_m,
                                                          int codes = 8) {
  std::vector<CodedBeacon> beacons;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const Vector3 p_W(spacing_m * (j - 0.5 * (columns - 1)), height_m, spacing_m * (i - 0.5 * (rows - 1)));
      beacons.push_back({static_cast<int>(beacons.size()) % codes, p_W, -Vector3::UnitY()});
    }
  }
  return beacons;
}

/// So far out that nothing further would be heard from within 1 m of the middle.
[[nodiscard]] inline std::vector<CodedBeacon> infinite_constellation(int codes = 8) {
  return beacon_grid(17, 17, two_feet_m, 3.0, codes);
}

[[nodiscard]] inline std::vector<CodedBeacon> bench_constellation() {
  std::vector<CodedBeacon> beacons = beacon_grid(3, 3, two_feet_m, 1.5, 9);
  beacons.pop_back();
  return beacons;
}

[[nodiscard]] inline std::vector<RangeReceiver> camera_receivers() {
  const Vector3 up = Vector3::UnitY();
  return {{Vector3(-0.14, 0.0, 0.0), up}, {Vector3(0.14, 0.0, 0.0), up}, {Vector3(0.0, 0.25, 0.0), up}};
}

/// The corners of an equilateral triangle, level, 12 cm above the origin: on top of a head.
[[nodiscard]] inline std::vector<RangeReceiver> head_receivers(double baseline_m = 0.15) {
  const Vector3 up = Vector3::UnitY();
  const double across = 0.5 * baseline_m, along = baseline_m / std::sqrt(12.0);
  return {
      {Vector3(-across, 0.12, along), up}, {Vector3(across, 0.12, along), up}, {Vector3(0.0, 0.12, -2.0 * along), up}};
}

}  // namespace holdfast
