// The code of docs/deflection.md, as it stands there, round an engine of a few lines.
#include <cstdint>
#include <cstdio>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/deflection.hpp>
#include <holdfast/optics/hmd.hpp>

using namespace holdfast;

namespace {
struct Texture {
  int id = 0;
};
Texture engine_draws(const RenderedView&) {
  return {7};
}
void engine_warps(const Texture&, const SourceMatrices&, const Vector3&) {}
}  // namespace

TEST_CASE("the page's first example: a frame with a late rotation") {
  HmdModel hmd = default_hmd();
  const EyeModel& eye = hmd.left;
  FieldTangents overfilled_field = eye.tangents;
  PixelSize overfilled_size = eye.resolution;
  HostTime display_time{};
  Rigid X_WE_predicted, X_WE_at_scan_begin, X_WE_at_scan_middle, X_WE_at_scan_end;
  X_WE_at_scan_middle = Rigid::rotation(so3::exp<double>(Vector3(0.0, 0.01, 0.0)));
  X_WE_at_scan_end = Rigid::rotation(so3::exp<double>(Vector3(0.0, 0.02, 0.0)));
  int shown = 0;

  // The picture is drawn for a predicted pose, which stays with it.
  RenderedView view{X_WE_predicted, overfilled_field, overfilled_size, display_time};
  RenderedPicture<Texture> picture(view, engine_draws(view));

  // Just before scan-out: where is the eye really?
  LatePoses late{X_WE_at_scan_begin, X_WE_at_scan_end, X_WE_at_scan_middle};
  DeflectionResult deflection = deflect({.kind = DeflectionKind::rotation}, picture, late);
  if (!deflection.ok()) std::puts(describe(deflection.problem).data());  // it is shown as it was drawn

  SourceMatrices M = source_matrices(picture.view(), deflection.H_SE);
  engine_warps(picture.picture(), M, line_fraction_coefficients(hmd.timing));
  shown = picture.picture().id;

  CHECK(shown == 7);
  CHECK(deflection.ok());
  CHECK_FALSE(M.is_constant());
}

TEST_CASE("the page's second example: by depth, with its disocclusion") {
  HmdModel hmd = default_hmd({64, 48});
  const EyeModel& eye = hmd.left;
  const PixelSize size = eye.resolution;
  const RenderedPicture<Texture> picture(RenderedView{{}, eye.tangents, size, {}}, Texture{});
  const LatePoses late = LatePoses::at_once(Rigid::translation(Vector3(0.01, 0, 0)));
  const ClipPlanes clip{0.05, 100.0};
  const std::vector<float> depth_buffer(64 * 48, 0.98f);

  DepthImage depth{size, std::vector<float>(depth_buffer.size())};
  distances_of_depth_buffer(depth_buffer, projection_matrix(picture.view().tangents, clip),
                            DepthRange::minus_one_to_one, depth.distance_m);
  DepthSurface surface;  // keep it: it takes its memory once
  if (surface.update(picture.view(), depth) != DepthProblem::none) std::puts("no depth deflection this frame");

  DeflectionResult deflection = deflect({.kind = DeflectionKind::depth}, picture, late);
  ComposedWarp warp(eye, LensMode::exact, hmd.timing, picture.view(), DepthSearch(surface, deflection.X_SE));
  SourceSample sample = warp.sample(Vector2(30.5, 20.5));  // source pixel; covered, disoccluded, outside or not_seen
  std::vector<SourceState> mask(128 * 72);
  Coverage view = coverage(warp, {128, 72}, mask);
  std::printf("%.2f %% missing, %.2f %% disoccluded\n", view.missing_pct(), view.disocclusion_pct());

  CHECK(sample.state == SourceState::covered);
  CHECK(view.disocclusion_pct() == 0.0);  // a single plane hides nothing
}

TEST_CASE("the page's example on a CPU") {
  const EyeModel eye = default_hmd({64, 48}).left;
  const RenderedView view{Rigid(), eye.tangents, {64, 48}, {}};
  const int width = view.size.width, height = view.size.height;
  const ComposedWarp composed_warp(eye, LensMode::exact, {}, view, {});
  const std::vector<std::uint8_t> picture(4 * 64 * 48, 200);
  std::vector<std::uint8_t> panel(picture.size());
  const std::uint8_t* pixels = picture.data();
  std::uint8_t* panel_pixels = panel.data();

  WarpLattice lattice(eye, LensMode::exact);
  CpuWarp warp({.threads = 2, .filter = WarpFilter::bilinear});

  PictureSpan<const std::uint8_t> source(pixels, width, height);
  PictureSpan<std::uint8_t> target(panel_pixels, eye.resolution.width, eye.resolution.height);
  CpuWarpProblem problem = warp.draw(lattice, composed_warp, RenderedPicture(view, source), target);
  if (problem != CpuWarpProblem::none) std::puts(describe(problem).data());

  CHECK(problem == CpuWarpProblem::none);
  CHECK(*target.pixel(32, 24) == 200);
}
