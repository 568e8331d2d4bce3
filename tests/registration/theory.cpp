#include <doctest/doctest.h>

#include <holdfast/registration/theory.hpp>

using namespace holdfast;

TEST_CASE("gains and errors of the predictors are evaluation.md's formulas") {
  for (const double x : {0.01, 0.3, 1.0, 2.5}) {
    CHECK(theory::gain(0, x) == 1.0);
    CHECK(theory::gain(1, x) == doctest::Approx(std::sqrt(1.0 + x * x)).epsilon(1e-12));
    CHECK(theory::gain(2, x) == doctest::Approx(std::sqrt(1.0 + std::pow(x, 4) / 4.0)).epsilon(1e-12));
    CHECK(theory::error_ratio(0, x) == doctest::Approx(2.0 * std::sin(x / 2.0)).epsilon(1e-12));
  }
  // Leading terms; the next one is smaller by x / 3 and x / 4 or better.
  CHECK(theory::error_ratio(1, 0.01) == doctest::Approx(0.01 * 0.01 / 2.0).epsilon(0.005));
  CHECK(theory::error_ratio(2, 0.01) == doctest::Approx(std::pow(0.01, 3) / 6.0).epsilon(0.005));
}

TEST_CASE("doubling the interval multiplies the constant-velocity error by about four (value 2)") {
  CHECK(theory::error_ratio(1, 0.1) / theory::error_ratio(1, 0.05) == doctest::Approx(4.0).epsilon(0.005));
}

TEST_CASE("prediction is worse than none above f T = 0.302 and 0.365") {
  const auto crossing = [](int order) {
    double low = 0.1, high = 0.45;  // f T
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high), x = theory::phase_of(1.0, middle);
      (theory::error_ratio(order, x) < theory::error_ratio(0, x) ? low : high) = middle;
    }
    return low;
  };
  CHECK(crossing(1) == doctest::Approx(0.302).epsilon(0.002));  // printed with three digits
  CHECK(crossing(2) == doctest::Approx(0.365).epsilon(0.002));
}

TEST_CASE("the lag of no prediction is the interval; constant velocity leaves the third power of it") {
  CHECK(theory::lag_s(0, 2.0, 0.06) == doctest::Approx(0.06).epsilon(1e-12));
  const double x = theory::phase_of(2.0, 0.02);
  CHECK(theory::lag_s(1, 2.0, 0.02) == doctest::Approx((x - std::atan(x)) / (4.0 * std::numbers::pi)).epsilon(1e-9));
}
