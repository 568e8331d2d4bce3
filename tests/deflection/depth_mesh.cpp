#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/depth_mesh.hpp>
#include <holdfast/deflection/depth_raster.hpp>

#include "deflection/depth_scene.hpp"
#include "deflection/setups.hpp"

using namespace holdfast;

namespace {

struct Drawn {
  Coverage coverage;
  std::vector<SourceSample> samples;

  [[nodiscard]] const SourceSample& at(const EyeModel& eye, int x, int y) const {
    return samples[static_cast<std::size_t>(y * eye.resolution.width + x)];
  }
};

Drawn draw(const ComposedWarp& warp) {
  DepthMesh mesh;
  mesh.update(warp);
  const PixelSize panel = warp.eye().resolution;
  Drawn drawn;
  drawn.samples.resize(static_cast<std::size_t>(panel.width) * static_cast<std::size_t>(panel.height));
  std::vector<float> nearness(drawn.samples.size());
  drawn.coverage = rasterize(mesh, panel, warp.view().size, drawn.samples, nearness);
  return drawn;
}

}  // namespace

TEST_CASE("without motion the mesh shows each pixel itself, over all edges, and nothing is disoccluded") {
  const PixelSize size{160, 120};
  EyeModel eye = default_hmd(size).left;
  const RenderedView view = test::wide_view(size);
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  for (const LensMode mode : {LensMode::none, LensMode::exact}) {
    const ComposedWarp warp(eye, mode, DisplayTiming{}, view, DepthSearch(surface, ScanPose()));
    const Drawn drawn = draw(warp);
    CHECK(drawn.coverage.disoccluded == 0);
    double worst = 0.0;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const SourceSample expected = warp.sample(Vector2(x + 0.5, y + 0.5));
        REQUIRE(drawn.at(eye, x, y).state == expected.state);  // the lens shows the panel's corners farther out
        if (expected.state != SourceState::covered) continue;
        worst = std::max(worst, (drawn.at(eye, x, y).pixel - expected.pixel).norm());
      }
    }
    // Single-precision vertices: 6e-8 of 160 px. With the lens, its curvature inside one pixel of the depth image.
    CHECK(worst < (mode == LensMode::none ? 1e-4 : 1e-2));
  }
}

TEST_CASE("the mesh's vertices stay to the last bit when the eye stays") {
  const PixelSize size{80, 60};
  const EyeModel eye = default_hmd(size).left;
  DisplayTiming timing;
  timing.scan_out = ScanOut::rolling;
  timing.scan_duration = from_milliseconds(11.1);
  const RenderedView view = test::wide_view(size);
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  const DeflectionResult still = deflect({DeflectionKind::depth}, view, LatePoses::at_once(view.X_WS));
  const ComposedWarp warp(eye, LensMode::exact, timing, view, DepthSearch(surface, still.X_SE));
  const ComposedWarp undeflected(eye, LensMode::exact, timing, view, ScanHomography());
  DepthMesh mesh;
  mesh.update(warp);
  CHECK(mesh.disoccluded().empty());
  for (const DepthVertex& vertex : mesh.vertices()) {
    if (!(vertex.source[2] > 0.0f)) continue;
    CHECK(vertex.source[2] == 1.0f);
    const Vector2 source(double(vertex.source[0]) * size.width, double(vertex.source[1]) * size.height);
    const auto panel = undeflected.panel_pixel(source);
    REQUIRE(panel);
    // The source coordinate in the vertex is rounded to single precision: 80 px times 6e-8.
    CHECK((Vector2(double(vertex.panel_x) * size.width, double(vertex.panel_y) * size.height) - *panel).norm() < 2e-5);
  }
}

