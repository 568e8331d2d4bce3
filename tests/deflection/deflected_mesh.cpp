#include <cstring>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/deflected_mesh.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

namespace {

std::vector<DeflectedVertex> deflected(const PredistortionMesh& mesh, const RenderedView& view,
                                       const DisplayTiming& timing, const DeflectionSettings& settings,
                                       const LatePoses& late) {
  const DeflectionResult result = deflect(settings, view, late);
  REQUIRE(result.ok());
  std::vector<DeflectedVertex> vertices(mesh.vertices.size());
  deflect_mesh(mesh, source_matrices(view, result.H_SE), timing, vertices);
  return vertices;
}

DisplayTiming rolling_timing() {
  DisplayTiming timing;
  timing.scan_out = ScanOut::rolling;
  timing.scan_duration = from_milliseconds(11.1);
  return timing;
}

}  // namespace

TEST_CASE("zero motion gives the mesh of no deflection, to the last bit, for every kind and pose") {
  test::Random random(601);
  for (int i = 0; i < 5; ++i) {
    const EyeModel eye = random.eye();
    const PredistortionMesh mesh = grid_mesh(eye, LensMode::exact, 8, 8);
    REQUIRE(mesh.ok());
    const DisplayTiming timing = random.timing(true);
    const RenderedView view = random.view(eye);
    const LatePoses still = LatePoses::at_once(view.X_WS);
    std::vector<DeflectedVertex> undeflected(mesh.vertices.size());
    deflect_mesh(mesh, source_matrices(view, ScanHomography()), timing, undeflected);
    for (const DeflectionKind kind : deflection_kinds) {
      const auto vertices = deflected(mesh, view, timing, {kind, 1.0}, still);
      CHECK(std::memcmp(vertices.data(), undeflected.data(), vertices.size() * sizeof(DeflectedVertex)) == 0);
    }
    for (const DeflectedVertex& vertex : undeflected) {
      for (int color = 0; color < 3; ++color) CHECK(vertex.source[color][2] == 1.0f);
    }
  }
}

TEST_CASE("every vertex shows what the composed warp says of its panel point") {
  test::Random random(602);
  double worst = 0.0;
  for (int i = 0; i < 10; ++i) {
    const EyeModel eye = random.eye();
    const PredistortionMesh mesh = grid_mesh(eye, LensMode::exact, 8, 8);
    REQUIRE(mesh.ok());
    const DisplayTiming timing = random.timing(i % 2 == 0);
    const RenderedView view = random.view(eye);
    const LatePoses late{view.X_WS * random.pose(0.1, 0.05), view.X_WS * random.pose(0.1, 0.05)};
    const DeflectionResult result = deflect({DeflectionKind::plane, 1.5}, view, late);
    const ComposedWarp warp(eye, LensMode::exact, timing, view, result.H_SE);
    const auto vertices = deflected(mesh, view, timing, {DeflectionKind::plane, 1.5}, late);
    for (const DeflectedVertex& vertex : vertices) {
      const Vector2 panel(double(vertex.panel_x) * eye.resolution.width,
                          double(vertex.panel_y) * eye.resolution.height);
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        const float* uvw = vertex.source[static_cast<int>(color)];
        const auto expected = warp.source_pixel(panel, color);
        REQUIRE(expected);
        const Vector2 shown(double(uvw[0] / uvw[2]) * view.size.width, double(uvw[1] / uvw[2]) * view.size.height);
        worst = std::max(worst, (shown - *expected).norm());
      }
    }
  }
  MESSAGE("vertices of the deflected mesh against the composed warp: worst ", worst, " px");
  // Single precision: a few roundings of 6e-8 in tangents, times 2000 px.
  CHECK(worst < 2e-3);
}

TEST_CASE("on a global display the late correction adds no error inside a triangle; on a rolling one little per cell") {
  const EyeModel eye = default_hmd().left;
  const RenderedView view{{}, eye.tangents, eye.resolution, {}};
  const LatePoses late =
      test::moved_on(view, Vector3(0.1, degrees(200).radians(), 0.2), Vector3(0.3, 0, 0.2), 0.01, 0.0111);
  const auto error = [&](int cells, const LatePoses& poses, const DisplayTiming& timing) {
    const PredistortionMesh mesh = grid_mesh(eye, LensMode::none, cells, cells);
    const DeflectionResult result = deflect({}, view, poses);
    return scan_error_px(mesh, source_matrices(view, result.H_SE), timing, view.size);
  };
  CHECK(error(1, LatePoses::at_once(late.X_WE_end), DisplayTiming{}) < 1e-9);
  const double coarse = error(16, late, rolling_timing()), fine = error(32, late, rolling_timing());
  MESSAGE("scan error of a deflected grid at 200 deg/s, 11.1 ms: 16 x 16 cells ", coarse, " px, 32 x 32 cells ", fine,
          " px, two triangles ", error(1, late, rolling_timing()), " px");
  CHECK(fine < 0.02);
  CHECK(coarse / fine == doctest::Approx(4.0).epsilon(0.1));
}
