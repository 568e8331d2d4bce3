#include <doctest/doctest.h>

#include <holdfast/rendering/make_context.hpp>
#include <holdfast/rendering/render_target.hpp>

using namespace holdfast;
using namespace holdfast::rendering;

TEST_CASE("a cleared target reads back its colour and depth, with one sample and with four") {
  for (const Backend backend : built_backends()) {
    const auto context = make_context(backend);
    for (const int samples : {1, 4}) {
      CAPTURE(backend_name(backend));
      CAPTURE(samples);
      RenderTarget target(*context, 17, 5, samples);  // an odd width: rows without padding
      target.clear({0.2f, 0.4f, 0.6f, 1.0f}, 0.25f);
      const io::Image image = target.read_rgba();
      CHECK(image == io::Image(17, 5, {51, 102, 153, 255}));  // 0.2 * 255 = 51: linear, no sRGB encoding
      const std::vector<float> depth = target.read_depth();
      REQUIRE(depth.size() == 17 * 5);
      for (const float d : depth) CHECK(d == 0.25f);
    }
  }
}

TEST_CASE("row 0 is the bottom row") {
  const auto context = make_context();
  RenderTarget target(*context, 4, 4);
  target.clear();
  const GlFunctions& gl = context->gl();
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(1, 0, 1, 1);
  gl.ClearColor(1, 1, 1, 1);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  CHECK(target.read_rgba().at(1, 0) == io::Rgba{255, 255, 255, 255});
  CHECK(target.read_rgba().at(1, 3) == io::Rgba{0, 0, 0, 255});
}

TEST_CASE("impossible targets are refused in words") {
  const auto context = make_context();
  CHECK_THROWS_WITH_AS(RenderTarget(*context, 0, 5), "a render target of 0 x 5 pixels; expected at least 1 x 1",
                       RenderingError);
  CHECK_THROWS_AS(RenderTarget(*context, 8, 8, 1000), RenderingError);
  CHECK_THROWS_AS(RenderTarget(*context, 1 << 20, 1 << 20), RenderingError);
  // and the context still works
  RenderTarget target(*context, 2, 2);
  target.clear({1, 1, 1, 1});
  CHECK(target.read_rgba().at(0, 0) == io::Rgba{255, 255, 255, 255});
}
