// The late warp on the GPU against a bare pass over the same mesh with as many texture fetches and nothing else: plain texture
// coordinates, no division, no coverage. Both are drawn in turn in one run, timed by the CPU's clock round glFinish.
//
//   build/bench/bin/bench_gl_warp
//
// `ratio` is the median of the late warp over that of the bare pass; it must be at most 1.15.
#include <algorithm>
#include <vector>

#include <benchmark/benchmark.h>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/rendering/frame_time.hpp>
#include <holdfast/rendering/late_warp_pass.hpp>
#include <holdfast/rendering/make_context.hpp>

namespace {

using namespace holdfast;
using namespace holdfast::rendering;

constexpr ShaderSource bare_vert{"bare.vert", R"glsl(#version 450 core
layout(location = 0) in vec2 place;
layout(location = 2) in vec2 green;
out vec2 uv;
void main() {
  uv = 0.5 + 0.5 * green;
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
)glsl"};
constexpr ShaderSource bare_frag{"bare.frag", R"glsl(#version 450 core
in vec2 uv;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;
void main() { result = textureLod(picture, uv, 0.0); }
)glsl"};
constexpr ShaderSource bare_per_colour_vert{"bare_per_colour.vert", R"glsl(#version 450 core
layout(location = 0) in vec2 place;
layout(location = 1) in vec2 red;
layout(location = 2) in vec2 green;
layout(location = 3) in vec2 blue;
out vec2 uv_red, uv_green, uv_blue;
void main() {
  uv_red = 0.5 + 0.5 * red;
  uv_green = 0.5 + 0.5 * green;
  uv_blue = 0.5 + 0.5 * blue;
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
)glsl"};
constexpr ShaderSource bare_per_colour_frag{"bare_per_colour.frag", R"glsl(#version 450 core
in vec2 uv_red, uv_green, uv_blue;
layout(binding = 0) uniform sampler2D picture;
out vec4 result;
void main() {
  result = vec4(textureLod(picture, uv_red, 0.0).r, textureLod(picture, uv_green, 0.0).g,
                textureLod(picture, uv_blue, 0.0).b, 1.0);
}
)glsl"};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

EyeModel eye_of(bool per_colour) {
  EyeModel eye = default_hmd().left;  // 1280 x 720
  if (!per_colour) return eye;
  eye.lens_red = Lens(RadialLens{0.1836}, eye.lens.placement());
  eye.lens_blue = Lens(RadialLens{0.203}, eye.lens.placement());
  return eye;
}

void late_warp(benchmark::State& state, Backend backend, bool per_colour, bool rolling) {
  const auto context = make_context(backend);
  const GlFunctions& gl = context->gl();
  const EyeModel eye = eye_of(per_colour);
  const WarpMesh mesh(*context, adaptive_mesh(eye, LensMode::exact));
  RenderTarget source(*context, eye.resolution.width, eye.resolution.height);
  RenderTarget result(*context, eye.resolution.width, eye.resolution.height);
  source.clear({0.3f, 0.5f, 0.7f, 1.0f});
  const RenderedPicture<RenderTarget*> picture({Rigid(), eye.tangents, eye.resolution, HostTime{}}, &source);
  const auto turned = [](double degrees_up) {
    return Rigid::rotation(so3::exp<double>(Vector3(0.017 * degrees_up, 0.01, 0.005)));
  };
  const DisplayTiming timing{.scan_out = rolling ? ScanOut::rolling : ScanOut::global,
                             .scan_duration = std::chrono::milliseconds(11)};
  const LatePoses late = rolling ? LatePoses{turned(0.5), turned(1.5)} : LatePoses::at_once(turned(1.0));
  const ScanHomography H_SE = deflect({}, picture, late).H_SE;

  const LateWarpPass pass(*context);
  const Program bare(*context, per_colour ? bare_per_colour_vert : bare_vert,
                     per_colour ? bare_per_colour_frag : bare_frag);
  const auto draw_late = [&] { pass.draw(picture, mesh, H_SE, timing, result); };
  const auto draw_bare = [&] {
    result.clear({0, 0, 0, 0});
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_CULL_FACE);
    bare.use();
    gl.BindTextureUnit(0, source.colour_texture());
    mesh.draw();
  };
  std::vector<double> late_ms, bare_ms;
  for (int i = 0; i < 4; ++i) {  // shaders are compiled at first use
    draw_late();
    draw_bare();
  }
  for (auto _ : state) {
    bare_ms.push_back(frame_ms(*context, draw_bare));
    late_ms.push_back(frame_ms(*context, draw_late));
    state.SetIterationTime(1e-3 * late_ms.back());
  }
  state.counters["late_ms"] = median(late_ms);
  state.counters["bare_ms"] = median(bare_ms);
  state.counters["ratio"] = median(late_ms) / median(bare_ms);
  state.counters["vertices"] = static_cast<double>(mesh.vertex_count());
}

void register_all() {
  for (const Backend backend : built_backends()) {
    for (const bool per_colour : {false, true}) {
      for (const bool rolling : {false, true}) {
        const std::string name = "late_warp/" + std::string(backend_name(backend)) +
                                 (per_colour ? "/three_colours" : "/one_colour") + (rolling ? "/rolling" : "/global");
        benchmark::RegisterBenchmark(name.c_str(), late_warp, backend, per_colour, rolling)
            ->UseManualTime()
            ->Iterations(120)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

[[maybe_unused]] const bool registered = (register_all(), true);

}  // namespace
