// The code of docs/optics.md, "Predistortion mesh and overfill", as it stands there.
#include <cstdio>

#include <doctest/doctest.h>

#include <holdfast/optics/optics.hpp>

using namespace holdfast;

TEST_CASE("the page's mesh and overfill") {
  const EyeModel eye = default_hmd().left;
  PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact);
  if (!mesh.ok()) std::puts(describe(mesh.problem).data());
  const PredistortionVertex& v = mesh.vertices[mesh.triangles[0]];
  CHECK(v.panel_x >= 0.0f);
  PredistortionMesh plain = grid_mesh(eye, LensMode::exact, 64, 64);
  CHECK(plain.max_error_px == doctest::Approx(0.34).epsilon(0.02));  // as the page says

  DeflectionBudget budget{degrees(6), degrees(4), degrees(3)};
  FieldTangents wide = overfilled(eye.tangents, budget);
  PixelSize size = overfilled_size(eye, wide);
  EyePicture exact = whole_pixels(eye, wide);
  FieldResult seen = overfilled(mesh, budget);
  CHECK(size.width > eye.resolution.width);
  CHECK(exact.size.width >= size.width);
  REQUIRE(seen.ok());
  CHECK(seen.value().right > wide.right);  // this lens magnifies
}
