#include <array>
#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/radial_model.hpp>

using namespace holdfast;

namespace {

/// f(r) = sinh(4 r) / 4: rises forever, ever more steeply; its inverse is known.
struct Sinh {
  double scale(double r2) const { return r2 > 0.0 ? at(std::sqrt(r2)).seen / std::sqrt(r2) : 1.0; }
  RadialValue at(double r) const { return {std::sinh(4.0 * r) / 4.0, std::cosh(4.0 * r)}; }
  double fold() const { return 20.0; }
};

/// f(r) = sin r, which folds at pi / 2, where its slope vanishes.
struct Sine {
  double scale(double r2) const { return r2 > 0.0 ? std::sin(std::sqrt(r2)) / std::sqrt(r2) : 1.0; }
  RadialValue at(double r) const { return {std::sin(r), std::cos(r)}; }
  double fold() const { return std::numbers::pi / 2.0; }
};

/// f with a corner at r = 1, where the slope falls from 3 to 0.1: Newton's steps leap across it.
struct Corner {
  double scale(double r2) const { return r2 > 0.0 ? at(std::sqrt(r2)).seen / std::sqrt(r2) : 3.0; }
  RadialValue at(double r) const {
    return r < 1.0 ? RadialValue{3.0 * r, 3.0} : RadialValue{3.0 + 0.1 * (r - 1.0), 0.1};
  }
  double fold() const { return std::numeric_limits<double>::infinity(); }
};

}  // namespace

TEST_CASE("the shared inverse finds inverses that are known") {
  static_assert(RadialProfile<Sinh> && RadialProfile<Sine> && RadialProfile<Corner> && RadialProfile<EvenPolynomial>);
  const RadialModel<Sinh> sinh;
  for (double v = 1e-9; v < 1e30; v *= 1.7) {
    const double expected = std::asinh(4.0 * v) / 4.0;
    // The logarithm of a rounding of v: absolute 1e-16.
    CHECK(std::abs(sinh.undistort(Vector2(0.0, v)).value().y() - expected) < 4e-16 * (1.0 + expected));
  }
  const RadialModel<Sine> sine;
  for (double v = 0.0; v < 1.0; v += 0.001) {
    // Near the fold the inverse's slope 1 / cos magnifies a rounding of v.
    const double expected = std::asin(v);
    CHECK(std::abs(sine.undistort(Vector2(v, 0.0)).value().x() - expected) < 4e-16 * (1.0 + 1.0 / std::cos(expected)));
  }
  CHECK(sine.undistort(Vector2(1.0, 0.0)).value().x() == doctest::Approx(std::numbers::pi / 2).epsilon(1e-7));
  CHECK_FALSE(sine.undistort(Vector2(1.0 + 1e-12, 0.0)).has_value());
  CHECK_FALSE(sine.distort(Vector2(1.571, 0.0)).has_value());
  const RadialModel<Corner> corner;
  for (const double r : {0.1, 0.999999, 1.0, 1.000001, 2.0, 30.0, 1e5}) {
    const double seen = Corner().at(r).seen;
    CHECK(corner.undistort(Vector2(seen, 0.0)).value().x() == doctest::Approx(r).epsilon(1e-14 * (1 + 30 / r)));
  }
}

TEST_CASE("the centre stays, and its Jacobian is the slope there") {
  const PolynomialLens lens(std::array<double, 2>{0.3, 0.1}, 1.2);
  CHECK(lens.distort(Vector2::Zero()).value() == Vector2::Zero());
  CHECK(lens.undistort(Vector2::Zero()).value() == Vector2::Zero());
  CHECK(lens.distort_jacobian(Vector2::Zero()) == 1.2 * Matrix2::Identity());
}

TEST_CASE("where a polynomial first changes sign") {
  using detail::first_sign_change;
  // (x - 1)(x - 2)(x - 3) = -6 + 11 x - 6 x^2 + x^3.
  CHECK(first_sign_change(std::array<double, 4>{-6, 11, -6, 1}, 1e6) == doctest::Approx(1.0).epsilon(1e-14));
  CHECK(std::isinf(first_sign_change(std::array<double, 4>{1, 2, 3, 4}, 1e6)));
  CHECK(std::isinf(first_sign_change(std::array<double, 4>{1, 0, 0, 0}, 1e6)));
  // (x - 1)^2 + 1e-9 comes near zero and turns back; (x - 1)^2 - 1e-9 crosses it.
  CHECK(std::isinf(first_sign_change(std::array<double, 4>{1 + 1e-9, -2, 1, 0}, 1e6)));
  CHECK(first_sign_change(std::array<double, 4>{1 - 1e-9, -2, 1, 0}, 1e6) ==
        doctest::Approx(1 - std::sqrt(1e-9)).epsilon(1e-10));
  // The only root lies beyond the limit: not known to hold farther.
  CHECK(first_sign_change(std::array<double, 2>{1, -1e-9}, 1e6) == 1e6);
  // Roots of negative x do not count.
  CHECK(std::isinf(first_sign_change(std::array<double, 3>{2, 3, 1}, 1e6)));
}
