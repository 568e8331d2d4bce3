/// Settings of an inertial navigator corrected by ranges (range_aided_ins.hpp), and what it says about itself.
///
/// Noises are those of a good unit of today with some room for what a model leaves out; ranges err as 003 found: 1 mm a metre
/// (section 4.1), and about 3 mm that stays (table 1, at 2 to 3 m). Units are in the names: m, s, rad/s, m/s^2.
#pragma once

#include <cstdint>
#include <string_view>

#include <holdfast/tracking/inertial_health.hpp>
#include <holdfast/tracking/innovation_gate.hpp>

namespace holdfast {

struct RangeAidedInsSettings {
  Vector3 unit_B = Vector3::Zero();                          ///< where the inertial unit sits on the body, m
  Vector3 gravity_W = -standard_gravity * Vector3::UnitY();  ///< where things fall
  InertialRanges ranges;
  // White noise, and walks of the biases.
  double rate_noise = 2e-4;       ///< rad/s / sqrt(Hz)
  double force_noise = 2e-3;      ///< m/s^2 / sqrt(Hz)
  double rate_bias_walk = 5e-5;   ///< rad/s / sqrt(s)
  double force_bias_walk = 5e-4;  ///< m/s^2 / sqrt(s)
  // Of a head whose sensors say nothing: the same units.
  double no_rate_noise = 0.7, no_force_noise = 2.0;
  double usual_rate = 1.0, usual_force = 3.0;  ///< rad/s, m/s^2: what a sensor that failed may have missed
  // Standard deviations at the start.
  double speed_m_s = 0.5, rate_bias = 0.02, force_bias = 0.5;
  // Of a range.
  double range_noise_m = 0.3e-3, range_noise_per_m = 1e-3;
  double systematic_m = 2e-3;             ///< stays with a pair of transducers
  double systematic_correlation_s = 1.0;  ///< for so long
  GateSettings gate{.probability = 0.999, .patience = 12, .device_probation = 0, .lost_after = 150};
};

enum class RangeUpdate { accepted, gated, refused };

struct RangeAidedInsCounts {
  std::uint64_t ranges_accepted = 0, ranges_gated = 0, ranges_refused = 0, readings_refused = 0;
};

struct RangeAidedInsStatus {
  SensorFault gyro = SensorFault::none, accelerometer = SensorFault::none;
  bool trusted = false;    ///< ranges have agreed of late
  bool lost = false;       ///< they do not: acquire anew
  double unaided_s = 0.0;  ///< since the newest range that was accepted
  RangeAidedInsCounts counts;
};

}  // namespace holdfast
