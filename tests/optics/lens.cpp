#include <array>

#include <doctest/doctest.h>

#include <holdfast/optics/lens_mode.hpp>

using namespace holdfast;

namespace {
const Lens helmet(RadialLens{0.1933}, placed_at(0.5, Vector2(0.02, 0.01)), -0.1);
const Vector2 ideal(0.3, -0.25);
}  // namespace

TEST_CASE("what the eye sees under each mode") {
  const Lens& lens = helmet;
  CHECK(seen_tangent(lens, LensMode::none, ideal).value() == ideal);
  // Exact: in place, to rounding.
  CHECK((seen_tangent(lens, LensMode::exact, ideal).value() - ideal).norm() < 1e-15);
  CHECK(seen_tangent(lens, LensMode::uncorrected, ideal).value() == helmet.distort(ideal).value());
  const Vector2 cubic = helmet.cubic_inverse().distort(ideal).value();
  CHECK(seen_tangent(lens, LensMode::cubic, ideal).value() == helmet.distort(cubic).value());
  // The cubic errs, and less than no correction.
  const double cubic_error = (seen_tangent(lens, LensMode::cubic, ideal).value() - ideal).norm();
  const double uncorrected_error = (seen_tangent(lens, LensMode::uncorrected, ideal).value() - ideal).norm();
  CHECK(cubic_error > 1e-3);
  CHECK(cubic_error < 0.5 * uncorrected_error);
}

TEST_CASE("every map has its inverse") {
  for (const Lens& lens :
       {Lens(NoLens{}), helmet, Lens(PolynomialLens(std::array<double, 2>{0.22, 0.24}), placed_at(0.9)),
        Lens(RadialLens{-0.15}, placed_at(0.5), 0.2)}) {
    for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
      const Vector2 seen = seen_tangent(lens, mode, ideal).value();
      CHECK((ideal_tangent(lens, mode, seen).value() - ideal).norm() < 1e-14);
      const Vector2 drawn = drawn_tangent(lens, mode, ideal).value();
      CHECK((ideal_tangent_at_panel(lens, mode, drawn).value() - ideal).norm() < 1e-14);
    }
    CHECK((lens.undistort(lens.distort(ideal).value()).value() - ideal).norm() < 1e-14);
    const Matrix2 J = lens.distort_jacobian(ideal);
    CHECK((lens.undistort_jacobian(lens.distort(ideal).value()).value() * J - Matrix2::Identity()).norm() < 1e-13);
  }
}

TEST_CASE("outside the domain nothing is seen") {
  const Lens barrel(RadialLens{-0.2}, placed_at(0.5), 0.1);
  const Vector2 far(1.0, 0.0);  // valid_radius is 0.645
  CHECK_FALSE(barrel.distort(far).has_value());
  CHECK_FALSE(seen_tangent(barrel, LensMode::uncorrected, far).has_value());
  CHECK_FALSE(seen_tangent(barrel, LensMode::exact, far).has_value());
  CHECK(seen_tangent(barrel, LensMode::none, far).has_value());
  CHECK_FALSE(ideal_tangent(barrel, LensMode::uncorrected, far).has_value());
  CHECK(barrel.valid_radius() == doctest::Approx(0.5 / std::sqrt(0.6)).epsilon(1e-14));
  CHECK(barrel.valid_image_radius() < barrel.valid_radius());
  // The paper's cubic folds over at r = 1.826 although the lens itself has no limit.
  CHECK_FALSE(seen_tangent(helmet, LensMode::cubic, Vector2(0.02 + 0.92, 0.01)).has_value());
  CHECK(seen_tangent(helmet, LensMode::exact, Vector2(0.02 + 0.92, 0.01)).has_value());
}
