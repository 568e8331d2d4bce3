/// What an inertial unit says at one time: three angular velocities and three specific forces.
///
/// B is the unit's own frame: its sensors' place and axes. Where the three accelerometers sit apart, each number of the
/// force is that of its own place (linear_acceleration.hpp). A number that a unit does not have is not a number (NaN).
#pragma once

#include <holdfast/geometry/types.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// Standard gravity, m/s^2.
inline constexpr double standard_gravity = 9.80665;

struct InertialReading {
  HostTime t;
  Vector3 rate_B = Vector3::Zero();   ///< angular velocity, rad/s
  Vector3 force_B = Vector3::Zero();  ///< specific force, m/s^2: what a body at rest feels points up

  [[nodiscard]] bool is_finite() const { return rate_B.allFinite() && force_B.allFinite(); }
};

}  // namespace holdfast
