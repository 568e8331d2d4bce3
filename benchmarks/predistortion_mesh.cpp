// Building the predistortion meshes of both eyes, to 0.05 px (at most 2 ms): the default headset, 1280 x 720, the same
// seen through an eye's own field only, and every headset of assets/hmds; those also as if they were not symmetric
// (each_eye). Counters: vertices and triangles of one eye, the stated error. A fixed 64 x 64 grid is there to compare
// with.
//     bench_predistortion_mesh [Google Benchmark options...]
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <holdfast/io/hmd.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>

namespace {

using namespace holdfast;

template <typename Build>
void both_eyes(benchmark::State& state, const Build& build) {
  EyeMeshes meshes;
  for (auto _ : state) {
    meshes = build();
    benchmark::DoNotOptimize(meshes.left.vertices.data());
    benchmark::DoNotOptimize(meshes.right.vertices.data());
  }
  state.counters["vertices"] = static_cast<double>(meshes.left.vertices.size());
  state.counters["triangles"] = static_cast<double>(meshes.left.triangle_count());
  state.counters["error_px"] = meshes.left.max_error_px;
}

void adaptive(benchmark::State& state, const HmdModel& hmd, double bound_px) {
  both_eyes(state, [&] { return adaptive_meshes(hmd, LensMode::exact, {.max_error_px = bound_px}); });
}

/// As if the headset were not symmetric.
void each_eye(benchmark::State& state, const HmdModel& hmd) {
  both_eyes(state, [&] {
    return EyeMeshes{adaptive_mesh(hmd.left, LensMode::exact), adaptive_mesh(hmd.right, LensMode::exact)};
  });
}

void within_field(benchmark::State& state, const HmdModel& hmd) {
  both_eyes(state, [&] { return adaptive_meshes(hmd, LensMode::exact, {.field = hmd.left.tangents}); });
}

void grid(benchmark::State& state, const HmdModel& hmd) {
  both_eyes(state, [&] {
    return EyeMeshes{grid_mesh(hmd.left, LensMode::exact, 64, 64), grid_mesh(hmd.right, LensMode::exact, 64, 64)};
  });
}

int register_all() {
  const HmdModel usual = default_hmd();
  const auto in_ms = [](auto* run) { run->Unit(benchmark::kMillisecond); };
  in_ms(benchmark::RegisterBenchmark("default/0.05_px", adaptive, usual, 0.05));
  in_ms(benchmark::RegisterBenchmark("default/0.5_px", adaptive, usual, 0.5));
  in_ms(benchmark::RegisterBenchmark("default/0.05_px/own_field", within_field, usual));
  in_ms(benchmark::RegisterBenchmark("default/grid_64x64", grid, usual));
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(HOLDFAST_SOURCE_DIR "/assets/hmds")) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const HmdModel hmd = io::read_hmd(file);
    const std::string name = file.stem().string();
    in_ms(benchmark::RegisterBenchmark((name + "/0.05_px").c_str(), adaptive, hmd, 0.05));
    in_ms(benchmark::RegisterBenchmark((name + "/0.05_px/each_eye").c_str(), each_eye, hmd));
  }
  return 0;
}

[[maybe_unused]] const int registered = register_all();

}  // namespace
