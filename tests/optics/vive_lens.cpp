#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/optics/vive_lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("the formula by hand") {
  const ViveLens lens({0.1, 0.02, 0.003, 0.05});
  const double r2 = 0.25;
  const double scale = 1.0 / (1.0 + 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2) + 0.05;
  CHECK(lens.distort(Vector2(0.3, -0.4)).value().x() == doctest::Approx(0.3 * scale).epsilon(1e-15));
  CHECK(lens.distort(Vector2(0.3, -0.4)).value().y() == doctest::Approx(-0.4 * scale).epsilon(1e-15));
}

TEST_CASE("r / (1 + k r^2) folds at 1 / sqrt(k), seen at half of it, and its inverse is a quadratic's root") {
  const double k = 0.37;
  const ViveLens lens({k, 0.0, 0.0, 0.0});
  CHECK(lens.valid_radius() == doctest::Approx(1.0 / std::sqrt(k)).epsilon(1e-14));
  CHECK(lens.valid_image_radius() == doctest::Approx(0.5 / std::sqrt(k)).epsilon(1e-14));
  for (double v = 0.01; v < 0.5 / std::sqrt(k); v += 0.01) {
    const double root = std::sqrt(1.0 - 4.0 * k * v * v);
    const double expected = 2.0 * v / (1.0 + root);
    CHECK(std::abs(lens.undistort(Vector2(v, 0.0)).value().x() - expected) <
          2e-15 / root);  // ill-conditioned at the fold
  }
  CHECK_FALSE(lens.distort(Vector2(1.001 / std::sqrt(k), 0.0)).has_value());
  CHECK_FALSE(lens.undistort(Vector2(0.5001 / std::sqrt(k), 0.0)).has_value());
}

TEST_CASE("with k1 < 0 the domain ends short of the pole") {
  const ViveLens lens({-0.25, 0.0, 0.0, 0.0});  // pole at r = 2
  CHECK(lens.valid_radius() == doctest::Approx(std::sqrt(4.0 * 0.999)).epsilon(1e-12));
  CHECK(test::worst_residual(lens, Vector2::Zero(), 100.0) < 1e-11);  // slope there 1e4
}

TEST_CASE("the Vive magnifies blue most, keeps its order of colours over its whole field, and never folds there") {
  const ViveLens red(test::vive_red);
  const ViveLens green(test::vive_green);
  const ViveLens blue(test::vive_blue);
  // undistort_r2_cutoff of its left eye is 1.116: what SteamVR draws.
  const double cutoff = std::sqrt(1.11622154712677);
  for (const ViveLens* lens : {&red, &green, &blue}) CHECK(lens->valid_radius() > cutoff);
  for (double r = 0.05; r < cutoff; r += 0.05) {
    const Vector2 p(0.6 * r, 0.8 * r);
    CHECK(red.distort(p)->norm() < green.distort(p)->norm());
    CHECK(green.distort(p)->norm() < blue.distort(p)->norm());
  }
}

TEST_CASE("bad coefficients are named") {
  CHECK(ViveLens::problem_of(test::vive_green) == LensProblem::none);
  CHECK(ViveLens::problem_of({0.0, 0.0, 0.0, -1.0}) == LensProblem::folds_at_centre);
  CHECK(ViveLens::problem_of({0.0, std::nan(""), 0.0, 0.0}) == LensProblem::not_finite);
}
