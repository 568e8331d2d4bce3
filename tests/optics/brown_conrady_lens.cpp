#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/brown_conrady_lens.hpp>
#include <holdfast/optics/radial_lens.hpp>

#include "optics/lens_checks.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("OpenCV's formula by hand") {
  const BrownConradyCoefficients c{-0.2, 0.1, 0.01, -0.02, 0.03, 0.04, -0.05, 0.06};
  const double x = 0.3, y = -0.2, r2 = 0.13;
  const double s =
      (1 - 0.2 * r2 + 0.1 * r2 * r2 + 0.03 * r2 * r2 * r2) / (1 + 0.04 * r2 - 0.05 * r2 * r2 + 0.06 * r2 * r2 * r2);
  const Vector2 expected(x * s + 2 * 0.01 * x * y - 0.02 * (r2 + 2 * x * x),
                         y * s + 0.01 * (r2 + 2 * y * y) - 2 * 0.02 * x * y);
  CHECK((BrownConradyLens(c).distort(Vector2(x, y)).value() - expected).norm() < 1e-16);
}

TEST_CASE("with k1 alone it is the paper's lens, whose fold it finds just short") {
  const RadialLens radial{-0.2};
  const BrownConradyLens lens({-0.2});
  CHECK(lens.valid_radius() < radial.valid_radius());
  CHECK(lens.valid_radius() > 0.99 * radial.valid_radius());  // where the slope is 1 %, by 0.5 %
  // The image: 1.5 d^2 of it for a fraction d of the radius, and what lies between the samples of its edge.
  CHECK(lens.valid_image_radius() < radial.valid_image_radius());
  CHECK(lens.valid_image_radius() > 0.998 * radial.valid_image_radius());
  test::for_disc(Vector2::Zero(), lens.valid_image_radius(), [&](const Vector2& v) {
    // Near the fold both lose the factor 1 / slope, up to 100.
    CHECK((*lens.undistort(v) - *radial.undistort(v)).norm() < 1e-13);
  });
}

TEST_CASE("p1 alone folds at 1 / (6 p1), below the centre") {
  // f' has the eigenvalues 1 + 4 p1 y -+ 2 p1 r: least at y = -r, 1 - 6 p1 r. The domain ends where that is 1 %.
  for (const double p1 : {0.1, 0.03}) {
    const BrownConradyLens lens({0.0, 0.0, p1, 0.0});
    CHECK(lens.valid_radius() == doctest::Approx(0.99 / (6.0 * p1)).epsilon(1e-4));
    CHECK(lens.distort_jacobian(Vector2(0.0, -lens.valid_radius())).determinant() > 0.0);
  }
  // Mirrored and turned: p2 is p1 for x.
  CHECK(BrownConradyLens({0.0, 0.0, 0.0, 0.1}).valid_radius() == doctest::Approx(0.99 / 0.6).epsilon(1e-4));
}

TEST_CASE("inside the domain no two points are seen at one place") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int trial = 0; trial < 30; ++trial) {
    const BrownConradyLens lens(
        {0.4 * u(random), 0.3 * u(random), 0.05 * u(random), 0.05 * u(random), 0.1 * u(random)});
    const double R = lens.valid_radius();
    for (int i = 0; i < 200; ++i) {
      const Vector2 a = 0.7 * R * Vector2(u(random), u(random));
      const Vector2 b = 0.7 * R * Vector2(u(random), u(random));
      // What the proof says: (a - b) . (f(a) - f(b)) > m |a - b|^2, with m at least 1 %, less what rings may miss.
      const Vector2 d = a - b;
      CHECK(d.dot(*lens.distort(a) - *lens.distort(b)) > 0.009 * d.squaredNorm());
    }
    CHECK_FALSE(lens.distort(Vector2(1.0001 * R, 0.0)).has_value());
  }
}

TEST_CASE("a denominator that vanishes ends the domain before it") {
  const BrownConradyLens lens({0.0, 0.0, 0.0, 0.0, 0.0, -0.25});  // pole at r = 2
  CHECK(lens.valid_radius() < 2.0);
  CHECK(lens.valid_radius() > 1.99);
  CHECK(test::worst_residual(lens, Vector2::Zero(), 100.0) < 1e-10);  // slope there 1e4
}

TEST_CASE("OpenCV's y points down: a negative scale in y is the same lens with p1 reversed") {
  const Lens down(BrownConradyLens({-0.2, 0.05, 0.02, 0.01}), {Vector2::Zero(), Vector2(1.0, -1.0)});
  const BrownConradyLens up({-0.2, 0.05, -0.02, 0.01});
  test::for_disc(Vector2::Zero(), 0.9,
                 [&](const Vector2& p) { CHECK((*down.distort(p) - *up.distort(p)).norm() < 1e-15); });
}

TEST_CASE("bad coefficients are named") {
  CHECK(BrownConradyLens::problem_of(test::euroc) == LensProblem::none);
  CHECK(BrownConradyLens::problem_of({0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, std::nan("")}) == LensProblem::not_finite);
}
