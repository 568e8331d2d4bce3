/// The motion that a simulated HiBall is taken along: a recording below its ceiling, or a generated walk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <holdfast/motion/spline_trajectory.hpp>

namespace swimlab {

/// The true motion of the HiBall, and what to call it.
struct TrueMotion {
  std::string name;
  holdfast::SplineTrajectory motion;
};

[[nodiscard]] TrueMotion generated_walk(std::uint64_t seed, double seconds);

struct RecordedMotion {
  std::filesystem::path file;
  holdfast::Vector3 up_R = holdfast::Vector3::UnitY();
  bool lenient = false;  ///< drop bad rows
};

/// Its first seconds. io::InputError when it cannot be read, or has less than two.
[[nodiscard]] TrueMotion recorded_motion(const RecordedMotion& recorded, double seconds);

/// "x", "y" or "z"; io::InputError that names --up otherwise.
[[nodiscard]] holdfast::Vector3 up_axis(const std::string& word);

}  // namespace swimlab
