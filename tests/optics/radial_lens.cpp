#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/optics/cubic_fit.hpp>
#include <holdfast/optics/radial_lens.hpp>

#include "optics/lens_checks.hpp"

using namespace holdfast;

namespace {

/// The Flight Helmet's lens of table 8.1, in pixels of the left eye.
const Lens helmet(RadialLens{0.1933}, placed_at(256.0, Vector2(395.9, 256.0)), -0.1);
const double corner_px = Vector2(395.9, 256.0).norm();

double drawn_error_px(const Lens& lens, double r) {
  const Vector2 ideal = lens.centre() + Vector2(r * lens.placement().scale.x(), 0.0);
  const auto seen = lens.distort(lens.cubic_inverse().distort(ideal).value());
  return (seen.value() - ideal).norm();
}

}  // namespace

TEST_CASE("distortion is eq. 7.9.2") {
  const Vector2 at_norm = helmet.distort(Vector2(helmet.centre() + Vector2(0.0, 256.0))).value();
  CHECK(at_norm.y() == doctest::Approx(256.0 + 256.0 * 1.1933).epsilon(1e-14));
  CHECK(at_norm.x() == helmet.centre().x());
  CHECK(helmet.distort(helmet.centre()).value() == helmet.centre());
}

TEST_CASE("the exact inverse leaves nothing: value 6 of the evaluation asks 1e-6 px") {
  // The visible field: the farthest corner of the panel, as seen through the lens.
  const double seen = (helmet.distort(Vector2(0.0, 0.0)).value() - helmet.centre()).norm();
  CHECK(seen > corner_px * 1.6);
  // 1e-12 px is 5 units in the last place of a coordinate of 800 px.
  CHECK(test::worst_residual(helmet, helmet.centre(), seen) < 1e-12);
}

TEST_CASE("the paper's cubic leaves 2.5, 6.8 and 10.5 px at r = 0.5, 0.75 and 1") {
  CHECK(drawn_error_px(helmet, 0.5) == doctest::Approx(2.5).epsilon(0.05 / 2.5));
  CHECK(drawn_error_px(helmet, 0.75) == doctest::Approx(6.8).epsilon(0.05 / 6.8));
  CHECK(drawn_error_px(helmet, 1.0) == doctest::Approx(10.5).epsilon(0.05 / 10.5));
  // By hand at r = 1: 0.9 + 0.1933 * 0.9^3 - 1 = 0.0409.
  CHECK(drawn_error_px(helmet, 1.0) == doctest::Approx(256 * (0.9 + 0.1933 * 0.729 - 1)).epsilon(1e-12));
}

TEST_CASE("the paper's cubic folds over at r = 1.826, before the viewport's corner") {
  const Lens cubic = helmet.cubic_inverse();
  CHECK(cubic.valid_radius() / 256.0 == doctest::Approx(1.826).epsilon(0.0005 / 1.8));
  CHECK(cubic.valid_radius() < corner_px);
  CHECK(cubic.distort(Vector2(cubic.centre() + Vector2(1.82 * 256, 0.0))).has_value());
  CHECK_FALSE(cubic.distort(Vector2(cubic.centre() + Vector2(1.83 * 256, 0.0))).has_value());
  CHECK_FALSE(cubic.distort(Vector2(0.0, 0.0)).has_value());
}

TEST_CASE("the best cubic is about -0.1335 and leaves 2.1 px") {
  const double k = best_cubic_inverse(RadialLens{0.1933});
  CHECK(k == doctest::Approx(-0.1335).epsilon(0.0005 / 0.13));
  CHECK(256 * cubic_residual(RadialLens{0.1933}, k) == doctest::Approx(2.1).epsilon(0.05 / 2.1));
  // A minimum: worse on both sides.
  CHECK(cubic_residual(RadialLens{0.1933}, k + 1e-3) > cubic_residual(RadialLens{0.1933}, k));
  CHECK(cubic_residual(RadialLens{0.1933}, k - 1e-3) > cubic_residual(RadialLens{0.1933}, k));
  // A barrel so strong that only k_pd below -0.18 keeps r = 1 inside its domain has a best one all the same.
  const RadialLens strong{-0.5};
  const double least = best_cubic_inverse(strong);
  CHECK(least < -0.18);
  CHECK(cubic_residual(strong, least) <= cubic_residual(strong, -0.25));
  // No cubic helps a lens that folds well inside r = 1.
  CHECK(best_cubic_inverse(RadialLens{-20.0}) == 0.0);
}

