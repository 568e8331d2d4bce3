#include <doctest/doctest.h>

#include <holdfast/rendering/frame_time.hpp>
#include <holdfast/rendering/make_context.hpp>
#include <holdfast/rendering/mesh.hpp>
#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/shaders.hpp>

using namespace holdfast;
using namespace holdfast::rendering;

TEST_CASE("a shader that does not compile is named with its line and the driver's log") {
  for (const Backend backend : built_backends()) {
    const auto context = make_context(backend);
    const ShaderSource broken{"broken.frag",
                              "#version 450 core\nout vec4 result;\nvoid main() {\n  result = nonsense;\n}\n"};
    try {
      const Program program(*context, shaders::full_screen_vert, broken);
      FAIL("must not compile");
    } catch (const ShaderError& error) {
      CHECK(error.shader() == "broken.frag");
      CHECK(error.line() == 4);
      CHECK(std::string(error.what()).find("shader broken.frag, line 4: ") == 0);
      CHECK(std::string(error.what()).find("nonsense") != std::string::npos);
    }
  }
}

TEST_CASE("a definition reaches both shaders, and lines keep their numbers") {
  const auto context = make_context();
  const ShaderSource guarded{"guarded.frag",
                             "#version 450 core\nout vec4 result;\n#ifdef WANTED\nvoid main() { result = vec4(1); }\n"
                             "#else\nvoid main() { result = nonsense; }\n#endif\n"};
  CHECK_NOTHROW(Program(*context, shaders::full_screen_vert, guarded, "WANTED"));
  try {
    const Program program(*context, shaders::full_screen_vert, guarded, "OTHER");
    FAIL("must not compile");
  } catch (const ShaderError& error) {
    CHECK(error.line() == 6);
  }
}

TEST_CASE("shaders that do not fit together are both named") {
  const auto context = make_context();
  const ShaderSource fragment{
      "wants_more.frag",
      "#version 450 core\nin vec3 absent;\nout vec4 result;\nvoid main() { result = vec4(absent, 1); }\n"};
  CHECK_THROWS_WITH_AS(Program(*context, shaders::full_screen_vert, fragment),
                       doctest::Contains("full_screen.vert with wants_more.frag"), ShaderError);
}

TEST_CASE("lines are read from the logs of several drivers") {
  CHECK(line_of_shader_log("0:12(5): error: x") == 12);
  CHECK(line_of_shader_log("0(7) : error C1008: undefined") == 7);
  CHECK(line_of_shader_log("ERROR: 0:31: 'a' : undeclared") == 31);
  CHECK(!line_of_shader_log("something went wrong"));
  CHECK(!line_of_shader_log(""));
}

TEST_CASE("a uniform that the program does not have is an error, not a silence") {
  const auto context = make_context();
  const Program program(*context, shaders::lit_vert, shaders::lit_frag);
  CHECK(program.uniform("base_colour") >= 0);
  CHECK_THROWS_WITH_AS(static_cast<void>(program.uniform("base_color")), doctest::Contains("base_color"),
                       RenderingError);
}

TEST_CASE("a box has twelve triangles, and a draw is timed") {
  const auto context = make_context();
  const Mesh box = make_box(*context, Vector3(-1, -1, -1), Vector3(1, 2, 3));
  CHECK(box.triangle_count() == 12);
  int calls = 0;
  const double ms = median_frame_ms(*context, 5, [&](int) { ++calls; });
  CHECK(calls == 7);  // two of them warm up
  CHECK(ms >= 0.0);
}
