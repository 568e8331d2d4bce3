/// The recording of a head in the shared data.
#pragma once

#include <filesystem>
#include <vector>

#include <holdfast/io/trajectory.hpp>

namespace holdfast::test {

/// Empty where the recording is not there.
inline std::vector<TimedPose> head_recording() {
  const std::filesystem::path file = std::filesystem::path(HOLDFAST_RECORDINGS) / "head/optitrack_head_120hz.tum";
  if (!std::filesystem::exists(file)) return {};
  return io::read_trajectory(file).samples;
}

}  // namespace holdfast::test
