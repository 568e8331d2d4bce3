#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/prediction/predictor_theory.hpp>

using namespace holdfast::theory;

namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

/// Greatest |Taylor prediction - truth| of a unit sine over one period, by brute force.
double worst_error(Order order, double hz, double interval) {
  const double w = two_pi * hz;
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double t = i / 4000.0 / hz;
    double predicted = std::sin(w * t);
    if (order != Order::none) predicted += w * interval * std::cos(w * t);
    if (order == Order::constant_acceleration) predicted -= 0.5 * w * w * interval * interval * std::sin(w * t);
    worst = std::max(worst, std::abs(predicted - std::sin(w * (t + interval))));
  }
  return worst;
}

}  // namespace

TEST_CASE("gains are those of the table") {
  for (const double x : {0.01, 0.3, 0.75, 2.0}) {
    const double hz = x / two_pi;
    CHECK(gain(Order::none, hz, 1.0) == 1.0);
    CHECK(gain(Order::constant_velocity, hz, 1.0) == doctest::Approx(std::sqrt(1 + x * x)).epsilon(1e-14));
    CHECK(gain(Order::constant_acceleration, hz, 1.0) ==
          doctest::Approx(std::sqrt(1 + std::pow(x, 4) / 4)).epsilon(1e-14));
  }
}

TEST_CASE("errors agree with brute force, and with their small-x laws") {
  for (const Order order : {Order::none, Order::constant_velocity, Order::constant_acceleration}) {
    for (const double hz : {0.5, 2.0, 5.0}) {
      // 4000 points per period miss a sine's top by at most (pi/4000)^2 / 2 = 3e-7 of it.
      CHECK(error(order, hz, 0.06) == doctest::Approx(worst_error(order, hz, 0.06)).epsilon(1e-6));
    }
  }
  const double x = 0.02, hz = x / two_pi;
  CHECK(error(Order::none, hz, 1.0) == doctest::Approx(2 * std::sin(x / 2)).epsilon(1e-14));
  CHECK(error(Order::constant_velocity, hz, 1.0) ==
        doctest::Approx(x * x / 2).epsilon(1e-3));  // next order: x/3 in quadrature
  CHECK(error(Order::constant_acceleration, hz, 1.0) == doctest::Approx(x * x * x / 6).epsilon(1e-3));
}

TEST_CASE("prediction does harm above f T = 0.302 and 0.365: at 60 ms above 5.0 and 6.1 Hz") {
  CHECK(std::abs(crossover(Order::constant_velocity) - 0.302) < 0.0005);  // printed with three decimals
  CHECK(std::abs(crossover(Order::constant_acceleration) - 0.365) < 0.0005);
  CHECK(crossover(Order::constant_velocity) / 0.06 == doctest::Approx(5.0).epsilon(0.01));
  CHECK(crossover(Order::constant_acceleration) / 0.06 == doctest::Approx(6.1).epsilon(0.01));
  for (const Order order : {Order::constant_velocity, Order::constant_acceleration}) {
    CHECK(error(order, 0.99 * crossover(order), 1.0) < error(Order::none, 0.99 * crossover(order), 1.0));
    CHECK(error(order, 1.01 * crossover(order), 1.0) > error(Order::none, 1.01 * crossover(order), 1.0));
  }
}

TEST_CASE("without prediction the picture lags by x, with constant velocity by x - atan x") {
  const double x = 0.4, hz = x / two_pi;
  CHECK(phase_error(Order::none, hz, 1.0) == doctest::Approx(-x).epsilon(1e-12));
  CHECK(phase_error(Order::constant_velocity, hz, 1.0) == doctest::Approx(std::atan(x) - x).epsilon(1e-12));
}
