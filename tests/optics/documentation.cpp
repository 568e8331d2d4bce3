// The code of docs/optics.md, as it stands there.
#include <cstdio>
#include <vector>

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

TEST_CASE("the page's lenses") {
  EyeModel eye = default_hmd().left;
  eye.lens = Lens(RadialLens{0.1933}, placed_at(0.504));
  eye.lens_red = Lens(PolynomialLens(std::vector{0.22, 0.24}, 0.996), placed_at(0.91, Vector2(0.15, 0.0)));
  eye.lens_blue = ReversedLens(BrownConradyLens({.k1 = -0.283, .k2 = 0.074}));
  std::optional<Vector2> panel = eye.lens.undistort(Vector2(0.3, 0.2));
  double radius = eye.lens.valid_radius();
  CHECK(panel.has_value());
  CHECK(radius > 1.0);
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    const Vector2 seen = seen_pixel(eye, LensMode::exact, Vector2(700.0, 300.0), color).value();
    CHECK((seen - Vector2(700.0, 300.0)).norm() < 1e-11);
  }
}