TEST_CASE("exact over the whole domain, for strong and weak, pincushion and barrel") {
  for (const double k : {1e-9, 1e-3, 0.1933, 1.0, 30.0, 1e4}) {
    const Lens lens(RadialLens{k}, placed_at(0.5, Vector2(0.02, -0.01)));
    for (const double seen : {1e-6, 0.1, 1.0, 10.0, 1e4}) {
      // Relative to the seen radius: a few units in the last place.
      CHECK(test::worst_residual(lens, lens.centre(), seen) < 2e-15 * (1.0 + seen));
    }
  }
  for (const double k : {-1e-9, -1e-5, -1e-3, -0.1, -0.2, -1.0, -25.0}) {
    const Lens lens(RadialLens{k}, placed_at(0.5, Vector2(0.02, -0.01)));
    const double seen = std::min(lens.valid_image_radius(), 50.0);
    // The whole domain, the fold included (one rounding inside it).
    CHECK(test::worst_residual(lens, lens.centre(), seen * (1 - 4e-16)) < 4e-15 * (1.0 + seen));
  }
}

TEST_CASE("the inverse lands in the one-to-one part of a barrel lens") {
  const RadialLens lens{-0.2};
  CHECK(lens.valid_radius() == doctest::Approx(std::sqrt(1 / 0.6)).epsilon(1e-14));
  CHECK(lens.valid_image_radius() == doctest::Approx(2.0 / 3.0 * lens.valid_radius()).epsilon(1e-14));
  // Points of the panel come back to themselves, so the right one of three roots was taken.
  for (double r = 0.0; r < 0.999; r += 0.01) {
    const Vector2 p(r * lens.valid_radius(), 0.0);
    const Vector2 back = lens.undistort(lens.distort(p).value()).value();
    // Near the fold the inverse's slope grows without bound: 1 / (1 - r^2).
    CHECK((back - p).norm() < 1e-15 / (1 - r * r) * 4);
  }
  CHECK(lens.distort(Vector2(lens.valid_radius() * 0.9999999, 0.0)).has_value());
  CHECK_FALSE(lens.distort(Vector2(lens.valid_radius() * 1.0000001, 0.0)).has_value());
  CHECK(lens.undistort(Vector2(lens.valid_image_radius() * 0.9999999, 0.0)).has_value());
  CHECK_FALSE(lens.undistort(Vector2(lens.valid_image_radius() * 1.0000001, 0.0)).has_value());
  CHECK_FALSE(lens.undistort_jacobian(Vector2(1.0, 0.0)).has_value());
}

TEST_CASE("a lens without distortion changes nothing at all") {
  const Lens lens(RadialLens{0.0}, placed_at(0.7, Vector2(0.1, 0.2)));
  CHECK(std::isinf(lens.valid_radius()));
  test::for_disc(lens.centre(), 3.0, [&](const Vector2& p) {
    CHECK((*lens.distort(p) - p).norm() < 1e-15 * 4);  // centre subtracted and added again
    CHECK((*lens.undistort(p) - p).norm() < 1e-15 * 4);
  });
}

TEST_CASE("bad numbers are answered with nothing") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity}) {
    CHECK_FALSE(helmet.distort(Vector2(bad, 0.0)).has_value());
    CHECK_FALSE(helmet.undistort(Vector2(0.0, bad)).has_value());
    CHECK_FALSE(RadialLens{}.undistort(Vector2(0.0, bad)).has_value());
  }
}

TEST_CASE("the Jacobians are those of central differences") {
  test::check_jacobians(helmet, helmet.centre(), corner_px);
  test::check_jacobians(Lens(RadialLens{-0.2}, placed_at(0.5, Vector2(0.02, -0.01))), Vector2(0.02, -0.01), 0.5);
  test::check_jacobians(Lens(RadialLens{5.0}, placed_at(0.5, Vector2(0.02, -0.01))), Vector2(0.02, -0.01), 2.0);
}

TEST_CASE("the scale solves its cubic to rounding from the fold to the largest numbers") {
  for (double c = -4.0 / 27.0; c < 0.0; c += 1e-4) {
    const double m = detail::cubic_scale(c);
    CHECK(std::abs(m + c * m * m * m - 1.0) < 1e-15);
    CHECK(m <= 1.5 + 1e-7);  // at the fold an error of 1e-15 in c is one of 1e-7.5 in m
  }
  for (double c = 1e-12; c < 1e200; c *= 1.37) {
    const double m = detail::cubic_scale(c);
    CHECK(std::abs(m + c * m * m * m - 1.0) < 1e-15);
    CHECK(m > 0.0);
  }
  // Continuous where the method changes.
  CHECK(detail::cubic_scale(-1.0000001e-6) == doctest::Approx(detail::cubic_scale(-0.9999999e-6)).epsilon(1e-12));
  CHECK(detail::cubic_scale(1.0) == doctest::Approx(detail::cubic_scale(std::nextafter(1.0, 2.0))).epsilon(1e-15));
}
