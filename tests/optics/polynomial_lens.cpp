#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/radial_lens.hpp>

#include "optics/lens_checks.hpp"

using namespace holdfast;

TEST_CASE("one coefficient is the radial lens") {
  for (const double k : {0.1933, -0.2}) {
    const RadialLens radial{k};
    const PolynomialLens polynomial(std::array<double, 1>{k});
    if (k > 0.0) {
      CHECK(std::isinf(polynomial.valid_radius()));
    } else {
      CHECK(polynomial.valid_radius() == doctest::Approx(radial.valid_radius()).epsilon(1e-14));
      CHECK(polynomial.valid_image_radius() == doctest::Approx(radial.valid_image_radius()).epsilon(1e-14));
    }
    const double radius = k > 0.0 ? 2.0 : radial.valid_image_radius() * 0.99;
    test::for_disc(Vector2::Zero(), radius, [&](const Vector2& v) {
      // Two exact inverses of the same function; near the fold both lose the factor 1 / slope, here up to 1e2.
      CHECK((*radial.undistort(v) - *polynomial.undistort(v)).norm() < 1e-13);
    });
  }
}

TEST_CASE("Cardboard's and the DK1's lenses are inverted exactly") {
  const PolynomialLens cardboard(std::array<double, 2>{0.441, 0.156});
  CHECK(std::isinf(cardboard.valid_radius()));
  // Residual in tangents: 1e-15 of a picture with 900 px per unit of tangent is 1e-12 px.
  CHECK(test::worst_residual(cardboard, Vector2::Zero(), 2.0) < 1e-15);
  const PolynomialLens dk1(std::array<double, 2>{0.22, 0.24});
  // At 4 (76 degrees) one rounding of the panel radius, magnified by the slope there, is 2e-15.
  CHECK(test::worst_residual(dk1, Vector2::Zero(), 4.0 / 0.9132) < 1e-14);
  // By hand: r = 1 is seen at 1 + 0.441 + 0.156.
  CHECK(cardboard.distort(Vector2(1.0, 0.0)).value().x() == doctest::Approx(1.597).epsilon(1e-15));
}

TEST_CASE("the fold is where the derivative first vanishes") {
  // d/dr r (1 + a r^2 + b r^4) = 1 + 3 a x + 5 b x^2 with x = r^2; for a = -1, b = 0.1 the smaller root is 3 - sqrt(7).
  const PolynomialLens lens(std::array<double, 2>{-1.0, 0.1});
  CHECK(lens.valid_radius() == doctest::Approx(std::sqrt(3.0 - std::sqrt(7.0))).epsilon(1e-14));
  CHECK(test::worst_residual(lens, Vector2::Zero(), lens.valid_image_radius() * (1 - 4e-16)) < 4e-15);
  CHECK_FALSE(lens.distort(Vector2(lens.valid_radius() * 1.000001, 0)).has_value());
  CHECK_FALSE(lens.undistort(Vector2(lens.valid_image_radius() * 1.000001, 0)).has_value());
  // A derivative that stays positive: 1 - 3 x + 5 x^2 has no real root.
  CHECK(std::isinf(PolynomialLens(std::array<double, 2>{-1.0, 1.0}).valid_radius()));
  // A derivative that touches zero without crossing, (1 - x)^2 = 1 - 2 x + x^2: no fold, the map keeps rising.
  const PolynomialLens touching(std::array<double, 2>{-2.0 / 3.0, 1.0 / 5.0});
  CHECK(touching.undistort(Vector2(0.4, 0.0)).has_value());
}

TEST_CASE("random lenses: exact inside the domain, one-to-one up to the fold and not beyond") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coefficient(-1.0, 1.0);
  int folding = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::array<double, 4> k{};
    for (double& value : k) value = coefficient(random);
    const double k0 = 1.0 + 0.1 * coefficient(random);
    const PolynomialLens lens(k, k0);
    const double radius = std::min(lens.valid_radius(), 1.5);
    const auto seen = [&](double r) {
      const double x = r * r;
      return r * (k0 + x * (k[0] + x * (k[1] + x * (k[2] + x * k[3]))));
    };
    for (double r = 0.0; r < 0.99 * radius; r += 0.01 * radius) CHECK(seen(r + 0.01 * radius) > seen(r));
    if (lens.valid_radius() < 1.5) {
      ++folding;
      CHECK(seen(radius * (1 + 1e-3)) < seen(radius));
    }
    // The panel radius is right to a rounding, which the lens's slope (up to nine times seen / r) magnifies.
    CHECK(test::worst_residual(lens, Vector2::Zero(), seen(radius) * (1 - 1e-15)) < 1e-14 * (1.0 + seen(radius)));
  }
  CHECK(folding > 50);  // the trials met both kinds
  CHECK(folding < 150);
}

TEST_CASE("the Jacobians are those of central differences") {
  test::check_jacobians(PolynomialLens(std::array<double, 2>{0.441, 0.156}), Vector2::Zero(), 1.5);
  test::check_jacobians(PolynomialLens(std::array<double, 3>{-0.2, 0.1, -0.05}, 1.01), Vector2::Zero(), 0.87);
}

TEST_CASE("no coefficients, and bad numbers") {
  const PolynomialLens none;
  CHECK(none.distort(Vector2(0.3, 0.4)).value() == Vector2(0.3, 0.4));
  CHECK((none.undistort(Vector2(0.3, 0.4)).value() - Vector2(0.3, 0.4)).norm() < 1e-16);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(none.distort(Vector2(nan, 0.0)).has_value());
  CHECK_FALSE(none.undistort(Vector2(std::numeric_limits<double>::infinity(), 0.0)).has_value());
  const PolynomialLens magnifying(std::array<double, 1>{0.0}, 1.25);
  CHECK(magnifying.distort(Vector2(0.4, 0.0)).value().x() == 0.5);
  CHECK(magnifying.undistort(Vector2(0.5, 0.0)).value().x() == doctest::Approx(0.4).epsilon(1e-15));
}
