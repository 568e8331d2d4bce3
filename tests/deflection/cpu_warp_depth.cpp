// The CPU warp by depth, against its definition.
#include <doctest/doctest.h>

#include <holdfast/deflection/cpu_warp.hpp>

#include "deflection/depth_scene.hpp"
#include "deflection/warp_pictures.hpp"

using namespace holdfast;

TEST_CASE("by depth the CPU warp shows what the search finds, per colour, with vectors and without, on any threads") {
  EyeModel eye = default_hmd({83, 61}).left;
  eye.lens_red = Lens(RadialLens{0.15}, placed_at(0.5));
  const double half_x = 1.2 * tan(degrees(30)), half_y = half_x * 61 / 83;
  const RenderedView view{{}, {-half_x, half_x, -half_y, half_y}, {120, 90}, {}};
  DepthSurface surface;
  REQUIRE(surface.update(view, test::room().depth_image(view)) == DepthProblem::none);
  DisplayTiming timing;
  timing.scan_out = ScanOut::rolling;
  timing.scan_duration = from_milliseconds(11.1);
  const LatePoses late{Rigid::translation(Vector3(0.02, 0.01, 0.0)),
                       Rigid(so3::exp<double>(Vector3(0.0, 0.02, 0.01)), Vector3(0.03, 0.0, 0.0))};
  const DeflectionResult result = deflect({DeflectionKind::depth}, view, late);
  REQUIRE(result.ok());
  const ComposedWarp warp(eye, LensMode::exact, timing, view, DepthSearch(surface, result.X_SE));
  // Linear in the pixel, which bilinear interpolation returns exactly, half a pixel from the border on.
  test::Picture<float> source(120, 90);
  source.fill([](double x, double y, int c) { return c == 3 ? 1.0 : c == 1 ? y : x; });
  const WarpLattice lattice(eye, LensMode::exact);
  test::Picture<float> first(83, 61);
  for (const bool vectors : {false, true}) {
    for (const int threads : {1, 3}) {
      CpuWarp cpu({.threads = threads, .vectors = vectors});
      test::Picture<float> target(83, 61);
      REQUIRE(cpu.draw<float>(lattice, warp, source.span(), target.span()) == CpuWarpProblem::none);
      if (first.at(41, 30, 3) == 0.0F) first = target;
      int compared = 0, disoccluded = 0;
      for (int y = 0; y < 61; ++y) {
        for (int x = 0; x < 83; ++x) {
          const Vector2 pixel(x + 0.5, y + 0.5);
          const SourceSample red = warp.sample(pixel, Color::red), green = warp.sample(pixel, Color::green);
          const auto shown = [](const SourceSample& sample) {
            return sample.state == SourceState::covered || sample.state == SourceState::disoccluded;
          };
          const auto inner = [](const Vector2& p) { return p.x() > 1 && p.y() > 1 && p.x() < 119 && p.y() < 89; };
          if (!shown(red) || !shown(green) || !inner(red.pixel) || !inner(green.pixel)) continue;
          // Single precision: 120 px times a few 6e-8.
          CHECK(std::abs(double(target.at(x, y, 0)) - red.pixel.x()) < 1e-4);
          CHECK(std::abs(double(target.at(x, y, 1)) - green.pixel.y()) < 1e-4);
          CHECK(target.at(x, y, 3) == doctest::Approx(1.0));
          CHECK(std::abs(target.at(x, y, 2) - first.at(x, y, 2)) < 1e-4F);
          ++compared;
          disoccluded += green.state == SourceState::disoccluded ? 1 : 0;
        }
      }
      CHECK(compared > 4000);
      CHECK(disoccluded > 20);
    }
  }
}

TEST_CASE("by depth, what lies beyond the picture is the border") {
  const EyeModel eye = test::plain_eye(40, 30);
  const RenderedView view{{}, eye.tangents, {40, 30}, {}};
  DepthSurface surface;
  REQUIRE(surface.update(view, DepthImage{{40, 30}, std::vector<float>(1200, 1.0F)}) == DepthProblem::none);
  const ScanPose moved({}, LatePoses::at_once(Rigid::translation(Vector3(0.010, 0.0, 0.0))));  // 10 px at 1 m
  const ComposedWarp warp(eye, LensMode::none, DisplayTiming{}, view, DepthSearch(surface, moved));
  const test::Picture<std::uint8_t> source = test::noise<std::uint8_t>(40, 30, 5, true);
  test::Picture<std::uint8_t> target(40, 30);
  CpuWarp cpu({.threads = 1});
  REQUIRE(cpu.draw<std::uint8_t>(WarpLattice(eye, LensMode::none), warp, source.span(), target.span()) ==
          CpuWarpProblem::none);
  for (int y = 0; y < 30; ++y) {
    for (int c = 0; c < 4; ++c) {
      CHECK(target.at(5, y, c) == source.at(15, y, c));
      CHECK(target.at(35, y, c) == 0);
    }
  }
}
