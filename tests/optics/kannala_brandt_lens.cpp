#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/optics/kannala_brandt_lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("the formula by hand: an angle of one radian") {
  const KannalaBrandtLens lens(test::tum_vi);
  const double sum = 1.0 + test::tum_vi[0] + test::tum_vi[1] + test::tum_vi[2] + test::tum_vi[3];
  const Vector2 seen = std::tan(1.0) * Vector2(0.6, 0.8);
  CHECK((lens.undistort(seen).value() - sum * Vector2(0.6, 0.8)).norm() < 1e-15);
  CHECK((lens.distort(Vector2(sum * Vector2(0.6, 0.8))).value() - seen).norm() < 1e-14);
}

TEST_CASE("without coefficients the panel's radius is the seen angle") {
  const KannalaBrandtLens lens;
  for (double r = 0.01; r < 1.5; r += 0.01) {
    CHECK(lens.distort(Vector2(0.0, r)).value().y() == doctest::Approx(std::tan(r)).epsilon(1e-14 * (1 + std::tan(r))));
  }
  CHECK(lens.valid_image_radius() == doctest::Approx(100.0).epsilon(1e-13));
  CHECK(lens.valid_radius() == doctest::Approx(std::atan(100.0)).epsilon(1e-15));
  CHECK_FALSE(lens.distort(Vector2(1.57, 0.0)).has_value());
  CHECK_FALSE(lens.undistort(Vector2(100.1, 0.0)).has_value());
}

TEST_CASE("theta - a theta^3 folds at 1 / sqrt(3 a)") {
  const double a = 0.4;
  const KannalaBrandtLens lens({-a, 0.0, 0.0, 0.0});
  const double fold = 1.0 / std::sqrt(3.0 * a);
  CHECK(lens.valid_image_radius() == doctest::Approx(std::tan(fold)).epsilon(1e-13));
  CHECK(lens.valid_radius() == doctest::Approx(2.0 / 3.0 * fold).epsilon(1e-14));
  CHECK_FALSE(lens.distort(Vector2(0.667 * fold, 0.0)).has_value());
}

TEST_CASE("TUM-VI's lens sees nearly a half space, and is inverted there") {
  const KannalaBrandtLens lens(test::tum_vi);
  CHECK(lens.valid_image_radius() == doctest::Approx(100.0).epsilon(1e-13));
  // At a tangent of 100 the slope is 1e4: a rounding of the angle is 2e-12 of tangent.
  CHECK(test::worst_residual(lens, Vector2::Zero(), 99.99) < 2e-11);
  CHECK(test::worst_residual(lens, Vector2::Zero(), 5.0) < 2e-14);
}

TEST_CASE("bad coefficients are named") {
  CHECK(KannalaBrandtLens::problem_of(test::tum_vi) == LensProblem::none);
  CHECK(KannalaBrandtLens::problem_of({0.0, 0.0, std::nan(""), 0.0}) == LensProblem::not_finite);
}
