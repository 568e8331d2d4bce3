#pragma once
#include <array>
#include <cstddef>

#include <holdfast/geometry/vqs.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/optics/eye.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

using Sizes = std::array<std::size_t, 12>;

/// Size and alignment of types that travel between translation units.
inline Sizes sizes() {
  using namespace holdfast;
  return {sizeof(Rigid),       alignof(Rigid),       sizeof(Vqs),          alignof(Vqs),
          sizeof(MotionState), alignof(MotionState), sizeof(PoseEstimate), alignof(PoseEstimate),
          sizeof(EyeModel),    alignof(EyeModel),    sizeof(Matrix4),      alignof(Matrix4)};
}
