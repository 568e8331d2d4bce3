#include <doctest/doctest.h>

#include <holdfast/registration/theory.hpp>

using namespace holdfast;
using theory::Order;

TEST_CASE("the lag of no prediction is the interval; constant velocity leaves the third power of it") {
  CHECK(theory::lag_s(Order::none, 2.0, 0.06) == doctest::Approx(0.06).epsilon(1e-12));
  const double x = 2.0 * std::numbers::pi * 2.0 * 0.02;
  CHECK(theory::lag_s(Order::constant_velocity, 2.0, 0.02) ==
        doctest::Approx((x - std::atan(x)) / (4.0 * std::numbers::pi)).epsilon(1e-9));
  // x^3 / 3 of phase; the next term is smaller by 3 x^2 / 5.
  CHECK(theory::lag_s(Order::constant_velocity, 0.5, 0.01) ==
        doctest::Approx(std::pow(std::numbers::pi * 0.01, 3) / 3.0 / std::numbers::pi).epsilon(1e-3));
}

TEST_CASE("swim between frames is that of the continuous error, less by sinc") {
  const double continuous = 2.0 * std::numbers::pi * 2.0 * 1.5;
  CHECK(theory::swim_amplitude(1.5, 2.0, 1e-5) == doctest::Approx(continuous).epsilon(1e-8));
  CHECK(theory::swim_amplitude(1.5, 2.0, 1.0 / 90.0) == doctest::Approx(continuous * (1.0 - 8.1e-4)).epsilon(1e-5));
}
