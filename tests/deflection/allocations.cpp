// What a frame does to deflect allocates nothing: counted by replacing the global operator new of this test program.
#include <cmath>
#include <cstddef>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/deflection.hpp>
#include <holdfast/optics/hmd.hpp>

#include "allocation_counter.hpp"
#include "deflection/depth_scene.hpp"

using namespace holdfast;

TEST_CASE("deflecting a frame by any kind allocates nothing once its memory is there") {
  const PixelSize size{64, 48};
  const EyeModel eye = default_hmd(size).left;
  DisplayTiming timing;
  timing.scan_out = ScanOut::rolling;
  timing.scan_duration = from_milliseconds(11.1);
  const RenderedPicture<DepthImage> depth({{}, eye.tangents, size, {}},
                                          test::room().depth_image({{}, eye.tangents, size, {}}));
  const RenderedView& view = depth.view();
  const LatePoses late{Rigid::translation(Vector3(0.01, 0.0, 0.0)),
                       Rigid(so3::exp<double>(Vector3(0.0, 0.02, 0.0)), Vector3(0.02, 0.0, 0.0))};
  const PredistortionMesh lens_mesh = grid_mesh(eye, LensMode::exact, 8, 8);
  std::vector<DeflectedVertex> vertices(lens_mesh.vertices.size());
  std::vector<SourceState> mask(16 * 9);
  std::vector<SourceSample> samples(64 * 48);
  std::vector<float> nearness(samples.size());
  DepthSurface surface;
  DepthMesh mesh;
  double sum = 0.0;
  const auto frame = [&] {
    for (const DeflectionKind kind : deflection_kinds) {
      const DeflectionResult result = deflect({kind, 1.0}, depth, late);
      sum += result.ok() ? result.H_SE.at(0.3).sum() : 0.0;
      deflect_mesh(lens_mesh, source_matrices(view, result.H_SE), timing, vertices);
      const ComposedWarp warp(eye, LensMode::exact, timing, view, result.H_SE);
      sum += warp.source_pixel(Vector2(30, 20))->sum() + warp.seen_pixel(Vector2(30, 20))->sum();
      sum += coverage(warp, {16, 9}, mask).missing_pct();
    }
    surface.update(depth);
    const ScanPose X_SE = deflect({DeflectionKind::depth}, depth, late).X_SE;
    const ComposedWarp warp(eye, LensMode::exact, timing, view, DepthSearch(surface, X_SE));
    sum += coverage(warp, {16, 9}, mask).disocclusion_pct();
    mesh.update(warp);
    sum += rasterize(mesh, size, size, samples, nearness).missing_pct();
  };
  frame();
  const std::size_t before = test::allocations();
  frame();
  const std::size_t after = test::allocations();
  CHECK(after == before);
  CHECK(std::isfinite(sum));
  CHECK(test::counts_allocations());
}

TEST_CASE("warping on the CPU allocates nothing after the first frame, with threads of its own") {
  EyeModel eye = default_hmd({200, 120}).left;
  eye.lens_red = Lens(RadialLens{0.18});
  DisplayTiming timing;
  timing.scan_out = ScanOut::rolling;
  timing.scan_duration = from_milliseconds(11.1);
  const RenderedView view{{}, eye.tangents, eye.resolution, {}};
  const WarpLattice lattice(eye, LensMode::exact);
  std::vector<std::uint8_t> source(4 * 200 * 120, 9);
  std::vector<std::uint8_t> target(source.size());
  CpuWarp warp({2});
  const auto frame = [&](double turn) {
    const Rigid late(so3::exp<double>(Vector3(0.0, turn, 0.0)), Vector3::Zero());
    const DeflectionResult result = deflect({}, view, {late, Rigid()});
    const ComposedWarp composed(eye, LensMode::exact, timing, view, result.H_SE);
    return warp.draw(lattice, composed, PictureSpan<std::uint8_t>(source.data(), 200, 120),
                     PictureSpan<std::uint8_t>(target.data(), 200, 120));
  };
  CHECK(frame(0.01) == CpuWarpProblem::none);
  const std::size_t before = test::allocations();
  int problems = 0;
  for (int i = 0; i < 20; ++i) problems += frame(0.002 * i) != CpuWarpProblem::none;
  const std::size_t after = test::allocations();
  CHECK(after == before);
  CHECK(problems == 0);
}
