/// What a head usually does, for the covariance of what is assumed about it meanwhile.
///
/// Root mean squares per axis. The defaults lie between those of two recordings (docs/prediction.md has the command): a
/// player's head, 0.10 m/s, 0.30 rad/s, 0.36 m/s^2, 2.1 rad/s^2, and a camera carried round a table, 0.42, 0.33,
/// 0.92, 3.0.
#pragma once

namespace holdfast {

struct HeadDynamics {
  double speed_m_s = 0.25;
  double angular_speed_rad_s = 0.3;
  double acceleration_m_s2 = 0.6;
  double angular_acceleration_rad_s2 = 2.5;
};

/// Nothing moves but as estimated: leaves only the estimate's own uncertainty.
inline constexpr HeadDynamics no_dynamics{0.0, 0.0, 0.0, 0.0};

}  // namespace holdfast