TEST_CASE("forward mesh and backward search agree, and both with the truth: 0.1 px where not disoccluded") {
  const PixelSize size{320, 240};
  const RenderedView view = test::wide_view(size);
  const EyeModel eye = default_hmd(size).left;
  const test::DepthScene scene = test::room();
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
  test::Random random(901);
  for (int i = 0; i < 4; ++i) {
    const Rigid first(so3::exp<double>(Vector3(0.02, -0.01, 0.03)), random.vector(0.04));
    const Rigid last(first.q() * so3::exp<double>(random.vector(0.02)), first.p() + random.vector(0.006));
    const DeflectionResult result = deflect({DeflectionKind::depth}, view, {view.X_WS * first, view.X_WS * last});
    REQUIRE(result.ok());
    const DisplayTiming timing = random.timing(true);
    const LensMode mode = i % 2 == 0 ? LensMode::none : LensMode::exact;
    const ComposedWarp warp(eye, mode, timing, view, DepthSearch(surface, result.X_SE));
    const Drawn drawn = draw(warp);
    int compared = 0, disoccluded = 0, reported = 0, wrong = 0, at_edge = 0, wrong_at_edge = 0;
    double worst = 0.0, worst_to_search = 0.0;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const Vector2 pixel(x + 0.5, y + 0.5);
        const auto t_E = ideal_tangent_at_panel(eye.lens, mode, tangent_of_pixel(eye, pixel));
        REQUIRE(t_E);
        const auto truth = scene.truth(result.X_SE.at(warp.line_fraction(pixel)), *t_E);
        if (!truth || !is_inside(view, source_pixel_of_tangent(view, truth->t_S))) continue;
        const SourceSample& sample = drawn.at(eye, x, y);
        const SourceSample searched = warp.sample(pixel);
        const double error = (sample.pixel - source_pixel_of_tangent(view, truth->t_S)).norm();
        const bool right = truth->was_seen ? sample.state == SourceState::covered && error < 0.1
                                           : sample.state == SourceState::disoccluded;
        ++compared;
        disoccluded += truth->was_seen ? 0 : 1;
        reported += sample.state == SourceState::disoccluded ? 1 : 0;
        if (test::near_edge(surface, truth->t_S, 2) ||
            test::near_edge(surface, tangent_of_source_pixel(view, sample.pixel), 2)) {
          ++at_edge;
          wrong_at_edge += right ? 0 : 1;
          continue;
        }
        wrong += (sample.state == SourceState::covered) == truth->was_seen ? 0 : 1;
        if (!truth->was_seen || sample.state != SourceState::covered) continue;
        worst = std::max(worst, error);
        // Beside a silhouette, which is known to half a pixel, the search may take the nearer side, at its edge.
        if (test::near_edge(surface, tangent_of_source_pixel(view, searched.pixel), 2)) continue;
        worst_to_search = std::max(worst_to_search, (searched.pixel - sample.pixel).norm());
      }
    }
    MESSAGE("forward mesh: worst ", worst, " px (against the search ", worst_to_search, "); disoccluded: truth ",
            100.0 * disoccluded / compared, " %, stretched triangles ", 100.0 * reported / compared,
            " %; wrong away from edges ", wrong, ", within 2 px of an edge ", wrong_at_edge, " of ", at_edge, " of ",
            compared);
    CHECK(compared > 60000);
    CHECK(worst < 0.1);
    CHECK(worst_to_search < 0.1);
    CHECK(wrong == 0);
    CHECK(wrong_at_edge < 0.5 * at_edge);
    // A stretched bridge begins half a pixel on either side of the edge, and short ones count as covered.
    CHECK(std::abs(reported - disoccluded) < 0.25 * disoccluded + 0.005 * compared);
  }
}

