/// The default motions M0-M8 of the experiments, by name. (M9 is a recorded file: io/trajectory.hpp.)
///
///   M0 still                     3 s
///   M1 yaw 2 Hz +-3 deg          3 s, yaw = 3 deg sin(2 pi 2 t)
///   M2 yaw 1 Hz +-15 deg         3 s, yaw = 15 deg sin(2 pi t)
///   M3 yaw ramp 100 deg/s        2 s: still at -20 deg, from 0.6 s turning, at 1.0 s and +20 deg abruptly still
///   M4 walk-around              10 s, seeded (head_motions.hpp)
///   M5 rotation                 10 s, seeded
///   M6 swing                    10 s, seeded
///   M7 lateral 0.5 m/s           4.8 s: two rounds of passes of 0.3 m at 0.5 m/s with smooth turns of 0.6 s; |x| at
///                                most 0.254 m
///   M8 yaw chirp 0.2-10 Hz      20 s, +-2 deg, exponential
///
/// The world W is right-handed with +Y up; the head starts near the origin and looks along -Z, where the scene is (0.5
/// to 2 m). Each begins at HostTime 0 and has exact derivatives. The seed matters for M4-M6 only. Source:
/// evaluation.md, "Default experiments"; 001 section 5.3.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include <holdfast/motion/head_motions.hpp>
#include <holdfast/motion/test_signals.hpp>

namespace holdfast {

struct MotionName {
  std::string_view id;
  std::string_view title;
};

[[nodiscard]] inline std::span<const MotionName> motion_names() {
  static constexpr std::array<MotionName, 9> names{{{"M0", "still"},
                                                    {"M1", "yaw 2 Hz +-3 deg"},
                                                    {"M2", "yaw 1 Hz +-15 deg"},
                                                    {"M3", "yaw ramp 100 deg/s, abrupt stop"},
                                                    {"M4", "walk-around"},
                                                    {"M5", "rotation"},
                                                    {"M6", "swing"},
                                                    {"M7", "lateral 0.5 m/s"},
                                                    {"M8", "yaw chirp 0.2-10 Hz"}}};
  return names;
}

/// The named motion, or nullptr when the name is none of motion_names().
[[nodiscard]] inline std::unique_ptr<Motion> make_motion(std::string_view name, std::uint64_t seed = 1) {
  using std::chrono::milliseconds;
  using std::chrono::seconds;
  if (name == "M0") return make_still(seconds(3));
  if (name == "M1") return make_yaw_sine(2.0, degrees(3.0), seconds(3));
  if (name == "M2") return make_yaw_sine(1.0, degrees(15.0), seconds(3));
  if (name == "M3") return make_yaw_ramp(YawRamp(), seconds(2));
  if (name == "M4") return make_walk_around(seed, seconds(10));
  if (name == "M5") return make_rotation(seed, seconds(10));
  if (name == "M6") return make_swing(seed, seconds(10));
  if (name == "M7") return make_lateral_shuttle(LateralShuttle(), milliseconds(4800));
  if (name == "M8") {
    Chirp chirp;
    chirp.amplitude = degrees(2.0).radians();
    return make_yaw_chirp(chirp);
  }
  return nullptr;
}

}  // namespace holdfast
