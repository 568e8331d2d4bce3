#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/optics/catmull_rom_lens.hpp>
#include <holdfast/optics/radial_lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("the spline passes through 1 and the knots, and colours multiply it") {
  const CatmullRomLens green({test::dk2_knots, 1.0, {0.0, 0.0}});
  const CatmullRomLens red({test::dk2_knots, 1.0, {-0.0112, -0.015}});
  for (std::size_t k = 1; k <= 10; ++k) {
    const double r = std::sqrt(double(k) / 10.0);
    const double seen = green.distort(Vector2(r, 0.0)).value().x();
    CHECK(seen == doctest::Approx(r * test::dk2_knots[k]).epsilon(1e-13));
    CHECK(red.distort(Vector2(r, 0.0)).value().x() ==
          doctest::Approx(seen * (1 - 0.0112 - 0.015 * r * r)).epsilon(1e-13));
  }
  CHECK(green.distort_jacobian(Vector2::Zero()) == Matrix2::Identity());
  // Beyond the last knot straight on in r^2.
  CHECK(green.distort(Vector2(std::sqrt(1.3), 0.0)).value().x() ==
        doctest::Approx(std::sqrt(1.3) * (1.38 + 3 * 0.07)).epsilon(1e-13));
}

TEST_CASE("the DK2's own numbers give the field that its runtime reported") {
  // LibOVR 0.4: 36 mm per unit of tangent, screen 125.76 x 70.74 mm, lenses 63.5 mm apart and 35.3 mm from the top; its
  // default field is 1.058 outward, 1.092 inward and 1.329 up and down.
  const CatmullRomLens lens({test::dk2_knots, 1.0, {0.0, 0.0}});
  const auto seen = [&](double metres) { return lens.distort(Vector2(metres / 0.036, 0.0)).value().x(); };
  CHECK(seen(0.12576 / 2 - 0.0635 / 2) == doctest::Approx(1.058).epsilon(0.005));
  CHECK(seen(0.0635 / 2) == doctest::Approx(1.092).epsilon(0.005));
  CHECK(seen(0.0353) == doctest::Approx(1.329).epsilon(0.005));
}

TEST_CASE("knots that rise evenly are the paper's cubic lens, but for the spline's odd last stretch") {
  const double rise = 0.04;
  CatmullRomCoefficients c;
  for (std::size_t k = 0; k < 11; ++k) c.knots[k] = 1.0 + rise * double(k);
  c.r_max = 1.3;
  const CatmullRomLens spline(c);
  const RadialLens radial{10.0 * rise / (1.3 * 1.3)};
  for (double r = 0.01; r < 3.0; r += 0.01) {
    const double x = 10.0 * r * r / 1.69;
    if (x > 9.0 && x < 10.0) continue;
    const Vector2 p(0.6 * r, 0.8 * r);
    CHECK((*spline.distort(p) - *radial.distort(p)).norm() < 1e-14 * (1.0 + r * r * r));
  }
  CHECK(test::worst_residual(spline, Vector2::Zero(), 5.0) < 1e-14);
}

TEST_CASE("knots that fall evenly fold where the cubic does, inside the first stretches or beyond the last") {
  for (const double fall : {0.2, 0.03}) {
    CatmullRomCoefficients c;
    for (std::size_t k = 0; k < 11; ++k) c.knots[k] = 1.0 - fall * double(k);
    const CatmullRomLens spline(c);
    const double fold = 1.0 / std::sqrt(30.0 * fall);  // k = -10 fall; x = 1 / (3 fall) = 1.67 or 11.1
    CHECK(spline.valid_radius() == doctest::Approx(fold).epsilon(1e-12));
    CHECK(spline.valid_image_radius() == doctest::Approx(2.0 / 3.0 * fold).epsilon(1e-12));
  }
}

TEST_CASE("bad numbers are named") {
  CHECK(CatmullRomLens::problem_of({test::dk2_knots, 1.0, {0.0, 0.0}}) == LensProblem::none);
  CHECK(CatmullRomLens::problem_of({test::dk2_knots, 0.0, {0.0, 0.0}}) == LensProblem::radius_not_positive);
  CHECK(CatmullRomLens::problem_of({test::dk2_knots, 1.0, {-1.0, 0.0}}) == LensProblem::folds_at_centre);
  auto knots = test::dk2_knots;
  knots[7] = std::numeric_limits<double>::infinity();
  CHECK(CatmullRomLens::problem_of({knots, 1.0, {0.0, 0.0}}) == LensProblem::not_finite);
}
