// The code of docs/optics.md, as it stands there.
#include <cstdio>

#include <doctest/doctest.h>

#include <holdfast/optics/optics.hpp>

using namespace holdfast;

TEST_CASE("the page's first example") {
  HmdModel hmd = default_hmd();
  const EyeModel& eye = hmd.eye(EyeSide::left);
  Matrix4 projection = projection_matrix(eye, ClipPlanes{.near_m = 0.05, .far_m = 100.0});
  std::optional<Vector2> pixel = project(eye, Vector3(0.1, 0.0, -2.0));
  REQUIRE(pixel.has_value());
  // The two ways to the pixel agree.
  const Vector3 ndc = project_to_ndc(projection, Vector3(0.1, 0.0, -2.0)).value();
  CHECK(pixel->x() == doctest::Approx((ndc.x() + 1) / 2 * 1280).epsilon(1e-13));
}

TEST_CASE("the page's second example") {
  FieldResult field = tangents_of(VirtualImage{.w_x = 1.57, .w_y = 1.19, .z_p = -1.18, .x_cw = -0.187, .y_cw = 0.0});
  if (!field.ok()) std::puts(describe(field.problem).data());
  Angle width = fov_horizontal(field.value());
  CHECK(width.degrees() == doctest::Approx(66.35).epsilon(1e-4));
}
