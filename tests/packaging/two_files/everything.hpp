#pragma once
#include <array>
#include <cstddef>

#include <holdfast/holdfast.hpp>
#ifdef WITH_CALIBRATION
#include <holdfast/calibration/filter_tuning.hpp>
#endif
#ifdef WITH_IO
#include <holdfast/io/io.hpp>
#endif
#ifdef WITH_RENDERING
#include <holdfast/rendering/rendering.hpp>
#endif
#ifdef WITH_SCENE
#include <holdfast/scene/scene.hpp>
#endif
#ifdef WITH_GLM
#include <holdfast/interop/glm.hpp>
#endif
#ifdef WITH_OPENXR
#include <holdfast/interop/openxr.hpp>
#endif

using Sizes = std::array<std::size_t, 12>;

/// Size and alignment of types that travel between translation units.
inline Sizes sizes() {
  using namespace holdfast;
  return {sizeof(Rigid),       alignof(Rigid),       sizeof(Vqs),          alignof(Vqs),
          sizeof(MotionState), alignof(MotionState), sizeof(PoseEstimate), alignof(PoseEstimate),
          sizeof(EyeModel),    alignof(EyeModel),    sizeof(Matrix4),      alignof(Matrix4)};
}
