#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/bivariate_lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

namespace {

double polyval2d(const std::array<double, 16>& c, double x, double y) {
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) sum += c[std::size_t(4 * i + j)] * std::pow(x, i) * std::pow(y, j);
  }
  return sum;
}

}  // namespace

TEST_CASE("North Star's calibration and the lens made of it show the same, over the whole panel") {
  const auto compare = [](const std::array<double, 16>& rect_x, const std::array<double, 16>& rect_y) {
    const auto eye = north_star_eye(rect_x, rect_y);
    REQUIRE(eye.has_value());
    const BivariateLens lens(eye->lens);
    const FieldTangents& t = eye->tangents;
    CHECK(problem_of(t) == FieldProblem::none);
    // The direction straight ahead has tangent 0 on the panel too, and there the panel's tangents are the seen ones in
    // x and y (what is left off the diagonal is the eye's rotation).
    CHECK(lens.distort(Vector2::Zero()).value().norm() < 1e-14);
    const Matrix2 J = lens.distort_jacobian(Vector2::Zero());
    CHECK(J(0, 0) == doctest::Approx(1.0).epsilon(1e-13));
    CHECK(J(1, 1) == doctest::Approx(1.0).epsilon(1e-13));
    int inside = 0;
    for (int i = 0; i <= 20; ++i) {
      for (int j = 0; j <= 20; ++j) {
        const double u = i / 20.0;
        const double v = j / 20.0;
        const Vector2 panel(t.left + u * (t.right - t.left), t.up - v * (t.up - t.down));
        const auto seen = lens.distort(panel);
        if (!seen) continue;
        ++inside;
        const Vector2 ray(polyval2d(rect_x, v, u), -polyval2d(rect_y, v, u));
        CHECK((*seen - ray).norm() < 1e-12);  // sums of 16 terms up to 5, moved twice
        CHECK((*lens.undistort(*seen) - panel).norm() < 1e-13);
      }
    }
    return inside;
  };
  CHECK(compare(test::north_star_left_x, test::north_star_left_y) == 441);
  CHECK(compare(test::north_star_right_x, test::north_star_right_y) == 441);
}

TEST_CASE("a separable cubic folds where each part does") {
  BivariateCoefficients c;
  c.x[12] = -0.4;  // x = u - 0.4 u^3 folds at u = 1 / sqrt(1.2)
  c.y[3] = 0.3;
  const BivariateLens lens(c);
  CHECK(lens.valid_radius() < 1.0 / std::sqrt(1.2));
  CHECK(lens.valid_radius() > 0.99 / std::sqrt(1.2));
  CHECK(test::worst_residual(lens, Vector2::Zero(), lens.valid_image_radius()) < 1e-15);
  // A rotation is no fold: the domain is proven with the rotation at the centre undone.
  BivariateCoefficients turned;
  turned.x = {};
  turned.y = {};
  turned.x[1] = -1.0;
  turned.y[4] = 1.0;
  const BivariateLens quarter_turn(turned);
  CHECK(quarter_turn.valid_radius() == 10.0);
  CHECK((quarter_turn.undistort(Vector2(-2.0, 3.0)).value() - Vector2(3.0, 2.0)).norm() < 1e-15 * 10);
}

TEST_CASE("the bicubic's derivatives and its other variables") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    std::array<double, 16> c{};
    for (double& value : c) value = u(random);
    const double a = u(random), b = u(random);
    const Vector3 f = detail::bicubic(c, a, b);
    CHECK(f[0] == doctest::Approx(polyval2d(c, a, b)).epsilon(1e-13));
    const double h = 1e-5;  // truncation h^2, rounding 1e-16 / h
    CHECK(std::abs(f[1] - (polyval2d(c, a + h, b) - polyval2d(c, a - h, b)) / (2 * h)) < 1e-8);
    CHECK(std::abs(f[2] - (polyval2d(c, a, b + h) - polyval2d(c, a, b - h)) / (2 * h)) < 1e-8);
    const auto moved = detail::bicubic_moved(c, 0.3, -0.7, -0.2, 1.4);
    CHECK(std::abs(polyval2d(moved, a, b) - polyval2d(c, 0.3 - 0.7 * a, -0.2 + 1.4 * b)) < 1e-12);
  }
}

TEST_CASE("calibrations that are no lens") {
  BivariateCoefficients c;
  CHECK(BivariateLens::problem_of(c) == LensProblem::none);
  c.limit = 0.0;
  CHECK(BivariateLens::problem_of(c) == LensProblem::radius_not_positive);
  c.limit = 1.0;
  c.y[1] = -1.0;  // mirrored
  CHECK(BivariateLens::problem_of(c) == LensProblem::folds_at_centre);
  c.y[1] = std::numeric_limits<double>::infinity();
  CHECK(BivariateLens::problem_of(c) == LensProblem::not_finite);
  // A panel on which nothing is seen straight ahead, one that is constant, one of NaN.
  std::array<double, 16> x{-5.0, 1.0};
  std::array<double, 16> y{-0.5, 0.0, 0.0, 0.0, 1.0};
  CHECK_FALSE(north_star_eye(x, y).has_value());
  CHECK_FALSE(north_star_eye({}, {}).has_value());
  x[0] = std::nan("");
  CHECK_FALSE(north_star_eye(x, y).has_value());
}
