/// Head motions like those on which Azuma & Bishop judged prediction: walk-around, rotation and swing (001
/// section 5.3).
///
/// Their recordings are lost, but figure 6 tells how fast they were: without prediction the error over 60 ms is the
/// movement in 60 ms, so error / 0.06 s is a speed. Ours are formulas with about the same speeds:
///
///                 mean / peak angular speed (deg/s)   mean / peak speed (m/s)
///   walk-around         22 / 72                            0.24 / 0.63
///   rotation            37 / 88                            0.11 / 0.29
///   swing               42 / 108                           0.30 / 0.77
///
/// Table E.1 of 002 (a visitor's head, 3 minutes: per-axis peaks 0.47-0.73 m/s and 88-95 deg/s, means 0.03-0.08 m/s and
/// 6-14 deg/s) gives the same peaks. Peaks of ours are those of smooth formulas and lie lower than those of the
/// recordings, which hold noise and jerks; docs/motion.md prints both.
///
/// The head starts near W's origin and keeps its gaze on the scene round gaze_target_W, up to the wander below. Each
/// motion lasts as long as asked; the seed moves phases and, by up to 8 %, amplitudes and frequencies. Same seed, same
/// motion, on any machine.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>

#include <holdfast/motion/test_signals.hpp>

namespace holdfast {

/// What the eyes stay on: the corner of the registration scene's frame lies near it (W, metres).
inline const Vector3 gaze_target_W(0.0, 0.0, -1.2);

namespace detail {

/// Uniform numbers that are the same with every standard library (its distributions are not).
class SeededNumbers {
 public:
  explicit SeededNumbers(std::uint64_t seed) : engine_(seed) {}
  [[nodiscard]] double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// The sine with a random phase and amplitude and frequency changed by up to 8 %.
  [[nodiscard]] Harmonic vary(double amplitude, double hz) {
    Harmonic varied;
    varied.amplitude = amplitude * between(0.92, 1.08);
    varied.hz = hz * between(0.92, 1.08);
    varied.phase_rad = between(0.0, 2.0 * std::numbers::pi);
    return varied;
  }

 private:
  std::mt19937_64 engine_;
};

/// Yaw and pitch that look from (x, y, z) at the target.
inline void look_at_target(HeadCurve& curve) {
  const Jet dx = gaze_target_W.x() - curve.x;
  const Jet dy = gaze_target_W.y() - curve.y;
  const Jet dz = gaze_target_W.z() - curve.z;
  curve.yaw = atan2(-dx, -dz);
  curve.pitch = atan2(dy, sqrt(dx * dx + dz * dz));
}

/// Small movements of a head that looks at something without being fixed to it: two sines for each angle.
struct GazeWander {
  std::array<Harmonic, 2> yaw, pitch, roll;

