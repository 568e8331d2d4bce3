/// What an inertial unit says at one time: three angular velocities and three specific forces.
///
/// B is the unit's own frame: its sensors' place and axes. Where the three accelerometers sit apart, each number of the
/// force is that of its own place (linear_acceleration.hpp). A number that a unit does not have is not a number (NaN).
/// Bad input: has_rate, has_force and is_usual tell.
#pragma once

#include <holdfast/geometry/types.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// Standard gravity, m/s^2.
inline constexpr double standard_gravity = 9.80665;

/// No head comes near these; below them what is made of readings stays finite.
inline constexpr double fastest_rad_s = 1e4, hardest_m_s2 = 1e6;

/// Within 140 years of the clock's zero: differences of such times do not overflow.
[[nodiscard]] constexpr bool is_usual(HostTime t) {
  constexpr auto limit = std::chrono::hours(140 * 365 * 24);
  return t.time_since_epoch() < limit && t.time_since_epoch() > -limit;
}

struct InertialReading {
  HostTime t;
  Vector3 rate_B = Vector3::Zero();   ///< angular velocity, rad/s
  Vector3 force_B = Vector3::Zero();  ///< specific force, m/s^2: what a body at rest feels points up

  // Finite and below the limits.
  [[nodiscard]] bool has_rate() const { return (rate_B.array().abs() < fastest_rad_s).all(); }
  [[nodiscard]] bool has_force() const { return (force_B.array().abs() < hardest_m_s2).all(); }
};

}  // namespace holdfast
