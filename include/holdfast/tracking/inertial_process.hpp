/// What makes an inertial filter's state more uncertain from pose to pose: the sensors' noise, and how their parameters
/// wander.
///
/// The turn's and the velocity's errors grow by white noise. To the sensors' own comes that of errors which last as
/// long as a head turns one way, some 0.05 s: a scale that is off, and a lever to the sensors that is.
/// Units: intensities rad^2/s, m^2/s^3. Bad input: precondition finite numbers.
#pragma once

#include <algorithm>

#include <holdfast/tracking/inertial_state.hpp>

namespace holdfast {

struct InertialProcessSettings {
  double rate_noise = 5e-4;          ///< of the gyro, rad/s / sqrt(Hz); 0.3 to 1 times that, as the poses tell
  double rate_scale_error = 0.01;    ///< and this part of what it says; likewise
  double force_noise = 0.005;        ///< of the accelerometer, m/s^2 / sqrt(Hz); 0.3 to 4 times that, as the poses tell
  double swing_m = 0.03;             ///< the sensors sit so far from where they are believed to, when turning fast
  double no_force_noise = 1.0;       ///< of the body's acceleration, where there is no accelerometer
  double rate_bias_walk = 2e-5;      ///< rad/s / sqrt(s)
  double force_bias_walk = 1e-3;     ///< m/s^2 / sqrt(s)
  double gravity_walk = 1e-3;        ///< m/s^2 / sqrt(s)
  double time_offset_walk_s = 1e-5;  ///< s / sqrt(s)
};

/// Intensities of white noise.
struct ProcessNoise {
  double turn = 0.0;   ///< rad^2/s
  double force = 0.0;  ///< m^2/s^3
};

[[nodiscard]] inline ProcessNoise process_noise(const StrapdownIncrement& step, const InertialProcessSettings& settings,
                                                double turn_scale, double force_scale) {
  const auto square = [](double x) { return x * x; };
  const double rate_squared = std::max(step.rate_begin_B.squaredNorm(), step.rate_end_B.squaredNorm());
  const double force = step.has_force ? force_scale * settings.force_noise : settings.no_force_noise;
  return {square(turn_scale) * (square(settings.rate_noise) + 0.05 * square(settings.rate_scale_error) * rate_squared),
          square(force) + 1.25e-4 * square(settings.swing_m * rate_squared)};
}

inline void add_process_noise(InertialState::Covariance& P, const ProcessNoise& noise, double dt,
                              const InertialProcessSettings& settings) {
  using S = InertialState;
  const auto walk = [dt](double deviation) { return deviation * deviation * dt; };
  for (int i = 0; i < 3; ++i) {
    P(S::turn + i, S::turn + i) += noise.turn * dt;
    P(S::place + i, S::place + i) += noise.force * dt * dt * dt / 3.0;
    P(S::place + i, S::velocity + i) += noise.force * dt * dt / 2.0;
    P(S::velocity + i, S::place + i) += noise.force * dt * dt / 2.0;
    P(S::velocity + i, S::velocity + i) += noise.force * dt;
    P(S::rate_bias + i, S::rate_bias + i) += walk(settings.rate_bias_walk);
    P(S::force_bias + i, S::force_bias + i) += walk(settings.force_bias_walk);
    P(S::gravity + i, S::gravity + i) += walk(settings.gravity_walk);
  }
  P(S::offset, S::offset) += walk(settings.time_offset_walk_s);
}

}  // namespace holdfast