  GazeWander(SeededNumbers& numbers, Angle amplitude) {
    const double a = amplitude.radians();
    yaw = {numbers.vary(a, 0.45), numbers.vary(0.35 * a, 1.1)};
    pitch = {numbers.vary(0.7 * a, 0.4), numbers.vary(0.3 * a, 1.2)};
    roll = {numbers.vary(0.5 * a, 0.35), numbers.vary(0.2 * a, 0.9)};
  }
  void add_to(HeadCurve& curve, const Jet& t) const {
    curve.yaw = curve.yaw + yaw[0].at(t) + yaw[1].at(t);
    curve.pitch = curve.pitch + pitch[0].at(t) + pitch[1].at(t);
    curve.roll = curve.roll + roll[0].at(t) + roll[1].at(t);
  }
};

/// Adds R_WB p_B to the position, all of it as functions of time.
inline void add_rotated(HeadCurve& curve, const Vector3& p_B) {
  const Jet x1 = cos(curve.roll) * p_B.x() - sin(curve.roll) * p_B.y();
  const Jet y1 = sin(curve.roll) * p_B.x() + cos(curve.roll) * p_B.y();
  const Jet y2 = cos(curve.pitch) * y1 - sin(curve.pitch) * p_B.z();
  const Jet z2 = sin(curve.pitch) * y1 + cos(curve.pitch) * p_B.z();
  curve.x = curve.x + cos(curve.yaw) * x1 + sin(curve.yaw) * z2;
  curve.y = curve.y + y2;
  curve.z = curve.z - sin(curve.yaw) * x1 + cos(curve.yaw) * z2;
}

}  // namespace detail

/// Walks slowly on an arc of +-25 deg and 1.2 m radius round the target, once to each side in 10 s, bobbing 12 mm at
/// the rate of steps (1.8 Hz) and swaying 15 mm at half of it.
[[nodiscard]] inline std::unique_ptr<Motion> make_walk_around(std::uint64_t seed, Duration duration) {
  detail::SeededNumbers numbers(seed ^ 0x4d34u);
  const double arc_rad = degrees(25.0).radians() * numbers.between(0.95, 1.05);
  const Harmonic bob = numbers.vary(0.012, 1.8);
  const Harmonic sway = numbers.vary(0.015, 0.9);
  const Harmonic lean = numbers.vary(0.06, 0.21);
  const detail::GazeWander wander(numbers, degrees(6.0));
  return std::make_unique<CurveMotion>(duration, [=](const Jet& t) {
    const Jet around = Harmonic{arc_rad, 0.1, 0.0}.at(t);
    const Jet radius = 1.2 + lean.at(t);
    HeadCurve curve;
    curve.x = gaze_target_W.x() + radius * sin(around) + cos(around) * sway.at(t);
    curve.y = gaze_target_W.y() + bob.at(t);
    curve.z = gaze_target_W.z() + radius * cos(around) - sin(around) * sway.at(t);
    detail::look_at_target(curve);
    wander.add_to(curve, t);
    return curve;
  });
}

/// Stands and turns the head about its neck: yaw in the first third of each 10 s, pitch in the second, circling in the
/// third, with 1.4 s of smooth change between them. The eyes lie 110 mm above and 150 mm before the neck's pivot.
[[nodiscard]] inline std::unique_ptr<Motion> make_rotation(std::uint64_t seed, Duration duration) {
  detail::SeededNumbers numbers(seed ^ 0x4d35u);
  const Harmonic yaw = numbers.vary(degrees(17.0).radians(), 0.54);
  const Harmonic pitch = numbers.vary(degrees(15.0).radians(), 0.60);
  const Harmonic circle = numbers.vary(degrees(11.0).radians(), 0.57);
  const Harmonic hurry = numbers.vary(0.2, 0.23);  // turns are now quicker, now slower
  const detail::GazeWander wander(numbers, degrees(2.0));
  return std::make_unique<CurveMotion>(duration, [=](const Jet& t) {
    const double cycle = 10.0, third = cycle / 3.0, change = 1.4;
    const Jet local = t - cycle * std::floor(t.value / cycle);
    const auto after = [&](double moment) { return smooth_step((local - moment) / Jet(change) + 0.5); };
    // Each weight rises where the one before it falls; the cycle closes smoothly on itself.
    const Jet yawing = after(0.0), pitching = after(third), circling = after(2.0 * third), next_cycle = after(cycle);
    const Jet yaw_weight = yawing - pitching + next_cycle;
    const Jet pitch_weight = pitching - circling;
    const Jet circle_weight = circling - next_cycle + 1.0 - yawing;
    const Jet hurried = t + hurry.at(t);
    HeadCurve curve;
    curve.yaw = yaw_weight * yaw.at(hurried) + circle_weight * circle.at(hurried);
    const Harmonic quarter_later{circle.amplitude, circle.hz, circle.phase_rad + 0.5 * std::numbers::pi};
    curve.pitch = pitch_weight * pitch.at(hurried) + circle_weight * quarter_later.at(hurried);
    wander.add_to(curve, t);
    const Vector3 eyes_B(0.0, 0.11, -0.15);  // from the neck's pivot
    curve.y = -eyes_B.y();
    curve.z = -eyes_B.z();
    detail::add_rotated(curve, eyes_B);
    return curve;
  });
}

/// Swings the upper body from side to side (140 mm), up and down and to and fro, and rolls and turns the head with it.
[[nodiscard]] inline std::unique_ptr<Motion> make_swing(std::uint64_t seed, Duration duration) {
  detail::SeededNumbers numbers(seed ^ 0x4d36u);
  const Harmonic side = numbers.vary(0.14, 0.45);
  const Harmonic up = numbers.vary(0.04, 0.75);
  const Harmonic fore = numbers.vary(0.07, 0.37);
  const Harmonic roll = numbers.vary(degrees(8.0).radians(), 0.45);
  const Harmonic turn = numbers.vary(degrees(11.0).radians(), 0.62);
  const Harmonic nod = numbers.vary(degrees(5.0).radians(), 0.8);
  const Harmonic hurry = numbers.vary(0.45, 0.19);
  const detail::GazeWander wander(numbers, degrees(2.0));
  return std::make_unique<CurveMotion>(duration, [=](const Jet& t) {
    const Jet hurried = t + hurry.at(t);
    HeadCurve curve;
    curve.x = side.at(hurried);
    curve.y = up.at(hurried);
    curve.z = fore.at(hurried);
    detail::look_at_target(curve);
    curve.yaw = curve.yaw + turn.at(hurried);
    curve.pitch = curve.pitch + nod.at(hurried);
    curve.roll = curve.roll + roll.at(hurried);
    wander.add_to(curve, t);
    return curve;
  });
}

}  // namespace holdfast
