#include <array>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/optics/lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("a reversed lens undoes the lens") {
  const BrownConradyLens camera(test::euroc);
  const ReversedLens<BrownConradyLens> display(camera);
  test::for_disc(Vector2::Zero(), 0.8, [&](const Vector2& p) {
    CHECK(*display.undistort(p) == *camera.distort(p));
    CHECK(*display.distort(p) == *camera.undistort(p));
    CHECK((*camera.distort(*display.distort(p)) - p).norm() < 1e-15);
  });
  CHECK(display.valid_radius() == camera.valid_image_radius());
  CHECK(display.valid_image_radius() == camera.valid_radius());
  test::check_jacobians(display, Vector2::Zero(), 0.5);
}

TEST_CASE("outside its domain a reversed lens has neither points nor Jacobians") {
  const ReversedLens<PolynomialLens> lens(PolynomialLens(std::array<double, 1>{-0.2}));
  const Vector2 far(1.5, 0.0);
  CHECK_FALSE(lens.distort(far).has_value());
  CHECK_FALSE(lens.undistort(far).has_value());
  CHECK(std::isnan(lens.distort_jacobian(far)(0, 0)));
  CHECK_FALSE(lens.undistort_jacobian(far).has_value());
}

TEST_CASE("reversed twice is the lens") {
  const PolynomialLens lens(std::array<double, 2>{0.34, 0.55});
  const ReversedLens<PolynomialLens> once(lens);
  const ReversedLens<ReversedLens<PolynomialLens>> twice(once);
  CHECK(*twice.distort(Vector2(0.3, 0.4)) == *lens.distort(Vector2(0.3, 0.4)));
}