TEST_CASE("the nearer surface wins, and bridges that fold over are left out") {
  const PixelSize size{320, 240};
  const RenderedView view = test::wide_view(size);
  EyeModel eye = default_hmd(size).left;
  test::DepthScene scene;
  scene.planes.push_back(Plane{Vector3(0, 0, 1), -2.0});
  scene.boards.push_back({0.5, -0.1, 0.1, -0.1, 0.1});
  DepthSurface surface;
  REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
  const DeflectionResult result =
      deflect({DeflectionKind::depth}, view, LatePoses::at_once(view.X_WS * Rigid::translation(Vector3(0.05, 0, 0))));
  const ComposedWarp warp(eye, LensMode::none, DisplayTiming{}, view, DepthSearch(surface, result.X_SE));
  const Drawn drawn = draw(warp);
  const auto sample_at = [&](double t_x) {
    const Vector2 pixel = pixel_of_tangent(eye, Vector2(t_x, 0.02));
    return drawn.at(eye, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  };
  // The board reaches from -0.3 to 0.1 now; before, from -0.2 to 0.2.
  for (const double x : {-0.29, -0.2, -0.1, 0.05, 0.08}) {
    CHECK(sample_at(x).state == SourceState::covered);
    // To the pixel, as the sample is that of the pixel's centre.
    CHECK(tangent_of_source_pixel(view, sample_at(x).pixel).x() == doctest::Approx(x + 0.1).epsilon(0.05));
  }
  CHECK(sample_at(0.14).state == SourceState::disoccluded);  // revealed at its right, 0.1 to 0.175
  CHECK(sample_at(0.2).state == SourceState::covered);
  CHECK(sample_at(-0.33).state == SourceState::covered);
}

TEST_CASE(
    "a mesh of another colour goes through that colour's lens; vertices that the panel cannot show are left out") {
  const PixelSize size{80, 60};
  const RenderedView view = test::wide_view(size);
  EyeModel eye = default_hmd(size).left;
  eye.lens_red = Lens(RadialLens{0.15}, placed_at(0.4));
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  const ComposedWarp warp(eye, LensMode::exact, DisplayTiming{}, view, DepthSearch(surface, ScanPose()));
  DepthMesh mesh;
  mesh.update(warp, Color::red);
  const auto& vertex = mesh.vertices()[30 * 80 + 20];
  const auto expected = warp.panel_pixel(Vector2(20.5, 30.5), Color::red);
  REQUIRE(expected);
  CHECK(double(vertex.panel_x) * 80 == doctest::Approx(expected->x()).epsilon(1e-6));
  eye.lens = Lens(RadialLens{-0.4}, placed_at(0.5));  // folds over inside the panel
  mesh.update(warp, Color::green);
  CHECK(mesh.vertices()[0].source[2] == 0.0f);
  for (const std::uint32_t i : mesh.solid()) CHECK(mesh.vertices()[i].source[2] > 0.0f);
}

TEST_CASE("a triangle that reaches far beyond the panel is drawn on it, one without end is left out") {
  const PixelSize panel{8, 6};
  std::vector<SourceSample> samples(48);
  std::vector<float> nearness(48, -1.0f);
  const deflection_detail::DepthTarget target{panel, panel, samples, nearness};
  const auto vertex = [](float x, float y) { return DepthVertex{x, y, 1.0f, {x, y, 1.0f}}; };
  constexpr float far = 1e20f, infinite = std::numeric_limits<float>::infinity();
  const auto covered = [&](const DepthVertex& a, const DepthVertex& b, const DepthVertex& c) {
    std::fill(nearness.begin(), nearness.end(), -1.0f);
    deflection_detail::fill_triangle(target, a, b, c, SourceState::covered);
    return std::count(nearness.begin(), nearness.end(), 1.0f);
  };
  CHECK(covered(vertex(-1, -1), vertex(3, -1), vertex(-1, 3)) == 48);
  CHECK(covered(vertex(-far, -far), vertex(far, -far), vertex(0, far)) == 48);
  CHECK(covered(vertex(far, far), vertex(2 * far, far), vertex(far, 2 * far)) == 0);
  CHECK(covered(vertex(-far, -far), vertex(-2 * far, -far), vertex(-far, -2 * far)) == 0);
  CHECK(covered(vertex(-1, -1), vertex(infinite, -1), vertex(-1, 3)) == 0);
  CHECK(covered(vertex(-1, -1), vertex(3, NAN), vertex(-1, 3)) == 0);
  CHECK(covered(vertex(0, 0), vertex(1, 0), vertex(0, 1)) > 20);
}
