// Uses something of every component that was asked for, by its own header: the umbrellas are compiled by other tests.
#include <cstdio>

#include <holdfast/optics/hmd.hpp>
#ifdef WITH_CALIBRATION
#include <holdfast/calibration/filter_tuning.hpp>
#endif
#ifdef WITH_IO
#include <holdfast/io/png.hpp>
#endif
#ifdef WITH_RENDERING
#include <holdfast/rendering/make_context.hpp>
#endif
#ifdef WITH_SCENE
#include <holdfast/scene/load_model.hpp>
#endif
#ifdef WITH_GLM
#include <holdfast/interop/glm.hpp>
#endif
#ifdef WITH_OPENXR
#include <holdfast/interop/openxr.hpp>
#endif

int main() {
  const holdfast::HmdModel hmd = holdfast::default_hmd();
  const auto pixel = holdfast::project(hmd.left, holdfast::Vector3(0, 0, -1));
  if (!pixel) return 1;
  std::printf("a point straight ahead of the left eye is at pixel %.1f, %.1f\n", pixel->x(), pixel->y());
#ifdef WITH_CALIBRATION
  const std::vector<holdfast::TunedParameter> parameters{{"gain", "", 2.0}, {"decay", "1/s", 2.0}};
  const auto cost = [](std::span<const double> x) { return x[0] + 1 / x[0] + x[1] + 1 / x[1]; };
  if (!holdfast::tune(parameters, cost).ok()) return 1;
#endif
#ifdef WITH_IO
  const holdfast::io::Image image(1, 1, {1, 2, 3, 255});
  if (holdfast::io::encode_png(image).empty()) return 1;
#endif
#ifdef WITH_RENDERING
  std::printf("drawn by %s\n", holdfast::rendering::make_context()->info().gl_renderer.c_str());
#endif
#ifdef WITH_SCENE
  try {
    static_cast<void>(holdfast::scene::load_model("absent.glb"));
    return 1;
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
  }
#endif
#ifdef WITH_GLM
  if (holdfast::to_glm(hmd.left.X_HE.q()).w != 1.0) return 1;
#endif
#ifdef WITH_OPENXR
  if (holdfast::to_xr(hmd.left.X_HE).orientation.w != 1.0f) return 1;
#endif
  return 0;
}
