/// Time of flight of ultrasound, and what a tracker takes it for (003 section 2.1).
///
/// Speed of sound in air at T kelvin: c = 331.4 m/s sqrt(T / 273.15), 343.3 m/s at 20 degrees Celsius. One degree is 0.17 % of a
/// range: 5 mm at 3 m. Humidity adds up to 0.4 % at 30 degrees and is left out, as in the paper.
/// Units: degrees Celsius, s, m. Bad input: at and below absolute zero there is no sound: 0 m/s.
#pragma once

#include <algorithm>
#include <cmath>

#include <holdfast/geometry/types.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

[[nodiscard]] inline double speed_of_sound(double celsius) {
  return 331.4 * std::sqrt(std::max(0.0, celsius / 273.15 + 1.0));
}

/// A range from a beacon to a receiver on the body, at the time of its arrival: sound spreads from the fixed beacon, so
/// however long it was under way, it tells where the receiver was when it heard it.
struct BeaconRange {
  HostTime t;
  int beacon = 0;    ///< index
  int receiver = 0;  ///< index
  double range_m = 0.0;
};

}  // namespace holdfast
