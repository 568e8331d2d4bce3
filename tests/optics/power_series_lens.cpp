#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/power_series_lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("even powers alone are the polynomial lens") {
  const PowerSeriesLens series(std::array<double, 5>{1.0, 0.0, 0.22, 0.0, 0.24});
  const PolynomialLens even(std::array<double, 2>{0.22, 0.24});
  test::for_disc(Vector2::Zero(), 3.0, [&](const Vector2& p) {
    const Vector2 seen = *even.distort(p);  // up to 65: relative roundings
    CHECK((*series.distort(p) - seen).norm() < 2e-15 * (1.0 + seen.norm()));
    CHECK((*series.undistort(p) - *even.undistort(p)).norm() < 1e-15 * 2);
  });
}

TEST_CASE("PS VR by hand: r = 1 is seen at 0.75 - 0.01 + 0.75 + 3.8") {
  const PowerSeriesLens lens(test::psvr);
  CHECK(lens.distort(Vector2(0.0, 1.0)).value().y() == doctest::Approx(5.29).epsilon(1e-15));
  CHECK(lens.distort(Vector2(0.3, 0.4)).value().norm() ==
        doctest::Approx(0.5 * (0.75 - 0.005 + 0.75 * 0.25 + 3.8 * 0.0625)).epsilon(1e-15));
  CHECK(std::isinf(lens.valid_radius()));
}

TEST_CASE("folds that are known: r - a r^2 at 1 / 2a, and OSVR's HDK 1.1 past its picture's corner") {
  const PowerSeriesLens lens(std::array<double, 2>{1.0, -0.4});
  CHECK(lens.valid_radius() == doctest::Approx(1.25).epsilon(1e-14));
  CHECK(lens.valid_image_radius() == doctest::Approx(0.625).epsilon(1e-14));
  for (double v = 0.0; v < 0.625; v += 0.01) {
    const double expected = (1.0 - std::sqrt(1.0 - 1.6 * v)) / 0.8;
    // Near the fold a rounding of v is magnified by 1 / (1 - 0.8 r).
    CHECK(std::abs(lens.undistort(Vector2(v, 0.0)).value().x() - expected) < 1e-15 / (1.0 - 0.8 * expected));
  }
  // 1 + 1.5 x - 5.75 x^2 + 64.75 x^3 - 45 x^4 with x = r^2 vanishes near x = 1.37 (the last two terms dominate).
  const double fold = PowerSeriesLens(test::osvr_hdk_1_1).valid_radius();
  const double x = fold * fold;
  CHECK(1 + x * (1.5 + x * (-5.75 + x * (64.75 - 45 * x))) == doctest::Approx(0.0).epsilon(1e-11));
  CHECK(fold > 1.15);
  CHECK(fold < 1.2);
}

TEST_CASE("coefficients that are no lens are named") {
  const auto problem = [](const std::vector<double>& c) { return PowerSeriesLens::problem_of(c); };
  CHECK(problem({1.0, 0.2}) == LensProblem::none);
  CHECK(problem({}) == LensProblem::folds_at_centre);
  CHECK(problem({0.0, 1.0}) == LensProblem::folds_at_centre);
  CHECK(problem({-1.0}) == LensProblem::folds_at_centre);
  CHECK(problem({1.0, std::nan("")}) == LensProblem::not_finite);
  CHECK(problem(std::vector<double>(17, 0.1)) == LensProblem::none);
  CHECK(problem(std::vector<double>(18, 0.1)) == LensProblem::too_many_coefficients);
}

TEST_CASE("far out, where the highest power rules and Newton's steps shrink slowly, the inverse is as exact") {
  std::vector<double> c(17, 0.0);
  c[0] = 1.0;
  c[16] = 1000.0;
  const PowerSeriesLens lens(c);
  for (double v = 1e-3; v < 1e9; v *= 3.0) {
    const double back = lens.distort(*lens.undistort(Vector2(v, 0.0)))->x();
    CHECK(back == doctest::Approx(v).epsilon(1e-14));  // a rounding of r, times 17
  }
}

TEST_CASE("the highest degree: sixteen powers at once") {
  std::vector<double> c(17, 0.0);
  double sign = 1.0;
  for (std::size_t i = 0; i < c.size(); ++i, sign = -sign) c[i] = sign / std::tgamma(double(i) + 1.0);
  const PowerSeriesLens lens(c);  // r exp(-r), but for the terms after: folds at r = 1
  CHECK(lens.valid_radius() == doctest::Approx(1.0).epsilon(1e-13));
  CHECK(lens.valid_image_radius() == doctest::Approx(std::exp(-1.0)).epsilon(1e-14));
  CHECK(test::worst_residual(lens, Vector2::Zero(), 0.999 * lens.valid_image_radius()) < 1e-15);
}
