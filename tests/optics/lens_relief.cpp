#include <array>
#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/optics/lens_relief.hpp>

#include "optics/published_lenses.hpp"

using namespace holdfast;

namespace {

/// The DK1 as LibOVR 0.4 has it: three dials, the middle one at 12.76 mm.
std::vector<LensesAtRelief> dk1_table() {
  const auto row = [](double relief, const std::array<double, 11>& knots, double r_max) {
    const auto lens = [&](double c0) { return Lens(CatmullRomLens({knots, r_max, {c0, 0.0}})); };
    return LensesAtRelief{relief, lens(0.0), lens(-0.006), lens(0.014)};
  };
  return {row(0.007760465, test::dk1_near_knots, std::sqrt(1.8)), row(0.012760465, test::dk1_middle_knots, 1.0),
          row(0.017760465, test::dk1_far_knots, 1.0)};
}

double seen(const Lens& lens, double r) {
  return lens.distort(Vector2(r, 0.0)).value().x();
}

}  // namespace

TEST_CASE("at a measured relief the lens is the measured one, outside the nearest") {
  const auto table = dk1_table();
  for (const LensesAtRelief& row : table) {
    const LensesAtRelief lenses = lenses_at(table, row.eye_relief_m).value();
    for (const double r : {0.2, 0.5, 0.8}) {
      CHECK(seen(lenses.lens, r) == seen(row.lens, r));
      CHECK(seen(*lenses.lens_red, r) == seen(*row.lens_red, r));
    }
  }
  CHECK(seen(lenses_at(table, 0.001)->lens, 0.8) == seen(table.front().lens, 0.8));
  CHECK(seen(lenses_at(table, 0.1)->lens, 0.8) == seen(table.back().lens, 0.8));
  CHECK_FALSE(lenses_at({}, 0.01).has_value());
}

TEST_CASE("between two reliefs the spline's values are mixed, even when their last knots stand apart") {
  const auto table = dk1_table();
  for (const double t : {0.25, 0.5, 0.9}) {
    const Lens near = lenses_at(table, 0.007760465 + 0.005 * t)->lens;
    const CatmullRomCoefficients& c = near.model_if<CatmullRomLens>()->coefficients();
    CHECK(c.r_max == doctest::Approx((1 - t) * std::sqrt(1.8) + t).epsilon(1e-13));
    for (int k = 1; k <= 10; ++k) {
      const double r = std::sqrt(k / 10.0) * c.r_max;
      CHECK(seen(near, r) ==
            doctest::Approx((1 - t) * seen(table[0].lens, r) + t * seen(table[1].lens, r)).epsilon(1e-12));
    }
  }
  // With the same r_max the knots themselves are mixed.
  const Lens far = lenses_at(table, 0.015260465)->lens;
  const auto& knots = far.model_if<CatmullRomLens>()->coefficients().knots;
  for (std::size_t k = 0; k < 11; ++k) {
    CHECK(knots[k] == doctest::Approx((test::dk1_middle_knots[k] + test::dk1_far_knots[k]) / 2).epsilon(1e-13));
  }
}

