// Uses something of every component that was asked for.
#include <cstdio>

#include <holdfast/holdfast.hpp>
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

int main() {
  const holdfast::HmdModel hmd = holdfast::default_hmd();
  const auto pixel = holdfast::project(hmd.left, holdfast::Vector3(0, 0, -1));
  if (!pixel) return 1;
  std::printf("a point straight ahead of the left eye is at pixel %.1f, %.1f\n", pixel->x(), pixel->y());
  return 0;
}
