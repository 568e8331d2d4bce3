/// Motions with a closed form, from which theory's values follow: still, sine, ramp and stop, lateral shuttle, chirp.
///
/// The head stands at the origin of W and looks along -Z at angle zero; one coordinate moves, the others stay zero.
/// Angles are typed, lengths metres, frequencies Hz. All start at time zero. `at` gives exact derivatives; where a
/// motion has a corner (the ramp), the derivative from the right, and no acceleration for the infinite one of the
/// corner. Source: evaluation by sinusoids as in Azuma & Bishop 1995 and 001 appendix D; the numbers of M0-M3, M7, M8
/// are in generators.hpp. Bad input: durations must not be negative (assert).
#pragma once

#include <cmath>
#include <memory>
#include <numbers>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/motion/head_curve.hpp>

namespace holdfast {

/// amplitude * sin(2 pi hz t + phase); the unit is the amplitude's.
struct Harmonic {
  double amplitude = 0.0;
  double hz = 0.0;
  double phase_rad = 0.0;

  [[nodiscard]] Jet at(const Jet& t) const { return amplitude * sin(2.0 * std::numbers::pi * hz * t + phase_rad); }
};

/// A member of HeadCurve that a single-axis motion drives.
using HeadAxis = Jet HeadCurve::*;

[[nodiscard]] inline std::unique_ptr<Motion> make_still(Duration duration) {
  return std::make_unique<CurveMotion>(duration, [](const Jet&) { return HeadCurve(); });
}

/// One axis of the head curve as amplitude * sin(2 pi hz t + phase): radians for angles, metres for x, y, z.
[[nodiscard]] inline std::unique_ptr<Motion> make_axis_sine(HeadAxis axis, const Harmonic& sine, Duration duration) {
  return std::make_unique<CurveMotion>(duration, [axis, sine](const Jet& t) {
    HeadCurve curve;
    curve.*axis = sine.at(t);
    return curve;
  });
}

[[nodiscard]] inline std::unique_ptr<Motion> make_yaw_sine(double hz, Angle amplitude, Duration duration) {
  return make_axis_sine(&HeadCurve::yaw, {amplitude.radians(), hz, 0.0}, duration);
}

/// Still at `first`, from `start` on turning at rate_per_s until `last` is reached, then still at once.
struct YawRamp {
  Angle first = degrees(-20.0);
  Angle last = degrees(20.0);
  Angle rate_per_s = degrees(100.0);  ///< magnitude; the direction follows from first and last
  Duration start = std::chrono::milliseconds(600);

  [[nodiscard]] Duration stop() const { return start + from_seconds(std::abs((last - first) / rate_per_s)); }
};

[[nodiscard]] inline std::unique_ptr<Motion> make_yaw_ramp(const YawRamp& ramp, Duration duration) {
  return std::make_unique<CurveMotion>(duration, [ramp](const Jet& t) {
    HeadCurve curve;
    const double since_start = t.value - to_seconds(ramp.start);
    const double travel = (ramp.last - ramp.first).radians();
    const double rate = std::copysign(ramp.rate_per_s.radians(), travel);
    if (since_start < 0.0) {
      curve.yaw = ramp.first.radians();
    } else if (t.value >= to_seconds(ramp.stop())) {
      curve.yaw = ramp.last.radians();
    } else {
      curve.yaw = Jet(ramp.first.radians() + rate * since_start, rate, 0.0);
    }
    return curve;
  });
}

/// Sideways, to the right and back: straight passes at constant speed through x = 0, joined by turns in which the
/// velocity goes over smoothly (smooth_step). The speed never exceeds that of the passes; acceleration is continuous.
struct LateralShuttle {
  double speed_m_s = 0.5;
  double pass_s = 0.6;  ///< one pass, half of it on each side of x = 0
  double turn_s = 0.6;

  /// Greatest |x|: half a pass, and the reach of a turn.
  [[nodiscard]] double reach_m() const { return speed_m_s * (0.5 * pass_s + 0.34375 * turn_s); }
  [[nodiscard]] double period_s() const { return 2.0 * (pass_s + turn_s); }

  /// x at time t; at t = 0 in the middle of a pass to the right.
  [[nodiscard]] Jet at(const Jet& t) const {
    const double half = 0.5 * period_s();
    const double lap = std::floor((t.value + 0.5 * pass_s) / half);  // even laps go right
    const double sign = std::fmod(std::abs(lap), 2.0) == 0.0 ? 1.0 : -1.0;
    const Jet local = t - lap * half;  // in [-pass/2, pass/2 + turn)
    if (local.value <= 0.5 * pass_s) return sign * speed_m_s * local;
    const Jet s = (local - 0.5 * pass_s) / Jet(turn_s);
    const Jet turned = s - 2.0 * (s * s * s * s * (s * (s - 3.0) + 2.5));  // integral of 1 - 2 smooth_step
    return sign * speed_m_s * (0.5 * pass_s + turn_s * turned);
  }
};

[[nodiscard]] inline std::unique_ptr<Motion> make_lateral_shuttle(const LateralShuttle& shuttle, Duration duration) {
  return std::make_unique<CurveMotion>(duration, [shuttle](const Jet& t) {
    HeadCurve curve;
    curve.x = shuttle.at(t);
    return curve;
  });
}

/// Sine whose frequency rises exponentially (equal time for every octave) from first_hz at t = 0 to last_hz at the end.
struct Chirp {
  double first_hz = 0.2;
  double last_hz = 10.0;
  double amplitude = 0.0;
  double duration_s = 20.0;

  [[nodiscard]] double hz_at(double seconds) const {
    return first_hz * std::pow(last_hz / first_hz, seconds / duration_s);
  }
  [[nodiscard]] Jet at(const Jet& t) const {
    const double growth = std::log(last_hz / first_hz) / duration_s;
    const Jet phase = 2.0 * std::numbers::pi * first_hz / growth * (exp(growth * t) - 1.0);
    return amplitude * sin(phase);
  }
};

[[nodiscard]] inline std::unique_ptr<Motion> make_yaw_chirp(const Chirp& chirp) {
  return std::make_unique<CurveMotion>(from_seconds(chirp.duration_s), [chirp](const Jet& t) {
    HeadCurve curve;
    curve.yaw = chirp.at(t);
    return curve;
  });
}

}  // namespace holdfast