TEST_CASE("every model mixes with its own kind; the middle of two slightly different ones lies between them") {
  const auto other = [](const Lens& lens) {  // with other coefficients
    return lens.with_placement({lens.centre(), Vector2(1.1 * lens.placement().scale)}).with_k_pd(0.2);
  };
  for (const test::PublishedLens& p : test::published_lenses()) {
    CAPTURE(p.name);
    const Lens b = other(p.lens);
    const Lens middle = lens_between(p.lens, b, 0.5).value();
    CHECK(middle.k_pd() == doctest::Approx(0.1));
    CHECK((middle.placement().scale - 1.05 * p.lens.placement().scale).norm() < 1e-15);
    CHECK(middle.model().index() == p.lens.model().index());
    // The same model at both ends is the same between them, but for the rounding of the mixing.
    const Lens same = lens_between(p.lens, p.lens, 0.3).value();
    const Vector2 t(0.2, -0.3);
    CHECK((*same.distort(t) - *p.lens.distort(t)).norm() < 1e-14);
  }
  const Lens a(PolynomialLens(std::array{0.2}));
  const Lens b(PolynomialLens(std::array{0.4, 0.1}, 1.2));
  const Lens quarter = lens_between(a, b, 0.25).value();
  const auto* mixed = quarter.model_if<PolynomialLens>();
  REQUIRE(mixed);
  CHECK(mixed->coefficients()[0] == doctest::Approx(0.25).epsilon(1e-15));
  CHECK(mixed->coefficients()[1] == doctest::Approx(0.025).epsilon(1e-15));
  CHECK(mixed->k0() == doctest::Approx(1.05).epsilon(1e-15));
}

TEST_CASE("what cannot be mixed is not") {
  const Lens radial = RadialLens{0.2};
  const Lens vive = ViveLens(test::vive_green);
  CHECK_FALSE(lens_between(radial, vive, 0.5).has_value());
  CHECK(lens_between(radial, vive, 0.0).has_value());
  CHECK(lens_between(radial, vive, 1.0).has_value());
  CHECK_FALSE(lens_between(radial, mirrored(radial), 0.5).has_value());  // the scale would vanish
  const std::vector<LensesAtRelief> table{{0.01, radial, std::nullopt, std::nullopt},
                                          {0.02, vive, std::nullopt, std::nullopt}};
  CHECK_FALSE(lenses_at(table, 0.015).has_value());
}

TEST_CASE("a headset worn at another relief takes the lenses of that relief, for both eyes and each colour") {
  HmdModel hmd = default_hmd();
  hmd.left.eye_relief_m = 0.012760465;
  hmd.left.lenses_at_relief = dk1_table();
  hmd.right = mirrored(hmd.left);
  const HmdModel near = with_eye_relief(hmd, 0.007760465);
  CHECK(near.left.tangents == hmd.left.tangents);  // a collimated image stays
  CHECK(seen(near.left.lens, 0.8) == seen(hmd.left.lenses_at_relief[0].lens, 0.8));
  CHECK(near.left.lens_blue.has_value());
  CHECK(*near.right.lens.distort(Vector2(-0.8, 0.1)) ==
        Vector2(-near.left.lens.distort(Vector2(0.8, 0.1))->x(), near.left.lens.distort(Vector2(0.8, 0.1))->y()));
  // An eye farther away sees this point through more of the lens's rim, and farther out: by 6 %.
  CHECK(seen(with_eye_relief(hmd, 0.017760465).left.lens, 0.8) > 1.05 * seen(near.left.lens, 0.8));
  // There and back again.
  const HmdModel back = with_eye_relief(with_eye_relief(near, 0.02), 0.007760465);
  CHECK(seen(back.left.lens, 0.8) == seen(near.left.lens, 0.8));
}

TEST_CASE("a virtual image at a distance narrows as the eye goes back; the table's lenses are taken as they are") {
  HmdModel hmd = default_hmd();
  for (EyeModel* eye : {&hmd.left, &hmd.right}) {
    eye->image_distance_m = 2.0;
    eye->eye_relief_m = 0.01;
    eye->lenses_at_relief = dk1_table();
  }
  const HmdModel back = with_eye_relief(hmd, 0.017760465);
  CHECK(back.left.tangents.right < hmd.left.tangents.right);
  CHECK(seen(back.left.lens, 0.5) == seen(hmd.left.lenses_at_relief[2].lens, 0.5));
  // Another IPD moves the optics sideways, and every lens of the table with them.
  const HmdModel wide = with_ipd(hmd, 0.072);
  CHECK(wide.left.lenses_at_relief[0].lens.centre().x() == doctest::Approx(0.005 / 2.0).epsilon(1e-12));
}
